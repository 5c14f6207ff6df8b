//! Simplification from options to result: collapses, error limit, fit.

use core::ops::ControlFlow;
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use glam::DVec3;
use mesh_core::{Remap, RemapOf, TriMesh, VertexId, VertexMap};
use mesh_metric::{
    CertifyOptions, CompareOptions, Surface, SurfaceError, compare, hausdorff_bounds,
};

use crate::anneal::{AnnealOptions, AnnealReport, anneal};
use crate::constraint::Boundary;
use crate::cost::{
    AttributeDeviation, Cost, CurvatureFactor, CurvatureNorm, GarlandHeckbert, Hybrid, Memoryless,
    Norm,
};
use crate::curve::Curve;
use crate::driver::{Policies, Progress, Run, collapse_edges};
use crate::fit::{FitConstraints, FitOptions, FitReport, fit};
use crate::guard::{
    ComponentGuard, Guard, IntersectionGuard, NormalGuard, Refusals, ShapeGuard, TextureGuard,
};
use crate::log::CollapseLog;
use crate::options::{ErrorCheck, Metric, Options, PlacementRule};
use crate::placement::{BestEndpoint, ButterflyPoint, Midpoint, Optimal, Placement};
use crate::stop::{Limits, StopReason};
use crate::texture_fit::{TextureCheck, fit_unfolded};

/// A simplified mesh and how it came about.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// The mesh, without gaps.
    pub mesh: TriMesh,
    /// For each vertex of the original, the vertex of the result that it has become; `None` where
    /// the original had a removed vertex.
    pub vertex_map: VertexMap<Option<VertexId>>,
    /// Every collapse, before fitting.
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
    /// What fitting did; `None` when there was none, or when it was undone because it exceeded the
    /// largest allowed error.
    pub fit: Option<FitReport>,
    /// What annealing did; `None` as for `fit`, and when it was undone because it folded the
    /// texture.
    pub anneal: Option<AnnealReport>,
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
/// # let triangles: Vec<[u32; 3]> = soup.faces().filter_map(|f| f.try_into().ok()).collect();
/// # let mesh = TriMesh::from_triangles(soup.positions(), &triangles)?;
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
    let wants_fit = options.fit.filter(|_| !is_cancelled && !run.log.is_empty());
    let wants_error = options.max_error.is_some() || options.error != ErrorCheck::None;
    let has_faces = mesh.topology().face_count() > 0;
    let original = match has_faces && (wants_error || wants_fit.is_some()) {
        true => Some(Surface::new(mesh)?),
        false => None,
    };
    let mut remap = working.compact();
    let mut error = None;
    if let (Some(original), true) = (&original, wants_error) {
        let within = match options.max_error {
            Some(limit) => restrict(mesh, original, options, limit, &run.log)?,
            None => run.log.len(),
        };
        if within < run.log.len() {
            working = mesh.clone();
            let limits = Limits { collapses: Some(within), ..options.limits };
            run = collapse(&mut working, options, &limits, observe);
            run.stop = StopReason::Error;
            remap = working.compact();
        }
        error = Some(measure(original, &working, options)?);
    }
    let base_map = vertex_map(mesh, &run.log, &remap);
    let mut finish = Finish { mesh: working, fit: None, anneal: None };
    if let (Some(original), Some(fit_options)) = (&original, wants_fit) {
        let constraints = FitConstraints {
            fixed: run.locked.as_ref().map(|locked| locked.compact(&remap)),
            features: run.features.as_ref().map(|features| features.compact(&remap)),
            boundary_curve: boundary_to_slide_on(mesh, options.constraints.boundary),
            feature_curve: options.constraints.features.as_ref().and_then(|features| {
                let is_feature = |e| features.get(e).is_some_and(|&feature| feature);
                Curve::of_edges(mesh, is_feature).map(Arc::new)
            }),
        };
        let fit_options = FitOptions {
            forbid_intersections: fit_options.forbid_intersections || options.forbid_intersections,
            ..fit_options
        };
        let texture = texture_check(mesh, options, &base_map);
        let closer = finish.fitted(
            original,
            &constraints,
            &fit_options,
            options.anneal,
            texture.as_ref(),
        )?;
        let check = match wants_error {
            true => Some(measure(original, &closer.mesh, options)?),
            false => None,
        };
        let allowed = options.max_error.zip(check).is_none_or(|(limit, e)| e.is_within(limit));
        if allowed {
            (finish, error) = (closer, check);
        }
    }
    let Finish { mesh: finished, fit, anneal } = finish;
    let mut vertex_map = base_map;
    if let Some(report) = &anneal {
        for new in vertex_map.as_mut_slice() {
            *new = new.and_then(|v| report.vertex_map.get(v).copied().flatten());
        }
    }
    Ok(Simplified {
        vertex_map,
        boundary_shift: boundary_shift(mesh, &finished),
        mesh: finished,
        log: run.log,
        stop: run.stop,
        refusals: run.refusals,
        max_cost: run.max_cost,
        error,
        fit,
        anneal,
    })
}

/// A mesh after the collapses, and what was done with it since.
struct Finish {
    mesh: TriMesh,
    fit: Option<FitReport>,
    anneal: Option<AnnealReport>,
}

