//! A layout from coarse to fine.
//!
//! Annealing takes longest with many faces, because dislocations must find each other. If each face of a mesh is cut in
//! four at the midpoints of its sides, all new vertices have valence 6, and shapes and size ratios stay the same. So a
//! mesh with a quarter, a sixteenth, ... of the faces is annealed, which takes little time; its faces are cut in four;
//! and it is annealed again with smaller jumps, until it has as many faces as the input. At each stage, only the few
//! vertices with another valence in the coarsest mesh remain to be healed.
//!
//! Their number and positions depend on chance, and the coarsest mesh is the cheapest. So several layouts are started,
//! and only the closest ones continue to the next stage.
//!
//! This is meant for surfaces that are smooth at the scale of the faces. On other surfaces, the coarse mesh cannot
//! represent the details, and the result is worse and is not kept.

use core::ops::{ControlFlow, Range};
use core::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use mesh_core::{EdgeId, FaceId, TriMesh, VertexId, VertexMap, parallel};
use mesh_metric::{Surface, SurfaceError};

use crate::collapse_back::{CollapseBack, collapse_back};
use crate::density::Density;
use crate::error::RefineError;
use crate::fit::constraints::FitConstraints;
use crate::fit::spread::area;
use crate::fit::{FitOptions, fit_observed};
use crate::norm::Power;
use crate::observer::Observer;
use crate::vertex_relocation::{Cooling, anneal_layout};
use mesh_collapse::{Boundary, Phase, Progress};

/// The layouts to start, and their options.
pub(crate) struct CoarseStarts<'a> {
    /// The numbers of the layouts. Each has its own random jumps; number 0 uses the seed itself.
    pub(crate) starts: Range<usize>,
    pub(crate) schedule: &'a Cooling,
    /// The density that each layout starts with.
    pub(crate) density: &'a Density,
    pub(crate) fit: &'a FitOptions,
    /// Points of the original, at which layouts are compared.
    pub(crate) points: &'a [DVec3],
    pub(crate) power: Power,
}

/// A mesh with a new layout and at most the number of faces of the input. It still has to be fitted.
pub(crate) struct Multiresolution {
    pub(crate) mesh: TriMesh,
    pub(crate) constraints: FitConstraints,
    /// Number of sweeps of all layouts.
    pub(crate) sweeps: usize,
}

/// One of several layouts.
struct Trial {
    mesh: TriMesh,
    density: Density,
    seed: u64,
}

/// The smallest number of faces to start with.
const LEAST_FACES: usize = 100;
/// The factor on the jumps after the first stage, and the divisor of the number of sweeps.
const COOLER: f64 = 0.25;
const SHORTER: usize = 4;
/// The number of rounds of fitting after each stage.
const ROUNDS: usize = 3;
/// One in this many layouts continues to the next stage.
const ONE_OF: usize = 4;

/// Lays out a mesh again, and returns the best of several layouts. `None` if there are too few faces, if its vertices
/// are held by features, locks, limits, their importance or a boundary without a curve, or if the run was stopped.
pub(crate) fn lay_out_nested(
    mesh: &TriMesh,
    original: &Surface,
    constraints: &FitConstraints,
    beginnings: &CoarseStarts<'_>,
    observer: &mut Observer<'_>,
) -> Result<Option<Multiresolution>, RefineError> {
    let &CoarseStarts { schedule, density, points, power, .. } = beginnings;
    let faces = mesh.topology().face_count();
    let stages = stages(faces);
    if stages == 0 || is_held(mesh, constraints) {
        return Ok(None);
    }
    let mut mesh = mesh.clone();
    let coarse = CollapseBack {
        faces: faces_at(stages, faces),
        locked: &[],
        boundary: Boundary::Quadrics,
        forbid_intersections: schedule.forbid_intersections,
        // Every component keeps enough vertices to survive.
        min_component_vertices: Some(4),
        first: None,
    };
    let back = collapse_back(&mut mesh, constraints, &coarse, Phase::Anneal, observer);
    let constraints = back.constraints;
    if mesh.topology().face_count() > coarse.faces {
        return Ok(None);
    }
    let trial = |start: usize| {
        // Far from nearby seeds, since users often take consecutive seeds.
        let seed = schedule.seed.wrapping_add((start as u64) << 32);
        Trial { mesh: mesh.clone(), density: density.clone(), seed }
    };
    let mut trials: Vec<Trial> = beginnings.starts.clone().map(trial).collect();
    let mut schedule = Cooling { is_smooth: true, ..*schedule };
    let fit = FitOptions { rounds: ROUNDS, ..*beginnings.fit };
    let mut sweeps = 0;
    for stage in (0..=stages).rev() {
        let is_last = stage == 0;
        let is_alone = trials.len() == 1;
        let step = Step {
            original,
            constraints: &constraints,
            schedule: &schedule,
            faces: faces_at(stage, faces),
            fit: (!(is_last && is_alone)).then_some(&fit),
        };
        for group in trials.chunks_mut(parallel::threads()) {
            sweeps += step.take_all(group, observer)?;
            if observer.is_stopped() || (!is_last && schedule.is_over()) {
                return Ok(None);
            }
        }
        if !is_alone {
            let carried = if is_last { 1 } else { trials.len().div_ceil(ONE_OF) };
            trials = closest(trials, carried, points, power)?;
        }
        if !is_last && !trials.iter_mut().all(|trial| quadruple(&mut trial.mesh)) {
            return Ok(None);
        }
        if stage == stages {
            schedule.jump *= COOLER;
            schedule.sweeps = schedule.sweeps.div_ceil(SHORTER);
        }
    }
    Ok(trials.pop().map(|Trial { mesh, .. }| Multiresolution { mesh, constraints, sweeps }))
}

