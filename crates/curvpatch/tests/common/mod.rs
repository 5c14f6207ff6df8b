//! Meshes and statistics for several tests.
#![allow(unreachable_pub, clippy::unwrap_used)]

use curvpatch::{CurvatureEstimator, DiscCurvature, DiscSize, Params};
use mesh_core::{FaceId, Handle, PolygonSoup, TriMesh};
use mesh_shapes::{AnalyticSurface, Cylinder, Diagonals, RowPhase, Saddle, Sphere, Torus};

pub fn mesh(soup: &PolygonSoup) -> TriMesh {
    TriMesh::from_soup(soup).unwrap()
}

pub const CYLINDER: Cylinder = Cylinder { radius: 1.0, height: 4.0 };
pub const SADDLE: Saddle = Saddle { coefficient: 0.5, half_width: 1.0 };
pub const TORUS: Torus = Torus { major: 2.0, minor: 1.0 };

pub fn bare_half_cylinder() -> TriMesh {
    mesh(&Cylinder { radius: 1.0, height: 6.0 }.half_with_bare_sides(24).unwrap())
}

pub fn cylinder(sectors: usize, rows: usize, phase: RowPhase) -> TriMesh {
    mesh(&CYLINDER.mesh(rows, sectors, phase).unwrap())
}

pub fn saddle(cells: usize) -> TriMesh {
    mesh(&SADDLE.mesh(cells, Diagonals::Alternating).unwrap())
}

pub fn torus(rings: usize, sides: usize) -> TriMesh {
    mesh(&TORUS.mesh(rings, sides).unwrap())
}

pub fn icosphere(level: u32) -> TriMesh {
    mesh(&Sphere::UNIT.icosphere(level).unwrap())
}

pub fn uv_sphere(bands: usize, sectors: usize) -> TriMesh {
    mesh(&Sphere::UNIT.uv_mesh(bands, sectors).unwrap())
}

pub fn mean_edge(mesh: &TriMesh) -> f64 {
    let topology = mesh.topology();
    let length = |[a, b]: [_; 2]| mesh.position(a).distance(mesh.position(b));
    topology.edges().map(|e| length(topology.edge_vertices(e))).sum::<f64>()
        / topology.edge_count() as f64
}

/// About this many faces, evenly spaced by index. The reference statistics use the same faces.
pub fn sample(mesh: &TriMesh, about: usize) -> impl Iterator<Item = FaceId> + Clone {
    let count = mesh.topology().face_count();
    (0..count).step_by((count / about).max(1)).map(FaceId::from_index)
}

/// The 50th and the 95th percentile, with linear interpolation between neighbours.
pub fn percentiles(mut values: Vec<f64>) -> [f64; 2] {
    assert!(!values.is_empty());
    values.sort_by(f64::total_cmp);
    [0.5, 0.95].map(|p| {
        let at = p * (values.len() - 1) as f64;
        let (low, share) = (at.floor() as usize, at.fract());
        let high = (low + 1).min(values.len() - 1);
        values[low] + share * (values[high] - values[low])
    })
}

/// Curvature errors of a sample of faces.
pub struct Accuracy {
    /// Median and 95th percentile of the larger error of the two principal curvatures over the
    /// largest exact curvature, in percent.
    pub curvature: [f64; 2],
    /// Median and 95th percentile of the error of the directions, in degrees; `None` at umbilics.
    pub direction: Option<[f64; 2]>,
    pub samples: usize,
}

/// Errors of the sampled faces that `keep` accepts and whose disc is not truncated.
pub fn accuracy(
    mesh: &TriMesh,
    surface: &dyn AnalyticSurface,
    params: Params,
    size: impl Into<DiscSize>,
    keep: impl Fn(&DiscCurvature) -> bool,
) -> Accuracy {
    let estimator = CurvatureEstimator::new(mesh, params).unwrap();
    let mut errors = Vec::new();
    let mut angles = Vec::new();
    let size = size.into();
    for face in sample(mesh, 300) {
        let disc = estimator.at(face, size).unwrap();
        if disc.truncated || !keep(&disc) {
            continue;
        }
        let exact = surface.principal_curvatures(disc.center);
        let [max, min] = disc.curvatures;
        assert!(max >= min);
        let scale = exact.max.abs().max(exact.min.abs());
        errors.push(100.0 * (max - exact.max).abs().max((min - exact.min).abs()) / scale);
        if let Some([of_max, of_min]) = exact.directions {
            let first = if exact.max.abs() >= exact.min.abs() { of_max } else { of_min };
            // Measured in the tangent plane of the estimate, so that the tilt of its normal does not count.
            // On a saddle the two directions can be exchanged; the angle to the nearer one counts.
            let [x, y] = [disc.frame[0], disc.frame[1]].map(|axis| axis.dot(first));
            let off = y.abs().atan2(x.abs()).to_degrees();
            angles.push(off.min(90.0 - off));
        }
    }
    let samples = errors.len();
    let direction = (!angles.is_empty()).then(|| percentiles(angles));
    Accuracy { curvature: percentiles(errors), direction, samples }
}

/// The axes of a disc in the order of SN10: the curvature with the larger absolute value first.
pub fn sn10_order(disc: &DiscCurvature) -> [usize; 2] {
    let [k1, k2] = disc.curvatures.map(f64::abs);
    if k1 >= k2 { [0, 1] } else { [1, 0] }
}

/// The part of the saddle away from its boundary.
pub fn inner(disc: &DiscCurvature) -> bool {
    disc.center.x.abs() < 0.45 && disc.center.y.abs() < 0.45
}
