//! Simplification from options to result: collapses, error limit, fit.

use core::ops::ControlFlow;
use std::cell::RefCell;
use std::rc::Rc;

use glam::DVec3;
use mesh_core::{RemapOf, TriMesh, VertexId, VertexMap};
use mesh_metric::{Surface, SurfaceError};

use crate::attributes::attribute_deviation::AttributeDeviation;
use crate::attributes::texture_guard::TextureGuard;
use crate::collapse::cost::{
    Cost, CurvatureFactor, CurvatureNorm, GarlandHeckbert, Hybrid, Memoryless, Norm,
};
use crate::collapse::driver::{Policies, Progress, Run, collapse_edges};
use crate::collapse::guard::{
    ComponentGuard, Guard, IntersectionGuard, NormalGuard, Refusals, ShapeGuard,
};
use crate::collapse::log::CollapseLog;
use crate::collapse::placement::{BestEndpoint, ButterflyPoint, Midpoint, Optimal, Placement};
use crate::collapse::stop::{Limits, StopReason};
use crate::finish::anneal::AnnealReport;
use crate::finish::curve::Curve;
use crate::finish::finishing::{Finished, Finishing, Found, Level};
use crate::finish::fit::FitReport;
use crate::finish::peaks::PeakReport;
use crate::options::{ErrorCheck, Metric, Options, PlacementRule};

/// A simplified mesh and how it came about.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// The mesh, without gaps.
    pub mesh: TriMesh,
    /// For each vertex of the original, the vertex of the result that it has become; `None` where
    /// the original had a removed vertex.
    pub vertex_map: VertexMap<Option<VertexId>>,
    /// Every collapse, before fitting and before [`Options::squeeze`].
    pub log: CollapseLog,
    /// Why it stopped.
    pub stop: StopReason,
    /// How often edges were refused, by reason.
    pub refusals: Refusals,
    /// The largest cost of a collapse, in the unit of the cost.
    pub max_cost: f64,
    /// The distance from the original, if it was asked for.
    pub error: Option<AchievedError>,
    /// The largest distance of a boundary vertex of the original to the boundary of the result;
    /// `None` when there is no boundary.
    pub boundary_shift: Option<f64>,
    /// What fitting did, if it was asked for.
    pub fit: Option<FitReport>,
    /// What annealing did, if it was asked for; `None` when it was undone because it folded the
    /// texture.
    pub anneal: Option<AnnealReport>,
    /// What was done about the largest errors; `None` as for `anneal`.
    pub peaks: Option<PeakReport>,
}

/// A distance between two surfaces: the larger of the two one-sided Hausdorff distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AchievedError {
    /// It is not smaller than this.
    pub lower: f64,
    /// It is proved not to be larger than this; `None` when it was only sampled.
    pub upper: Option<f64>,
}

/// Why a mesh cannot be simplified as asked.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplifyError {
    /// An option has a value that makes no sense.
    #[error("{option} is {value}, but it must be {expected}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        expected: &'static str,
    },
    /// A position is infinite or not a number.
    #[error("{vertex:?} is at {position}, which is not finite; remove it or give it a place")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
        /// Its position.
        position: DVec3,
    },
    /// The distance between the surfaces cannot be measured.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
}

/// Simplifies a mesh.
///
/// ```
/// use mesh_core::TriMesh;
/// use simplify::{Options, Preset, simplify};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let soup = mesh_core::shapes::Sphere { radius: 1.0 }.icosphere(3)?;
/// # let mesh = TriMesh::from_soup(&soup)?;
/// let result = simplify(&mesh, &Options::preset(Preset::Default).to_faces(200))?;
/// assert_eq!(result.mesh.topology().face_count(), 200);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// An option makes no sense, or a position is not finite.
pub fn simplify(mesh: &TriMesh, options: &Options) -> Result<Simplified, SimplifyError> {
    simplify_observed(mesh, options, &mut |_| ControlFlow::Continue(()))
}

