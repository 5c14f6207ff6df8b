//! Reduction of the largest errors.
//!
//! A metric that sums squared distances over areas allows a small part to be far from its place. The reduction first
//! moves the vertices around the largest distances to lower them: a fit in which the farthest pairs have the largest
//! weights. Then each round finds the vertices of the original that are farthest from the mesh, inserts vertices there,
//! and collapses the cheapest edges elsewhere until the number of faces is as before. Vertices of the mesh that are far
//! from the original are moved back to it, and if the middle of an edge is farthest, the edge is split there. The
//! result of a round is kept if the largest distance has fallen and the root mean square is not much larger than at the
//! start.

mod distance_update;
mod elements;
mod flatten;
mod place;
mod points;

use mesh_collapse::{Boundary, NewIntersections, Phase};
use mesh_core::{EdgeId, Handle, RemapOf, TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;

use crate::collapse_back::{Back, CollapseBack, collapse_back, follow};
use crate::error::RefineError;
use crate::fit::FitOptions;
use crate::fit::constraints::FitConstraints;
use crate::max_error::distance_update::Became;
use crate::max_error::points::{Heights, Most, Peaks, Points};
use crate::observer::Observer;

/// Options of [`reduce_max_error`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MaxErrorOptions {
    /// Largest number of rounds.
    pub rounds: usize,
    /// The distance at which a peak starts in a round, relative to the largest distance.
    pub above: f64,
    /// Largest number of vertices that are inserted in a round, relative to the number of faces.
    pub share: f64,
    /// Distance between points on the longer edges of the original, which are measured in addition to its vertices,
    /// relative to the square root of the mean area of its triangles.
    pub spacing: f64,
    /// Largest factor by which the mean or the root mean square of the distances may rise.
    pub max_rise: f64,
    /// The smallest number of faces of the result. A collapse removes two faces or, on the boundary, one. So a mesh with
    /// exactly this number may get one face more.
    pub min_faces: usize,
    /// Options of the fit around the largest errors, before the rounds and after each round that was kept. It uses
    /// [`FitOptions::tail`], and continues for as many rounds as the largest errors fall; edges are not flipped. With 0
    /// rounds there is no such fit.
    pub fit: FitOptions,
    /// Whether faces must not intersect if they did not before.
    pub forbid_intersections: bool,
    /// The number of vertices that every component keeps.
    pub min_component_vertices: Option<usize>,
}

impl Default for MaxErrorOptions {
    fn default() -> Self {
        Self {
            rounds: 6,
            above: 0.7,
            share: 0.003,
            spacing: 3.0,
            max_rise: 1.03,
            min_faces: 0,
            fit: FitOptions {
                rounds: 0,
                samples_per_face: 30,
                own_samples_per_face: 30,
                tail: 300.0,
                ..FitOptions::default()
            },
            forbid_intersections: false,
            min_component_vertices: None,
        }
    }
}

impl MaxErrorOptions {
    /// Checks that the options are in range.
    pub fn check(&self) -> Result<(), RefineError> {
        let is_part = |x: f64| (0.0..=1.0).contains(&x);
        let part = "between 0 and 1";
        RefineError::unless(is_part(self.above), "max_error above", self.above, part)?;
        RefineError::unless(is_part(self.share), "max_error share", self.share, part)?;
        let (spacing, rise) = (self.spacing, self.max_rise);
        let is_size = spacing > 0.0 && spacing.is_finite();
        RefineError::unless(is_size, "max_error spacing", spacing, "positive and finite")?;
        let is_ratio = rise >= 0.0 && rise.is_finite();
        RefineError::unless(is_ratio, "max_error max_rise", rise, "at least 0 and finite")?;
        self.fit.check()
    }
}

/// Report of [`reduce_max_error`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MaxErrorReport {
    /// Number of rounds.
    pub rounds: usize,
    /// Number of rounds that were kept.
    pub kept: usize,
    /// The largest distance at the start, over the measured points of both surfaces.
    pub largest_before: f64,
    /// That distance at the end.
    pub largest_after: f64,
    /// For each vertex of the input mesh, the vertex of the result that it corresponds to.
    pub vertex_map: VertexMap<Option<VertexId>>,
}

impl MaxErrorReport {
    /// The report of both runs, one after the other.
    #[must_use]
    pub(crate) fn then(mut self, next: &Self) -> Self {
        follow(&mut self.vertex_map, &next.vertex_map);
        self.rounds += next.rounds;
        self.kept += next.kept;
        self.largest_after = next.largest_after;
        self
    }
}

