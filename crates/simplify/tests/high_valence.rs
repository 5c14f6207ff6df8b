//! Vertices of very high valence, as at the caps of cones and cylinders, do not take a disproportionate time.
#![allow(clippy::unwrap_used)]

use core::f64::consts::TAU;
use core::sync::atomic::{AtomicU64, Ordering};
use std::ops::ControlFlow;
use std::sync::Arc;

use glam::{DQuat, DVec3, EulerRot};
use mesh_core::{FaceTree, TriMesh, TriangleBounds, VertexId};
use simplify::{
    Cost, EdgePatch, Memoryless, Optimal, Options, Policies, Policy, Preset, Quadric,
    RefineOptions, Schedule, Scratch, StopReason, Target, collapse_edges, simplify,
};

/// A cone with this many faces, optionally closed by a second cone below.
fn cone(faces: u32, is_closed: bool) -> TriMesh {
    let rim = |i: u32| {
        let angle = TAU * f64::from(i) / f64::from(faces);
        DVec3::new(angle.cos(), angle.sin(), 0.0)
    };
    let mut points: Vec<DVec3> = (0..faces).map(rim).collect();
    points.extend([DVec3::Z, -DVec3::Z]);
    let sides = |i: u32| {
        let (a, b) = (i, (i + 1) % faces);
        [[a, b, faces], [b, a, faces + 1]]
    };
    let triangles: Vec<[u32; 3]> =
        (0..faces).flat_map(|i| sides(i).into_iter().take(1 + usize::from(is_closed))).collect();
    points.truncate(faces as usize + 1 + usize::from(is_closed));
    TriMesh::from_triangles(&points, &triangles).unwrap()
}

/// A cost that counts the faces that it was evaluated with.
struct Counted(Memoryless, Arc<AtomicU64>);

impl Policy for Counted {}

impl Cost for Counted {
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        self.1.fetch_add(patch.faces().len() as u64, Ordering::Relaxed);
        self.0.quadric(patch)
    }

    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> f64 {
        self.0.cost(patch, quadric, x, scratch)
    }
}

#[test]
fn the_work_on_a_cone_does_not_grow_with_the_square_of_its_faces() {
    let faces_seen = |faces: u32, schedule: Schedule| {
        let mut mesh = cone(faces, true);
        let seen = Arc::new(AtomicU64::new(0));
        let cost = Counted(Memoryless, Arc::clone(&seen));
        let mut policies = Policies::new(cost, Optimal::default());
        policies.schedule = schedule;
        let limits = Target { faces: Some(100), ..Target::default() };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let run = collapse_edges(&mut mesh, policies, &Default::default(), &limits, go_on);
        assert_eq!(run.stop, StopReason::Faces);
        mesh.topology().validate().unwrap();
        seen.load(Ordering::Relaxed)
    };
    for schedule in [Schedule::Lazy, Schedule::Exact] {
        let [small, large] = [2000, 16_000].map(|faces| faces_seen(faces, schedule));
        // The ratio would be 64 if every edge at the apex visited all faces of the apex.
        assert!(large < 16 * small, "{schedule:?}: {small} {large}");
    }
}

#[test]
fn cones_of_sixty_thousand_faces_are_collapsed() {
    for preset in [Preset::Fast, Preset::Default] {
        let mut options = Options::preset(preset).to_faces(2000);
        // The distances of a fit are not part of this test.
        options.refine = RefineOptions::none();
        for is_closed in [false, true] {
            let result = simplify(&cone(60_000, is_closed), &options).unwrap();
            let topology = result.mesh.topology();
            topology.validate().unwrap();
            let faces = topology.face_count();
            assert!((1999..=2000).contains(&faces), "{preset}: {faces} {:?}", result.rejections);
        }
    }
}

