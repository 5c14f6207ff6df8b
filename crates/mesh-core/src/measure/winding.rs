//! Winding numbers of a closed surface about points.

use glam::DVec3;

use crate::measure::bounding_box::BoundingBox;
use crate::measure::containment::Containment;
use crate::measure::face_tree::FaceTree;
use crate::mesh::TriMesh;

/// Winding numbers of a closed surface about points, decided exactly: 0 outside, 1 inside a surface whose faces point
/// outwards, -1 inside one whose faces point inwards. Where parts overlap or are nested, the numbers of the parts are
/// added.
///
/// ```
/// use mesh_core::{TriMesh, WindingNumbers};
///
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let mesh = TriMesh::from_triangles(&corners, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
/// let numbers = WindingNumbers::new(&mesh).expect("the surface is closed");
/// assert_eq!(numbers.about([0.2, 0.2, 0.2].into()), 1);
/// assert_eq!(numbers.about([0.4, 0.4, 0.4].into()), 0);
/// # Ok::<(), mesh_core::build::BuildError>(())
/// ```
#[derive(Clone, Debug)]
pub struct WindingNumbers<'m> {
    mesh: &'m TriMesh,
    tree: FaceTree,
    bounds: BoundingBox,
}

impl<'m> WindingNumbers<'m> {
    /// For a mesh; `None` if its surface is open or has no faces. Boundary edges do not count as open if another one
    /// joins the same two places in the opposite direction, as where a surface was cut because it is no manifold.
    #[must_use]
    pub fn new(mesh: &'m TriMesh) -> Option<Self> {
        let bounds = mesh.bounding_box()?;
        let has_faces = mesh.topology().face_count() > 0;
        (has_faces && is_closed(mesh)).then(|| Self { mesh, tree: FaceTree::new(mesh), bounds })
    }

    /// The winding number about a point. On the surface, it is that of one of the two sides.
    #[must_use]
    pub fn about(&self, point: DVec3) -> i32 {
        let containment = Containment::new(self.mesh, &self.tree, self.bounds);
        containment.winding_numbers(point, |_| Some(0)).iter().map(|&(_, number)| number).sum()
    }
}

/// Whether each boundary edge joins the same places as another one in the opposite direction.
fn is_closed(mesh: &TriMesh) -> bool {
    let topology = mesh.topology();
    // Zero has two signs, but is one place.
    let place = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
    let sides = topology.half_edges().filter(|&side| topology.is_exterior(side));
    let mut edges: Vec<([[u64; 3]; 2], i32)> = sides
        .map(|side| {
            let [a, b] = [topology.origin(side), topology.target(side)];
            let [a, b] = [a, b].map(|v| place(mesh.position(v)));
            if a <= b { ([a, b], 1) } else { ([b, a], -1) }
        })
        .collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a.0 == b.0).all(|same| {
        // An edge between equal places is closed in itself.
        same[0].0[0] == same[0].0[1] || same.iter().map(|(_, turn)| turn).sum::<i32>() == 0
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A box between two corners, with faces that point outwards.
    fn cuboid(low: DVec3, high: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corner = |i: u32| {
            let pick = |axis: usize| if i & (1 << axis) == 0 { low[axis] } else { high[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        ((0..8).map(corner).collect(), faces.collect())
    }

    fn joined(parts: &[(Vec<DVec3>, Vec<[u32; 3]>)]) -> TriMesh {
        let (mut points, mut faces): (Vec<DVec3>, Vec<[u32; 3]>) = Default::default();
        for (more, triangles) in parts {
            let shift = points.len() as u32;
            points.extend(more);
            faces.extend(triangles.iter().map(|t| t.map(|v| v + shift)));
        }
        TriMesh::from_triangles(&points, &faces).unwrap()
    }

    #[test]
    fn numbers_of_overlapping_nested_and_reversed_boxes_are_those_of_intervals() {
        let boxes = [
            (DVec3::ZERO, DVec3::ONE, false),
            (DVec3::splat(0.5), DVec3::splat(1.5), false),
            (DVec3::splat(0.1), DVec3::splat(0.4), true),
            (DVec3::splat(3.0), DVec3::splat(4.0), true),
        ];
        let parts = boxes.map(|(low, high, is_reversed)| {
            let (points, mut faces) = cuboid(low, high);
            if is_reversed {
                faces.iter_mut().for_each(|face| face.swap(0, 1));
            }
            (points, faces)
        });
        let mesh = joined(&parts);
        let numbers = WindingNumbers::new(&mesh).unwrap();
        for i in 0..20_i32.pow(3) {
            let at = |digit: i32| 0.25 * f64::from(digit % 20) - 0.3;
            let point = DVec3::new(at(i), at(i / 20), at(i / 400));
            let expected: i32 = boxes
                .iter()
                .filter(|(low, high, _)| point.cmpgt(*low).all() && point.cmplt(*high).all())
                .map(|(.., is_reversed)| if *is_reversed { -1 } else { 1 })
                .sum();
            assert_eq!(numbers.about(point), expected, "{point}");
        }
    }

    #[test]
    fn a_surface_with_a_hole_has_no_numbers_but_a_cut_one_has() {
        let (points, mut faces) = cuboid(DVec3::ZERO, DVec3::ONE);
        // The first face has its own copies of its corners.
        let mut cut = points.clone();
        cut.extend(faces[0].map(|v| points[v as usize]));
        let mut apart = faces.clone();
        apart[0] = [8, 9, 10];
        let mesh = TriMesh::from_triangles(&cut, &apart).unwrap();
        assert_eq!(WindingNumbers::new(&mesh).unwrap().about(DVec3::splat(0.5)), 1);
        faces.pop();
        let open = TriMesh::from_triangles(&points, &faces).unwrap();
        assert!(WindingNumbers::new(&open).is_none());
    }
}
