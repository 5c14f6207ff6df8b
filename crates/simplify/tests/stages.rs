//! Stages of runs as levels of detail.
#![allow(clippy::unwrap_used)]

use crate::any_mesh::random_mesh;
use mesh_core::TriMesh;
use mesh_metric::Surface;
use mesh_shapes::{Irregular, Sphere, Wave, add_normal_noise};
use simplify::{
    FitConstraints, Options, Preset, Stages, StopReason, UnfoldOptions, simplify, unfold,
};

/// Rough surfaces, on which chains of collapses turn faces over.
fn rough(seed: u64, noise: f64) -> [TriMesh; 2] {
    let wave = Wave { amplitude: 0.15, wavelength: 0.4, half_width: 1.0 };
    let irregular = Irregular { jitter: 0.2, seed };
    [wave.irregular_mesh(40, irregular).unwrap(), Sphere::UNIT.icosphere(4).unwrap()].map(
        |mut soup| {
            add_normal_noise(&mut soup, noise, seed);
            TriMesh::from_soup(&soup).unwrap()
        },
    )
}

fn turned_over(mesh: &TriMesh, original: &Surface) -> usize {
    let (mesh, constraints) = (&mut mesh.clone(), FitConstraints::default());
    unfold(mesh, original, &constraints, &UnfoldOptions::default()).turned_before
}

/// Also, the boundary and vertices that the collapses have not moved stay where they are.
#[test]
fn faces_that_collapses_turn_over_are_turned_back_in_stages() {
    let (mut before, mut after) = (0, 0);
    for mesh in (0..8).flat_map(|seed| rough(seed, 0.7)) {
        let options = Options::preset(Preset::Fast).for_levels();
        let log = simplify(&mesh, &options.to_faces(40)).unwrap().log;
        let original = Surface::new(&mesh).unwrap();
        let stages = Stages::new(&mesh, &log, Options::default());
        for collapses in (1..=8).map(|part| log.len() * part / 8) {
            let (plain, plain_map) = log.level(&mesh, collapses).unwrap();
            let (level, vertex_map) = stages.level(collapses).unwrap();
            let [old, new] = [&plain, &level].map(|mesh| turned_over(mesh, &original));
            before += old;
            after += new;
            let topology = plain.topology();
            for (v, w) in plain_map.iter().filter_map(|(v, w)| Some((v, (*w)?))) {
                let is_fixed =
                    topology.is_boundary_vertex(w) || mesh.position(v) == plain.position(w);
                if old == 0 || is_fixed {
                    assert_eq!(plain.position(w), level.position(vertex_map[v].unwrap()));
                }
            }
            if old == 0 {
                assert_eq!(topology.canonical_triangles(), level.topology().canonical_triangles());
            }
        }
    }
    assert!(before > 4 && after == 0, "{before} {after}");
}

/// Where a face would stay turned over, the result has a few faces more than wanted.
#[test]
fn results_have_more_faces_where_one_would_stay_turned_over() {
    let mut finer = 0;
    for mesh in (7000..7100).filter_map(|seed| random_mesh(seed, 8, 3, false)) {
        for preset in [Preset::PaperL1Guarded, Preset::PaperL2Guarded] {
            let mut options = Options { record: true, ..Options::preset(preset).to_faces(24) };
            let result = simplify(&mesh, &options).unwrap();
            options.refine.unfold = false;
            let folded = simplify(&mesh, &options).unwrap();
            if (folded.stop, result.stop) == (StopReason::Faces, StopReason::NothingLeft) {
                finer += 1;
                let faces = result.mesh.topology().face_count();
                assert!((25..=29).contains(&faces) && result.shortfall.is_some(), "{faces}");
                assert_eq!(result.unfold.map_or(0, |report| report.turned_after), 0);
                let (level, _) = result.log.level(&mesh, result.log.len()).unwrap();
                assert_eq!(level.topology().face_count(), faces);
            }
        }
    }
    assert!(finer > 0);
}