/// Reduces the largest distances of the vertices of the original from a mesh without gaps. The number of faces does not
/// rise by more than one, see [`MaxErrorOptions::min_faces`]; `constraints` follow the mesh.
///
/// Fixed vertices do not move, and boundary edges whose ends are both fixed are not split. If intersections are
/// forbidden, no step makes faces intersect that did not before.
///
/// # Errors
/// An option is out of range, or the mesh has no faces.
pub fn reduce_max_error(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &mut FitConstraints,
    options: &MaxErrorOptions,
) -> Result<MaxErrorReport, RefineError> {
    options.check()?;
    reduce_max_error_observed(mesh, original, constraints, options, &mut Observer::none())
}

/// [`reduce_max_error`] with an observer. If it stops the run, there are fewer rounds.
pub(crate) fn reduce_max_error_observed(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &mut FitConstraints,
    options: &MaxErrorOptions,
    observer: &mut Observer<'_>,
) -> Result<MaxErrorReport, RefineError> {
    let fit = FitOptions {
        forbid_intersections: options.fit.forbid_intersections || options.forbid_intersections,
        ..options.fit
    };
    let faces = mesh.topology().face_count();
    let points = Points::new(original, options.spacing, faces);
    let identity = (0..mesh.topology().vertex_capacity()).map(VertexId::from_index).map(Some);
    let mut map: VertexMap<Option<VertexId>> = VertexMap::from_vec(identity.collect());
    let mut max_error = Peaks::new(mesh, original, &points)?;
    let Heights { largest: largest_before, mean, rms } = max_error.heights;
    let most = Most { mean: options.max_rise * mean, rms: options.max_rise * rms };
    let (mut rounds, mut kept) = (0, 0);
    max_error.flatten(mesh, original, constraints, &fit, most, observer)?;
    // At first all far vertices are moved back. If that fails, only the farthest are.
    let (mut share, mut returning) = (options.share, usize::MAX);
    let mut failed = 0;
    let most_faces = faces.max(options.min_faces.saturating_add(1).min(faces + 1));
    let step = CollapseBack {
        faces: most_faces,
        locked: &[],
        boundary: Boundary::Quadrics,
        forbid_intersections: options.forbid_intersections,
        min_component_vertices: options.min_component_vertices,
        first: None,
    };
    // Cheap edges, of which a round collapses a few.
    let mut cheapest: Vec<EdgeId> = Vec::new();
    // The vertices and positions of the last round, if it failed. The same change, or no change, would fail again.
    let mut in_vain = Vec::new();
    while rounds < options.rounds && failed < PATIENCE && max_error.heights.largest > 0.0 {
        if observer.stops(Phase::MaxError, mesh) {
            break;
        }
        rounds += 1;
        let count = at_once(share, faces);
        let mut next = mesh.clone();
        let bar = options.above * max_error.heights.largest;
        let mut found = options.forbid_intersections.then(|| NewIntersections::new(&next));
        let mut placed =
            max_error.bring_back(&mut next, original, (constraints, &mut found), bar, returning);
        let with = (&*constraints, &mut found);
        placed.extend(max_error.put_vertices(&mut next, original, with, bar, count));
        let places: Vec<_> = placed.iter().map(|&v| (v, next.position(v))).collect();
        let mut better = None;
        if places != in_vain {
            if cheapest.len() < CHEAPEST * count {
                let shortlist = (2 * CHEAPEST * count).max(FEWEST_CHEAPEST);
                cheapest = step.cheapest_edges(mesh, constraints, shortlist);
            }
            let step = CollapseBack { locked: &placed, first: Some(&cheapest), ..step };
            let back = collapse_back(&mut next, constraints, &step, Phase::MaxError, observer);
            let left = next.topology().face_count();
            if (options.min_faces..=most_faces).contains(&left) {
                let (vertex_map, bar) = (Became::Other(&back.remap), max_error.heights.largest);
                let change = max_error.after(mesh, &next, original, vertex_map, bar)?;
                let change = change.filter(|c| is_better(c.heights, max_error.heights, most));
                better = change.map(|change| (back, change));
            }
        }
        if let Some((Back { vertex_map, constraints: following, remap }, change)) = better {
            follow(&mut map, &vertex_map);
            (*mesh, *constraints) = (next, following);
            cheapest = cheapest.into_iter().filter_map(|edge| remap.new_handle(edge)).collect();
            max_error.take_up(change);
            max_error.flatten(mesh, original, constraints, &fit, most, observer)?;
            in_vain.clear();
            (kept, failed) = (kept + 1, 0);
            continue;
        }
        in_vain = places;
        if returning > count {
            returning = count;
        } else {
            share *= LESS;
            failed += 1;
        }
    }
    let largest_after = max_error.heights.largest;
    Ok(MaxErrorReport { rounds, kept, largest_before, largest_after, vertex_map: map })
}

