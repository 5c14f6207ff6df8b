//! Scale, position, threads and bad input: changes that must not affect the result, and input that must not cause
//! failures.
#![allow(clippy::unwrap_used)]

use crate::common;
use curvpatch::{
    Cover, CoverMethod, CoverOptions, CoverRecord, CurvatureError, CurvatureEstimator,
    DiscCurvature, FitTest, Params, Patch, PatchSizer, Seeds, Shape, SizeOptions, StopReason,
    Unfit, cover,
};
use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::{FaceId, PolygonSoup, Repair, TriMesh, build};
use mesh_shapes::RowPhase;
use proptest::prelude::*;

fn moved(mesh: &TriMesh, scale: f64, offset: DVec3) -> TriMesh {
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    let positions: Vec<DVec3> = mesh.positions().iter().map(|&p| scale * p + offset).collect();
    TriMesh::from_triangles(&positions, &triangles).unwrap()
}

fn all(mesh: &TriMesh, params: Params, radius: f64) -> Vec<DiscCurvature> {
    let estimator = CurvatureEstimator::new(mesh, params).unwrap();
    let discs = estimator.all_faces(radius).unwrap();
    discs.into_vec().into_iter().map(Result::unwrap).collect()
}

#[test]
fn scale_and_place_change_nothing_but_units() {
    let meshes = [common::torus(24, 12), common::saddle(12)];
    for mesh in &meshes {
        let reference = all(mesh, Params::robust(), 0.6);
        for (scale, offset) in
            [(1e-6, DVec3::ZERO), (1e6, DVec3::ZERO), (1.0, DVec3::new(1000.0, -2000.0, 500.0))]
        {
            let other = moved(mesh, scale, offset);
            let discs = all(&other, Params::robust(), 0.6 * scale);
            for (a, b) in reference.iter().zip(&discs) {
                assert_eq!(a.class(), b.class());
                assert_eq!((a.truncated, a.wrapped), (b.truncated, b.wrapped));
                for (a, b) in a.curvatures.into_iter().zip(b.curvatures) {
                    assert!((a - b * scale).abs() < 1e-9, "{a} {}", b * scale);
                }
                assert!(a.normal().distance(b.normal()) < 1e-9);
            }
        }
    }
    // Powers of two change no digit, so sizes and covers are equal bit for bit.
    let torus = &meshes[0];
    let other = moved(torus, 1024.0, DVec3::ZERO);
    let [a, b] = [(torus, 0.1), (&other, 102.4)].map(|(mesh, tolerance)| {
        let estimator = CurvatureEstimator::new(mesh, Params::robust()).unwrap();
        cover(&estimator, &CoverOptions::new(tolerance)).unwrap()
    });
    assert_eq!(a.patch_of_face, b.patch_of_face);
    assert_eq!(a.max_error() * 1024.0, b.max_error());
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let mesh = common::torus(80, 40);
    let compute = || {
        let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
        let discs = estimator.all_faces(0.4).unwrap();
        let mut options = CoverOptions::new(0.02);
        options.seeds = Seeds::Redundancy(4.0);
        (discs, cover(&estimator, &options).unwrap())
    };
    let with_threads = |threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(compute)
    };
    let (discs, covered) = with_threads(1);
    for threads in [2, 3, 8] {
        let (other_discs, other) = with_threads(threads);
        assert_eq!(discs, other_discs);
        assert_eq!(covered, other);
    }
    // A single face has the same bits as in a run over all faces.
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    for face in mesh.topology().faces().step_by(37) {
        assert_eq!(discs[face], estimator.at(face, 0.4));
    }
    // With fewer seeds than faces, every face is still covered or residual.
    assert!(covered.seeds < mesh.topology().face_count());
    assert!(covered.residual.is_empty());
}

