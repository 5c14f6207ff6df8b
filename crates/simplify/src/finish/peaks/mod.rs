//! Taking down the largest errors.
//!
//! A metric that adds up squared distances over areas lets a small part go far from its place. Where
//! that is asked for, the vertices round the largest distances first move to a place where these are
//! smaller: a fit in which the farthest pairs count most. Then each round looks for the vertices of
//! the original that are farthest from the mesh, puts vertices there, and collapses the cheapest
//! edges elsewhere until there are as many faces as before.
//! Vertices of the mesh that are far from the original go back to it. The result is kept when the
//! largest distance has become smaller and the root mean square is not much larger than at the
//! start.

mod flatten;
mod place;
mod points;

use mesh_core::{Handle, TriMesh, VertexId, VertexMap};
use mesh_metric::{Surface, SurfaceError};

use crate::collapse::constraint::Boundary;
use crate::finish::collapse_back::{CollapseBack, collapse_back};
use crate::finish::fit::FitOptions;
use crate::finish::fit::constraints::FitConstraints;
use crate::finish::peaks::points::{Most, Peaks, Points};

/// How to take down peaks; see [`cut_peaks`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PeakOptions {
    /// How many rounds at most.
    pub rounds: usize,
    /// What counts as a peak in a round, relative to the largest distance.
    pub above: f64,
    /// The most vertices that are put in place in a round, as a part of the faces.
    pub share: f64,
    /// How far apart points are on the longer edges of the original, which are measured besides its
    /// vertices: in roots of the mean area of its triangles.
    pub spacing: f64,
    /// How much the mean or the root mean square of the distances may rise in all, as a ratio.
    pub max_rise: f64,
    /// How many faces must be left. A round that ends on the boundary may take one more than it
    /// has made.
    pub min_faces: usize,
    /// How the vertices round the peaks are fitted before the rounds and after each that was kept,
    /// with [`FitOptions::tail`], for as many rounds as that lowers the peaks; edges are not
    /// flipped. Not at all with 0 rounds.
    pub fit: FitOptions,
    /// Whether faces must not come to cross that did not before.
    pub forbid_intersections: bool,
    /// How many vertices every component keeps.
    pub min_component_vertices: Option<usize>,
}

impl Default for PeakOptions {
    fn default() -> Self {
        Self {
            rounds: 5,
            above: 0.7,
            share: 0.003,
            spacing: 3.0,
            max_rise: 1.03,
            min_faces: 0,
            fit: FitOptions { rounds: 0, tail: 300.0, ..FitOptions::default() },
            forbid_intersections: false,
            min_component_vertices: None,
        }
    }
}

/// What [`cut_peaks`] did.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PeakReport {
    /// How many rounds were made.
    pub rounds: usize,
    /// How many of them were kept.
    pub kept: usize,
    /// The largest distance at the start, of the points of both surfaces that were measured.
    pub largest_before: f64,
    /// That distance at the end.
    pub largest_after: f64,
    /// For each vertex of the mesh that was given, the vertex that it has become.
    pub vertex_map: VertexMap<Option<VertexId>>,
}

/// Takes down the largest distances of the vertices of the original from a mesh without gaps. The
/// number of faces does not rise; `constraints` follow the mesh.
///
/// # Errors
/// The mesh has no faces.
pub fn cut_peaks(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &mut FitConstraints,
    options: &PeakOptions,
) -> Result<PeakReport, SurfaceError> {
    let faces = mesh.topology().face_count();
    let points = Points::new(original, options.spacing, faces);
    let identity = (0..mesh.topology().vertex_capacity()).map(VertexId::from_index).map(Some);
    let mut map: VertexMap<Option<VertexId>> = VertexMap::from_vec(identity.collect());
    let mut peaks = Peaks::new(mesh, original, &points)?;
    let largest_before = peaks.largest;
    let most = Most { mean: options.max_rise * peaks.mean, rms: options.max_rise * peaks.rms };
    let (mut rounds, mut kept) = (0, 0);
    peaks.flatten(mesh, original, constraints, &options.fit, most)?;
    // As many as there are; when that is too many, the farthest only.
    let (mut share, mut returning) = (options.share, usize::MAX);
    let mut failed = 0;
    while rounds < options.rounds && failed < PATIENCE && peaks.largest > 0.0 {
        rounds += 1;
        let count = ((share * faces as f64) as usize).max(1);
        let mut next = mesh.clone();
        let bar = options.above * peaks.largest;
        let mut placed = peaks.bring_back(&mut next, constraints, bar, returning);
        placed.extend(peaks.put_vertices(&mut next, constraints, bar, count));
        let step = CollapseBack {
            faces,
            locked: &placed,
            boundary: Boundary::Quadrics,
            forbid_intersections: options.forbid_intersections,
            min_component_vertices: options.min_component_vertices,
        };
        let back = collapse_back(&mut next, constraints, &step);
        let found = Peaks::new(&next, original, &points)?;
        let is_better = found.largest < peaks.largest && found.rms <= most.rms;
        let left = next.topology().face_count();
        if is_better && (options.min_faces..=faces).contains(&left) {
            for new in map.as_mut_slice() {
                *new = new.and_then(|v| back.vertex_map.get(v).copied().flatten());
            }
            (*mesh, *constraints, peaks) = (next, back.constraints, found);
            peaks.flatten(mesh, original, constraints, &options.fit, most)?;
            (kept, failed) = (kept + 1, 0);
        } else if returning > count {
            returning = count;
        } else {
            share *= 0.3;
            failed += 1;
        }
    }
    let largest_after = peaks.largest;
    Ok(PeakReport { rounds, kept, largest_before, largest_after, vertex_map: map })
}

