//! Vertices without faces have no effect.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::TriMesh;
use mesh_shapes::{Irregular, Wave};
use simplify::{ErrorCheck, Options, Preset, Simplified, simplify};

/// A wave, and a copy with an unused vertex far away.
fn wave_and_stray() -> [TriMesh; 2] {
    let wave = Wave { amplitude: 0.15, wavelength: 1.1, half_width: 1.0 };
    let soup = wave.irregular_mesh(24, Irregular { jitter: 0.2, seed: 4 }).unwrap();
    let mesh = TriMesh::from_soup(&soup).unwrap();
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    let mut positions = mesh.positions().to_vec();
    positions.push(DVec3::new(1e5, -2e5, 3e5));
    let stray = TriMesh::from_triangles(&positions, &triangles).unwrap();
    [mesh, stray]
}

fn assert_same_surface(expected: &Simplified, got: &Simplified) {
    let triangles = |result: &Simplified| -> Vec<[DVec3; 3]> {
        result.mesh.topology().faces().map(|f| result.mesh.triangle(f)).collect()
    };
    assert_eq!(triangles(expected), triangles(got));
}

#[test]
fn an_unused_vertex_far_away_is_no_peak() {
    let [mesh, stray] = wave_and_stray();
    let options = Options::preset(Preset::Quality).to_faces(150);
    let [expected, got] = [&mesh, &stray].map(|mesh| simplify(mesh, &options).unwrap());
    let reduced = expected.max_error.as_ref().unwrap();
    assert!(reduced.rounds > 0 && reduced.largest_before < 0.1);
    assert_eq!(got.max_error.as_ref().unwrap().largest_before, reduced.largest_before);
    assert_same_surface(&expected, &got);
}

#[test]
fn an_unused_vertex_far_away_does_not_spoil_the_search_for_an_error_limit() {
    let [mesh, stray] = wave_and_stray();
    for decimate in [false, true] {
        let mut options = Options::preset(Preset::Default).within(0.02, ErrorCheck::Sampled);
        options.tolerance.decimate = decimate;
        let [expected, got] = [&mesh, &stray].map(|mesh| simplify(mesh, &options).unwrap());
        assert!(2 * expected.mesh.topology().face_count() < mesh.topology().face_count());
        assert_eq!(expected.log.len(), got.log.len());
        assert_same_surface(&expected, &got);
    }
}
