//! `curvmesh patch` and `curvmesh curvature --estimator face` on shapes with known curvature.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;

use crate::common::{code, curvmesh, json, write};
use curvpatch::{CoverOptions, CoverRecord, CurvatureEstimator, Params, Shape, cover};
use glam::{DVec2, DVec3};
use mesh_core::{Repair, TriMesh, build};
use mesh_io::{Model, read};
use mesh_shapes::{Plane, Saddle, Sphere, Torus};

const TORUS: Torus = Torus { major: 2.0, minor: 1.0 };
const SPHERE: Sphere = Sphere { radius: 2.0 };

fn torus(folder: &Path) -> String {
    let path = folder.join("torus.ply");
    write(TORUS.mesh(48, 24).unwrap(), &path);
    path.to_str().unwrap().to_owned()
}

fn sphere(folder: &Path) -> String {
    let path = folder.join("sphere.ply");
    write(SPHERE.icosphere(4).unwrap(), &path);
    path.to_str().unwrap().to_owned()
}

fn loaded(path: &str) -> TriMesh {
    build(&read(path).unwrap().soup, &Repair::strict()).unwrap().mesh
}

fn number(report: &serde_json::Value, key: &str) -> f64 {
    report[key].as_f64().unwrap_or_else(|| panic!("{key} of {report}"))
}

fn face_numbers(model: &Model, name: &str) -> Vec<f64> {
    model
        .face_scalars
        .iter()
        .find(|scalars| scalars.name == name)
        .unwrap()
        .values
        .to_f64()
        .into_owned()
}

fn vertex_numbers(model: &Model, name: &str) -> Vec<f64> {
    model
        .vertex_scalars
        .iter()
        .find(|scalars| scalars.name == name)
        .unwrap()
        .values
        .to_f64()
        .into_owned()
}

#[test]
fn a_cover_becomes_triangles_that_lie_near_the_surface() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("cover.ply");
    let out = out.to_str().unwrap();
    let report = json(&["patch", &torus(folder.path()), "-o", out, "--tolerance", "0.05"]);
    assert_eq!(report["command"], "patch");
    assert_eq!((&report["tolerance"], &report["faces"]), (&0.05.into(), &2304.into()));
    let uncovered = number(&report, "uncovered_faces");
    assert!((number(&report, "covered_faces") + uncovered - 2304.0).abs() < 0.5);
    assert!(number(&report, "max_error") <= 0.05);
    assert!(number(&report, "patches") < 100.0);

    let model = read(out).unwrap();
    let patches = face_numbers(&model, "patch");
    let largest = patches.iter().copied().fold(-1.0, f64::max);
    assert!((largest + 1.0 - number(&report, "patches")).abs() < 0.5);
    let residual = patches.iter().filter(|&&patch| patch < 0.0).count();
    assert!((residual as f64 - uncovered).abs() < 0.5);
    // Tolerance, sag of the original facets, and half a tolerance for cutting the patches into triangles.
    for p in model.soup.positions() {
        let ring = DVec3::new(p.x, p.y, 0.0).normalize() * TORUS.major;
        assert!((p.distance(ring) - TORUS.minor).abs() < 0.1, "{p}");
    }
    // One colour per patch.
    let colors = model.vertex_colors.as_ref().unwrap();
    let mut of_patch = std::collections::HashMap::new();
    for (face, patch) in patches.iter().enumerate() {
        for &v in model.soup.face(face) {
            let color = colors[v as usize].map(f32::to_bits);
            assert_eq!(*of_patch.entry(patch.to_bits()).or_insert(color), color);
        }
    }
}

#[test]
fn a_record_holds_every_bit_of_the_cover() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (torus(folder.path()), folder.path().join("cover.json"));
    let path = out.to_str().unwrap();
    let run = curvmesh(&["patch", &input, "-o", path, "--tolerance", "0.01", "--relative"]);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let text = std::fs::read_to_string(&out).unwrap();
    let record: CoverRecord = serde_json::from_str(&text).unwrap();

    let mesh = loaded(&input);
    let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
    let tolerance = 0.01 * mesh.bounding_box().unwrap().diagonal();
    let expected = cover(&estimator, &CoverOptions::new(tolerance)).unwrap();
    assert_eq!(record, expected.record());
    for (patch, made) in record.patches.iter().zip(&expected.patches) {
        assert_eq!(curvpatch::Patch::try_from(patch.patch).unwrap(), made.fit.patch);
    }
}

