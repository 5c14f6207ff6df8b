//! Properties of curvature on random meshes.
#![allow(clippy::unwrap_used)]

use core::f64::consts::{PI, TAU};

use dcurv::{
    CurvatureOptions, Curvatures, VertexArea, extrinsic_curvature, total_extrinsic_curvature,
};
use glam::{DQuat, DVec3};
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use mesh_shapes::{Sphere, Torus, scramble};
use proptest::prelude::*;

/// A closed surface, a surface with boundary, or a closed surface with folds.
fn mesh(kind: usize, seed: u64) -> TriMesh {
    let mut random = SplitMix64::new(seed);
    let soup = match kind {
        0 => Sphere { radius: 1.0 }.random_hull(40, seed % 1000).unwrap(),
        1 => Torus { major: 3.0, minor: 1.0 }.mesh(9, 7).unwrap(),
        _ => return grid(&mut random),
    };
    let mut mesh = TriMesh::from_soup(&soup).unwrap();
    scramble(&mut mesh, (seed % 40) as usize, &mut random, |_, _| true);
    mesh.positions_mut().iter_mut().for_each(|p| {
        *p += 0.1 * DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
    });
    mesh
}

fn grid(random: &mut SplitMix64) -> TriMesh {
    let side = 7_u32;
    let points: Vec<[f64; 3]> = (0..side * side)
        .map(|i| [f64::from(i % side), f64::from(i / side), random.uniform()])
        .collect();
    let cells = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    let triangles: Vec<[u32; 3]> =
        cells.flat_map(|v| [[v, v + 1, v + side + 1], [v, v + side + 1, v + side]]).collect();
    TriMesh::from_triangles(&points, &triangles).unwrap()
}

/// F2, the sums of K and |K| and the extrinsic curvature, which face splits do not change.
fn integrals(mesh: &TriMesh) -> [f64; 5] {
    let options = CurvatureOptions { area: VertexArea::Voronoi };
    let totals = Curvatures::of(mesh, &options).totals();
    [
        totals.gaussian.value(),
        totals.abs_gaussian.value(),
        totals.mean.value(),
        totals.f2(),
        total_extrinsic_curvature(mesh).value(),
    ]
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + a.abs().max(b.abs()))
}