/// After so many rounds in vain in a row, it is enough.
const PATIENCE: usize = 2;

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use mesh_core::TriMesh;
    use mesh_metric::Surface;

    use super::{FitConstraints, PeakOptions, PeakReport, cut_peaks};

    /// A flat square of 10 x 10 cells, all lengths times `scale`, with a peak of height 3 at one of
    /// its vertices if there is to be one.
    fn plain(scale: f64, has_peak: bool) -> TriMesh {
        const CELLS: u32 = 10;
        let side = CELLS + 1;
        let vertices = (0..side * side).map(|v| {
            let height = if has_peak && v == 5 * side + 4 { 3.0 } else { 0.0 };
            scale * DVec3::new(f64::from(v % side), f64::from(v / side), height)
        });
        let vertices: Vec<DVec3> = vertices.collect();
        let cells = (0..CELLS * CELLS).map(|cell| cell % CELLS + cell / CELLS * side);
        let faces = cells.flat_map(|a| {
            let b = a + side;
            [[a, a + 1, b + 1], [a, b + 1, b]]
        });
        TriMesh::from_triangles(&vertices, &faces.collect::<Vec<_>>()).expect("a square")
    }

    fn cut(scale: f64, options: &PeakOptions) -> (TriMesh, PeakReport) {
        let original = Surface::new(&plain(scale, true)).expect("there are faces");
        let mut mesh = plain(scale, false);
        let mut constraints = FitConstraints::default();
        let report = cut_peaks(&mut mesh, &original, &mut constraints, options);
        (mesh, report.expect("there are faces"))
    }

    #[test]
    fn a_peak_gets_a_vertex_at_any_scale() {
        for scale in [1e-6, 1.0, 1e6] {
            let (mesh, report) =
                cut(scale, &PeakOptions { max_rise: 2.0, ..PeakOptions::default() });
            assert!(report.kept > 0, "at scale {scale}");
            assert!((report.largest_before - 3.0 * scale).abs() < 1e-9 * scale);
            assert!(report.largest_after < 0.5 * report.largest_before, "at scale {scale}");
            assert_eq!(mesh.topology().face_count(), 200);
            let highest = mesh.positions().iter().map(|p| p.z).fold(0.0, f64::max);
            assert_eq!(highest, 3.0 * scale);
        }
    }

    #[test]
    fn averages_may_rise_by_the_ratio_only() {
        // Whatever is done leaves averages above a thousandth of what they were.
        for scale in [1e-6, 1.0] {
            let options = PeakOptions { max_rise: 1e-3, ..PeakOptions::default() };
            assert_eq!(cut(scale, &options).1.kept, 0, "at scale {scale}");
        }
    }

    #[test]
    fn a_round_in_vain_is_followed_by_smaller_ones_and_two_are_the_end() {
        // No result has so many faces: all rounds are in vain. At first all vertices return that
        // are far away, then 100, then vertices are put in place at 30, where 30 return, then at 30
        // again.
        let options =
            PeakOptions { min_faces: 1000, share: 0.5, rounds: 50, ..PeakOptions::default() };
        let (mesh, report) = cut(1.0, &options);
        assert_eq!([report.rounds, report.kept], [4, 0]);
        assert_eq!(mesh.positions(), plain(1.0, false).positions());
        assert_eq!(report.largest_after, report.largest_before);
        let few = PeakOptions { rounds: 2, ..options };
        assert_eq!(cut(1.0, &few).1.rounds, 2);
    }
}
