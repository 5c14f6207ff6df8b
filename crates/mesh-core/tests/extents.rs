//! The quick tests for triangles that do not cross are correct.
#![allow(clippy::unwrap_used)]

use core::f64::consts::TAU;

use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::crossing::Triangle;
use mesh_core::{FaceTree, TriMesh, TriangleBounds, VertexId, triangles_cross};
use mesh_shapes::Sphere;

/// On a coarse grid, so that much touches; anywhere; or in a needle.
fn corners(random: &mut SplitMix64, kind: usize) -> [DVec3; 3] {
    let mut point = || DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
    let [a, b, c] = [point(), point(), point()];
    match kind % 4 {
        0 => [a, b, c].map(|p| (2.0 * p).round()),
        1 => [a, b, c],
        2 => [a, b, b + 1e-4 * c],
        _ => [a, b, c].map(|p| 1e-200 * p),
    }
}

#[test]
fn triangles_that_cross_may_cross() {
    let mut random = SplitMix64::new(1);
    let (mut crossing, mut apart) = ([0; 2], [0; 2]);
    for round in 0..60_000 {
        let own = corners(&mut random, round);
        let mut other = corners(&mut random, round);
        let mut vertices = [3, 4, 5].map(VertexId::new);
        let common = (round / 4) % 3;
        for (i, &corner) in own.iter().enumerate().take(common) {
            // At any corner.
            let at = (round / 12 + i) % 3;
            (vertices[at], other[at]) = (VertexId::new(i as u32), corner);
        }
        let [one, two]: [Triangle; 2] = [([0, 1, 2].map(VertexId::new), own), (vertices, other)];
        let may_cross = TriangleBounds::new(one).may_cross(&TriangleBounds::new(two));
        assert_eq!(may_cross, TriangleBounds::new(two).may_cross(&TriangleBounds::new(one)));
        if triangles_cross(one, two) {
            assert!(may_cross, "{round}: {one:?} {two:?}");
            crossing[common.min(1)] += 1;
        } else if !may_cross {
            apart[common.min(1)] += 1;
        }
    }
    assert!(crossing.into_iter().chain(apart).all(|count| count > 1000), "{crossing:?} {apart:?}");
}

/// A closed cone with this number of faces.
fn closed_cone(faces: u32) -> TriMesh {
    let n = faces / 2;
    let rim = |i: u32| {
        let angle = TAU * f64::from(i) / f64::from(n);
        DVec3::new(angle.cos(), angle.sin(), 0.0)
    };
    let points: Vec<DVec3> = (0..n).map(rim).chain([DVec3::Z, -DVec3::Z]).collect();
    let sides = |i: u32| [[i, (i + 1) % n, n], [(i + 1) % n, i, n + 1]];
    TriMesh::from_triangles(&points, &(0..n).flat_map(sides).collect::<Vec<_>>()).unwrap()
}

#[test]
fn every_face_that_crosses_a_triangle_is_found() {
    let mut random = SplitMix64::new(2);
    let sphere = TriMesh::from_soup(&Sphere::UNIT.icosphere(2).unwrap()).unwrap();
    for mut mesh in [sphere, closed_cone(300)] {
        let mut tree = FaceTree::new(&mesh);
        let mut crossing = 0;
        for round in 0..2000 {
            // Faces that have moved cross others, too.
            let count = mesh.topology().vertex_count();
            let moved = VertexId::new((random.uniform() * count as f64) as u32);
            if round % 5 == 0 {
                mesh.positions_mut()[moved.index()] += 0.1 * corners(&mut random, 1)[0];
                tree.update(&mesh, mesh.topology().faces_of_vertex(moved));
            }
            let own = mesh.topology().faces_of_vertex(moved).next().unwrap();
            let mut vertices = mesh.topology().face_vertices(own);
            let mut places = mesh.triangle(own);
            let new = 1 + round % 3;
            for i in 0..new {
                vertices[i] = VertexId::new((count + i) as u32);
                places[i] += 0.3 * corners(&mut random, 1)[0];
            }
            let triangle = (vertices, places);
            let now = |f| (mesh.topology().face_vertices(f), mesh.triangle(f));
            let mut missing: Vec<_> =
                mesh.topology().faces().filter(|&f| triangles_cross(triangle, now(f))).collect();
            crossing += usize::from(!missing.is_empty());
            tree.find_crossing(&mesh, &TriangleBounds::new(triangle), |found| {
                missing.retain(|&face| face != found);
                false
            });
            assert_eq!(missing, []);
        }
        assert!(crossing > 500, "{crossing}");
    }
}

#[test]
fn few_faces_of_a_cone_are_compared_with_each_other() {
    for turn in [0.0, 0.6] {
        let asked = |faces: u32| {
            let mut mesh = closed_cone(faces);
            let turned = glam::DQuat::from_euler(glam::EulerRot::XYZ, turn, turn, 0.0);
            mesh.positions_mut().iter_mut().for_each(|p| *p = turned * *p);
            let tree = FaceTree::new(&mesh);
            let mut asked = 0;
            for face in mesh.topology().faces().step_by(faces as usize / 100) {
                let triangle = (mesh.topology().face_vertices(face), mesh.triangle(face));
                let found = tree.find_crossing(&mesh, &TriangleBounds::new(triangle), |_| {
                    asked += 1;
                    false
                });
                assert_eq!(found, None);
            }
            asked
        };
        let [small, large] = [2000, 16_000].map(asked);
        // Eight times as many if each face is compared with a fixed share of all.
        assert!(large < 2 * small, "{turn}: {small} {large}");
    }
}

/// A star of spikes of random lengths. Sorted by place, spikes of very different directions would be neighbours.
#[test]
fn few_faces_of_a_star_are_compared_with_each_other() {
    let asked = |spikes: u32| {
        let mut random = SplitMix64::new(3);
        let at = |radius: f64, i: f64| {
            let angle = TAU * i / f64::from(spikes);
            DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.1 * radius)
        };
        let mut points: Vec<DVec3> = (0..spikes).map(|i| at(0.3, f64::from(i))).collect();
        points.extend((0..spikes).map(|i| at(0.3 + 0.7 * random.uniform(), f64::from(i) + 0.5)));
        points.push(DVec3::ZERO);
        let faces = |i: u32| {
            let next = (i + 1) % spikes;
            [[i, spikes + i, next], [2 * spikes, i, next]]
        };
        let triangles: Vec<[u32; 3]> = (0..spikes).flat_map(faces).collect();
        let mesh = TriMesh::from_triangles(&points, &triangles).unwrap();
        let tree = FaceTree::new(&mesh);
        let mut asked = 0;
        for face in mesh.topology().faces().step_by(2 * spikes as usize / 101) {
            let triangle = (mesh.topology().face_vertices(face), mesh.triangle(face));
            tree.find_crossing(&mesh, &TriangleBounds::new(triangle), |_| {
                asked += 1;
                false
            });
        }
        asked
    };
    let [small, large] = [2000, 16_000].map(asked);
    // Eight times as many if each face is compared with a fixed share of all.
    assert!(large < 2 * small, "{small} {large}");
}
