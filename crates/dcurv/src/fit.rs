//! Curvature of polynomial surfaces fitted to the points around each vertex.
//!
//! The estimator for values at points. The height function over the tangent plane is fitted to points around the
//! vertex by least squares (the jets of Cazals and Pouget 2005, Estimating differential quantities using polynomial
//! fitting of osculating jets). The principal curvatures and directions are the eigenvalues and eigenvectors of its
//! shape operator at the vertex. [`FitScale`] says which points are fitted, and with which weights.
//!
//! **Scale.** Larger neighbourhoods average noise out, and miss details. Four ways to choose:
//!
//! | scale | fitted | for |
//! |---|---|---|
//! | [`FitScale::Nearest`] | three rings, weight `1/distance^8`, through the vertex, degree 2 to 4 | meshes without noise: CAD, models of surfaces |
//! | [`FitScale::Noise`] | the same, or a smoothing fit of a radius that is chosen per vertex | scans |
//! | [`FitScale::Radius`] | a smoothing fit of degree 2 to 4 of this radius | details of a given size |
//! | [`FitScale::Rings`] | all points of this number of rings with equal weights, degree 2 | comparison with other programs |
//!
//! The weight `1/distance^8` lets near points decide what they can: across a pipe with triangles fifty times longer
//! than wide, only the neighbours in the same section do. With `Noise`, the fit is chosen by Lepski's method: the one
//! with the least noise that agrees with all noisier fits. Fits are compared by the covariance of their second
//! derivatives, because long triangles may determine one curvature much better than the other. The noise of a mesh is
//! estimated by [`estimate_noise`](crate::estimate_noise).
//!
//! **Coordinates.** Points lie in the direction of their projection to the tangent plane, at their own distance from
//! the vertex. So a sphere is a quadratic surface, `z = d²/2R`, and spheres and circular sections have no error, however
//! coarse they are. The tangent plane is found by a first fit.
//!
//! **Convergence.** With points no farther than `h`, the error of a fit of degree `p` is `O(h^(p-1))` at every vertex.
//! With `Rings` it is `O(h)` with a constant that grows with the length of the triangles: the ratio of the longest to
//! the shortest edge at a vertex should not exceed about 5. With `Nearest`, on the torus of radii 5 and 0.4 with 24 by
//! 48 vertices (ratio 25), 95 % of the errors of `k1` are below 0.1 %.
//!
//! **Error.** [`FittedCurvature::error`] bounds the error of both principal curvatures at 90 % of the vertices of
//! surfaces with known curvature. It combines the residuals, the noise, and the differences between fits.
//!
//! **Boundary.** Neighbourhoods at the boundary are cut off, and the fit is one-sided, with a larger error. Where
//! the rings have too few points, as at corners, further rings are added until there are enough points or the
//! connected component has no more.
//!
//! **Cost.** The time is proportional to the number of points: about 18 for two rings, 36 for three. At vertices with
//! very many edges the number of points is limited to [`JetFitOptions::most_points`], so that no mesh takes quadratic
//! time.

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, VertexMap};

use crate::height_points::Neighbourhood;
use crate::jet_fit::{JetFit, JetSolver};
use crate::principal::{PrincipalFrame, TangentFrame, fit_frame};
use crate::quantity::Pointwise;
use crate::scale_choice::{Candidate, choose, least_error};
use crate::vertex_loop::of_vertices;

/// The smallest number of points of a fit, if the surface has enough: slightly more than the five unknowns.
pub const LEAST_POINTS: usize = 8;

/// Which points around a vertex are fitted, and with which weights; see the [module page](self).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum FitScale {
    /// The nearest points decide. For positions without noise.
    #[default]
    Nearest,
    /// The scale of each vertex follows from the standard deviation of the noise along the normal, in model units.
    /// 0 is [`FitScale::Nearest`].
    Noise(f64),
    /// A radius in model units, within which points have similar weights.
    Radius(f64),
    /// This number of rings of neighbours, at least 1, with equal weights.
    Rings(usize),
}

/// How surfaces are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct JetFitOptions {
    /// Which points are fitted, and with which weights. The nearest by default.
    pub scale: FitScale,
    /// No further points are added beyond the first ring once this number is reached. 320 by default.
    pub most_points: usize,
}

impl Default for JetFitOptions {
    fn default() -> Self {
        Self { scale: FitScale::Nearest, most_points: 320 }
    }
}

impl JetFitOptions {
    /// Equal weights for all points of this number of rings.
    #[must_use]
    pub fn rings(rings: usize) -> Self {
        Self { scale: FitScale::Rings(rings), ..Self::default() }
    }
}

