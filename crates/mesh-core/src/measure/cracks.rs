//! Narrow gaps between boundaries, as between patches whose common points were rounded differently.

use crate::build::weld_within;
use crate::mesh::TriMesh;

/// Boundary vertices that are close to others, but not at the same place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cracks {
    /// The number of vertices that a weld within [`Cracks::width`] merges into others.
    pub vertices: usize,
    /// The largest distance between two of them, in model units.
    pub width: f64,
}

/// The largest width of a crack, as a share of the boundary edges beside it.
const WIDTH: f64 = 0.01;

/// The cracks of a mesh; `None` if fewer than two boundary vertices are close to others.
///
/// Two vertices are close if their distance is at most 1 % of all boundary edges at them, and of the median boundary
/// edge.
#[must_use]
pub fn cracks(mesh: &TriMesh) -> Option<Cracks> {
    let topology = mesh.topology();
    let mut shortest = topology.vertex_map(f64::INFINITY);
    let mut lengths = Vec::new();
    for edge in topology.edges().filter(|&edge| topology.is_boundary_edge(edge)) {
        let ends = topology.edge_vertices(edge);
        let length = mesh.position(ends[0]).distance(mesh.position(ends[1]));
        ends.into_iter().for_each(|v| shortest[v] = shortest[v].min(length));
        lengths.push(length);
    }
    let middle = lengths.len() / 2;
    let (_, &mut median, _) =
        (!lengths.is_empty()).then(|| lengths.select_nth_unstable_by(middle, f64::total_cmp))?;
    let rim: Vec<_> = topology.vertices().filter(|&v| shortest[v].is_finite()).collect();
    let points: Vec<_> = rim.iter().map(|&v| mesh.position(v)).collect();
    let targets = weld_within(&points, WIDTH * median);
    let widths = targets.iter().enumerate().filter_map(|(vertex, &target)| {
        let target = target as usize;
        let width = points[vertex].distance(points[target]);
        let most = WIDTH * shortest[rim[vertex]].min(shortest[rim[target]]);
        (width > 0.0 && width <= most).then_some(width)
    });
    let (vertices, width) = widths.fold((0, 0.0_f64), |(count, most), w| (count + 1, most.max(w)));
    (vertices > 1).then_some(Cracks { vertices, width })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::build::soup::PolygonSoup;
    use crate::build::{Repair, build};

    /// Two strips of squares beside each other, each with vertices of its own, with a gap between them.
    fn strips(gap: f64) -> TriMesh {
        let mut soup = PolygonSoup::new();
        for strip in 0..2 {
            let first = 12 * strip;
            for y in 0..6 {
                for x in 0..2 {
                    let left = f64::from(strip) * (1.0 + gap);
                    soup.push_vertex([left + f64::from(x), f64::from(y), 0.0]);
                }
            }
            for v in (0..5).map(|y| first + 2 * y) {
                soup.push_face(&[v, v + 1, v + 3, v + 2]).unwrap();
            }
        }
        build(&soup, &Repair::strict()).unwrap().mesh
    }

    #[test]
    fn a_narrow_gap_is_a_crack() {
        let found = cracks(&strips(1e-6)).unwrap();
        assert_eq!(found.vertices, 6);
        assert!((found.width - 1e-6).abs() < 1e-12);
        assert_eq!(cracks(&strips(0.1)), None);
        assert_eq!(cracks(&strips(0.0)), None);
    }
}