/// The work on each layout at a stage.
struct Step<'a> {
    original: &'a Surface,
    constraints: &'a FitConstraints,
    schedule: &'a Cooling,
    faces: usize,
    fit: Option<&'a FitOptions>,
}

impl Step<'_> {
    /// Takes the step for some layouts in parallel. Only the first layout calls the observer, since it stays on this
    /// thread. Returns the number of sweeps.
    fn take_all(
        &self,
        trials: &mut [Trial],
        observer: &mut Observer<'_>,
    ) -> Result<usize, RefineError> {
        let Some((first, others)) = trials.split_first_mut() else { return Ok(0) };
        let is_over = &AtomicBool::new(false);
        let here = || {
            let made = self.take(first, observer);
            is_over.store(made.is_err() || observer.is_stopped(), Ordering::Relaxed);
            made
        };
        let there = |trial: &mut Trial| {
            let ask = &mut |_: &Progress| match is_over.load(Ordering::Relaxed) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            self.take(trial, &mut Observer::new(0, 0, ask))
        };
        let (made, others) = parallel::beside(here, others, there);
        others.into_iter().try_fold(made?, |sum, made| Ok(sum + made?))
    }

    fn take(&self, trial: &mut Trial, observer: &mut Observer<'_>) -> Result<usize, RefineError> {
        let &Self { original, constraints, schedule, faces, fit } = self;
        let Trial { mesh, density, seed } = trial;
        top_up(mesh, faces);
        let schedule = Cooling { seed: *seed, ..*schedule };
        let sweeps = anneal_layout(mesh, original, constraints, (&schedule, density), observer);
        if let Some(fit) = fit
            && !observer.is_stopped()
        {
            fit_observed(mesh, original, constraints, fit, observer)?;
        }
        Ok(sweeps)
    }
}

/// The `count` layouts with the smallest sums of powers of distances from the points.
fn closest(
    trials: Vec<Trial>,
    count: usize,
    points: &[DVec3],
    power: Power,
) -> Result<Vec<Trial>, SurfaceError> {
    let mut ranked = Vec::with_capacity(trials.len());
    for trial in trials {
        let closest = Surface::new(&trial.mesh)?.closest_points(points);
        let powers = closest.iter().map(|closest| power.of(closest.offset.length_squared()));
        ranked.push((powers.sum::<f64>(), trial));
    }
    ranked.sort_by(|p, q| p.0.total_cmp(&q.0));
    Ok(ranked.into_iter().take(count).map(|(_, trial)| trial).collect())
}

/// For each vertex of a mesh, the closest vertex of another mesh on the same side of the surface.
pub(crate) fn counterparts(
    mesh: &TriMesh,
    other: &TriMesh,
) -> Result<VertexMap<Option<VertexId>>, SurfaceError> {
    let topology = mesh.topology();
    let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
    let vertices: Vec<VertexId> = used.collect();
    let points: Vec<DVec3> = vertices.iter().map(|&v| mesh.position(v)).collect();
    let mut map = topology.vertex_map(None);
    let closest = Surface::new(other)?.closest_points(&points);
    for ((&v, &point), closest) in vertices.iter().zip(&points).zip(closest) {
        let normal = topology.faces_of_vertex(v).map(|f| mesh.face_cross(f)).sum::<DVec3>();
        if normal.dot(other.face_cross(closest.face)) > 0.0 {
            let corners = other.topology().face_vertices(closest.face).into_iter();
            let distance = |w: VertexId| other.position(w).distance_squared(point);
            map[v] = corners.min_by(|&p, &q| distance(p).total_cmp(&distance(q)));
        }
    }
    Ok(map)
}

