//! `curvmesh subdivide` and `repair` on shapes with known results.
#![allow(clippy::unwrap_used)]

use crate::common;
use std::path::Path;

use crate::common::{code, json, write};
use glam::DVec3;
use mesh_core::{PolygonSoup, SplitMix64};
use mesh_io::{Model, WriteOptions};
use mesh_shapes::{Diagonals, Plane, Sphere, Torus, polyhedra};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn subdivision_makes_no_slivers_and_turns_no_face_over() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    let mut straight_edges = 0;
    for seed in 0..20 {
        // Cells of size 1, and corners that move by up to .4.
        let mut random = SplitMix64::new(seed);
        let mut soup = Plane { half_width: 6.0 }.mesh(12, Diagonals::Alternating).unwrap();
        for p in soup.positions_mut().iter_mut().filter(|p| p.abs().max_element() < 6.0) {
            *p += 0.4 * DVec3::new(random.symmetric(), random.symmetric(), 0.0);
        }
        write(soup, &input);
        let report = json(&["subdivide", text(&input), "-o", text(&output)]);
        straight_edges += report["straight_edges"].as_u64().unwrap();
        let [before, after] = [&input, &output].map(|path| mesh_io::read(path).unwrap().soup);
        let slivers = |soup: &PolygonSoup| mesh_core::diagnose(soup).unwrap().slivers;
        assert!(slivers(&after) <= 4 * slivers(&before), "{seed}");
        let z = |soup: &PolygonSoup, face: &[u32]| {
            let [a, b, c] = [0, 1, 2].map(|k| soup.positions()[face[k] as usize]);
            (b - a).cross(c - a).z
        };
        let upright = before.faces().all(|face| z(&before, face) > 0.0);
        assert!(!upright || after.faces().all(|face| z(&after, face) > 0.0), "{seed}");
    }
    assert!(straight_edges > 0);
}

#[test]
fn subdivision_comes_closer_to_the_smooth_surface() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.ply", "out.ply"].map(|name| folder.path().join(name));
    let torus = Torus { major: 5.0, minor: 2.0 };
    write(torus.mesh(24, 12).unwrap(), &input);
    let report = json(&["subdivide", text(&input), "-o", text(&output), "--steps", "2"]);
    assert_eq!((&report["faces"], &report["faces_out"]), (&576.into(), &9216.into()));
    let (before, after) = (mesh_io::read(&input).unwrap(), mesh_io::read(&output).unwrap());
    let kept = before.soup.vertex_count();
    assert_eq!(before.soup.positions(), &after.soup.positions()[..kept]);
    // The middle of an edge of the input is up to 0.08 inside of the torus.
    for p in after.soup.positions() {
        let ring = DVec3::new(p.x, p.y, 0.0).normalize() * torus.major;
        assert!((p.distance(ring) - torus.minor).abs() < 0.02, "{p}");
    }
    let flat = folder.path().join("flat.ply");
    json(&["subdivide", text(&input), "-o", text(&flat), "--tension", "0", "--eight-point"]);
    let measured = json(&["distance", text(&input), text(&flat), "--samples", "1000"]);
    assert!(measured["max"].as_f64().unwrap() < 1e-12, "{measured}");
    for wrong in [["--steps", "0"], ["--steps", "13"], ["--tension", "-1"], ["--tension", "nan"]] {
        let arguments = ["subdivide", text(&input), "-o", text(&output)];
        assert_eq!(code(&[&arguments[..], &wrong].concat()).0, 2, "{wrong:?}");
    }
}