/// Each face with its centroid as a new vertex.
fn with_face_splits(mesh: &TriMesh) -> TriMesh {
    let mut points = mesh.positions().to_vec();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for face in mesh.topology().faces() {
        let [a, b, c] = mesh.topology().face_vertices(face).map(mesh_core::VertexId::get);
        let new = points.len() as u32;
        points.push(mesh.triangle(face).iter().sum::<DVec3>() / 3.0);
        triangles.extend([[a, b, new], [b, c, new], [c, a, new]]);
    }
    TriMesh::from_triangles(&points, &triangles).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn angle_defects_add_up_to_the_euler_characteristic(kind in 0_usize..3, seed: u64) {
        let mesh = mesh(kind, seed);
        let topology = mesh.topology();
        let euler = topology.vertex_count() as f64 - topology.edge_count() as f64
            + topology.face_count() as f64;
        prop_assert!(close(integrals(&mesh)[0], TAU * euler));
    }

    #[test]
    fn scaling_multiplies_by_powers_of_the_scale(
        kind in 0_usize..3, seed: u64, exponent in -9_i32..10,
    ) {
        let before = mesh(kind, seed);
        let scale = 10.0_f64.powi(exponent);
        let mut after = before.clone();
        after.positions_mut().iter_mut().for_each(|p| *p *= scale);
        let powers = [0, 0, 1, 1, 0];
        for ((a, b), power) in integrals(&after).into_iter().zip(integrals(&before)).zip(powers) {
            prop_assert!(close(a / scale.powi(power), b), "{} {}", a, b);
        }
    }

    #[test]
    fn rotation_and_translation_change_nothing(
        kind in 0_usize..3, seed: u64, angles in prop::array::uniform3(-3.0_f64..3.0),
        offset in prop::array::uniform3(-9.0_f64..9.0),
    ) {
        let before = mesh(kind, seed);
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, angles[0], angles[1], angles[2]);
        let mut after = before.clone();
        after.positions_mut().iter_mut().for_each(|p| *p = turn * *p + DVec3::from(offset));
        for (a, b) in integrals(&after).into_iter().zip(integrals(&before)) {
            prop_assert!(close(a, b), "{} {}", a, b);
        }
    }

    #[test]
    fn face_splits_change_no_integral(kind in 0_usize..3, seed: u64) {
        let before = mesh(kind, seed);
        let after = with_face_splits(&before);
        for (a, b) in integrals(&after).into_iter().zip(integrals(&before)) {
            prop_assert!((a - b).abs() < 1e-7 * (1.0 + b.abs()), "{} {}", a, b);
        }
    }

    #[test]
    fn the_positive_part_is_at_least_the_gaussian_curvature(kind in 0_usize..3, seed: u64) {
        let mesh = mesh(kind, seed);
        let curvatures = Curvatures::of(&mesh, &CurvatureOptions::default());
        for v in mesh.topology().vertices() {
            let found = extrinsic_curvature(&mesh, v);
            if mesh.topology().is_boundary_vertex(v) {
                prop_assert_eq!(found.absolute().value(), 0.0);
                continue;
            }
            let gaussian = curvatures[v].integrals().angle_defect.value();
            prop_assert!(found.positive.value() >= gaussian.max(0.0));
            prop_assert!(found.negative.value() >= 0.0 && found.positive.value() <= TAU);
            prop_assert!(close(found.positive.value() - found.negative.value(), gaussian));
        }
        if mesh.topology().is_closed() {
            prop_assert!(total_extrinsic_curvature(&mesh).value() >= 4.0 * PI * (1.0 - 1e-9));
        }
    }

    #[test]
    fn thin_plate_energy_is_f1_and_a_constant(
        kind in 0_usize..3, seed: u64, a in -2.0_f64..2.0, b in -2.0_f64..2.0,
    ) {
        let start = mesh(kind, seed);
        let mut flipped = start.clone();
        scramble(&mut flipped, 20, &mut SplitMix64::new(seed), |_, _| true);
        let totals = |mesh: &TriMesh| Curvatures::of(mesh, &CurvatureOptions::default()).totals();
        let (before, after) = (totals(&start), totals(&flipped));
        let energy = after.thin_plate_energy(a, b) - before.thin_plate_energy(a, b);
        let expected = 4.0 * a * (after.f1 - before.f1);
        let size = 1.0 + 4.0 * a.abs() * (after.f1 + before.f1);
        prop_assert!((energy - expected).abs() < 1e-9 * size, "{} {}", energy, expected);
        let euler = {
            let t = start.topology();
            t.vertex_count() as f64 - t.edge_count() as f64 + t.face_count() as f64
        };
        let constant = 2.0 * (1.0 - a - b) * TAU * euler;
        let whole = before.thin_plate_energy(a, b);
        prop_assert!((whole - 4.0 * a * before.f1 - constant).abs() < 1e-9 * size.max(constant.abs()));
    }
}

#[test]
fn convex_surfaces_have_no_negative_part() {
    let sphere = TriMesh::from_soup(&Sphere { radius: 2.0 }.icosphere(3).unwrap()).unwrap();
    for v in sphere.topology().vertices() {
        assert!(extrinsic_curvature(&sphere, v).negative.value() < 1e-12);
    }
    assert!((total_extrinsic_curvature(&sphere).value() - 4.0 * PI).abs() < 1e-10);
}

/// A saddle: no half-space contains the star of its centre.
#[test]
fn saddle_vertices_have_no_positive_part() {
    let points =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, -0.5], [-1.0, 0.0, 0.5], [0.0, -1.0, -0.5]];
    let triangles = [[0_u32, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
    let mesh = TriMesh::from_triangles(&points, &triangles).unwrap();
    let center = mesh_core::VertexId::new(0);
    let found = extrinsic_curvature(&mesh, center);
    assert_eq!(found.positive.value(), 0.0);
    let curvatures = Curvatures::of(&mesh, &CurvatureOptions::default());
    assert!(
        (found.negative.value() + curvatures[center].integrals().angle_defect.value()).abs()
            < 1e-15
    );
}