/// A closed cylinder of radius and height 1 with this many sides, caps as fans around their centres.
fn cylinder(sides: u32) -> TriMesh {
    let rim = |i: u32, z: f64| {
        let angle = TAU * f64::from(i) / f64::from(sides);
        DVec3::new(angle.cos(), angle.sin(), z)
    };
    let mut points: Vec<DVec3> = (0..sides).map(|i| rim(i, 0.0)).collect();
    points.extend((0..sides).map(|i| rim(i, 1.0)));
    points.extend([DVec3::ZERO, DVec3::Z]);
    let faces = |i: u32| {
        let (a, b) = (i, (i + 1) % sides);
        let (above_a, above_b) = (sides + a, sides + b);
        let (below, above) = (2 * sides, 2 * sides + 1);
        [[a, b, above_b], [a, above_b, above_a], [b, a, below], [above_a, above_b, above]]
    };
    let triangles: Vec<[u32; 3]> = (0..sides).flat_map(faces).collect();
    TriMesh::from_triangles(&points, &triangles).unwrap()
}

/// The sides are slivers. Collapses along a rim make the slivers beside it a little more oblique.
#[test]
fn cylinders_of_slivers_lose_their_faces() {
    for preset in [Preset::Draft, Preset::Default] {
        for sides in [700, 2000, 5000] {
            let mut options = Options::preset(preset).to_faces(400);
            options.refine = RefineOptions::none();
            let result = simplify(&cylinder(sides), &options).unwrap();
            let faces = result.mesh.topology().face_count();
            assert!((399..=400).contains(&faces), "{preset} {sides}: {faces}");
        }
    }
}

#[test]
fn rejected_edges_at_a_cap_are_tried_a_few_times() {
    for sides in [400, 2000] {
        let mut options = Options::preset(Preset::Default).to_faces(400);
        options.refine = RefineOptions::none();
        let result = simplify(&cylinder(sides), &options).unwrap();
        let rejected = result.rejections.total() as u64;
        // Once for each collapse beside a cap, it would be hundreds for each face.
        assert!(rejected < 20 * 4 * u64::from(sides), "{sides}: {rejected}");
    }
}

/// The number of faces that are compared with the faces of some vertices after a small move.
fn faces_compared(mesh: &TriMesh, vertices: impl Iterator<Item = u32>) -> usize {
    let (topology, tree) = (mesh.topology(), FaceTree::new(mesh));
    let mut compared = 0;
    for moved in vertices.map(VertexId::new) {
        for face in topology.faces_of_vertex(moved) {
            let corners = topology.face_vertices(face);
            let place = |v| mesh.position(v) * if v == moved { 1.0001 } else { 1.0 };
            let extent = TriangleBounds::new((corners, corners.map(place)));
            tree.find_crossing(mesh, &extent, |_| {
                compared += 1;
                false
            });
        }
    }
    compared
}

#[test]
fn a_face_of_a_cone_is_compared_with_few_others_for_intersections() {
    let flat = |faces: u32| {
        let mut mesh = cone(faces, true);
        mesh.positions_mut().iter_mut().for_each(|p| p.z = p.z.max(0.0));
        mesh
    };
    let turned = |faces: u32| {
        let mut mesh = cone(faces, true);
        let turn = DQuat::from_euler(EulerRot::XYZ, 0.7, 0.5, 0.0);
        mesh.positions_mut().iter_mut().for_each(|p| *p = turn * *p);
        mesh
    };
    let shapes: [(&str, &dyn Fn(u32) -> TriMesh); 4] = [
        ("open", &|faces| cone(faces, false)),
        ("closed", &|faces| cone(faces, true)),
        ("flat below", &flat),
        ("turned", &turned),
    ];
    for (name, shape) in shapes {
        let [small, large] = [1000, 8000]
            .map(|faces| faces_compared(&shape(faces), (0..faces).step_by(faces as usize / 50)));
        // The ratio would be 8 if a fixed share of all faces were compared.
        assert!(large < 2 * small, "{name}: {small} {large}");
    }
}