/// The number of cheap edges for each inserted vertex. It is large enough for the case that some of them are near the
/// largest errors or have become more expensive since they were found.
const CHEAPEST: usize = 16;
/// The smallest number of cheap edges to find, so that they last for several rounds.
const FEWEST_CHEAPEST: usize = 256;

/// The number of consecutive failed rounds after which the reduction ends.
const PATIENCE: usize = 2;

/// The factor on the share after a failed round.
const LESS: f64 = 0.3;

/// The number of vertices that are inserted in one round.
fn at_once(share: f64, faces: usize) -> usize {
    ((share * faces as f64) as usize).max(1)
}

/// Whether the largest distance is smaller, and the root mean square not too large.
fn is_better(found: Heights, before: Heights, most: Most) -> bool {
    found.largest < before.largest && found.rms <= most.rms
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_shapes::{Irregular, Wave};

    fn wave(cells: usize) -> TriMesh {
        let wave = Wave { amplitude: 0.15, wavelength: 1.1, half_width: 1.0 };
        let soup = wave.irregular_mesh(cells, Irregular { jitter: 0.2, seed: 4 }).unwrap();
        TriMesh::from_soup(&soup).unwrap()
    }

    #[test]
    fn vertices_at_once_are_a_share_of_the_faces() {
        assert_eq!(at_once(0.003, 10_000), 30);
        assert_eq!(at_once(0.003 * LESS, 10_000), 9);
        assert_eq!(at_once(0.003 * LESS * LESS, 10_000), 2);
        assert_eq!(at_once(0.003, 10), 1);
    }

    #[test]
    fn a_round_is_kept_when_the_peaks_are_lower_and_the_rest_is_not_much_worse() {
        let with = |largest, rms| Heights { largest, mean: 1.0, rms };
        let (before, most) = (with(2.0, 1.0), Most { mean: 0.0, rms: 1.03 });
        assert!(is_better(with(1.999, 1.03), before, most));
        assert!(!is_better(with(2.0, 0.5), before, most));
        assert!(!is_better(with(1.0, 1.031), before, most));
    }

    #[test]
    fn rounds_in_vain_end_soon() {
        let (mut mesh, original) = (wave(6), Surface::new(&wave(20)).unwrap());
        let before = mesh.clone();
        let mut constraints = FitConstraints::default();
        // One round with all far vertices, and then as many failed rounds as are allowed.
        let options =
            MaxErrorOptions { rounds: 20, min_faces: usize::MAX, ..MaxErrorOptions::default() };
        let report = reduce_max_error(&mut mesh, &original, &mut constraints, &options).unwrap();
        assert_eq!((report.rounds, report.kept), (1 + PATIENCE, 0));
        assert_eq!(PATIENCE, 2);
        assert_eq!(mesh.positions(), before.positions());
        assert_eq!(report.largest_before, report.largest_after);
        // With a bar at the largest distance, there are no peaks.
        let options = MaxErrorOptions { above: 1.0, ..MaxErrorOptions::default() };
        let report = reduce_max_error(&mut mesh, &original, &mut constraints, &options).unwrap();
        assert_eq!((report.rounds, report.kept), (1 + PATIENCE, 0));
    }

    #[test]
    fn a_mesh_with_the_least_faces_may_get_one_more() {
        let original = Surface::new(&wave(20)).unwrap();
        let more = (4..10).map(|cells| {
            let mut mesh = wave(cells);
            let faces = mesh.topology().face_count();
            let options = MaxErrorOptions {
                min_faces: faces,
                share: 0.05,
                max_rise: 1.5,
                ..MaxErrorOptions::default()
            };
            let mut constraints = FitConstraints::default();
            let report =
                reduce_max_error(&mut mesh, &original, &mut constraints, &options).unwrap();
            assert!(report.largest_after <= report.largest_before);
            mesh.topology().face_count() - faces
        });
        let more: Vec<usize> = more.collect();
        assert!(more.iter().all(|&more| more <= 1) && more.contains(&1), "{more:?}");
    }
}
