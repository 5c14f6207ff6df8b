//! Closed surfaces that touch themselves come apart closed.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::BTreeSet;

use mesh_core::build::count_seam_edges;
use mesh_core::glam::{DQuat, DVec3};
use mesh_core::{Built, PolygonSoup, Repair, SplitMix64, Weld, build, cut_non_manifold, diagnose};
use proptest::prelude::*;

/// Walls between cubes that lie on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Walls {
    None,
    SameTriangles,
    OtherTriangles,
}

/// Adds a triangle with vertices of its own.
fn push(soup: &mut PolygonSoup, corners: [DVec3; 3]) {
    let first = soup.vertex_count() as u32;
    corners.into_iter().for_each(|p| soup.push_vertex(p));
    soup.push_face(&[first, first + 1, first + 2]).unwrap();
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
        let [a, b, c] = corners.map(|p| (turn * p).as_vec3().as_dvec3());
        push(&mut soup, if reversed { [a, c, b] } else { [a, b, c] });
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

/// Three sheets meet in an edge: the two that run straight on stay joined, whatever their order.
#[test]
fn what_runs_straight_on_stays_joined() {
    let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.5, -1.0, 0.1), DVec3::Z];
    let sheets = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    for turn in 0..3 {
        let mut triangles = sheets;
        triangles.rotate_left(turn);
        let mut copies = cut_non_manifold(&positions, &mut triangles).unwrap();
        copies.sort_unstable();
        assert_eq!(copies, [0, 1]);
        triangles.rotate_right(turn);
        let [[a, b, _], [d, c, _], [e, f, _]] = triangles;
        assert_eq!([a, b], [c, d]);
        assert!(a != e && b != f);
    }
    assert!(cut_non_manifold(&positions, &mut [[0, 1, 5]]).is_err());
}

/// A wall across a floor: the floor stays whole, whether it goes on around the ends of the wall or not, and whether it is
/// flat or bends more at the foot than the wall does.
#[test]
fn a_floor_stays_whole_under_a_wall() {
    for (width, bend) in [(5, 0.0), (9, 0.0), (9, 3.0)] {
        let mut soup = PolygonSoup::new();
        let quad = |soup: &mut PolygonSoup, corners: [[f64; 3]; 4]| {
            let [a, b, c, d] = corners.map(DVec3::from);
            [[a, b, c], [a, c, d]].into_iter().for_each(|half| push(soup, half));
        };
        let place = |x: i32, y: i32| [f64::from(x), f64::from(y), -bend * f64::from(y.abs())];
        for (x, y) in (0..width).flat_map(|x| (-2..2).map(move |y| (x, y))) {
            quad(
                &mut soup,
                [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]].map(|[x, y]| place(x, y)),
            );
        }
        let floor = soup.face_count() as u32;
        let over = |x: i32| [f64::from(x), -1.0, 1.0];
        let first = (width - 5) / 2;
        for x in first..first + 5 {
            quad(&mut soup, [place(x, 0), place(x + 1, 0), over(x + 1), over(x)]);
        }
        let mut repair = Repair::strict();
        (repair.weld, repair.cut_non_manifold) = (Weld::Exact, true);
        let built = build(&soup, &repair).unwrap();
        let found = diagnose(&built.mesh.to_soup()).unwrap();
        assert_eq!((found.components, found.boundary_loops), (2, 2), "{width} {bend}");
        assert_eq!(floor_rim(&built, floor), 2 * width as usize + 8);
    }
}

/// A book: pages around one edge, which face either way. The time grows with the pages, not with their square.
#[test]
fn pages_around_one_edge_come_apart() {
    let mut positions = vec![DVec3::ZERO, DVec3::Z];
    let mut triangles = Vec::new();
    let mut random = SplitMix64::new(1);
    for page in 0..20_000_u32 {
        let (y, x) = (f64::from(page) * 1e-4).sin_cos();
        positions.push(DVec3::new(x, y, 0.5));
        let [a, b] = if random.uniform() < 0.5 { [0, 1] } else { [1, 0] };
        triangles.push([a, b, page + 2]);
    }
    let back = triangles.iter().filter(|triangle| triangle[0] == 1).count();
    cut_non_manifold(&positions, &mut triangles).unwrap();
    let mut edges: Vec<[u32; 2]> =
        triangles.iter().map(|&[a, b, _]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.dedup();
    assert_eq!(edges.len(), back.max(20_000 - back));
}

/// The open edges of the faces whose source is below a number.
fn floor_rim(built: &Built, end: u32) -> usize {
    let faces = built.provenance.face_source.iter().zip(built.mesh.topology().triangles());
    let triangles: Vec<_> = faces.filter(|(source, _)| **source < end).map(|(_, t)| t).collect();
    let soup = PolygonSoup::from_triangles(built.mesh.positions(), &triangles).unwrap();
    diagnose(&soup).unwrap().boundary_edges
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Sheets stand on the surface of cubes, outside and inside, several on an edge as well. The surface stays closed.
    #[test]
    fn solids_stay_closed_under_fins(
        bits in any::<u32>(),
        thin in any::<u32>(),
        parts in 1_u32..3,
        fins in prop::collection::vec(
            (any::<prop::sample::Index>(), 1_u32..4, prop::array::uniform3(-1.0..1.0), any::<bool>()),
            1..5,
        ),
    ) {
        let (mut soup, _) = voxels(bits & thin | 1, parts, Walls::None, DQuat::IDENTITY, false);
        let solid = soup.face_count();
        for (foot, squares, rise, is_reversed) in fins {
            let face = foot.index(solid);
            let [a, b] = [0, 1].map(|k| soup.positions()[soup.face(face)[k] as usize]);
            let along = b - a;
            for square in 0..squares {
                let [p, q] = [square, square + 1].map(|k| a + f64::from(k) * along);
                let rise = DVec3::from(rise) + DVec3::splat(0.003);
                let [a, b, c, d] = [p, q, q + rise, p + rise];
                let halves = if is_reversed { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] };
                halves.into_iter().for_each(|half| push(&mut soup, half));
            }
        }
        let mut repair = Repair::strict();
        (repair.weld, repair.cut_non_manifold) = (Weld::Exact, true);
        (repair.drop_duplicates, repair.reorient) = (true, true);
        let built = build(&soup, &repair).unwrap();
        built.mesh.topology().validate().unwrap();
        prop_assert_eq!(floor_rim(&built, solid as u32), 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// A surface of cubes whose faces have vertices of their own is closed after its seams are joined.
    #[test]
    fn faces_with_vertices_of_their_own_are_joined(
        bits in any::<u32>(),
        thin in any::<u32>(),
        parts in 1_u32..4,
        angle in prop_oneof![Just(0.0), 0.1..1.0],
    ) {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), angle);
        let (soup, cubes) = voxels(bits & thin, parts, Walls::None, turn, false);
        let mut repair = Repair::strict();
        (repair.weld, repair.cut_non_manifold) = (Weld::Seams, true);
        let built = build(&soup, &repair).unwrap();
        let found = diagnose(&built.mesh.to_soup()).unwrap();
        prop_assert_eq!(found.boundary_edges, 0);
        prop_assert_eq!(count_seam_edges(&built.mesh.to_soup()), 0);
        prop_assert!((built.mesh.volume() - cubes as f64).abs() < 1e-4);
    }
}
