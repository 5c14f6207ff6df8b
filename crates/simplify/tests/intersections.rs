//! Simplified meshes do not intersect themselves if that is forbidden.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use crate::common::model;
use glam::DVec3;
use mesh_core::{EdgeId, FaceId, TriMesh};
use simplify::{AnnealOptions, Options, Preset, Rejection, simplify};

/// Every edge that passes through the interior of a face, found by a test of all pairs with independent floating-point
/// code.
fn piercings(mesh: &TriMesh) -> Vec<(EdgeId, FaceId)> {
    let topology = mesh.topology();
    let faces: Vec<_> = topology
        .faces()
        .map(|f| {
            let [a, b, c] = mesh.triangle(f);
            (f, topology.face_vertices(f), [a, b, c], a.min(b).min(c), a.max(b).max(c))
        })
        .collect();
    let mut found = Vec::new();
    for e in topology.edges() {
        let ends = topology.edge_vertices(e);
        let [p, q] = ends.map(|v| mesh.position(v));
        let (low, high) = (p.min(q), p.max(q));
        for (f, vertices, triangle, min, max) in &faces {
            let apart = low.cmpgt(*max).any() || high.cmplt(*min).any();
            if !apart && !ends.iter().any(|v| vertices.contains(v)) && pierces(p, q, triangle) {
                found.push((e, *f));
            }
        }
    }
    found
}

/// Whether a segment passes through a triangle, farther from its sides than rounding errors: its ends lie on opposite
/// sides of the plane, and its volumes with the three sides have the same sign.
fn pierces(p: DVec3, q: DVec3, &[a, b, c]: &[DVec3; 3]) -> bool {
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let size = p.distance(q).max(a.distance(b)).max(b.distance(c)).max(c.distance(a)).powi(3);
    let margin = 1e-9 * size;
    let (above, below) = (volume(a, b, c, p), volume(a, b, c, q));
    let round = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    above.abs().min(below.abs()) > margin
        && above.signum() != below.signum()
        && (round.iter().all(|&v| v > margin) || round.iter().all(|&v| v < -margin))
}

#[test]
fn forbidden_intersections_do_not_arise() {
    let (mut free_count, mut refused) = (0, 0);
    let cases = [
        ("horse.ply", 2908, Preset::Default),
        ("rocker-arm.obj", 602, Preset::Default),
        // The other metrics keep surfaces with different normals apart; the curvature norm does not.
        ("fandisk.obj", 602, Preset::PaperL1Guarded),
    ];
    for (name, faces, preset) in cases {
        let Some(mesh) = model(name) else { return };
        let mut options = Options::preset(preset).to_faces(faces);
        free_count += piercings(&simplify(&mesh, &options).unwrap().mesh).len();
        options.protect.forbid_intersections = true;
        let guarded = simplify(&mesh, &options).unwrap();
        assert_eq!(guarded.mesh.topology().face_count(), faces, "{name} {preset}");
        assert_eq!(piercings(&guarded.mesh), [], "{name} {preset}");
        refused += guarded.rejections.of(Rejection::Intersection);
    }
    eprintln!("{free_count} crossings without the constraint, {refused} collapses refused with it");
    assert!(free_count > 0 && refused > 0, "the meshes do not need the constraint");
}

#[test]
fn annealing_keeps_faces_apart_too() {
    let Some(mesh) = model("rocker-arm.obj") else { return };
    let mut options = Options::default().to_faces(602);
    options.refine.anneal = true;
    options.refine.tuning.anneal = AnnealOptions { rounds: 2, ..AnnealOptions::default() };
    options.protect.forbid_intersections = true;
    let result = simplify(&mesh, &options).unwrap();
    assert!(result.anneal.unwrap().kept > 0);
    assert_eq!(piercings(&result.mesh), []);
}
