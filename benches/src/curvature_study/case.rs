//! Meshes with the truth at their vertices, and our estimates.

use curvpatch::{CurvatureEstimator, Params};
use dcurv::{
    CurvatureOptions, Curvatures, FitScale, FittedCurvature, JetFitOptions, PrincipalFrame,
    ball_curvatures, corrected_curvatures, estimate_noise, fitted_curvatures,
};
use glam::DVec3;
use mesh_core::{PolygonSoup, TriMesh, VertexId, VertexMap};
use mesh_shapes::{add_normal_noise, mean_edge_length};
use xtask_common::Failure;

use super::row::{Key, Ours, Row};
use super::sampling::Sampled;
use super::surfaces::Exact;

/// What a program says of a vertex. NaN where it says nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub(super) principal: [f64; 2],
    pub(super) direction: DVec3,
    pub(super) normal: DVec3,
    pub(super) error: f64,
}

impl Estimate {
    pub(super) const UNKNOWN: Self = Self {
        principal: [f64::NAN; 2],
        direction: DVec3::NAN,
        normal: DVec3::NAN,
        error: f64::NAN,
    };

    fn of_frame(frame: &PrincipalFrame, error: f64) -> Self {
        Self {
            principal: [frame.k_max.value(), frame.k_min.value()],
            direction: frame.direction_max,
            normal: frame.normal,
            error,
        }
    }
}

/// A mesh with the truth at its vertices.
pub(super) struct Case {
    pub(super) mesh: TriMesh,
    pub(super) exact: Vec<Exact>,
    pub(super) edge: f64,
}

impl Case {
    pub(super) fn new(sampled: Sampled, noise: f64) -> Result<(Self, PolygonSoup), Failure> {
        let Sampled { mut soup, exact } = sampled;
        if noise > 0.0 {
            add_normal_noise(&mut soup, noise, 7);
        }
        soup.positions_mut().iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
        let mesh = TriMesh::from_soup(&soup).map_err(Failure::mesh)?;
        Ok((Self { mesh, exact, edge: mean_edge_length(&soup) }, soup))
    }

    /// The row of a program.
    pub(super) fn row(&self, key: Key, estimates: &[Estimate], seconds: f64) -> Row {
        let topology = self.mesh.topology();
        let larger = |exact: &Exact| exact.principal[0].abs().max(exact.principal[1].abs());
        let scale = self.exact.iter().map(larger).sum::<f64>() / self.exact.len() as f64;
        let mut errors: [Vec<f64>; 5] = Default::default();
        let (mut unknown, mut predicted, mut within, mut count) = (0, 0, 0, 0);
        for vertex in topology.vertices().filter(|&v| !topology.is_boundary_vertex(v)) {
            let (estimate, exact) = (&estimates[vertex.index()], &self.exact[vertex.index()]);
            count += 1;
            let ([k1, k2], [e1, e2]) = (estimate.principal, exact.principal);
            if k1.is_nan() || k2.is_nan() {
                unknown += 1;
                continue;
            }
            let error = (k1 - e1).abs().max((k2 - e2).abs());
            errors[0].push(error / scale);
            errors[1].push((0.5 * (k1 + k2) - 0.5 * (e1 + e2)).abs() / scale);
            errors[2].push((k1 * k2 - e1 * e2).abs() / (scale * scale));
            let angle = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b).abs()).to_degrees();
            if e1 - e2 > 0.2 * scale && estimate.direction.is_finite() {
                errors[3].push(angle(estimate.direction, exact.direction));
            }
            if estimate.normal.is_finite() {
                errors[4].push(angle(estimate.normal, exact.normal));
            }
            if estimate.error.is_finite() {
                predicted += 1;
                within += usize::from(error <= estimate.error);
            }
        }
        let rank = |values: &mut Vec<f64>, share: f64| {
            if values.is_empty() {
                return f64::NAN;
            }
            values.sort_by(f64::total_cmp);
            values[((values.len() - 1) as f64 * share) as usize]
        };
        let (surface, sampling, vertices, noise, program) = key;
        let share = |part: usize, all: usize| {
            if all == 0 { f64::NAN } else { part as f64 / all as f64 }
        };
        let [k, mean, gaussian, direction, normal] = &mut errors;
        Row {
            surface,
            sampling,
            vertices,
            noise: noise.parse().unwrap_or(f64::NAN),
            program,
            k_median: rank(k, 0.5),
            k_95: rank(k, 0.95),
            mean_median: rank(mean, 0.5),
            gaussian_median: rank(gaussian, 0.5),
            direction_median: rank(direction, 0.5),
            normal_median: rank(normal, 0.5),
            unknown: share(unknown, count),
            within: share(within, predicted),
            seconds,
        }
    }
}