/// A grid with a bump. Its texture coordinates are its first two coordinates, and its halves have different materials
/// and charts.
#[test]
fn subdivision_takes_textures_and_materials_along() {
    let cells = 6_u32;
    let mut soup = PolygonSoup::new();
    for i in 0..=cells {
        for j in 0..=cells {
            soup.push_vertex([f64::from(i), f64::from(j), f64::from(i * j) * 0.05]);
        }
    }
    let at = |i: u32, j: u32| i * (cells + 1) + j;
    let (mut uvs, mut materials) = (Vec::new(), Vec::new());
    for i in 0..cells {
        for j in 0..cells {
            let second = i >= cells / 2;
            for face in [
                [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
            ] {
                soup.push_face(&face).unwrap();
                materials.push(u32::from(second));
                let shift = if second { 20.0 } else { 0.0 };
                uvs.extend(face.map(|v| {
                    let p = soup.positions()[v as usize];
                    [p.x as f32 + shift, p.y as f32]
                }));
            }
        }
    }
    let named = |name: &str| mesh_io::Material { name: name.into(), ..Default::default() };
    let model = Model {
        corner_uvs: Some(uvs),
        face_materials: Some(materials),
        materials: vec![named("first"), named("second")],
        ..Model::from(soup)
    };
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.obj", "out.obj"].map(|name| folder.path().join(name));
    mesh_io::write(&input, &model, &WriteOptions::default()).unwrap();
    json(&["subdivide", text(&input), "-o", text(&output), "--steps", "2"]);
    let result = mesh_io::read(&output).unwrap();
    assert_eq!(result.soup.face_count(), 16 * 72);
    let (uvs, materials) = (result.corner_uvs.unwrap(), result.face_materials.unwrap());
    let middle = f64::from(cells) / 2.0;
    for (face, uvs) in uvs.as_chunks::<3>().0.iter().enumerate() {
        let points = result.soup.corner_range(face).map(|c| result.soup.corners()[c] as usize);
        let points: Vec<DVec3> = points.map(|v| result.soup.positions()[v]).collect();
        let second = materials[face] == 1;
        let centre = points.iter().map(|p| p.x).sum::<f64>() / 3.0;
        assert_eq!(second, centre > middle, "face {face}");
        for (p, uv) in points.iter().zip(uvs) {
            let expected = [p.x + if second { 20.0 } else { 0.0 }, p.y];
            // The surface follows a fourth-order scheme; the texture is linear in between.
            assert!(uv.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < 0.2), "{p}");
        }
    }
}

#[test]
fn repair_makes_a_closed_manifold_of_parts() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    // A cube of single triangles: one reversed, one duplicated, one missing.
    let cube = polyhedra::cube();
    let mut parts = PolygonSoup::new();
    for (i, face) in cube.faces().enumerate() {
        let mut corners = face.to_vec();
        if i == 3 {
            corners.reverse();
        }
        for _ in 0..=usize::from(i == 5) {
            let first = parts.vertex_count() as u32;
            corners.iter().for_each(|&v| parts.push_vertex(cube.positions()[v as usize]));
            let face: Vec<u32> = (0..corners.len() as u32).map(|k| first + k).collect();
            if i != 1 {
                parts.push_face(&face).unwrap();
            }
        }
    }
    write(parts, path("parts.obj").as_ref());
    let report = json(&["repair", &path("parts.obj"), "-o", &path("open.obj")]);
    assert_eq!(
        report["dropped_duplicates"].as_u64(),
        Some(if cube.face_count() > 6 { 1 } else { 2 })
    );
    assert!(
        report["welded_vertices"].as_u64() > Some(10)
            && report["reversed_faces"].as_u64() > Some(0)
    );
    let open = json(&["info", &path("open.obj")]);
    assert_eq!((&open["manifold"], &open["closed"]), (&true.into(), &false.into()));
    let filled =
        json(&["repair", &path("parts.obj"), "-o", &path("whole.obj"), "--fill-holes", "all"]);
    assert_eq!((&filled["holes"]["filled"], &filled["holes"]["left"]), (&1.into(), &0.into()));
    let whole = json(&["info", &path("whole.obj")]);
    assert_eq!((&whole["manifold"], &whole["closed"]), (&true.into(), &true.into()));
    assert_eq!((&whole["vertices"], &whole["volume"]), (&8.into(), &8.0.into()));
    let left = json(&["repair", &path("parts.obj"), "-o", &path("open.obj"), "--fill-holes", "2"]);
    assert_eq!((&left["holes"]["filled"], &left["holes"]["left"]), (&0.into(), &1.into()));

    // Only named repairs are made.
    let (status, message) = code(&[
        "repair",
        &path("parts.obj"),
        "-o",
        &path("o.obj"),
        "--weld",
        "exact",
        "--reorient",
    ]);
    assert_eq!(status, 4, "{message}");
    assert!(message.contains("--drop-duplicates"), "{message}");
    let sound = json(&["repair", &path("whole.obj"), "-o", &path("same.obj")]);
    assert_eq!(sound["unchanged"], true);
}

