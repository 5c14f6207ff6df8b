//! Normal sections: independent of the triangulation, correct at vertices and boundaries, and correct where they close.
#![allow(clippy::unwrap_used)]

use crate::common;
use core::f64::consts::PI;

use curvpatch::{
    CurvatureError, CurvatureEstimator, Params, PointClass, StripEnd, StripError, StripOptions,
    SurfacePoint,
};
use dcurv::{CurvatureOptions, Curvatures};
use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_shapes::{Diagonals, Plane, RowPhase, SignedDistance};

/// The face and point of a half cylinder's mesh over this angle and height.
fn locate(mesh: &TriMesh, at: DVec3) -> SurfacePoint {
    let coordinates = |face: FaceId| {
        let [a, b, c] = mesh.triangle(face);
        let normal = (b - a).cross(c - a);
        [(b, c), (c, a), (a, b)].map(|(p, q)| (p - at).cross(q - at).dot(normal))
    };
    let faces = mesh.topology().faces();
    // The point deepest inside its face, among the faces whose plane contains it.
    let depth = |&face: &FaceId| {
        let [a, ..] = mesh.triangle(face);
        let off_plane = (at - a).dot(mesh.face_normal(face)).abs();
        let inside = coordinates(face).into_iter().fold(f64::INFINITY, f64::min);
        if off_plane < 1e-9 { inside / mesh.face_area(face).powi(2) } else { f64::NEG_INFINITY }
    };
    let face = faces.max_by(|a, b| depth(a).total_cmp(&depth(b))).unwrap();
    SurfacePoint::new(face, coordinates(face)).unwrap()
}

/// SN10, Fig. 7. All vertices of the sparse half cylinder are on its end circles. Curvature per vertex is undefined
/// between them, and at the end circles it is the curvature of boundary vertices. Sections give the same curvature as
/// on a dense mesh of the same facets.
#[test]
fn half_cylinder_without_inner_vertices_has_the_curvature_of_a_dense_one() {
    let sparse = common::bare_half_cylinder();
    let dense = common::mesh(
        &mesh_shapes::Cylinder { radius: 1.0, height: 6.0 }
            .mesh(48, 48, RowPhase::Aligned)
            .unwrap(),
    );
    let vertex_based = Curvatures::of(&sparse, &CurvatureOptions::default());
    let boundary = sparse.topology().vertices().all(|v| vertex_based.vertices()[v].is_boundary());
    assert!(boundary, "no vertex has the surface all round it");

    for params in [Params::paper(), Params::robust()] {
        let of_sparse = CurvatureEstimator::new(&sparse, params).unwrap();
        let of_dense = CurvatureEstimator::new(&dense, params).unwrap();
        for (sector, share, height) in [(11, 0.75, 3.02), (8, 0.75, 2.71), (14, 0.8, 3.3)] {
            let corner = |i: i32| (PI * f64::from(i) / 24.0).sin_cos();
            let ((s0, c0), (s1, c1)) = (corner(sector), corner(sector + 1));
            let at = DVec3::new(c0 + share * (c1 - c0), s0 + share * (s1 - s0), height);
            let (here, there) = (locate(&sparse, at), locate(&dense, at));
            // The planes are the same, since the first edges of both faces are parallel.
            assert!(first_edge(&sparse, here).cross(first_edge(&dense, there)).length() < 1e-12);
            for radius in [0.2, 0.4, 0.7] {
                let a = of_sparse.at(here, radius).unwrap();
                let b = of_dense.at(there, radius).unwrap();
                assert!(!a.truncated && !b.truncated);
                // The third-order rule takes the square root of S - d, which is pure rounding error along the
                // generators.
                let noise = if params == Params::paper() { 2e-7 } else { 1e-10 };
                for (a, b) in a.curvatures.into_iter().zip(b.curvatures) {
                    assert!((a - b).abs() < noise, "{radius}: {a} {b}");
                }
                assert!(a.normal().distance(b.normal()) < 1e-10);
                assert!((a.curvatures[0] - 1.0).abs() < 0.1, "{}", a.curvatures[0]);
            }
        }
    }
}