/// Simplifies a mesh, showing its progress and asking whether to go on. When it was told to stop,
/// the result is what there is by then, not fitted.
///
/// # Errors
/// An option makes no sense, or a position is not finite.
pub fn simplify_observed(
    mesh: &TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    check_options(options)?;
    check_positions(mesh)?;
    let mut working = mesh.clone();
    let mut run = collapse(&mut working, options, &options.limits, observe);
    let is_cancelled = run.stop == StopReason::Cancelled;
    let is_changed = !is_cancelled && !run.log.is_empty();
    let wants_finish = is_changed && (options.fit.is_some() || options.peaks.is_some());
    let wants_error = options.max_error.is_some() || options.error != ErrorCheck::None;
    let has_faces = mesh.topology().face_count() > 0;
    let mut level = Level::new(working, &run, run.log.len());
    let finished = if has_faces && (wants_finish || wants_error) {
        let original = Surface::new(mesh)?;
        let finishing = Finishing::new(mesh, &original, options, wants_finish);
        match options.max_error {
            None => finishing.finish(&level)?,
            Some(limit) => match finishing.search(&run, limit)? {
                Found::All(finished) => finished,
                Found::Fewer(collapses, finished) => {
                    let mut working = mesh.clone();
                    let limits =
                        Limits { collapses: Some(collapses), time: None, ..options.limits };
                    run = collapse(&mut working, options, &limits, observe);
                    let faces = finished.mesh.topology().face_count();
                    let target = options.limits.face_target(mesh.topology().face_count());
                    run.stop = if faces <= target { StopReason::Faces } else { StopReason::Error };
                    level = Level::new(working, &run, run.log.len());
                    finished
                }
            },
        }
    } else {
        Finished::untouched(level.mesh.clone())
    };
    let became = run.log.representatives(mesh, run.log.len());
    let follow = |&v: &VertexId| {
        let v = level.remap.new_handle(v)?;
        finished.vertex_map.as_ref().map_or(Some(v), |map| map.get(v).copied().flatten())
    };
    Ok(Simplified {
        vertex_map: VertexMap::from_vec(became.as_slice().iter().map(follow).collect()),
        boundary_shift: boundary_shift(mesh, &finished.mesh),
        mesh: finished.mesh,
        log: run.log,
        stop: run.stop,
        refusals: run.refusals,
        max_cost: run.max_cost,
        error: finished.error,
        fit: finished.fit,
        anneal: finished.anneal,
        peaks: finished.peaks,
    })
}

impl AchievedError {
    /// Whether the distance is known to be at most `limit`, as far as it is known.
    #[must_use]
    pub fn is_within(&self, limit: f64) -> bool {
        self.upper.unwrap_or(self.lower) <= limit
    }
}

fn check_options(options: &Options) -> Result<(), SimplifyError> {
    let check = |option, value: Option<f64>, fits: fn(f64) -> bool, expected| match value {
        Some(value) if !fits(value) => Err(SimplifyError::Option { option, value, expected }),
        _ => Ok(()),
    };
    let positive = |x: f64| x > 0.0 && x.is_finite();
    let not_negative = |x: f64| x >= 0.0 && x.is_finite();
    check("ratio", options.limits.ratio, |x| (0.0..=1.0).contains(&x), "between 0 and 1")?;
    check("cost limit", options.limits.cost, |x| x >= 0.0, "a number that is not negative")?;
    check("max_error", options.max_error, positive, "positive and finite")?;
    check(
        "curvature_weight",
        Some(options.curvature_weight),
        not_negative,
        "at least 0 and finite",
    )?;
    check(
        "attribute_weight",
        Some(options.attribute_weight),
        not_negative,
        "at least 0 and finite",
    )?;
    check("min_cosine", options.min_cosine, |x| (-1.0..=1.0).contains(&x), "between -1 and 1")?;
    check("min_shape", options.min_shape, |x| (0.0..=1.0).contains(&x), "between 0 and 1")?;
    check("fit pull", options.fit.map(|f| f.pull), not_negative, "at least 0 and finite")
}

