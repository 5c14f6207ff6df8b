//! `curvmesh curvature --estimator fit` and `ball` on a torus with known principal curvatures and directions.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;

use crate::common::{curvmesh, json, write};
use glam::DVec3;
use mesh_io::Model;
use mesh_shapes::Torus;

const TORUS: Torus = Torus { major: 2.0, minor: 1.0 };

fn torus(folder: &Path) -> String {
    let path = folder.join("torus.ply");
    write(TORUS.mesh(96, 48).unwrap(), &path);
    path.to_str().unwrap().to_owned()
}

fn numbers(model: &Model, name: &str) -> Vec<f64> {
    model
        .vertex_scalars
        .iter()
        .find(|scalars| scalars.name == name)
        .unwrap()
        .values
        .to_f64()
        .into_owned()
}

/// The two curvatures at a point of the torus, and the directions of the circles there: the small circle, then the
/// circle around the axis.
fn expected(p: DVec3) -> ([f64; 2], [DVec3; 2]) {
    let outward = DVec3::new(p.x, p.y, 0.0).normalize();
    let cosine = (p - TORUS.major * outward).normalize().dot(outward);
    let round = DVec3::new(-outward.y, outward.x, 0.0);
    let small = (p - TORUS.major * outward).cross(round).normalize();
    ([1.0 / TORUS.minor, cosine / (TORUS.major + TORUS.minor * cosine)], [small, round])
}

fn is_principal(estimator: &str, tolerance: f64) {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (torus(folder.path()), folder.path().join("out.ply"));
    let report = json(&[
        "curvature",
        &input,
        "-o",
        out.to_str().unwrap(),
        "--estimator",
        estimator,
        "--precision",
        "double",
    ]);
    assert_eq!(
        (&report["estimator"], &report["vertices_without_curvature"]),
        (&estimator.into(), &0.into())
    );
    let model = mesh_io::read(&out).unwrap();
    let direction = |name: &str, v: usize| {
        DVec3::from_array(["x", "y", "z"].map(|axis| numbers(&model, &format!("{name}_{axis}"))[v]))
    };
    for (v, &p) in model.soup.positions().iter().enumerate() {
        let ([k1, k2], [small, round]) = expected(p);
        for (name, value) in [("k1", k1), ("k2", k2), ("mean_curvature", 0.5 * (k1 + k2))] {
            let found = numbers(&model, name)[v];
            assert!((found - value).abs() < tolerance, "{name} at {p}: {found}, not {value}");
        }
        for (name, along) in [("k1", small), ("k2", round)] {
            let found = direction(name, v);
            assert!((found.length() - 1.0).abs() < 1e-6, "{name} at {p}: {found}");
            assert!(
                found.dot(along).abs() > 1.0 - tolerance,
                "{name} at {p}: {found}, not {along}"
            );
        }
    }
}

#[test]
fn fitted_surfaces_give_the_curvatures_and_directions_of_a_torus() {
    is_principal("fit", 0.02);
}

/// Balls average over their content. Four mean edges, the default, are half the radius of the tube. Inside the hole,
/// where the curvature changes most, the average is lower by a fifth.
#[test]
fn balls_give_the_curvatures_and_directions_of_a_torus() {
    is_principal("ball", 0.2);
}

/// Two diamonds at each vertex, in the two colours, flat on the surface.
#[test]
fn arrows_lie_along_the_directions() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (torus(folder.path()), folder.path().join("lines.ply"));
    let path = out.to_str().unwrap();
    json(&["curvature", &input, "-o", path, "--estimator", "fit", "--as", "arrows"]);
    let model = mesh_io::read(&out).unwrap();
    let vertices = 96 * 48;
    assert_eq!((model.soup.vertex_count(), model.soup.face_count()), (8 * vertices, 4 * vertices));
    let positions = model.soup.positions();
    for corners in positions.chunks_exact(8) {
        let (_, [small, round]) = expected(0.5 * (corners[0] + corners[2]));
        let [max, min] = [corners[0] - corners[2], corners[4] - corners[6]].map(DVec3::normalize);
        assert!(max.dot(small).abs() > 0.99 && min.dot(round).abs() > 0.99);
    }
    let colors = model.vertex_colors.unwrap();
    assert!(colors[0][0] > colors[0][2] && colors[4][2] > colors[4][0]);
}

#[test]
fn what_an_estimator_does_not_know_is_wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    for arguments in [
        &["--estimator", "fit", "--radius", "1"][..],
        &["--estimator", "ball", "--rings", "3"],
        &["--estimator", "fit", "--quantity", "willmore"],
        &["--estimator", "vertex", "--as", "arrows"],
    ] {
        let output = curvmesh(&[&["curvature", &input], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
}