/// The curvature of a surface fitted at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FittedCurvature {
    /// The principal curvatures and directions.
    pub frame: PrincipalFrame,
    /// The predicted error of both principal curvatures, per model unit; see the [module page](self). NaN if it is
    /// unknown, as with [`FitScale::Rings`].
    pub error: Pointwise,
    /// The degree of the polynomial: 2, 3 or 4.
    pub degree: u8,
    /// Number of points of the fit.
    pub points: u32,
}

/// The curvature of the surface fitted at a vertex; see the [module page](self).
///
/// `None` where the points do not determine a surface, or where the vertex has no normal: at isolated vertices, in
/// pieces of fewer than six vertices, in degenerate triangles, on curved strips of one row of faces.
///
/// # Panics
/// When the vertex is out of range for this mesh.
#[must_use]
pub fn fitted_curvature(
    mesh: &TriMesh,
    vertex: VertexId,
    options: &JetFitOptions,
) -> Option<FittedCurvature> {
    Fitter::new(mesh, None, *options).fit(vertex)
}

/// [`fitted_curvature`] of all vertices; `None` for removed ones, too.
///
/// ```
/// use dcurv::{JetFitOptions, fitted_curvatures};
/// use mesh_core::TriMesh;
/// use mesh_shapes::Sphere;
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let sphere = TriMesh::from_soup(&Sphere { radius: 2.0 }.icosphere(3)?)?;
/// for (_, fit) in fitted_curvatures(&sphere, &JetFitOptions::default()).iter() {
///     let frame = fit.ok_or("no fit")?.frame;
///     assert!((frame.mean().value() - 0.5).abs() < 1e-9);
///     assert!((frame.gaussian().value() - 0.25).abs() < 1e-9);
/// }
/// # Ok(())
/// # }
/// ```
#[must_use]
pub fn fitted_curvatures(
    mesh: &TriMesh,
    options: &JetFitOptions,
) -> VertexMap<Option<FittedCurvature>> {
    all_fits(mesh, options, &|| false)
}

/// As [`fitted_curvatures`], until `stops` returns true; then `None`. Any thread calls `stops` before each vertex.
/// Once true, it must stay true.
#[must_use]
pub fn fitted_curvatures_until(
    mesh: &TriMesh,
    options: &JetFitOptions,
    stops: &(dyn Fn() -> bool + Sync),
) -> Option<VertexMap<Option<FittedCurvature>>> {
    let found = all_fits(mesh, options, stops);
    (!stops()).then_some(found)
}

/// `None` for the vertices after `stops` has returned true.
fn all_fits(
    mesh: &TriMesh,
    options: &JetFitOptions,
    stops: &(dyn Fn() -> bool + Sync),
) -> VertexMap<Option<FittedCurvature>> {
    let normals = mesh.vertex_normals();
    let fitter = || Fitter::new(mesh, Some(normals.as_slice()), *options);
    of_vertices(mesh, stops, fitter, Fitter::fit)
}

/// Fits surfaces, with the memory for it.
struct Fitter<'a> {
    mesh: &'a TriMesh,
    options: JetFitOptions,
    rings: Rings,
    near: Neighbourhood<'a>,
    solver: JetSolver,
    fits: Vec<JetFit>,
    candidates: Vec<Candidate>,
}

impl<'a> Fitter<'a> {
    /// Rings of the fits through the vertex: 36 points for 14 unknowns.
    const RINGS: usize = 3;
    /// The number of points below which further rings are added.
    const LEAST: usize = 20;
    /// The square of this slope is below the rounding of double precision.
    const LEAST_SLOPE: f64 = 1e-8;
    /// The largest slope of a fit that is compared with others, against a tangent plane that more points determine.
    const MOST_SLOPE: f64 = 1.0;

    /// The smallest cosine of the angle between the normal of a fit to a strip and the normal of the vertex. Two rows of
    /// points do not determine the curvature across them: both circles of a cylinder lie on a sphere as well.
    const LEAST_STRIP_COSINE: f64 = 0.999_999;

    fn new(mesh: &'a TriMesh, normals: Option<&'a [DVec3]>, options: JetFitOptions) -> Self {
        Self {
            mesh,
            options,
            rings: Rings::new(mesh),
            near: Neighbourhood::new(mesh, normals),
            solver: JetSolver::default(),
            fits: Vec::new(),
            candidates: Vec::new(),
        }
    }