#[test]
fn bad_parameters_are_refused() {
    let mesh = common::icosphere(1);
    let few = Params { planes: 2, ..Params::robust() };
    let error = CurvatureEstimator::new(&mesh, few).unwrap_err();
    assert_eq!(error, CurvatureError::TooFewPlanes { planes: 2 });
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            estimator.at(FaceId::new(0), radius),
            Err(CurvatureError::BadRadius { .. })
        ));
        assert!(estimator.all_faces(radius).is_err());
    }
    let outside = FaceId::new(1_000_000);
    assert_eq!(estimator.at(outside, 0.1), Err(CurvatureError::NotInMesh { face: outside }));
    let mut sizer = PatchSizer::new(&estimator, SizeOptions::new(0.1)).unwrap();
    assert!(matches!(sizer.fit(outside, Shape::Circle), Err(Unfit::Curvature(_))));

    for change in [
        (|o| o.size.tolerance = 0.0) as fn(&mut CoverOptions),
        |o| o.size.tolerance = f64::NAN,
        |o| o.size.max_turn = 1.6,
        |o| o.size.growth = 1.0,
        |o| o.size.max_radius = Some(-1.0),
        |o| o.shapes.clear(),
        |o| o.seeds = Seeds::Redundancy(f64::NAN),
    ] {
        let mut options = CoverOptions::new(0.1);
        change(&mut options);
        assert!(cover(&estimator, &options).is_err(), "{options:?}");
    }
}

#[test]
fn faces_without_area_are_flagged_and_walked_over() {
    // A square whose middle has a face without area between two halves.
    let positions =
        [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0], [2.0, 2.0, 0.0]];
    let triangles = [[0, 1, 2], [0, 2, 4], [0, 4, 3], [4, 2, 3]];
    let mesh = TriMesh::from_triangles(&positions, &triangles).unwrap();
    let flat = FaceId::new(1);
    for params in [Params::paper(), Params::robust()] {
        let estimator = CurvatureEstimator::new(&mesh, params).unwrap();
        let discs = estimator.all_faces(1.5).unwrap();
        assert_eq!(discs[flat], Err(CurvatureError::DegenerateFace { face: flat }));
        for face in [0, 2, 3].map(FaceId::new) {
            let disc = discs[face].unwrap();
            assert!(disc.curvatures.iter().all(|k| k.abs() < 1e-6), "{disc:?}");
        }
        let cover = cover(&estimator, &CoverOptions::new(0.01)).unwrap();
        assert!(cover.covered_faces() + cover.residual.len() == 4);
        assert!(cover.to_mesh(&mesh, 0.01).unwrap().positions.iter().all(|p| p.is_finite()));
    }
    let huge = moved(&mesh, 1e200, DVec3::ZERO);
    let estimator = CurvatureEstimator::new(&huge, Params::robust()).unwrap();
    for disc in estimator.all_faces(1e200).unwrap().as_slice() {
        assert!(disc.is_err() || disc.unwrap().curvatures.iter().all(|k| k.is_finite()));
    }
}

#[test]
fn components_and_repaired_meshes_are_covered_one_by_one() {
    // Two spheres, one far away, and a fin of three faces on one edge of the first.
    let mut soup = PolygonSoup::new();
    for offset in [0.0, 900.0] {
        let first = soup.vertex_count() as u32;
        let sphere = common::icosphere(2);
        for &p in sphere.positions() {
            soup.push_vertex(p + offset * DVec3::X);
        }
        for triangle in sphere.topology().triangles() {
            soup.push_face(&triangle.map(|v| v + first)).unwrap();
        }
    }
    let [a, b, _] = [soup.face(0)[0], soup.face(0)[1], soup.face(0)[2]];
    let tip = soup.vertex_count() as u32;
    soup.push_vertex(DVec3::new(0.0, 3.0, 0.0));
    soup.push_face(&[a, b, tip]).unwrap();
    let mesh = build(&soup, &Repair::lenient()).unwrap().mesh;
    assert!(mesh.topology().components().count >= 2);
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    let mut options = CoverOptions::new(0.05);
    options.method = CoverMethod::Greedy;
    let cover = cover(&estimator, &options).unwrap();
    assert_eq!(cover.covered_faces() + cover.residual.len(), mesh.topology().face_count());
    assert!(cover.residual.len() < 10, "{}", cover.residual.len());
    let far = cover.patches.iter().filter(|p| p.fit.patch.origin().x > 100.0).count();
    assert!(far > 0 && far < cover.patches.len());
    for patch in &cover.patches {
        let side = patch.fit.patch.origin().x > 100.0;
        assert!(patch.faces.iter().all(|&f| (mesh.triangle(f)[0].x > 100.0) == side));
        assert!(patch.errors.max() <= cover.tolerance);
    }
}

