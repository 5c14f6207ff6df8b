//! Discs of local size: surfaces of known curvature, triangles of any aspect ratio.
#![allow(clippy::unwrap_used)]

use crate::common;
use core::f64::consts::{PI, TAU};

use curvpatch::{CurvatureError, CurvatureEstimator, DiscCurvature, DiscSize, Params};
use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::{FaceId, TriMesh};
use mesh_shapes::{Irregular, Saddle, Torus};

/// A cylinder of radius 0.4 around z without caps, `sides` x `rows` quads, and its height.
fn open_cylinder(sides: u32, rows: u32, height: f64) -> TriMesh {
    let vertices: Vec<[f64; 3]> = (0..=rows)
        .flat_map(|row| {
            (0..sides).map(move |side| {
                let (sin, cos) = (TAU * f64::from(side) / f64::from(sides)).sin_cos();
                [0.4 * cos, 0.4 * sin, height * f64::from(row) / f64::from(rows)]
            })
        })
        .collect();
    let vertex = |row: u32, side: u32| row * sides + side % sides;
    let mut triangles = Vec::new();
    for row in 0..rows {
        for side in 0..sides {
            let [a, b] = [vertex(row, side), vertex(row, side + 1)];
            let [c, d] = [vertex(row + 1, side), vertex(row + 1, side + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    TriMesh::from_triangles(&vertices, &triangles).unwrap()
}

fn discs(mesh: &TriMesh) -> Vec<DiscCurvature> {
    let estimator = CurvatureEstimator::new(mesh, Params::robust()).unwrap();
    assert_eq!(estimator.default_size(), DiscSize::Local);
    let found = estimator.all_faces(DiscSize::Local).unwrap().into_vec();
    found.into_iter().map(Result::unwrap).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A pipe bend: a torus with triangles 1 to 50 times longer along the tube than around it.
#[test]
fn pipe_bends_of_any_aspect_ratio_have_the_curvature_of_the_tube() {
    let torus = Torus { major: 5.0, minor: 0.4 };
    for sides in [24, 48, 96] {
        for aspect in [1, 2, 5, 12, 25, 50] {
            // Edges along the tube are `aspect` times longer than edges around it.
            let rings = (5.0 / 0.4 * f64::from(sides) / f64::from(aspect)) as usize;
            // With fewer rings, the polygonal tube itself is more than 1 % thinner between its rings.
            if rings < 20 || rings * sides as usize > 15_000 {
                continue;
            }
            let found = discs(&common::mesh(&torus.mesh(rings, sides as usize).unwrap()));
            let k1 = median(found.iter().map(|disc| disc.curvatures[0]).collect());
            assert!((k1 / 2.5 - 1.0).abs() < 0.02, "{sides} sides, aspect {aspect}: {k1}");
            assert!(found.iter().all(|disc| !disc.wrapped));
            let errors: Vec<f64> =
                found.iter().map(|disc| (disc.curvatures[0] / 2.5 - 1.0).abs()).collect();
            let [_, most] = common::percentiles(errors);
            assert!(most < 0.06, "{sides} sides, aspect {aspect}: 95 % below {most}");
        }
    }
}

/// Cylinders and tori with triangles up to 40 times longer around the tube than along it. Sections of four edges in
/// the short direction alone would stay in one facet.
#[test]
fn long_triangles_across_the_curvature_show_no_facets() {
    for sides in [12, 24] {
        for aspect in [3, 6, 12, 25, 40] {
            let chord = 0.8 * (PI / f64::from(sides)).sin();
            let height = 6.0 * chord;
            let rows = 6 * aspect;
            let is_inside = |disc: &&DiscCurvature| (disc.center.z / height - 0.5).abs() < 0.1;
            let found = discs(&open_cylinder(sides, rows, height));
            let inside: Vec<[f64; 2]> =
                found.iter().filter(is_inside).map(|disc| disc.curvatures).collect();
            assert!(inside.len() as u32 >= sides * rows / 8);
            for [k1, k2] in inside {
                assert!((k1 / 2.5 - 1.0).abs() < 0.02, "{sides} sides, aspect {aspect}: k1 = {k1}");
                assert!(k2.abs() < 0.03 * 2.5, "{sides} sides, aspect {aspect}: k2 = {k2}");
            }
        }
    }
    let torus = Torus { major: 3.0, minor: 1.0 };
    for (rings, sides) in [(288, 12), (600, 12), (400, 16)] {
        let found = discs(&common::mesh(&torus.mesh(rings, sides).unwrap()));
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for DiscCurvature { center, curvatures: [k1, k2], .. } in found {
            let cos = (center.truncate().length() - 3.0)
                / (center.truncate().length() - 3.0).hypot(center.z);
            first.push((k1 - 1.0).abs());
            second.push((k2 - cos / (3.0 + cos)).abs());
        }
        for errors in [first, second] {
            let [middle, most] = common::percentiles(errors);
            assert!(
                middle < 0.015 && most < 0.04,
                "{rings} rings of {sides}: {middle}, 95 % below {most}"
            );
        }
    }
}

/// A cylinder is straight in one direction: at every face, also where the boundary cuts sections short.
#[test]
fn open_cylinders_are_straight_along_their_axis() {
    let cylinders = [
        (16, 2, 2.0),
        (24, 4, 5.2),
        (24, 24, 2.5),
        (32, 1, 1.0),
        (48, 4, 5.2),
        (48, 96, 5.0),
        (96, 8, 1.0),
    ];
    for (sides, rows, height) in cylinders {
        let found = discs(&open_cylinder(sides, rows, height));
        assert!(found.iter().any(|disc| disc.truncated));
        for disc in &found {
            let [k1, k2] = disc.curvatures;
            assert!(
                (k1 / 2.5 - 1.0).abs() < 0.02,
                "{sides} x {rows}: k1 = {k1} at {}",
                disc.center
            );
            assert!(k2.abs() < 0.02 * 2.5, "{sides} x {rows}: k2 = {k2} at {}", disc.center);
        }
    }
}

/// At the boundary, the points of sections do not always determine a quadric.
#[test]
fn curvatures_at_the_boundary_of_half_a_torus_are_bounded() {
    let (major, minor) = (2.0, 0.7);
    for (around, across) in [(24, 8), (16, 6), (40, 10)] {
        let point = |i: u32, j: u32| {
            let (v, u) = (f64::from(i) / f64::from(around), f64::from(j) / f64::from(across));
            let ((y, x), (height, out)) = ((TAU * v).sin_cos(), (PI * u).sin_cos());
            let radius = major + minor * out;
            DVec3::new(radius * x, radius * y, minor * height)
        };
        let index = |i: u32, j: u32| (i % around) * (across + 1) + j;
        let points: Vec<DVec3> =
            (0..around).flat_map(|i| (0..=across).map(move |j| point(i, j))).collect();
        let cells = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
        let split = |(i, j): (u32, u32)| {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| index(i, j));
            if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        };
        let triangles: Vec<[u32; 3]> = cells.flat_map(split).collect();
        let found = discs(&TriMesh::from_triangles(&points, &triangles).unwrap());
        assert!(found.iter().any(|disc| disc.truncated));
        let largest =
            found.iter().flat_map(|disc| disc.curvatures).fold(0.0, |k: f64, l| k.max(l.abs()));
        assert!(largest < 2.0 / minor, "{around} x {across}: {largest}");
    }
}

/// On meshes with triangles of one size, local discs are as accurate as discs of four mean edges.
#[test]
fn local_discs_are_as_accurate_as_four_mean_edges_on_even_meshes() {
    let irregular = Irregular { jitter: 0.2, seed: 3 };
    let torus = common::TORUS;
    let meshes =
        [common::torus(64, 32), common::mesh(&torus.irregular_mesh(64, 32, irregular).unwrap())];
    for mesh in meshes {
        let suggested =
            CurvatureEstimator::new(&mesh, Params::robust()).unwrap().suggested_radius();
        let fixed = common::accuracy(&mesh, &torus, Params::robust(), suggested, |_| true);
        let local = common::accuracy(&mesh, &torus, Params::robust(), DiscSize::Local, |_| true);
        for i in 0..2 {
            let bound = 1.2 * fixed.curvature[i] + 0.5;
            assert!(local.curvature[i] < bound, "{:?} {:?}", local.curvature, fixed.curvature);
        }
    }
    let saddle = common::saddle(32);
    let local = common::accuracy(
        &saddle,
        &common::SADDLE,
        Params::robust(),
        DiscSize::Local,
        common::inner,
    );
    assert!(local.curvature[1] < 3.0, "{:?}", local.curvature);
    let sphere = discs(&common::icosphere(3));
    for disc in sphere {
        assert!(disc.curvatures.iter().all(|k| (k - 1.0).abs() < 0.02), "{disc:?}");
    }
}

/// A triangle without neighbours and a tetrahedron have faces whose sections never leave the first face
/// or close at once. The curvature is unknown, not zero.
#[test]
fn sections_inside_one_face_give_no_curvature() {
    let lone =
        TriMesh::from_triangles(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])
            .unwrap();
    let estimator = CurvatureEstimator::new(&lone, Params::robust()).unwrap();
    let face = FaceId::new(0);
    let error = estimator.at(face, DiscSize::Local).unwrap_err();
    assert_eq!(error, CurvatureError::TooFewDirections { face });
}

/// Scaling by powers of two scales the curvature exactly.
#[test]
fn local_discs_scale_with_the_mesh() {
    let soup = Saddle { coefficient: 0.5, half_width: 1.0 }.mesh(8, Default::default()).unwrap();
    let expected = discs(&common::mesh(&soup));
    for exponent in [-240, -40, 40, 240] {
        let scale = 2.0_f64.powi(exponent);
        let mut scaled = soup.clone();
        scaled.positions_mut().iter_mut().for_each(|p| *p *= scale);
        for (a, b) in discs(&common::mesh(&scaled)).iter().zip(&expected) {
            assert_eq!(a.curvatures.map(|k| k * scale), b.curvatures, "{exponent}");
        }
    }
}

/// Random heights over a fan of thin triangles: every result is finite or an error.
#[test]
fn thin_fans_have_finite_curvature() {
    let mut random = SplitMix64::new(7);
    let count = 2000_u32;
    let mut vertices = vec![[0.0, 0.0, 0.1]];
    for i in 0..count {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(count)).sin_cos();
        vertices.push([cos, sin, 1e-3 * random.symmetric()]);
    }
    let triangles: Vec<[u32; 3]> = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect();
    let mesh = TriMesh::from_triangles(&vertices, &triangles).unwrap();
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    for disc in estimator.all_faces(DiscSize::Local).unwrap().into_vec().into_iter().flatten() {
        assert!(disc.curvatures.iter().all(|k| k.is_finite()), "{disc:?}");
    }
}