    fn fit(&mut self, vertex: VertexId) -> Option<FittedCurvature> {
        let topology = self.mesh.topology();
        if !topology.contains_vertex(vertex) || topology.is_isolated_vertex(vertex) {
            return None;
        }
        match self.options.scale {
            FitScale::Rings(rings) => {
                let most_points = self.options.most_points;
                self.rings.fit(self.mesh, vertex, rings, most_points)
            }
            FitScale::Nearest => self.nearest(vertex, 0.0),
            FitScale::Noise(noise) => self.nearest(vertex, noise.max(0.0)),
            FitScale::Radius(radius) => self.within(vertex, radius),
        }
    }

    fn collect(&mut self, vertex: VertexId, radius: f64) {
        let most = self.options.most_points.max(LEAST_POINTS);
        self.near.collect(vertex, Self::RINGS, Self::LEAST, radius, most);
    }

    /// A smoothing fit of given radius. The degree is the largest one whose noise is at most three times that of the
    /// quadratic fit.
    fn within(&mut self, vertex: VertexId, radius: f64) -> Option<FittedCurvature> {
        self.collect(vertex, 1.5 * radius);
        let tangent = self.smooth_tangent(vertex, radius)?;
        self.fits.clear();
        self.solver.smoothing(&self.near.points, radius, &mut self.fits);
        let quadratic = self.fits.first()?.noise.total();
        let is_stable = |fit: &&JetFit| fit.noise.total() <= 9.0 * quadratic;
        let fit = *self.fits.iter().rev().find(is_stable)?;
        // Fits of other degrees show the error of the model.
        let others = self.fits.iter().filter_map(|other| Candidate::new(*other, 1.0));
        let chosen = Candidate::new(fit, 1.0)?;
        let error = others.map(|other| chosen.distance(&other)).fold(0.0, f64::max);
        let error = if self.fits.len() > 1 { error } else { f64::NAN };
        FittedCurvature::new(&fit, &tangent, error)
    }

    /// The tangent plane of a smoothing fit. Leaves the points over it.
    fn smooth_tangent(&mut self, vertex: VertexId, radius: f64) -> Option<TangentFrame> {
        let mut tangent = TangentFrame::of(self.near.normal(vertex))?;
        for _ in 0..2 {
            self.near.heights(&tangent);
            self.fits.clear();
            let radius = if radius > 0.0 { radius } else { self.near.reach() };
            self.solver.smoothing(&self.near.points, radius, &mut self.fits);
            let Some(fit) = self.fits.first() else { break };
            tangent = tangent.tilted(&fit.jet)?;
        }
        self.near.heights(&tangent);
        Some(tangent)
    }

    /// A fit through the vertex. If its noise is not small, a smoothing fit is tried, and the fit with the smaller
    /// predicted error is returned.
    fn nearest(&mut self, vertex: VertexId, noise: f64) -> Option<FittedCurvature> {
        self.collect(vertex, 0.0);
        let mut tangent = TangentFrame::of(self.near.normal(vertex))?;
        let rounding = f64::EPSILON * self.mesh.position(vertex).abs().max_element();
        let mut best = None;
        for _ in 0..4 {
            self.near.heights(&tangent);
            self.fit_through_vertex(noise.max(rounding));
            let Some(found) = least_error(&self.candidates) else { break };
            best = Some((found, tangent));
            if found.noise > 4.0 * Self::least_noise(&found) {
                break;
            }
            let jet = found.fit.jet;
            let slope = jet.px.abs() + jet.py.abs();
            // The error by a slope is its square.
            if slope < Self::LEAST_SLOPE || slope * slope * found.size() < 0.1 * found.error() {
                break;
            }
            tangent = tangent.tilted(&jet)?;
        }
        let exact = best
            .and_then(|(found, tangent)| FittedCurvature::new(&found.fit, &tangent, found.error()));
        let normal = self.near.normal(vertex);
        let is_tilted =
            exact.is_some_and(|fit| fit.frame.normal.dot(normal) < Self::LEAST_STRIP_COSINE);
        if is_tilted && self.near.is_strip() {
            return None;
        }
        if let Some((found, _)) = best
            && found.noise <= Self::least_noise(&found)
        {
            return exact;
        }
        let smoothed = if noise > 0.0 { self.smoothed(vertex, noise) } else { None };
        let error = |fit: &FittedCurvature| fit.error.value();
        exact.into_iter().chain(smoothed).min_by(|a, b| error(a).total_cmp(&error(b)))
    }

    /// The noise of a fit through the vertex above which smoothing may have less error. A model error that is not small
    /// beside the curvature may be noise, too.
    fn least_noise(found: &Candidate) -> f64 {
        (0.6 * found.model_error()).min(0.05 * found.size()).max(1e-4 * found.size())
    }