#[test]
fn sizes_stop_for_the_reason_they_give() {
    let sized = |mesh: &TriMesh, face: u32, options: SizeOptions| {
        let estimator = CurvatureEstimator::new(mesh, Params::robust()).unwrap();
        let mut sizer = PatchSizer::new(&estimator, options).unwrap();
        sizer.fit(FaceId::new(face), Shape::Circle)
    };
    let torus = common::torus(48, 24);
    let bent = sized(&torus, 500, SizeOptions::new(0.02)).unwrap();
    assert_eq!(bent.stop, StopReason::Tolerance);
    // The patch keeps the tolerance; a patch that is an eighth larger does not.
    let estimator = CurvatureEstimator::new(&torus, Params::robust()).unwrap();
    let mut probe = FitTest::new(&torus);
    assert!(probe.full_error(&bent.fit, 0.02, false).max() <= 0.02);
    let larger = 1.25 * bent.fit.curvature.radius;
    let larger = estimator.patch(FaceId::new(500), larger, Shape::Circle).unwrap();
    assert!(probe.full_error(&larger, 0.02, false).max() > 0.02);

    let sphere = common::icosphere(3);
    let cap = sized(&sphere, 7, SizeOptions::new(0.05)).unwrap();
    assert_eq!(cap.stop, StopReason::Angle);
    assert!((1.15..=1.21).contains(&cap.fit.curvature.radius));
    let small = SizeOptions { max_radius: Some(0.5), ..SizeOptions::new(0.05) };
    let small = sized(&sphere, 7, small).unwrap();
    assert_eq!(small.stop, StopReason::MaxRadius);
    assert!((0.45..=0.5).contains(&small.fit.curvature.radius));

    let saddle = common::saddle(24);
    let at_rim = sized(&saddle, 24 * 24 + 2, SizeOptions::new(0.05)).unwrap();
    assert_eq!(at_rim.stop, StopReason::Boundary);
    let over = SizeOptions { overhang: true, ..SizeOptions::new(0.05) };
    let over = sized(&saddle, 24 * 24 + 2, over).unwrap();
    assert!(over.fit.curvature.radius > 1.5 * at_rim.fit.curvature.radius);

    // A tolerance below the sagitta of the facets.
    let unfit = sized(&torus, 500, SizeOptions::new(1e-5)).unwrap_err();
    assert!(matches!(unfit, Unfit::NoRadius { stop: StopReason::Tolerance, .. }), "{unfit}");
}

#[test]
fn exports_hold_the_whole_cover() {
    let mesh = common::cylinder(24, 8, RowPhase::Staggered);
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    // A tolerance so small that some faces stay triangles.
    let cover = cover(&estimator, &CoverOptions::new(0.02)).unwrap();
    let tolerance = 0.005;
    let out = cover.to_mesh(&mesh, tolerance).unwrap();
    assert_eq!(out.positions.len(), out.normals.len());
    assert_eq!(out.positions.len(), out.colors.len());
    assert_eq!(out.triangles.len(), out.patch_of_triangle.len());
    let residual = out.patch_of_triangle.iter().filter(|patch| patch.is_none()).count();
    assert_eq!(residual, cover.residual.len());
    for (triangle, patch) in out.triangles.iter().zip(&out.patch_of_triangle) {
        for &v in triangle {
            let p = out.positions[v as usize];
            if let Some(patch) = patch {
                let patch = &cover.patches[*patch as usize].fit.patch;
                let local = patch.to_local(p);
                assert!((patch.height(local.x, local.y).unwrap() - local.z).abs() < 1e-9);
            }
        }
    }
    let splats = cover.splats();
    assert_eq!(splats.len(), cover.patches.len());
    for (splat, patch) in splats.iter().zip(&cover.patches) {
        let [a, b] = splat.axes.map(DVec3::from_array);
        let normal = DVec3::from_array(splat.normal);
        assert!(a.dot(b).abs() < 1e-12 && a.cross(b).normalize().distance(normal) < 1e-12);
        assert!((a.length() - patch.fit.patch.semi_axes()[0]).abs() < 1e-12);
        assert_eq!(DVec3::from_array(splat.center), patch.fit.patch.center());
    }
    check_record(&cover, &cover.record());
}