/// Texture coordinates and materials of the faces around a hole are continued into it.
#[test]
fn holes_that_meet_in_a_vertex_are_filled_each_by_itself() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let corners = "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n";
    let faces = "f 3 2 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
    std::fs::write(path("in.obj"), format!("{corners}{faces}")).unwrap();
    for how in [&["--fill-holes", "all"][..], &["--fill-holes", "3"], &["--for", "printing"]] {
        let (input, output) = (path("in.obj"), path("out.obj"));
        let report = json(&[&["repair", &input, "-o", &output], how].concat());
        assert_eq!(report["holes"]["new_faces"], 2, "{report}");
        assert_eq!(report["written"]["watertight"], true, "{report}");
        let info = json(&["info", &output]);
        assert_eq!((&info["vertices"], &info["faces"]), (&6.into(), &8.into()), "{info}");
        assert!((info["volume"].as_f64().unwrap() - 4.0 / 3.0).abs() < 1e-12, "{info}");
    }
}

#[test]
fn filled_holes_have_the_data_of_their_outline() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let whole = Torus { major: 5.0, minor: 2.0 }.mesh(24, 12).unwrap();
    let mut soup = PolygonSoup::new();
    whole.positions().iter().for_each(|&p| soup.push_vertex(p));
    for (i, face) in whole.faces().enumerate() {
        if !(100..110).contains(&i) && i != 300 {
            soup.push_face(face).unwrap();
        }
    }
    let corners = soup.corners().iter().map(|&v| soup.positions()[v as usize]);
    let uvs = corners.map(|p| [p.x, p.y].map(|x| x as f32)).collect();
    let model = Model { corner_uvs: Some(uvs), ..Model::from(soup) };
    mesh_io::write(path("in.obj"), &model, &WriteOptions::default()).unwrap();
    let report = json(&["repair", &path("in.obj"), "-o", &path("out.obj"), "--fill-holes", "all"]);
    assert!(report["holes"]["filled"].as_u64() >= Some(2), "{report}");
    assert_eq!(json(&["info", &path("out.obj")])["closed"], true);
    let result = mesh_io::read(path("out.obj")).unwrap();
    let uvs = result.corner_uvs.unwrap();
    for (uv, &v) in uvs.iter().zip(result.soup.corners()) {
        let p = result.soup.positions()[v as usize];
        // Holes have the vertices of their outline, so this holds in them too.
        assert_eq!(*uv, [p.x, p.y].map(|x| x as f32));
    }
}

#[test]
fn completions_and_manual_pages_name_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let output = common::curvmesh(&["completions", "bash"]);
    let script = String::from_utf8(output.stdout).unwrap();
    let output = common::curvmesh(&["man"]);
    let page = String::from_utf8(output.stdout).unwrap();
    let pages = folder.path().join("man1");
    assert!(common::curvmesh(&["man", "-o", text(&pages)]).status.success());
    for command in ["info", "simplify", "flip", "repair", "subdivide", "completions"] {
        assert!(script.contains(command) && page.contains(command), "{command}");
        let own = std::fs::read_to_string(pages.join(format!("curvmesh-{command}.1"))).unwrap();
        assert!(own.contains(".TH curvmesh"), "{command}: {own}");
    }
    assert!(script.contains("--keep-partial") && pages.join("curvmesh.1").is_file());
    let flip = std::fs::read_to_string(pages.join("curvmesh-flip.1")).unwrap();
    assert!(flip.contains("look") && flip.contains("json"), "{flip}");
}

/// The faces of a soup in opposite orientation.
fn inverted(soup: &PolygonSoup) -> PolygonSoup {
    let mut result = PolygonSoup::new();
    soup.positions().iter().for_each(|&p| result.push_vertex(p));
    for face in soup.faces() {
        result.push_face(&face.iter().rev().copied().collect::<Vec<_>>()).unwrap();
    }
    result
}