impl Finish {
    fn fitted(
        &self,
        original: &Surface,
        constraints: &FitConstraints,
        options: &FitOptions,
        then: Option<AnnealOptions>,
        texture: Option<&TextureCheck<'_>>,
    ) -> Result<Self, SimplifyError> {
        let mut mesh = self.mesh.clone();
        let report = match texture {
            Some(check) => fit_unfolded(&mut mesh, original, constraints, options, check)?,
            None => fit(&mut mesh, original, constraints, options)?,
        };
        let anneal = match then {
            Some(then) => {
                let forbid_intersections = options.forbid_intersections;
                let fit = FitOptions { forbid_intersections, ..then.fit };
                let then = AnnealOptions { fit, ..then };
                let fitted = mesh.clone();
                let report = anneal(&mut mesh, original, constraints, &then)?;
                let folds = texture.is_some_and(|check| check.folds_more(&mesh, &fitted, &report));
                if folds {
                    mesh = fitted;
                }
                (!folds).then_some(report)
            }
            None => None,
        };
        Ok(Self { mesh, fit: Some(report), anneal })
    }
}

/// What keeps a fit from folding the texture, if there is one that counts.
fn texture_check<'a>(
    mesh: &'a TriMesh,
    options: &'a Options,
    became: &'a VertexMap<Option<VertexId>>,
) -> Option<TextureCheck<'a>> {
    let attributes = options.attributes.as_ref().filter(|a| a.has_texture())?;
    let seams = options.constraints.features.as_ref()?;
    let counts = options.attribute_weight > 0.0;
    counts.then_some(TextureCheck { original: mesh, attributes, seams, became })
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
fn collapse(
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

/// How many of the collapses may be carried out for the result to be within the limit, by
/// bisection of the log.
fn restrict(
    mesh: &TriMesh,
    original: &Surface,
    options: &Options,
    limit: f64,
    log: &CollapseLog,
) -> Result<usize, SimplifyError> {
    let is_within = |count: usize| -> Result<bool, SimplifyError> {
        // The log is of this very mesh, so that it can be replayed.
        let Ok(mut level) = log.replay(mesh, count) else { return Ok(false) };
        level.compact();
        Ok(measure(original, &level, options)?.is_within(limit))
    };
    let (mut good, mut bad) = (0, log.len());
    if is_within(bad)? {
        return Ok(bad);
    }
    let vertices = mesh.topology().vertex_count();
    while bad - good > 1 + (vertices - good) / 200 {
        // In between as a ratio: errors grow with the size of the faces.
        let middle = vertices as f64 - (((vertices - good) * (vertices - bad)) as f64).sqrt();
        let middle = (middle as usize).clamp(good + 1, bad - 1);
        if is_within(middle)? {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Ok(good)
}

/// How many of the collapses of a run may be carried out for the result to be within a distance of
/// the mesh that the run was made on, both ways, up to half a percent of the vertices.
///
/// # Errors
/// The mesh has no faces.
pub fn collapses_within(
    mesh: &TriMesh,
    log: &CollapseLog,
    max_error: f64,
    error: ErrorCheck,
) -> Result<usize, SimplifyError> {
    let options = Options { max_error: Some(max_error), error, ..Options::default() };
    restrict(mesh, &Surface::new(mesh)?, &options, max_error, log)
}

fn measure(
    original: &Surface,
    mesh: &TriMesh,
    options: &Options,
) -> Result<AchievedError, SimplifyError> {
    let surface = Surface::new(mesh)?;
    if options.error == ErrorCheck::Certified {
        let size = original.bounding_box().diagonal();
        let tolerance = options.max_error.map_or(1e-4 * size, |limit| 0.01 * limit);
        let certify = CertifyOptions { tolerance, limit: options.max_error, ..Default::default() };
        let bounds = hausdorff_bounds(original, &surface, &certify);
        Ok(AchievedError { lower: bounds.lower, upper: Some(bounds.upper) })
    } else {
        let samples = CompareOptions { samples: 200_000, ..CompareOptions::default() };
        let lower = compare(original, &surface, &samples).hausdorff();
        Ok(AchievedError { lower, upper: None })
    }
}

fn vertex_map(mesh: &TriMesh, log: &CollapseLog, remap: &Remap) -> VertexMap<Option<VertexId>> {
    let representatives = log.representatives(mesh, log.len());
    let new = representatives.as_slice().iter().map(|&v| remap.new_handle(v)).collect();
    VertexMap::from_vec(new)
}

/// The largest distance of a boundary vertex of one mesh to the boundary of another.
fn boundary_shift(from: &TriMesh, to: &TriMesh) -> Option<f64> {
    let topology = from.topology();
    let vertices = topology.vertices().filter(|&v| topology.is_boundary_vertex(v));
    let points: Vec<DVec3> = vertices.map(|v| from.position(v)).collect();
    Curve::boundary(to)?.farthest(&points)
}

/// The curve for boundary vertices while fitting, unless the boundary is locked.
fn boundary_to_slide_on(mesh: &TriMesh, boundary: Boundary) -> Option<Arc<Curve>> {
    match boundary {
        Boundary::Lock => None,
        Boundary::Quadrics | Boundary::Free => Curve::boundary(mesh).map(Arc::new),
    }
}