fn check_record(cover: &Cover, record: &CoverRecord) {
    assert_eq!(record.residual.len(), cover.residual.len());
    for (record, patch) in record.patches.iter().zip(&cover.patches) {
        let again = Patch::try_from(record.patch).unwrap();
        assert_eq!(again, patch.fit.patch, "bit for bit");
        assert!(record.faces.iter().copied().eq(patch.faces.iter().map(|f| f.get())));
    }
}

/// JSON keeps every bit of every patch.
#[cfg(feature = "serde")]
#[test]
fn records_survive_json() {
    let mesh = common::torus(24, 12);
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    let cover = cover(&estimator, &CoverOptions::new(0.1)).unwrap();
    let text = serde_json::to_string(&cover.record()).unwrap();
    let back: CoverRecord = serde_json::from_str(&text).unwrap();
    assert_eq!(back, cover.record());
    check_record(&cover, &back);
    let broken = text.replacen("\"arcs\":[", "\"arcs\":[-", 1);
    let patch: Result<CoverRecord, _> = serde_json::from_str(&broken);
    assert!(patch.is_ok_and(|record| Patch::try_from(record.patches[0].patch).is_err()));
}

/// A sheet over a grid. Some vertices are moved to other grid points, so that the sheet folds over itself and passes
/// close to itself.
fn crumpled_sheet(random: &mut SplitMix64) -> Option<TriMesh> {
    let side = 5;
    let mut whole = |limit: f64| (limit * random.symmetric()).round();
    let mut points: Vec<[f64; 3]> =
        (0..side * side).map(|i| [f64::from(i % side), f64::from(i / side), whole(2.0)]).collect();
    for _ in 0..6 {
        let moved = (random.uniform() * points.len() as f64) as usize;
        let mut whole = |limit: f64| (limit * random.symmetric()).round();
        points[moved] = [whole(4.0), whole(4.0), whole(4.0)];
    }
    let cells = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| x + y * side));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|a| [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]])
        .map(|corners| corners.map(|corner| corner as u32))
        .collect();
    let soup = PolygonSoup::from_triangles(&points, &triangles).ok()?;
    Some(build(&soup, &Repair::lenient()).ok()?.mesh)
}

/// A section to the face straight under a point may leave the region of the patch on its way. Such a face does not
/// count, and no patch may be accepted because of it.
#[test]
fn no_cover_of_a_sheet_that_folds_over_is_out_of_tolerance() {
    let mut random = SplitMix64::new(5);
    let mut patches = 0;
    for _ in 0..400 {
        let Some(mesh) = crumpled_sheet(&mut random) else { continue };
        let tolerance = 0.02 + 2.0 * random.uniform();
        let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
        for shape in Shape::ALL {
            let options = CoverOptions { shapes: vec![*shape], ..CoverOptions::new(tolerance) };
            let cover = cover(&estimator, &options).unwrap();
            patches += cover.patches.len();
            assert!(cover.max_error() <= tolerance, "{} > {tolerance}", cover.max_error());
        }
    }
    assert!(patches > 1000, "{patches}");
}

