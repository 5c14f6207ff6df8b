//! Proved error limits, and the number of faces that remain within them.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use crate::common::model;
use std::collections::HashMap;

use mesh_core::{PolygonSoup, Repair, TriMesh, build};
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use mesh_shapes::{Irregular, Sphere, Wave};
use simplify::{ErrorCheck, Options, Preset, simplify};

/// In percent of the diagonal of the bounding box.
const TOLERANCES: [f64; 3] = [0.05, 0.2, 1.0];

/// The number of faces that a preset leaves, with the distance proved again to be within the limit.
fn faces_within(mesh: &TriMesh, percent: f64, preset: Preset) -> usize {
    let original = Surface::new(mesh).unwrap();
    let limit = percent / 100.0 * original.bounding_box().diagonal();
    let options = Options::preset(preset).within(limit, ErrorCheck::Certified);
    let result = simplify(mesh, &options).unwrap();
    assert!(result.error.unwrap().is_within(limit));
    let surface = Surface::new(&result.mesh).unwrap();
    let tight = CertifyOptions { tolerance: 1e-4 * limit, ..CertifyOptions::default() };
    let proved = hausdorff_bounds(&original, &surface, &tight);
    assert!(proved.upper <= 1.0001 * limit, "{percent} % {preset}: {proved:?}");
    result.mesh.topology().face_count()
}

fn check(name: &str, mesh: &TriMesh) {
    for percent in TOLERANCES {
        let presets = [Preset::Default, Preset::Fast, Preset::Quality];
        let [default, fast, quality] = presets.map(|preset| faces_within(mesh, percent, preset));
        let least = default.min(fast).min(quality);
        assert!(
            4 * default <= 5 * least,
            "{name} {percent} %: default {default}, fast {fast}, quality {quality}"
        );
    }
}

#[test]
fn the_default_is_near_the_smallest_within_a_proved_error_on_a_sphere() {
    let soup = Sphere { radius: 1.0 }.icosphere(4).unwrap();
    let mesh = build(&soup, &Repair::strict()).unwrap().mesh;
    check("sphere", &mesh);
    // A face that spans an angle a lies at most a²/6 below the sphere, so that far fewer faces are needed than at the
    // start.
    assert!(faces_within(&mesh, 1.0, Preset::Default) < mesh.topology().face_count() / 10);
}

#[test]
fn the_default_is_near_the_smallest_within_a_proved_error_on_real_meshes() {
    for name in ["saddle.obj", "suzanne.obj"] {
        if let Some(mesh) = model(name) {
            check(name, &mesh);
        }
    }
}

/// With several threads, distances are computed ahead, and collapses in between change them. This matters most on flat
/// parts, where many neighbouring edges have the same cost.
#[test]
fn threads_do_not_change_a_bit() {
    let wave = Wave { amplitude: 0.15, wavelength: 0.7, half_width: 1.0 };
    let soup = wave.irregular_mesh(60, Irregular { jitter: 0.2, seed: 4 }).unwrap();
    let mut mesh = TriMesh::from_soup(&soup).unwrap();
    for p in mesh.positions_mut() {
        p.z = if p.x < 0.0 { 0.5 * p.x } else { p.z };
    }
    for (check, limit) in [(ErrorCheck::Sampled, 0.005), (ErrorCheck::Certified, 0.02)] {
        let options = Options::preset(Preset::Fast).within(limit, check);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| simplify(&mesh, &options).unwrap())
        };
        let one = run(1);
        assert!(2 * one.mesh.topology().face_count() < mesh.topology().face_count());
        for threads in [2, 3, 8] {
            let other = run(threads);
            assert_eq!(one.mesh.positions(), other.mesh.positions(), "{threads}");
            assert!(one.mesh.topology().triangles().eq(other.mesh.topology().triangles()));
            assert_eq!((one.error, one.rejections), (other.error, other.rejections));
            assert_eq!(one.vertex_map, other.vertex_map);
        }
    }
}

/// A sphere in which pairs of faces are cut out and put back as parts of their own. All edges of such a part lie on the
/// rest. If one of its faces disappears, its edges are still within the limit, but its interior is not.
fn sphere_with_loose_faces(every: usize) -> TriMesh {
    let soup = Sphere { radius: 1.0 }.icosphere(4).unwrap();
    let (mut positions, whole) = (soup.positions().to_vec(), TriMesh::from_soup(&soup).unwrap());
    let topology = whole.topology();
    let mut part = vec![None; topology.face_count()];
    for edge in topology.edges().step_by(every) {
        let faces = [edge.half_edge(), edge.half_edge().twin()].map(|h| topology.face(h).unwrap());
        if faces.iter().all(|face| part[face.index()].is_none()) {
            faces.iter().for_each(|face| part[face.index()] = Some(edge));
        }
    }
    let mut copies = HashMap::new();
    let mut triangles = Vec::new();
    for (face, corners) in topology.triangles().enumerate() {
        triangles.push(corners.map(|v| match part[face] {
            None => v,
            Some(edge) => *copies.entry((edge, v)).or_insert_with(|| {
                positions.push(soup.positions()[v as usize]);
                positions.len() as u32 - 1
            }),
        }));
    }
    let soup = PolygonSoup::from_triangles(&positions, &triangles).unwrap();
    // Without welding, the copies stay apart.
    let mut repair = Repair::strict();
    repair.cut_non_manifold = true;
    build(&soup, &repair).unwrap().mesh
}

#[test]
fn a_face_whose_edges_are_covered_by_others_does_not_stop_the_decimation() {
    // The fewer parts are loose, the fewer faces must stay.
    for (every, share) in [(7, 0.85), (40, 0.5), (300, 0.4)] {
        let mesh = sphere_with_loose_faces(every);
        let (before, after) =
            (mesh.topology().face_count(), faces_within(&mesh, 0.1, Preset::Default));
        assert!((after as f64) < share * before as f64, "{every}: {before} -> {after}");
    }
}