/// The direction of the first edge of a face, from which the angles of the planes are measured.
fn first_edge(mesh: &TriMesh, point: SurfacePoint) -> DVec3 {
    let [a, b, _] = mesh.triangle(point.face());
    (b - a).normalize()
}

#[test]
fn vertices_hit_exactly_are_walked_through() {
    // A grid of unit squares. From the barycentres, planes at multiples of 45° often pass through vertices and along
    // edges.
    let flat = common::mesh(&Plane { half_width: 8.0 }.mesh(16, Diagonals::Alternating).unwrap());
    for planes in [3, 4, 8, 36, 180] {
        let params = Params { planes, ..Params::paper() };
        let estimator = CurvatureEstimator::new(&flat, params).unwrap();
        for radius in [1.0 / 3.0, 1.0, 2.0 / 3.0, 3.5] {
            let disc = estimator.at(FaceId::new(16 * 16 + 16), radius).unwrap();
            assert!(disc.curvatures.iter().all(|k| k.abs() < 1e-6), "{disc:?}");
            assert_eq!(disc.class(), PointClass::Flat);
            assert!(!disc.truncated && !disc.wrapped);
        }
    }
    let robust = CurvatureEstimator::new(&flat, Params::robust()).unwrap();
    let disc = robust.at(FaceId::new(16 * 16 + 16), 3.0).unwrap();
    assert!(disc.curvatures.iter().all(|k| k.abs() < 1e-15), "{disc:?}");
}

#[test]
fn any_inner_point_has_a_disc_and_classes_are_told_apart() {
    let saddle = common::saddle(32);
    let estimator = CurvatureEstimator::new(&saddle, Params::robust()).unwrap();
    let face = FaceId::new(1055);
    for weights in [[1.0, 1.0, 1.0], [0.8, 0.1, 0.1], [1e-9, 1.0, 1.0], [3.0, 2.0, 1e-12]] {
        let disc = estimator.at(SurfacePoint::new(face, weights).unwrap(), 0.3).unwrap();
        assert_eq!(disc.class(), PointClass::Hyperbolic, "{disc:?}");
        assert!((disc.gaussian() + 1.0).abs() < 0.1 && disc.mean().abs() < 0.03, "{disc:?}");
    }
    for bad in [[0.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [f64::NAN, 1.0, 1.0], [f64::INFINITY; 3]] {
        let error = SurfacePoint::new(face, bad).unwrap_err();
        assert!(matches!(error, CurvatureError::BadPoint { .. }));
    }
    let suggested = estimator.suggested_radius();
    assert!((suggested - 4.0 * common::mean_edge(&saddle)).abs() < 1e-12);
    let class = |mesh: &TriMesh, face| {
        let estimator = CurvatureEstimator::new(mesh, Params::robust()).unwrap();
        estimator.at(FaceId::new(face), 0.4).unwrap().class()
    };
    assert_eq!(class(&common::icosphere(3), 7), PointClass::Umbilic);
    assert_eq!(class(&common::cylinder(48, 32, RowPhase::Staggered), 1536), PointClass::Parabolic);
    assert_eq!(class(&common::torus(64, 32), 0), PointClass::Elliptic);
}

#[test]
fn boundaries_truncate_and_closed_sections_wrap() {
    let saddle = common::saddle(16);
    let estimator = CurvatureEstimator::new(&saddle, Params::robust()).unwrap();
    let corner = estimator.at(FaceId::new(0), 0.3).unwrap();
    assert!(corner.truncated && !corner.wrapped);
    let middle = estimator.at(FaceId::new(16 * 16 + 16), 0.3).unwrap();
    assert!(!middle.truncated && !middle.wrapped);

    let sphere = common::icosphere(2);
    let estimator = CurvatureEstimator::new(&sphere, Params::robust()).unwrap();
    assert!(!estimator.at(FaceId::new(5), 3.0).unwrap().wrapped);
    assert!(estimator.at(FaceId::new(5), 7.0).unwrap().wrapped);

    let single =
        TriMesh::from_triangles(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])
            .unwrap();
    let estimator = CurvatureEstimator::new(&single, Params::robust()).unwrap();
    let alone = estimator.at(FaceId::new(0), 5.0).unwrap();
    assert!(alone.truncated && alone.curvatures.iter().all(|k| k.abs() < 1e-15));
}