/// Random small soups, repaired: folded, pinched, with needles and several components.
fn small_mesh() -> impl Strategy<Value = TriMesh> {
    let coordinate = || prop_oneof![4 => -3.0..3.0, 1 => (-2_i32..3).prop_map(f64::from)];
    let points = prop::collection::vec(prop::array::uniform3(coordinate()), 3..12);
    (points, prop::collection::vec(prop::array::uniform3(0_u32..12), 1..24)).prop_filter_map(
        "no face left",
        |(points, triangles)| {
            let soup = PolygonSoup::from_triangles(&points, &triangles).ok()?;
            let mesh = build(&soup, &Repair::lenient()).ok()?.mesh;
            (mesh.topology().face_count() > 0).then_some(mesh)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_meshes_neither_panic_nor_yield_nan(mesh in small_mesh(), radius in 0.01..10.0_f64) {
        for params in [Params::paper(), Params::robust()] {
            let estimator = CurvatureEstimator::new(&mesh, params).unwrap();
            for disc in estimator.all_faces(radius).unwrap().as_slice().iter().flatten() {
                prop_assert!(disc.curvatures.iter().all(|k| k.is_finite()));
                let [a, b, c] = disc.frame;
                prop_assert!((a.cross(b) - c).length() < 1e-9 && (c.length() - 1.0).abs() < 1e-9);
            }
            let cover = cover(&estimator, &CoverOptions::new(0.05 * radius)).unwrap();
            let whole = cover.covered_faces() + cover.residual.len();
            prop_assert_eq!(whole, mesh.topology().face_count());
            prop_assert!(cover.max_error() <= cover.tolerance * (1.0 + 1e-9));
            let out = cover.to_mesh(&mesh, 0.05).unwrap();
            prop_assert!(out.positions.iter().all(|p| p.is_finite()));
            for face in mesh.topology().faces() {
                if let Ok(fit) = estimator.patch(face, radius, Shape::Ellipse) {
                    let errors = FitTest::new(&mesh).full_error(&fit, 0.1, true);
                    prop_assert!(!errors.max().is_nan());
                    prop_assert!(fit.patch.translation().is_finite());
                }
            }
        }
    }
}

#[test]
fn noise_does_not_leave_gaps_in_the_books() {
    let mut random = SplitMix64::new(5);
    let mesh = common::torus(24, 12);
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    let shaken: Vec<DVec3> = mesh
        .positions()
        .iter()
        .map(|&p| p + 0.2 * DVec3::new(random.symmetric(), random.symmetric(), random.symmetric()))
        .collect();
    let mesh = TriMesh::from_triangles(&shaken, &triangles).unwrap();
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    let cover = cover(&estimator, &CoverOptions::new(0.05)).unwrap();
    assert_eq!(cover.covered_faces() + cover.residual.len(), triangles.len());
    assert!(!cover.residual.is_empty() && !cover.patches.is_empty());
    for &face in &cover.residual {
        let mut sizer =
            PatchSizer::new(&estimator, SizeOptions { overhang: true, ..SizeOptions::new(0.05) })
                .unwrap();
        for shape in [Shape::Circle, Shape::Ellipse] {
            let own = sizer.fit(face, shape);
            assert!(own.is_err() || !own.unwrap().faces.contains(&face));
        }
    }
}

/// If all corners of a face are one point, the search has no start radius.
#[test]
fn a_face_without_extent_stays_a_triangle() {
    let mut mesh = common::saddle(6);
    let face = mesh.topology().faces().nth(40).unwrap();
    let corners = mesh.topology().face_vertices(face);
    let at = mesh.position(corners[0]);
    corners.into_iter().for_each(|corner| mesh.positions_mut()[corner.index()] = at);
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    let expected = Unfit::Curvature(CurvatureError::DegenerateFace { face });
    let mut sizer = PatchSizer::new(&estimator, SizeOptions::new(0.05)).unwrap();
    assert_eq!(sizer.fit(face, Shape::Circle), Err(expected));
    for seeds in [Seeds::AllFaces, Seeds::default()] {
        let options = CoverOptions { seeds, ..CoverOptions::new(0.05) };
        let cover = cover(&estimator, &options).unwrap();
        assert!(cover.max_error() <= 0.05 && cover.covered_faces() > 60, "{cover:?}");
    }
}
