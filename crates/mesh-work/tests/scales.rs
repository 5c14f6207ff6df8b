//! Curvatures and patches of very small and very large meshes.
#![allow(clippy::unwrap_used)]

use curvpatch::{CoverOptions, CurvatureEstimator, Params, cover};
use dcurv::JetFitOptions;
use glam::DVec3;
use mesh_core::butterfly::ButterflyOptions;
use mesh_core::{PolygonSoup, Repair, TriMesh};
use mesh_io::Model;
use mesh_shapes::{Irregular, Torus};
use mesh_work::{
    FaceValues, FrameEstimator, FrameValues, Loaded, PatchMesh, cover_model, subdivide_step,
};

fn torus(scale: f64) -> TriMesh {
    let soup =
        Torus { major: 1.0, minor: 0.4 }.irregular_mesh(12, 8, Irregular::default()).unwrap();
    let mut mesh = TriMesh::from_soup(&soup).unwrap();
    mesh.positions_mut().iter_mut().for_each(|p| *p *= scale);
    mesh
}

const EXPONENTS: [i32; 12] = [-499, -400, -300, -200, -120, -41, 41, 120, 200, 300, 400, 498];

/// All estimators but that of the papers, as bits: curvature times length has no unit.
#[test]
fn curvatures_of_scaled_meshes_are_scaled_curvatures() {
    let measure = |scale: f64| {
        let mesh = torus(scale);
        let faces = FaceValues::of(&mesh, Params::default(), None).unwrap();
        let frames = [
            FrameEstimator::Auto { noise: None },
            FrameEstimator::Fit(JetFitOptions::rings(2)),
            FrameEstimator::Ball { radius: None },
            FrameEstimator::Corrected { radius: None },
        ]
        .map(|estimator| FrameValues::of(&mesh, estimator).unwrap());
        let mut numbers = vec![faces.radius / scale, frames[2].radius.unwrap() / scale];
        numbers.push(frames[0].noise().unwrap() / scale);
        for disc in faces.discs.as_slice().iter().flatten() {
            numbers.extend(disc.curvatures.map(|k| k * scale));
            numbers.extend((disc.center / scale).to_array());
        }
        for value in frames.iter().flat_map(|all| all.of_vertex.as_slice()).flatten() {
            numbers.extend(value.principal().map(|k| k * scale));
            numbers.extend([value.mean * scale, value.gaussian * scale * scale]);
        }
        let sums = frames.iter().map(|frames| frames.integrals(&mesh));
        for sums in sums.chain([faces.integrals(&mesh)]) {
            numbers.extend([sums.integral_gaussian, sums.f1, sums.f3 / scale]);
        }
        numbers.iter().map(|number| number.to_bits()).collect::<Vec<u64>>()
    };
    let unit = measure(1.0);
    assert!(unit.len() > 1500);
    for exponent in EXPONENTS {
        assert_eq!(measure(f64::from(exponent).exp2()), unit, "2^{exponent}");
    }
}

#[test]
fn patches_of_scaled_meshes_are_scaled_patches() {
    let measure = |scale: f64| {
        let original = torus(scale);
        let sized = PatchMesh::new(&original).unwrap();
        let estimator = CurvatureEstimator::new(sized.mesh(), Params::default()).unwrap();
        let found = cover(&estimator, &CoverOptions::new(sized.length(0.03 * scale))).unwrap();
        let found = sized.restore(found).unwrap();
        assert_eq!(found.tolerance, 0.03 * scale);
        let model = cover_model(&original, &found, 0.01 * scale).unwrap();
        let places = model.soup.positions().iter().map(|&p| (p / scale).to_array());
        let errors =
            found.patches.iter().map(|p| [p.errors.points, p.errors.heights, p.errors.overhang]);
        let numbers = places.chain(errors.map(|e| e.map(|x| x / scale)));
        (found.patches.len(), numbers.flatten().map(f64::to_bits).collect::<Vec<u64>>())
    };
    let unit = measure(1.0);
    assert!(unit.0 > 4);
    for exponent in EXPONENTS {
        assert_eq!(measure(f64::from(exponent).exp2()), unit, "2^{exponent}");
    }
}

/// Beyond the sizes at which areas are numbers, nothing is reported as 0.
#[test]
fn meshes_without_areas_are_refused() {
    for exponent in [-900, -502, 501, 900] {
        let mesh = torus(f64::from(exponent).exp2());
        assert!(FaceValues::of(&mesh, Params::default(), None).is_err());
        assert!(FrameValues::of(&mesh, FrameEstimator::Auto { noise: None }).is_err());
        assert!(FrameValues::of(&mesh, FrameEstimator::Ball { radius: None }).is_err());
        assert!(PatchMesh::new(&mesh).is_err());
    }
}

/// Two tetrahedra that touch in a vertex, which has two copies.
fn touching(place: impl Fn(DVec3) -> DVec3) -> Loaded {
    let mut soup = PolygonSoup::new();
    for side in [1.0, -1.0] {
        let first = soup.vertex_count() as u32;
        for corner in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
            soup.push_vertex(place(side * corner));
        }
        for mut face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
            if side < 0.0 {
                face.reverse();
            }
            soup.push_face(&face.map(|v| v + first)).unwrap();
        }
    }
    Loaded::build(Model::from(soup), &Repair::strict()).unwrap()
}

/// Beyond the range of single precision all positions would be equal there.
#[test]
fn only_parts_that_touch_are_separated_at_any_size() {
    let measure = |scale: f64| {
        let mut loaded = touching(|p| p * scale);
        let moved = loaded.separate_touching().unwrap();
        (moved, loaded.mesh.positions().iter().map(|&p| p / scale).collect::<Vec<_>>())
    };
    let unit = measure(1.0);
    assert_eq!(unit.0, 2);
    for exponent in [-990, -400, -120, 120, 400, 990] {
        assert_eq!(measure(f64::from(exponent).exp2()), unit, "2^{exponent}");
    }
}

/// The step that single precision needs grows with the distance from the origin.
#[test]
fn parts_are_not_separated_by_a_step_that_changes_the_shape() {
    for offset in [0.0, 1e3, 1e4, 1e5, 1e6, 1e9] {
        let mut loaded = touching(|p| p + DVec3::splat(offset));
        let before = loaded.mesh.positions().to_vec();
        let found = loaded.separate_touching();
        assert_eq!(found.is_err(), offset > 3e4, "{offset}");
        let moves = before.iter().zip(loaded.mesh.positions()).map(|(&p, &q)| p.distance(q));
        assert!(moves.fold(0.0, f64::max) < 0.05, "{offset}");
    }
}

#[test]
fn subdivided_meshes_scale_with_the_mesh() {
    let measure = |scale: f64| {
        let mesh = torus(scale);
        let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
        let soup = PolygonSoup::from_triangles(mesh.positions(), &triangles).unwrap();
        let found =
            subdivide_step(&mesh, &Model::from(soup), &ButterflyOptions::default()).unwrap();
        let places = found.mesh.positions().iter().map(|&p| p / scale);
        (found.straight_edges, places.collect::<Vec<DVec3>>())
    };
    let unit = measure(1.0);
    for exponent in [-990, -700, -400, -120, 120, 400, 700, 990] {
        assert!(measure(f64::from(exponent).exp2()) == unit, "2^{exponent}");
    }
}