/// SN10, Fig. 8: consecutive patches around a cylinder.
#[test]
fn strips_follow_a_section() {
    let mesh = common::cylinder(48, 32, RowPhase::Aligned);
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    let start = FaceId::new(48 * 32);
    let options = StripOptions { spacing: 0.5, ..StripOptions::new(0.35) };
    let round = estimator.strip(start, DVec3::Y, &options).unwrap();
    assert_eq!(round.end, StripEnd::Closed);
    // The circumference of 48 facets is slightly below 2π.
    assert_eq!(round.patches.len(), 13);
    for pair in round.patches.windows(2) {
        let chord = pair[0].patch.origin().distance(pair[1].patch.origin());
        assert!((0.48..=0.5).contains(&chord), "{chord}");
        assert!((pair[0].patch.origin().z - pair[1].patch.origin().z).abs() < 1e-9);
        assert!((pair[0].curvature.curvatures[0] - 1.0).abs() < 0.05);
    }
    let up = estimator.strip(start, DVec3::Z, &options).unwrap();
    assert_eq!(up.end, StripEnd::Boundary);
    assert_eq!(up.patches.len(), 4);
    assert!((up.patches[3].patch.origin().z - up.patches[0].patch.origin().z - 1.5).abs() < 1e-9);
    let two =
        estimator.strip(start, DVec3::Z, &StripOptions { max_patches: 2, ..options }).unwrap();
    assert_eq!((two.end, two.patches.len()), (StripEnd::MaxPatches, 2));

    let normal = mesh.face_normal(start);
    for direction in [DVec3::ZERO, normal, DVec3::NAN] {
        let error = estimator.strip(start, direction, &options).unwrap_err();
        assert!(matches!(error, StripError::BadDirection { .. }), "{direction}: {error}");
    }
    let still = StripOptions { spacing: 0.0, ..options };
    let error = estimator.strip(start, DVec3::Z, &still).unwrap_err();
    assert!(matches!(error, StripError::BadSpacing { .. }));
}

/// The polygon of a section lies on the mesh and in the plane, has the requested length, and has the curvature that the
/// estimate uses.
#[test]
fn traces_are_the_sections_that_were_measured() {
    let mesh = common::torus(48, 24);
    for params in [Params::paper(), Params::robust()] {
        let estimator = CurvatureEstimator::new(&mesh, params).unwrap();
        for index in [0, 333, 1000] {
            let face = FaceId::new(index);
            let disc = estimator.at(face, 0.5).unwrap();
            for i in 0..7 {
                let angle = 0.45 * f64::from(i);
                let trace = estimator.trace(face, &disc, angle);
                let legs = trace.points.windows(2).map(|p| p[0].distance(p[1]));
                let [back, forth]: [f64; 2] =
                    [legs.clone().take(trace.center).sum(), legs.skip(trace.center).sum()];
                assert!((back - 0.5).abs() < 1e-12 && (forth - 0.5).abs() < 1e-12);
                assert!(trace.points[trace.center].distance(disc.center) < 1e-15);
                let across = angle.cos() * disc.frame[1] - angle.sin() * disc.frame[0];
                for point in &trace.points {
                    assert!((*point - disc.center).dot(across).abs() < 1e-12);
                    // Facets lie inside the torus, by at most their sagitta.
                    let depth = common::TORUS.signed_distance(*point);
                    assert!((-0.03..1e-12).contains(&depth), "{depth}");
                }
                assert!(trace.chord() < 1.0 && trace.chord() > 0.9);
                // Euler's formula holds within the error of one section.
                let [k1, k2] = disc.curvatures;
                let euler = k1 * angle.cos().powi(2) + k2 * angle.sin().powi(2);
                assert!((trace.curvature - euler).abs() < 0.12, "{} {euler}", trace.curvature);
            }
        }
    }
}