#[test]
fn splats_are_discs_on_the_surface() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("splats.ply");
    let out = out.to_str().unwrap();
    let arguments = ["patch", &sphere(folder.path()), "-o", out, "--as", "splats"];
    let report = json(&[&arguments[..], &["--tolerance", "0.01", "--shape", "circle"]].concat());
    let model = read(out).unwrap();
    assert_eq!(
        (model.soup.vertex_count() as f64, model.soup.face_count()),
        (number(&report, "patches"), 0)
    );
    let normals = model.vertex_normals.as_ref().unwrap();
    let axis = |of: &str, i: usize| {
        let [x, y, z] = ["x", "y", "z"].map(|c| vertex_numbers(&model, &format!("{of}_{c}"))[i]);
        DVec3::new(x, y, z)
    };
    for (i, center) in model.soup.positions().iter().enumerate() {
        let normal = DVec3::from_array(normals[i].map(f64::from));
        assert!((center.length() - SPHERE.radius).abs() < 0.01);
        assert!(normal.dot(center.normalize()) > 0.999);
        let (u, v) = (axis("u", i), axis("v", i));
        assert!(u.dot(normal).abs() < 1e-5 && u.dot(v).abs() < 1e-9);
        assert!((u.length() / v.length() - 1.0).abs() < 0.05);
    }
}

#[test]
fn one_patch_of_given_radius_or_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (sphere(folder.path()), folder.path().join("one.json"));
    let path = out.to_str().unwrap();
    let arguments = ["patch", &input, "-o", path, "--face", "7", "--shape", "circle"];
    let report = json(&[&arguments[..], &["--radius", "0.8"]].concat());
    assert_eq!((&report["patches"], &report["tolerance"]), (&1.into(), &serde_json::Value::Null));
    let record: CoverRecord =
        serde_json::from_str(&std::fs::read_to_string(&out).unwrap()).unwrap();
    let [patch] = &record.patches[..] else { panic!("{} patches", record.patches.len()) };
    assert_eq!((patch.face, patch.radius, patch.shape), (7, 0.8, Shape::Circle));
    assert_eq!(patch.patch.arcs, [0.8, 0.8]);
    assert!(patch.patch.curvatures.iter().all(|k| (k - 0.5).abs() < 0.01));
    // A cap of the sphere, up to the faces that its rim cuts.
    let mesh = loaded(&input);
    let ids: Vec<_> = mesh.topology().faces().collect();
    let area: f64 = patch.faces.iter().map(|&f| mesh.face_area(ids[f as usize])).sum();
    let cap = core::f64::consts::TAU * 4.0 * (1.0 - 0.4_f64.cos());
    assert!(area < cap && area > 0.75 * cap, "{area} of {cap}");

    let report = json(&[&arguments[..], &["--tolerance", "0.01"]].concat());
    assert_eq!((&report["patches"], &report["method"]), (&1.into(), &"single".into()));
    assert!(number(&report, "max_error") <= 0.01);
}

