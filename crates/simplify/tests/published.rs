//! Errors on real meshes, compared with other simplifiers.
//!
//! Errors are means over both directions, in percent of the diagonal of the bounding box.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use crate::common::model;
use mesh_core::TriMesh;
use mesh_metric::{CompareOptions, Surface, compare};
use mesh_shapes::{Irregular, Torus};
use simplify::{Metric, Options, PlacementRule, Preset, Rejection, simplify};

/// The mean error of a preset.
fn mean(mesh: &TriMesh, original: &Surface, preset: Preset, faces: usize) -> f64 {
    let result = simplify(mesh, &Options::preset(preset).to_faces(faces)).unwrap();
    let got = result.mesh.topology().face_count();
    assert!(got == faces || got == faces - 1, "{got}, not {faces}");
    let options = CompareOptions { samples: 200_000, ..CompareOptions::default() };
    let surface = Surface::new(&result.mesh).unwrap();
    let diagonal = original.bounding_box().diagonal();
    100.0 * compare(original, &surface, &options).mean() / diagonal
}

/// Mesh, number of faces, and the mean error of the method of Lindstrom and Turk, as implemented in CGAL.
const PEER: [(&str, usize, f64); 7] = [
    ("igea.ply", 3000, 0.02772),
    ("rocker-arm.obj", 2008, 0.02197),
    ("rocker-arm.obj", 602, 0.05975),
    ("fandisk.obj", 1294, 0.00152),
    ("fandisk.obj", 388, 0.01088),
    ("horse.ply", 2908, 0.02031),
    ("stanford-bunny.obj", 2083, 0.03878),
];

#[test]
fn the_default_is_closer_than_lindstrom_and_turk() {
    for (name, faces, peer) in PEER {
        let Some(mesh) = model(name) else { return };
        let original = Surface::new(&mesh).unwrap();
        let mean = mean(&mesh, &original, Preset::Default, faces);
        assert!(mean < peer, "{name} {faces}: {mean:.5}, not below {peer}");
    }
}

#[test]
fn presets_are_ordered_by_quality() {
    for (name, faces, _) in &PEER[1..5] {
        let Some(mesh) = model(name) else { return };
        let original = Surface::new(&mesh).unwrap();
        let [fast, default, quality] = [Preset::Fast, Preset::Default, Preset::Quality]
            .map(|preset| mean(&mesh, &original, preset, *faces));
        // Both presets accept a slightly larger mean for a smaller maximum.
        assert!(quality <= 1.03 * default && default < fast, "{name} {faces}");
        if *faces == 388 {
            let paper = mean(&mesh, &original, Preset::PaperL1, *faces);
            assert!(fast < paper, "{name} {faces}");
        }
    }
}

/// The bounds are the largest errors after fitting alone, in percent of the diagonal, measured with an independent
/// prototype.
#[test]
fn quality_takes_the_largest_error_down() {
    for (name, faces, prototype) in [
        ("rocker-arm.obj", 2008, 0.333),
        ("rocker-arm.obj", 602, 0.675),
        ("fandisk.obj", 388, 0.128),
    ] {
        let Some(mesh) = model(name) else { return };
        let result = simplify(&mesh, &Options::preset(Preset::Quality).to_faces(faces)).unwrap();
        let original = Surface::new(&mesh).unwrap();
        let options = CompareOptions { samples: 200_000, ..CompareOptions::default() };
        let compared = compare(&original, &Surface::new(&result.mesh).unwrap(), &options);
        let largest = 100.0 * compared.hausdorff() / original.bounding_box().diagonal();
        // Differences below 3 % are noise.
        assert!(largest < 1.03 * prototype, "{name} {faces}: {largest:.4}, above {prototype}");
    }
}

/// In meshes with many small parts, the result with the best mean may leave one part far away.
#[test]
fn the_largest_error_is_not_above_that_of_plain_quadrics() {
    let Some(mesh) = model("helicopter.obj") else { return };
    let original = Surface::new(&mesh).unwrap();
    for min_component_vertices in [None, Some(4)] {
        let mut default = Options::preset(Preset::Default).to_faces(3280);
        default.protect.min_component_vertices = min_component_vertices;
        let mut plain = Options::preset(Preset::Fast).to_faces(3280);
        plain.protect.min_component_vertices = min_component_vertices;
        plain.cost.metric = Metric::Quadric;
        plain.placement = PlacementRule::Optimal;
        let samples = CompareOptions { samples: 200_000, ..CompareOptions::default() };
        let [ours, theirs] = [default, plain].map(|options| {
            let result = simplify(&mesh, &options).unwrap();
            let surface = Surface::new(&result.mesh).unwrap();
            compare(&original, &surface, &samples).hausdorff()
        });
        assert!(ours <= theirs, "{min_component_vertices:?}: {ours}, above {theirs}");
    }
}

/// KKL02 has no rule on faces: the presets of its norms reject none, the guarded ones do.
#[test]
fn the_norms_of_the_paper_have_no_constraint_on_faces() {
    let torus = Torus { major: 2.0, minor: 0.8 };
    let soup = torus.irregular_mesh(40, 20, Irregular::default()).unwrap();
    let mesh = TriMesh::from_soup(&soup).unwrap();
    let pairs =
        [(Preset::PaperL1, Preset::PaperL1Guarded), (Preset::PaperL2, Preset::PaperL2Guarded)];
    for (published, guarded) in pairs {
        let rejected = |preset: Preset| {
            let result = simplify(&mesh, &Options::preset(preset).to_faces(100)).unwrap();
            let by = |reason| result.rejections.of(reason);
            by(Rejection::NormalTurn) + by(Rejection::Sliver)
        };
        assert_eq!(rejected(published), 0, "{published}");
        assert!(rejected(guarded) > 0, "{guarded}: the constraints do nothing here");
    }
}