#[test]
fn inside_out_meshes_are_reported_and_turned() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let sphere = Sphere { radius: 1.0 }.icosphere(2).unwrap();
    write(inverted(&sphere), path("in.stl").as_ref());
    let found = json(&["info", &path("in.stl"), "--weld", "exact"]);
    assert_eq!(found["inside_out"], 1);
    assert!(found["volume"].as_f64().unwrap() < -3.5);
    let output = common::curvmesh(&["curvature", &path("in.stl"), "--weld", "exact"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("inside out"));
    let measured = json(&["curvature", &path("in.stl"), "--weld", "exact"]);
    assert_eq!(measured["inside_out"], 1);

    let repaired = json(&["repair", &path("in.stl"), "-o", &path("out.stl")]);
    assert_eq!(
        (&repaired["turned_components"], &repaired["reversed_faces"]),
        (&1.into(), &320.into())
    );
    assert_eq!(repaired["written"]["watertight"], true);
    json(&["convert", &path("in.stl"), "-o", &path("out.ply"), "--weld", "exact", "--reorient"]);
    for output in ["out.stl", "out.ply"] {
        let found = json(&["info", &path(output), "--weld", "exact"]);
        assert_eq!(found["inside_out"], 0, "{output}");
        assert!(found["volume"].as_f64().unwrap() > 3.5, "{output}");
    }
}

/// The written file is evaluated, and each open hole has a reason.
#[test]
fn repair_judges_the_file_that_it_wrote() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let cube = polyhedra::cube();
    let mut open = PolygonSoup::new();
    cube.positions().iter().for_each(|&p| open.push_vertex(p));
    cube.faces().skip(1).for_each(|face| open.push_face(face).unwrap());
    write(open, path("open.obj").as_ref());
    let report = json(&["repair", &path("open.obj"), "-o", &path("o.stl")]);
    let written = &report["written"];
    assert_eq!((&written["watertight"], &written["boundary_loops"]), (&false.into(), &1.into()));
    assert!(written["holes"][0]["why"].as_str().unwrap().contains("--fill-holes"), "{written}");
    let report = json(&["repair", &path("open.obj"), "-o", &path("o.stl"), "--fill-holes", "2"]);
    let why = report["written"]["holes"][0]["why"].as_str().unwrap().to_owned();
    assert!(why.contains("more than 2"), "{why}");
    let (status, message) =
        code(&["repair", &path("open.obj"), "-o", &path("o.stl"), "--fill-holes", "all"]);
    assert_eq!(status, 0, "{message}");
}

/// Two cubes that touch along an edge, debris and a hole: one command makes a file that slicers accept.
#[test]
fn repair_for_printing_gives_a_watertight_stl() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name)).to_owned();
    let mut soup = PolygonSoup::new();
    let mut add = |center: [f64; 3], size: f64, faces: usize| {
        let first = soup.vertex_count() as u32;
        let cube = inverted(&polyhedra::cube());
        for &p in cube.positions() {
            soup.push_vertex(p * size + DVec3::from(center));
        }
        // The missing face is not at the edge where the cubes touch.
        for face in cube.faces().skip(12 - faces) {
            soup.push_face(&face.iter().map(|&v| v + first).collect::<Vec<_>>()).unwrap();
        }
    };
    add([0.0; 3], 1.0, 11);
    add([2.0, 2.0, 0.0], 1.0, 12);
    add([9.0, 0.0, 0.0], 1e-3, 12);
    write(soup, path("in.obj").as_ref());
    let plain = json(&["repair", &path("in.obj"), "-o", &path("plain.stl"), "--fill-holes", "all"]);
    // STL joins the cubes at their common edge.
    assert_eq!(plain["written"]["watertight"], false);
    assert_eq!(plain["written"]["non_manifold_edges"], 1);
    let report = json(&["repair", &path("in.obj"), "-o", &path("out.stl"), "--for", "printing"]);
    assert_eq!(report["written"]["watertight"], true, "{report}");
    assert_eq!(report["printing"]["dropped_components"], 1);
    assert_eq!(report["printing"]["separated_vertices"], 4);
    let found = json(&["info", &path("out.stl"), "--weld", "exact"]);
    assert_eq!((&found["inside_out"], &found["edge_components"]), (&0.into(), &2.into()));
    assert!((found["volume"].as_f64().unwrap() - 16.0).abs() < 1e-3);
}