    /// Fits through the vertex as the candidates.
    fn fit_through_vertex(&mut self, noise: f64) {
        self.solver.through_vertex(&self.near.points, &mut self.fits);
        self.candidates.clear();
        self.candidates.extend(self.fits.iter().filter_map(|&fit| Candidate::new(fit, noise)));
    }

    /// The choice among smoothing fits of growing radius and fits through the vertex.
    fn smoothed(&mut self, vertex: VertexId, noise: f64) -> Option<FittedCurvature> {
        /// The ratio of subsequent radii.
        const STEP: f64 = 1.7;
        let tangent = self.smooth_tangent(vertex, 0.0)?;
        self.fit_through_vertex(noise);
        self.candidates.retain(|fit| fit.slope() < Self::MOST_SLOPE);
        let most = self.options.most_points;
        let mut radius = STEP * self.near.points.first()?.at.length();
        // Rings reach far along long triangles, and not far across them.
        let mut collected = 0.0;
        loop {
            if collected < 1.5 * radius && self.near.points.len() < most {
                collected = 1.8 * radius;
                self.collect(vertex, collected);
                self.near.heights(&tangent);
            }
            self.fits.clear();
            self.solver.smoothing(&self.near.points, radius, &mut self.fits);
            let known = self.candidates.len();
            let new = self.fits.iter().filter_map(|&fit| Candidate::new(fit, noise));
            self.candidates.extend(new.filter(|fit| fit.slope() < Self::MOST_SLOPE));
            let (noisier, new) = self.candidates.split_at(known);
            let is_done = !new.is_empty() && !new.iter().any(|fit| fit.agrees(noisier));
            if self.near.reach() < radius || is_done {
                break;
            }
            radius *= STEP;
        }
        let choice = choose(&mut self.candidates)?;
        FittedCurvature::new(&choice.fit, &tangent, choice.error)
    }
}

impl FittedCurvature {
    /// `None` if the curvatures overflow.
    fn new(fit: &JetFit, tangent: &TangentFrame, error: f64) -> Option<Self> {
        let frame = fit.jet.frame(tangent, 1.0);
        let is_finite = [frame.k_max, frame.k_min].iter().all(|k| k.value().is_finite())
            && frame.normal.is_finite()
            && frame.direction_max.is_finite();
        is_finite.then(|| Self {
            frame,
            error: Pointwise::new(error),
            degree: fit.degree,
            points: u32::try_from(fit.points).unwrap_or(u32::MAX),
        })
    }
}

/// Memory for the rings around a vertex.
struct Rings {
    /// One more than the index of the last vertex whose rings contained this vertex.
    seen_from: Vec<u32>,
    /// The points, ring after ring.
    points: Vec<VertexId>,
}

impl Rings {
    fn new(mesh: &TriMesh) -> Self {
        Self { seen_from: vec![0; mesh.topology().vertex_capacity()], points: Vec::new() }
    }

    fn fit(
        &mut self,
        mesh: &TriMesh,
        vertex: VertexId,
        rings: usize,
        most_points: usize,
    ) -> Option<FittedCurvature> {
        self.collect(mesh, vertex, rings, most_points);
        let origin = mesh.position(vertex);
        let distances = self.points.iter().map(|&v| mesh.position(v).distance(origin));
        let scale = distances.fold(0.0, f64::max);
        let frame = fit_frame(mesh, vertex, scale, |add| self.points.iter().for_each(|&v| add(v)))?;
        let points = u32::try_from(self.points.len()).unwrap_or(u32::MAX);
        Some(FittedCurvature { frame, error: Pointwise::new(f64::NAN), degree: 2, points })
    }

    /// Collects the vertices of the rings around a vertex.
    fn collect(&mut self, mesh: &TriMesh, vertex: VertexId, rings: usize, most_points: usize) {
        let topology = mesh.topology();
        let mark = vertex.get() + 1;
        self.seen_from[vertex.index()] = mark;
        self.points.clear();
        self.points.extend(topology.one_ring(vertex));
        self.points.iter().for_each(|v| self.seen_from[v.index()] = mark);
        let (mut ring, mut start) = (1, 0);
        while ring < rings || self.points.len() < LEAST_POINTS {
            let end = self.points.len();
            for i in start..end {
                for neighbour in topology.one_ring(self.points[i]) {
                    if self.points.len() >= most_points.max(LEAST_POINTS) {
                        return;
                    }
                    let seen = &mut self.seen_from[neighbour.index()];
                    if *seen != mark {
                        *seen = mark;
                        self.points.push(neighbour);
                    }
                }
            }
            if self.points.len() == end {
                return;
            }
            (ring, start) = (ring + 1, end);
        }
    }
}