impl Ours {
    pub(super) fn estimate(self, case: &Case) -> Result<Vec<Estimate>, Failure> {
        let Case { mesh, edge, .. } = case;
        let fitted = |scale| {
            let fits =
                fitted_curvatures(mesh, &JetFitOptions { scale, ..JetFitOptions::default() });
            let of = |fit: &Option<FittedCurvature>| match fit {
                Some(fit) => Estimate::of_frame(&fit.frame, fit.error.value()),
                None => Estimate::UNKNOWN,
            };
            fits.as_slice().iter().map(of).collect()
        };
        let of_ball = |frame: Option<PrincipalFrame>| {
            frame.map_or(Estimate::UNKNOWN, |frame| Estimate::of_frame(&frame, f64::NAN))
        };
        Ok(match self {
            Self::Auto => fitted(FitScale::Noise(estimate_noise(mesh))),
            Self::FitNearest => fitted(FitScale::Nearest),
            Self::Fit2Rings => fitted(FitScale::Rings(2)),
            Self::Fit3Edges => fitted(FitScale::Radius(3.0 * edge)),
            Self::Vertex => {
                let all = Curvatures::of(mesh, &CurvatureOptions::default());
                let of = |v: VertexId| Estimate {
                    principal: all[v].principal().map(dcurv::Pointwise::value),
                    ..Estimate::UNKNOWN
                };
                mesh.topology().vertices().map(of).collect()
            }
            Self::Ball4Edges => {
                let balls = ball_curvatures(mesh, 4.0 * edge).map_err(Failure::mesh)?;
                balls.as_slice().iter().map(|ball| of_ball(ball.principal())).collect()
            }
            Self::Corrected4Edges => {
                let balls = corrected_curvatures(mesh, 4.0 * edge).map_err(Failure::mesh)?;
                balls.as_slice().iter().map(|ball| of_ball(ball.principal())).collect()
            }
            Self::Face => of_faces(mesh)?,
        })
    }
}

/// Means of the curvatures of the faces around each vertex.
fn of_faces(mesh: &TriMesh) -> Result<Vec<Estimate>, Failure> {
    let estimator = CurvatureEstimator::new(mesh, Params::default()).map_err(Failure::mesh)?;
    let discs = estimator.all_faces(estimator.default_size()).map_err(Failure::mesh)?;
    let mut sums: VertexMap<[f64; 3]> = mesh.topology().vertex_map([0.0; 3]);
    for face in mesh.topology().faces() {
        let Ok(disc) = &discs[face] else { continue };
        for vertex in mesh.topology().face_vertices(face) {
            let [k1, k2] = disc.curvatures;
            for (sum, value) in sums[vertex].iter_mut().zip([k1, k2, 1.0]) {
                *sum += value;
            }
        }
    }
    let of = |&[k1, k2, count]: &[f64; 3]| Estimate {
        principal: [k1 / count, k2 / count],
        ..Estimate::UNKNOWN
    };
    Ok(sums.as_slice().iter().map(of).collect())
}