/// The number of times that a mesh can be cut in four.
fn stages(faces: usize) -> u32 {
    (faces / LEAST_FACES).checked_ilog(4).unwrap_or(0)
}

/// The number of faces at a stage, such that `stage` cuts in four lead to `faces`.
fn faces_at(stage: u32, faces: usize) -> usize {
    faces >> (2 * stage)
}

fn is_held(mesh: &TriMesh, constraints: &FitConstraints) -> bool {
    let FitConstraints { fixed, features, boundary_curve, limits, importance, .. } = constraints;
    let is_open = || mesh.topology().edges().any(|e| mesh.topology().is_boundary_edge(e));
    fixed.as_ref().is_some_and(|fixed| fixed.as_slice().contains(&true))
        || features.as_ref().is_some_and(|features| features.as_slice().contains(&true))
        || (boundary_curve.is_none() && is_open())
        || limits.is_any()
        || importance.is_some()
}

/// Cuts each face in four at the midpoints of its sides; the surface stays the same. Returns whether all elements could
/// be numbered.
fn quadruple(mesh: &mut TriMesh) -> bool {
    let old = mesh.topology().vertex_capacity();
    let edges: Vec<EdgeId> = mesh.topology().edges().collect();
    let mut incident_edges = Vec::with_capacity(2 * edges.len());
    for edge in edges {
        let [a, b] = mesh.segment(edge);
        let Ok(split) = mesh.topology().check_split_edge(edge) else { return false };
        incident_edges
            .extend(mesh.split_edge(split, a + 0.5 * (b - a)).incident_edges.into_iter().flatten());
    }
    // The first of the three edges inside a face joins a midpoint to the opposite corner.
    for edge in incident_edges {
        let ends = mesh.topology().edge_vertices(edge);
        if ends.iter().any(|v| v.index() < old)
            && let Ok(flip) = mesh.topology().check_flip(edge)
        {
            mesh.flip(flip);
        }
    }
    true
}

/// Cuts the longest sides of the largest faces until there are `faces` faces, or one fewer.
fn top_up(mesh: &mut TriMesh, faces: usize) {
    let missing = faces.saturating_sub(mesh.topology().face_count()) / 2;
    let mut ranked: Vec<(f64, FaceId)> =
        mesh.topology().faces().map(|f| (area(&mesh.triangle(f)), f)).collect();
    ranked.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
    for &(_, face) in ranked.iter().take(missing) {
        let topology = mesh.topology();
        let length = |e: EdgeId| {
            let [a, b] = mesh.segment(e);
            a.distance_squared(b)
        };
        let sides = topology.face_edges(face).into_iter();
        let inner = sides.filter(|&e| !topology.is_boundary_edge(e));
        let Some(edge) = inner.max_by(|&p, &q| length(p).total_cmp(&length(q))) else { continue };
        let [a, b] = mesh.segment(edge);
        if let Ok(split) = topology.check_split_edge(edge) {
            mesh.split_edge(split, a + 0.5 * (b - a));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{quadruple, stages, top_up};
    use mesh_core::TriMesh;
    use mesh_shapes::{Saddle, Sphere};

    #[test]
    fn a_mesh_cut_in_four_is_the_same_surface_with_regular_new_vertices() {
        let sphere = Sphere { radius: 1.0 }.icosphere(1).unwrap();
        let saddle =
            Saddle { half_width: 1.0, coefficient: 0.5 }.mesh(4, Default::default()).unwrap();
        for soup in [sphere, saddle] {
            let mut mesh = TriMesh::from_soup(&soup).unwrap();
            let before = mesh.clone();
            assert!(quadruple(&mut mesh));
            mesh.topology().validate().unwrap();
            assert_eq!(mesh.topology().face_count(), 4 * before.topology().face_count());
            assert!((mesh.area() - before.area()).abs() < 1e-12);
            for v in mesh.topology().vertices() {
                let is_old = before.topology().contains_vertex(v);
                let valence = if is_old { before.topology().valence(v) } else { 6 };
                let is_inner = !mesh.topology().is_boundary_vertex(v);
                assert!(!is_inner || mesh.topology().valence(v) == valence);
            }
            let faces = mesh.topology().face_count() + 7;
            top_up(&mut mesh, faces);
            assert_eq!(mesh.topology().face_count(), faces - 1);
        }
    }

    #[test]
    fn stages_leave_enough_faces() {
        assert_eq!([0, 99, 399, 400, 1599, 1600, 8000].map(stages), [0, 0, 0, 1, 1, 2, 3]);
    }
}
