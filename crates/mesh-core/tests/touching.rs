//! Closed surfaces that touch themselves come apart closed.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::BTreeSet;

use mesh_core::glam::{DQuat, DVec3};
use mesh_core::{PolygonSoup, Repair, Weld, build, cut_non_manifold, diagnose};
use proptest::prelude::*;

/// Walls between cubes that lie on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Walls {
    None,
    SameTriangles,
    OtherTriangles,
}

/// The surface of some cubes of a grid of 3 x 3 x 3, each with `parts` x `parts` squares on a side, turned, and rounded
/// to single precision.
fn voxels(
    bits: u32,
    parts: u32,
    walls: Walls,
    turn: DQuat,
    reversed: bool,
) -> (PolygonSoup, usize) {
    let cubes: BTreeSet<[i32; 3]> = (0..27)
        .filter(|bit| bits >> bit & 1 == 1)
        .map(|bit| [bit % 3, bit / 3 % 3, bit / 9])
        .collect();
    let mut soup = PolygonSoup::new();
    let mut put = |corners: [DVec3; 3]| {
        let first = soup.vertex_count() as u32;
        for p in corners {
            soup.push_vertex((turn * p).as_vec3().as_dvec3());
        }
        let face =
            if reversed { [first, first + 2, first + 1] } else { [first, first + 1, first + 2] };
        soup.push_face(&face).unwrap();
    };
    for &cube in &cubes {
        for axis in 0..3 {
            for side in 0..2 {
                let mut beyond = cube;
                beyond[axis] += 2 * side - 1;
                if walls == Walls::None && cubes.contains(&beyond) {
                    continue;
                }
                let axes = [axis, (axis + 1) % 3, (axis + 2) % 3];
                let place = |u: u32, v: u32| {
                    let mut p = DVec3::from(cube.map(f64::from));
                    p[axes[0]] += f64::from(side);
                    p[axes[1]] += f64::from(u) / f64::from(parts);
                    p[axes[2]] += f64::from(v) / f64::from(parts);
                    p
                };
                for (u, v) in (0..parts).flat_map(|u| (0..parts).map(move |v| (u, v))) {
                    let [a, b, c, d] =
                        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| place(u + i, v + j));
                    let is_other = side == 1 && walls == Walls::OtherTriangles;
                    let halves =
                        if is_other { [[b, c, d], [b, d, a]] } else { [[a, b, c], [a, c, d]] };
                    for [p, q, r] in halves {
                        put(if side == 1 { [p, q, r] } else { [p, r, q] });
                    }
                }
            }
        }
    }
    (soup, cubes.len())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Cubes touch with faces, along edges and in vertices in every way. The result is closed, manifold and oriented, and encloses
    /// the cubes.
    #[test]
    fn voxels_stay_closed(
        bits in any::<u32>(),
        thin in any::<u32>(),
        parts in 1_u32..4,
        walls in prop_oneof![Just(Walls::None), Just(Walls::SameTriangles), Just(Walls::OtherTriangles)],
        angle in prop_oneof![Just(0.0), 0.1..1.0],
        reversed in any::<bool>(),
    ) {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), angle);
        let (soup, cubes) = voxels(bits & thin, parts, walls, turn, reversed);
        let mut repair = Repair::strict();
        repair.weld = Weld::Exact;
        repair.cut_non_manifold = true;
        repair.drop_duplicates = true;
        let built = build(&soup, &repair).unwrap();
        built.mesh.topology().validate().unwrap();
        let found = diagnose(&built.mesh.to_soup()).unwrap();
        prop_assert_eq!(found.boundary_edges, 0);
        prop_assert!(cubes == 0 || found.is_closed());
        let volume = built.mesh.volume() * if reversed { -1.0 } else { 1.0 };
        prop_assert!((volume - cubes as f64).abs() < 1e-4, "{} cubes, volume {}", cubes, volume);
        prop_assert_eq!(built.mesh.topology().face_count(), soup.face_count());
    }
}

/// Boxes that lie on each other with walls of different triangles stay two boxes.
#[test]
fn walls_on_each_other_stay_apart() {
    let mut soup = PolygonSoup::new();
    let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
    for z in 0..3 {
        corners
            .iter()
            .for_each(|[x, y]| soup.push_vertex([f64::from(*x), f64::from(*y), f64::from(z)]));
    }
    for bottom in [0, 4] {
        let quads =
            [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
        for quad in quads.map(|quad| quad.map(|v: u32| v + bottom)) {
            let [a, b, c, d] = quad;
            soup.push_face(&[a, b, c]).unwrap();
            soup.push_face(&[a, c, d]).unwrap();
        }
    }
    let mut repair = Repair::strict();
    repair.cut_non_manifold = true;
    let built = build(&soup, &repair).unwrap();
    let found = diagnose(&built.mesh.to_soup()).unwrap();
    assert!(found.is_closed());
    assert_eq!((found.components, found.euler_characteristic), (2, 4));
    assert!((built.mesh.volume() - 2.0).abs() < 1e-12);
}

/// A sheet that is given once per side keeps one side, also where it is a fin on a closed surface: both sides would be a
/// closed part without a volume.
#[test]
fn sheets_without_a_volume_keep_one_side() {
    let positions: Vec<DVec3> = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 2, 2], [3, 2, 2]]
        .map(|p: [i32; 3]| DVec3::from(p.map(f64::from)))
        .to_vec();
    let solid = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let fins: [&[[u32; 3]]; 3] = [
        &[[1, 2, 4], [4, 2, 1]],
        &[[1, 2, 4], [4, 2, 1], [1, 4, 5], [5, 4, 1]],
        &[[4, 5, 1], [1, 5, 4]],
    ];
    for fin in fins {
        let soup = PolygonSoup::from_triangles(&positions, &[&solid, fin].concat()).unwrap();
        let built = build(&soup, &Repair::lenient()).unwrap();
        assert_eq!(built.mesh.topology().face_count(), 4 + fin.len() / 2);
        assert_eq!(diagnose(&built.mesh.to_soup()).unwrap().duplicate_faces, 0);
    }
}

/// Three sheets that meet in an edge have no inside; all get a boundary there.
#[test]
fn a_fin_is_cut_off() {
    let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_Y, DVec3::Z];
    let mut triangles = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    let copies = cut_non_manifold(&positions, &mut triangles).unwrap();
    let mut sources = copies;
    sources.sort_unstable();
    assert_eq!(sources, [0, 0, 1, 1]);
    assert!(cut_non_manifold(&positions, &mut [[0, 1, 5]]).is_err());
}