#[test]
fn what_cannot_be_done_is_refused_with_its_code() {
    let folder = tempfile::tempdir().unwrap();
    let input = sphere(folder.path());
    let refused = |arguments: &[&str], out: &str| {
        let out = folder.path().join(out);
        let output =
            curvmesh(&[&["patch", &input, "-o", out.to_str().unwrap()], arguments].concat());
        assert!(!out.exists());
        (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    for arguments in [
        &["--radius", "1"][..],
        &["--tolerance", "0"],
        &["--tolerance", "nan"],
        &["--tolerance", "1", "--radius", "1", "--face", "0"],
        &["--tolerance", "1", "--face", "0", "--cover", "greedy"],
        &["--face", "5120", "--radius", "1"],
    ] {
        assert_eq!(refused(arguments, "out.ply").0, 2, "{arguments:?}");
    }
    assert_eq!(refused(&["--tolerance", "1"], "out.xyz").0, 2);
    assert_eq!(refused(&["--tolerance", "1", "--as", "splats"], "out.obj").0, 2);
    let (code, message) = refused(&["--face", "0", "--radius", "3.5"], "out.ply");
    assert_eq!(code, 4);
    assert!(message.contains("use a radius below"), "{message}");
    let (code, message) = refused(&["--face", "0", "--tolerance", "1e-9"], "out.ply");
    assert_eq!(code, 4);
    assert!(message.contains("larger tolerance"), "{message}");

    let (empty, out) = (folder.path().join("empty.ply"), folder.path().join("of-nothing.ply"));
    write(mesh_core::PolygonSoup::new(), &empty);
    let arguments =
        ["patch", empty.to_str().unwrap(), "-o", out.to_str().unwrap(), "--allow-empty"];
    let report = json(&[&arguments[..], &["--tolerance", "1"]].concat());
    assert_eq!((&report["patches"], &report["uncovered_faces"]), (&0.into(), &0.into()));
    let relative = [&arguments[..], &["--tolerance", "1", "--relative"]].concat();
    assert_eq!(curvmesh(&relative).status.code(), Some(4));
}

#[test]
fn face_curvature_goes_to_faces_or_to_the_mean_of_vertices() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (sphere(folder.path()), folder.path().join("curvature.ply"));
    let path = out.to_str().unwrap();
    let report = json(&["curvature", &input, "-o", path, "--estimator", "face"]);
    assert_eq!(report["estimator"], "face");
    assert_eq!(report["faces_without_curvature"], 0);
    let pi = core::f64::consts::PI;
    // K = 1/4 and H = 1/2 on an area of 16 pi.
    assert!((number(&report, "integral_gaussian") / (4.0 * pi) - 1.0).abs() < 0.02);
    assert!((number(&report, "f2") / (8.0 * pi) - 1.0).abs() < 0.02);
    assert!(number(&report, "willmore").abs() < 0.01);
    let model = read(&out).unwrap();
    assert_eq!(model.face_colors.as_ref().map(Vec::len), Some(5120));
    for (name, value) in
        [("k1", 0.5), ("k2", 0.5), ("gaussian_curvature", 0.25), ("shape_index", 1.0)]
    {
        let worst =
            face_numbers(&model, name).iter().map(|v| (v - value).abs()).fold(0.0, f64::max);
        assert!(worst < 0.02, "{name}: {worst}");
    }
    assert!(face_numbers(&model, "curvature_known").iter().all(|&known| known == 1.0));

    let glb = folder.path().join("curvature.glb");
    json(&["curvature", &input, "-o", glb.to_str().unwrap(), "--estimator", "face"]);
    let model = read(&glb).unwrap();
    assert_eq!(model.soup.vertex_count(), 2562);
    assert_eq!(model.vertex_colors.as_ref().map(Vec::len), Some(2562));
}

/// A saddle has a boundary, whose effect is counted, and its shape index is about zero inside.
#[test]
fn face_curvature_says_where_sections_are_cut_off() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("saddle.ply"), folder.path().join("out.ply"));
    write(
        Saddle { coefficient: 0.5, half_width: 1.0 }.mesh(24, Default::default()).unwrap(),
        &input,
    );
    let arguments = ["curvature", input.to_str().unwrap(), "-o", out.to_str().unwrap()];
    let arguments =
        [&arguments[..], &["--estimator", "face", "--quantity", "shape-index"]].concat();
    let report = json(&[&arguments[..], &["--radius", "0.2"]].concat());
    let truncated = number(&report, "truncated_faces");
    assert!(truncated > 200.0 && truncated < 700.0, "{truncated}");
    assert!(number(&report, "integral_gaussian") < -1.0);
    let refused = curvmesh(&[&arguments[..5], &["face", "--quantity", "willmore"]].concat());
    assert_eq!(refused.status.code(), Some(2));
    let refused = curvmesh(&[&arguments[..], &["--radius", "-1"]].concat());
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn patches_that_stick_out_are_measured_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("plane.ply"), folder.path().join("patches.ply"));
    write(Plane { half_width: 1.0 }.mesh(8, Default::default()).unwrap(), &input);
    let [input, output] = [&input, &output].map(|path| path.to_str().unwrap());
    let report = json(&["patch", input, "-o", output]);
    let overhang = number(&report, "overhang");
    // The patches are flat and the plane is a square, so every point beyond it is outside of its box.
    let reaches = read(output)
        .unwrap()
        .soup
        .positions()
        .iter()
        .map(|p| DVec2::new((p.x.abs() - 1.0).max(0.0), (p.y.abs() - 1.0).max(0.0)).length())
        .fold(0.0, f64::max);
    assert!(overhang > 0.1 && (overhang - reaches).abs() < 0.1 * reaches, "{overhang} {reaches}");
    let (status, said) = code(&["patch", input, "-o", output]);
    assert!(status == 0 && said.is_empty(), "{said}");
    let said = String::from_utf8(curvmesh(&["patch", input, "-o", output]).stdout).unwrap();
    assert!(said.contains("beyond the boundary") && said.contains("--no-overhang"), "{said}");
    let inside = json(&["patch", input, "-o", output, "--no-overhang"]);
    assert_eq!(number(&inside, "overhang"), 0.0);
}
