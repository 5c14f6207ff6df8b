//! Vertices that a format splits are one vertex of the mesh, in all commands.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use crate::common::{json, write};
use mesh_core::PolygonSoup;
use mesh_io::{Model, WriteOptions};
use mesh_shapes::Sphere;
use serde_json::Value;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().unwrap()
}

/// A sphere whose faces share no vertex; each corner has the normal of its face.
fn flat(soup: &PolygonSoup) -> Model {
    let mut apart = PolygonSoup::new();
    let mut normals = Vec::new();
    for (i, face) in soup.faces().enumerate() {
        let corners = [face[0], face[1], face[2]].map(|v| soup.positions()[v as usize]);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        corners.into_iter().for_each(|p| apart.push_vertex(p));
        apart.push_face(&[0, 1, 2].map(|k| 3 * i as u32 + k)).unwrap();
        normals.extend([normal.as_vec3().to_array(); 3]);
    }
    Model { corner_normals: Some(normals), ..Model::from(apart) }
}

#[test]
fn a_flat_glb_equals_the_welded_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    // Coordinates in 32 bits, as in the GLB.
    let mut soup = Sphere { radius: 2.0 }.icosphere(3).unwrap();
    for p in soup.positions_mut() {
        *p = p.as_vec3().as_dvec3();
    }
    let model = flat(&soup);
    mesh_io::write(path("flat.glb"), &model, &WriteOptions::default()).unwrap();
    // Also without normals: only the format tells that vertices are split.
    let bare = Model { corner_normals: None, ..model };
    mesh_io::write(path("bare.glb"), &bare, &WriteOptions::default()).unwrap();
    write(soup, path("welded.ply").as_ref());
    for (arguments, keys) in [
        (&["curvature"][..], &["integral_abs_mean", "f1", "f2", "f3", "willmore"][..]),
        (&["flip", "--cost", "f2"], &["cost_before", "cost_after"]),
        (&["flip", "--cost", "f1"], &["cost_before", "cost_after"]),
        (&["patch", "--tolerance", "5%", "-o", &path("out.ply")], &["max_error"]),
        (&["curvature", "--estimator", "face"], &["f1", "f2", "radius"]),
        (&["simplify", "--faces", "300", "-o", &path("out.ply")], &["faces_out"]),
        (&["subdivide", "-o", &path("out.ply")], &["vertices_out"]),
    ] {
        let welded = json(&[arguments, &[&path("welded.ply")]].concat());
        for name in ["flat.glb", "bare.glb"] {
            let split = json(&[arguments, &[&path(name)]].concat());
            assert_eq!(split["vertices"], welded["vertices"], "{arguments:?} {name}");
            for key in keys {
                let (a, b) = (number(&split, key), number(&welded, key));
                assert!(
                    (a - b).abs() <= 1e-9 * b.abs() + 1e-12,
                    "{arguments:?} {name} {key}: {a} {b}"
                );
            }
        }
    }
    let told = json(&["curvature", &path("flat.glb"), "--weld", "none"]);
    assert!(number(&told, "f2").abs() < 1e-300, "apart, as told: {told}");
}

/// The output has the normals of the input, and a value at every vertex.
#[test]
fn results_go_back_to_the_split_vertices() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let model = flat(&Sphere { radius: 2.0 }.icosphere(2).unwrap());
    mesh_io::write(path("flat.glb"), &model, &WriteOptions::default()).unwrap();
    json(&["curvature", &path("flat.glb"), "-o", &path("out.glb"), "--range", "0,1"]);
    let (before, after) =
        (mesh_io::read(path("flat.glb")).unwrap(), mesh_io::read(path("out.glb")).unwrap());
    assert_eq!(after.soup.face_count(), before.soup.face_count());
    assert_eq!(after.corner_normals, before.corner_normals);
    let colors = after.vertex_colors.unwrap();
    assert_eq!(colors.len(), after.soup.vertex_count());
    // H is 1/2 everywhere: the pale middle between blue and red would be 0.
    assert!(colors.iter().all(|c| c[0] < 0.99 || c[2] < 0.99), "{:?}", &colors[..3]);
}