fn check_positions(mesh: &TriMesh) -> Result<(), SimplifyError> {
    let mut used = mesh.topology().vertices().map(|v| (v, mesh.position(v)));
    match used.find(|(_, position)| !position.is_finite()) {
        Some((vertex, position)) => Err(SimplifyError::NotFinite { vertex, position }),
        None => Ok(()),
    }
}

/// Runs the driver with the policies that the options name.
pub(crate) fn collapse(
    mesh: &mut TriMesh,
    options: &Options,
    limits: &Limits,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let job = Job { mesh, options, limits, texture: None, observe };
    match options.metric {
        Metric::Classic => job.with_factor(GarlandHeckbert::new()),
        Metric::Marginal => job.with_factor(GarlandHeckbert::marginal()),
        Metric::Memoryless => job.with_factor(Memoryless),
        Metric::Hybrid => job.with_factor(Hybrid::default()),
        Metric::CurvatureL1 => job.with_placement(CurvatureNorm::new(Norm::L1)),
        Metric::CurvatureL2 => job.with_placement(CurvatureNorm::new(Norm::L2)),
    }
}

/// A run whose policies are being chosen.
struct Job<'a> {
    mesh: &'a mut TriMesh,
    options: &'a Options,
    limits: &'a Limits,
    /// Set along with a cost that looks at attributes.
    texture: Option<TextureGuard>,
    observe: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
}

impl Job<'_> {
    fn with_factor(self, cost: impl Cost + 'static) -> Run {
        let weight = self.options.curvature_weight;
        if weight > 0.0 {
            self.with_attributes(CurvatureFactor::new(cost, weight))
        } else {
            self.with_attributes(cost)
        }
    }

    fn with_attributes(mut self, cost: impl Cost + 'static) -> Run {
        let weight = self.options.attribute_weight;
        let given = self.options.attributes.as_ref().filter(|_| weight > 0.0);
        let Some(attributes) = given else { return self.with_placement(cost) };
        let shared = Rc::new(RefCell::new(attributes.clone()));
        self.texture = Some(TextureGuard::new(Rc::clone(&shared)));
        self.with_placement(AttributeDeviation::new(Box::new(cost), weight, shared))
    }

    fn with_placement(self, cost: impl Cost) -> Run {
        match self.options.placement {
            PlacementRule::OptimalVolume => self.run(cost, Optimal { keep_volume: true }),
            PlacementRule::Optimal => self.run(cost, Optimal { keep_volume: false }),
            PlacementRule::Endpoint => self.run(cost, BestEndpoint),
            PlacementRule::Midpoint => self.run(cost, Midpoint),
            PlacementRule::Butterfly => self.run(cost, ButterflyPoint),
        }
    }

    fn run(self, cost: impl Cost, placement: impl Placement) -> Run {
        let Self { mesh, options, limits, texture, observe } = self;
        let mut guards: Vec<Box<dyn Guard>> = Vec::new();
        if let Some(min_vertices) = options.min_component_vertices {
            guards.push(Box::new(ComponentGuard::new(min_vertices)));
        }
        if let Some(min_cosine) = options.min_cosine {
            guards.push(Box::new(NormalGuard { min_cosine }));
        }
        if let Some(min_shape) = options.min_shape {
            guards.push(Box::new(ShapeGuard { min_shape }));
        }
        if let Some(guard) = texture {
            guards.push(Box::new(guard));
        }
        // The most expensive check comes last.
        if options.forbid_intersections {
            guards.push(Box::new(IntersectionGuard::default()));
        }
        let policies = Policies { cost, placement, guards, update: options.update };
        collapse_edges(mesh, policies, &options.constraints, limits, observe)
    }
}

/// The largest distance of a boundary vertex of one mesh to the boundary of another.
fn boundary_shift(from: &TriMesh, to: &TriMesh) -> Option<f64> {
    let topology = from.topology();
    let vertices = topology.vertices().filter(|&v| topology.is_boundary_vertex(v));
    let points: Vec<DVec3> = vertices.map(|v| from.position(v)).collect();
    Curve::boundary(to)?.farthest(&points)
}
