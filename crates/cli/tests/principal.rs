//! `curvmesh curvature` by the estimators of principal curvatures and directions on a torus with known principal curvatures and directions.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::HashMap;
use std::path::Path;

use crate::common::{curvmesh, json, write};
use glam::DVec3;
use mesh_core::PolygonSoup;
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
    is_principal("fit", 3e-3);
    is_principal("auto", 5e-3);
}

/// Balls average over their content. Four mean edges, the default, are half the radius of the tube. Inside the hole,
/// where the curvature changes most, the average is lower by a fifth.
#[test]
fn balls_give_the_curvatures_and_directions_of_a_torus() {
    is_principal("ball", 0.2);
    is_principal("corrected", 0.2);
}

/// A pipe with triangles 25 times longer than wide: the larger curvature is 2.5 everywhere.
#[test]
fn long_triangles_do_not_decide() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("pipe.ply"), folder.path().join("out.ply"));
    write(Torus { major: 5.0, minor: 0.4 }.mesh(24, 48).unwrap(), &input);
    let [input, output] = [&input, &out].map(|path| path.to_str().unwrap());
    for more in [&[][..], &["--estimator", "fit"]] {
        let report = json(&[&["curvature", input, "-o", output], more].concat());
        assert_eq!(report["vertices_without_curvature"], 0);
        let model = mesh_io::read(&out).unwrap();
        assert!(numbers(&model, "k1").iter().all(|k1| (k1 - 2.5).abs() < 0.05));
        assert!(numbers(&model, "curvature_error").iter().all(|&error| error < 0.25));
    }
}

/// A cube of many faces: edges and corners have no curvature, all other vertices have none to speak of.
#[test]
fn creases_are_known() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("cube.ply"), folder.path().join("out.ply"));
    let count = 8;
    let (mut cube, mut known) = (PolygonSoup::default(), HashMap::new());
    for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
        let mut corner = |u: usize, v: usize| {
            let mut place = [0; 3];
            place[axis] = side * count;
            place[(axis + 1) % 3] = u;
            place[(axis + 2) % 3] = v;
            *known.entry(place).or_insert_with(|| {
                cube.push_vertex(place.map(|x| x as f64));
                cube.vertex_count() as u32 - 1
            })
        };
        let cells = (0..count).flat_map(|u| (0..count).map(move |v| (u, v)));
        let quads: Vec<_> = cells
            .map(|(u, v)| [corner(u, v), corner(u + 1, v), corner(u + 1, v + 1), corner(u, v + 1)])
            .collect();
        for [a, b, c, d] in quads {
            let [b, d] = if side == 1 { [b, d] } else { [d, b] };
            cube.push_face(&[a, b, c]).unwrap();
            cube.push_face(&[a, c, d]).unwrap();
        }
    }
    write(cube, &input);
    let report = json(&["curvature", input.to_str().unwrap(), "-o", out.to_str().unwrap()]);
    let model = mesh_io::read(&out).unwrap();
    let (kinds, k1) = (numbers(&model, "curvature_kind"), numbers(&model, "k1"));
    let mut creases = 0;
    for ((p, kind), k1) in model.soup.positions().iter().zip(kinds).zip(k1) {
        let sides = p.to_array().iter().filter(|&&x| x == 0.0 || x == count as f64).count();
        creases += usize::from(sides > 1);
        assert_eq!((kind == 2.0, k1.is_nan()), (sides > 1, sides > 1), "{p}");
        assert!(sides > 1 || k1.abs() < 1e-6, "{p}: {k1}");
    }
    assert_eq!(report["creases"], creases);
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
        &["--radius", "1"][..],
        &["--estimator", "fit", "--radius", "1", "--rings", "2"],
        &["--estimator", "ball", "--noise", "1"],
        &["--estimator", "ball", "--rings", "3"],
        &["--estimator", "fit", "--quantity", "willmore"],
        &["--estimator", "vertex", "--as", "arrows"],
    ] {
        let output = curvmesh(&[&["curvature", &input], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
}
