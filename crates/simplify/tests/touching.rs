//! Assemblies: parts that touch at vertices with equal positions.
#![allow(clippy::unwrap_used)]

use std::collections::HashMap;

use crate::common::joined;
use glam::{DQuat, DVec3};
use mesh_core::{FaceId, TriMesh};
use mesh_shapes::polyhedra;
use simplify::{Options, Preset, simplify};

/// Copies of a part on a grid of this width, in one mesh, not connected.
fn assembly(width: i32, part: impl Fn(DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>)) -> TriMesh {
    let place = |place: i32| {
        let [x, y, z] = [place % width, place / width % width, place / width / width];
        part(DVec3::from([x, y, z].map(f64::from)))
    };
    joined(&(0..width.pow(3)).map(place).collect::<Vec<_>>())
}

/// A box with side 1 and its lowest corner at `at`. Each side is cut into squares, and each square into two triangles.
fn cut_box(at: DVec3, cells: i32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut numbers: HashMap<[i32; 3], u32> = HashMap::new();
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [0, cells] {
            let mut corner = |i: i32, j: i32| {
                let mut place = [0; 3];
                (place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3]) = (side, i, j);
                *numbers.entry(place).or_insert_with(|| {
                    let whole = at * f64::from(cells) + DVec3::from(place.map(f64::from));
                    points.push(whole / f64::from(cells));
                    points.len() as u32 - 1
                })
            };
            for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
                let (a, b) = (corner(i, j), corner(i + 1, j));
                let (c, d) = (corner(i + 1, j + 1), corner(i, j + 1));
                let both = if side == 0 { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] };
                triangles.extend(both);
            }
        }
    }
    (points, triangles)
}

/// A sphere of diameter 1 around `at`, with vertices at its six poles.
fn poled_sphere(at: DVec3, cuts: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut mesh = TriMesh::from_soup(&polyhedra::octahedron()).unwrap();
    for p in mesh.positions_mut() {
        *p = p.normalize();
    }
    for _ in 0..cuts {
        let (topology, _) = mesh.topology().subdivide_1_to_4().unwrap();
        let mut points = mesh.positions().to_vec();
        points.extend(mesh.topology().edges().map(|e| {
            let [a, b] = mesh.topology().edge_vertices(e);
            (mesh.position(a) + mesh.position(b)).normalize()
        }));
        mesh = TriMesh::new(topology, points).unwrap();
    }
    let points = mesh.positions().iter().map(|p| at + 0.5 * p).collect();
    (points, mesh.topology().triangles().collect())
}

/// The number of faces that edges of other parts pass through, at least `margin` away from their sides.
fn piercings(mesh: &TriMesh, margin: f64) -> usize {
    let topology = mesh.topology();
    let part = topology.components().of_vertex;
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let pierces = |p: DVec3, q: DVec3, f: FaceId| {
        let [a, b, c] = mesh.triangle(f);
        let (above, below) = (volume(a, b, c, p), volume(a, b, c, q));
        let round = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
        above.abs().min(below.abs()) > margin
            && above.signum() != below.signum()
            && (round.iter().all(|&v| v > margin) || round.iter().all(|&v| v < -margin))
    };
    let mut count = 0;
    for e in topology.edges() {
        let [p, q] = topology.edge_vertices(e);
        let (from, to) = (mesh.position(p), mesh.position(q));
        let is_other = |f: &FaceId| part[topology.face_vertices(*f)[0]] != part[p];
        count += topology.faces().filter(is_other).filter(|&f| pierces(from, to, f)).count();
    }
    count
}

#[test]
fn boxes_side_by_side_come_to_their_target() {
    // Rotated, so that no two walls are exactly coplanar.
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let boxes = assembly(3, |at| {
        let (points, triangles) = cut_box(at, 5);
        (points.into_iter().map(|p| turn * p).collect(), triangles)
    });
    let before = boxes.topology().face_count();
    for preset in [Preset::Fast, Preset::Default] {
        let target = before / 10;
        let mut options = Options::preset(preset).to_faces(target);
        options.protect.forbid_intersections = true;
        let result = simplify(&boxes, &options).unwrap();
        let faces = result.mesh.topology().face_count();
        assert!(faces <= target, "{preset}: {faces} of {before}, not {target}");
        assert_eq!(piercings(&result.mesh, 1e-4), 0, "{preset}");
    }
}

#[test]
fn spheres_that_touch_at_their_poles_come_to_their_target_and_do_not_cross() {
    let spheres = assembly(3, |at| poled_sphere(at, 3));
    let before = spheres.topology().face_count();
    for preset in [Preset::Fast, Preset::Default] {
        let target = before / 10;
        let mut options = Options::preset(preset).to_faces(target);
        options.protect.forbid_intersections = true;
        let result = simplify(&spheres, &options).unwrap();
        let faces = result.mesh.topology().face_count();
        assert!(faces <= target, "{preset}: {faces} of {before}, not {target}");
        assert_eq!(piercings(&result.mesh, 1e-9), 0, "{preset}");
    }
}
