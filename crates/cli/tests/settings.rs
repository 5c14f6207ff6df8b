//! The settings in a report are all settings of the run: with them, the libraries give the same results.
#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

use std::ops::ControlFlow;
use std::path::Path;

use crate::common::{json, write};
use curvpatch::{CoverOptions, CurvatureEstimator, DiscSize, Params, Shape, SizeOptions, cover};
use dcurv::{CurvatureOptions, Curvatures, JetFitOptions, VertexArea};
use dtri_flip::{CostName, FlipOptions};
use mesh_core::{FaceId, Handle, TriMesh};
use mesh_shapes::Torus;
use mesh_work::{
    FaceValues, FrameEstimator, FrameValues, Integrals, patch_of_radius, patch_within,
};
use serde::de::DeserializeOwned;
use serde_json::Value;

const TORUS: Torus = Torus { major: 5.0, minor: 2.0 };

fn torus(folder: &Path) -> String {
    let path = folder.join("torus.ply");
    write(TORUS.shifted_mesh(40, 20).unwrap(), &path);
    path.to_str().unwrap().to_owned()
}

fn mesh(path: impl AsRef<Path>) -> TriMesh {
    TriMesh::from_soup(&mesh_io::read(path).unwrap().soup).unwrap()
}

/// All fields are required, so the report has all of them.
fn read<T: DeserializeOwned>(value: &Value) -> T {
    serde_json::from_value(value.clone()).unwrap()
}

#[test]
fn levels_of_detail() {
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (torus(folder.path()), folder.path().join("levels"));
    let start = ["lod", &input, "-o", out.to_str().unwrap(), "--levels", "0.4,0.2", "--to", "ply"];
    for preset in ["draft", "fast", "default", "thin-features", "paper-l2", "paper-l1-guarded"] {
        let report = json(&[&start[..], &["--preset", preset]].concat());
        assert_eq!(report["preset"], preset);
        let mut again = simplify::simplify(&mesh(&input), &read(&report["settings"])).unwrap();
        again.mesh.compact();
        assert_eq!(report["collapses"], again.collapses, "{preset}");
        let last = mesh(report["levels"][1]["output"].as_str().unwrap());
        assert_eq!(again.mesh.positions(), last.positions(), "{preset}");
    }
    // A replay has no settings: its collapses were found before.
    let record = folder.path().join("collapses");
    let file = record.to_str().unwrap();
    assert!(!json(&[&start[..], &["--record", file]].concat())["settings"].is_null());
    assert!(json(&[&start[..], &["--replay", file]].concat())["settings"].is_null());
}

#[test]
fn region_by_region() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    for (name, more) in [("one", &["--faces", "100"][..]), ("two", &["--levels", "0.5,0.2"])] {
        let work = folder.path().join(name);
        let work = work.to_str().unwrap();
        let start =
            ["region", "split", &input, "-w", work, "--memory", "64MiB", "--preset", "fast"];
        let report = json(&[&start[..], more].concat());
        let mut all = report["regions"].clone();
        all["options"] = report["settings"].clone();
        let settings: out_of_core::Settings = read(&all);
        assert_eq!(settings.finer_levels.len(), usize::from(name == "two"));
        let kept = out_of_core::Work::open(Path::new(work)).unwrap().manifest().settings.clone();
        assert_eq!(format!("{settings:?}"), format!("{kept:?}"));
    }
}

#[test]
fn flips() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (torus(folder.path()), folder.path().join("out.ply"));
    let start = ["flip", &input, "-o", output.to_str().unwrap(), "--cost"];
    let variants: [&[&str]; 5] = [
        &["f3", "--area", "barycentric", "--random-ties", "--seed", "9"],
        &["f2", "--shape-constraint", "unrestricted", "--max-fold", "80", "--max-flips", "50"],
        &["willmore", "--feature-angle", "70", "--no-intersections"],
        &["f2", "--anneal-steps", "3", "--time-limit", "1000"],
        &["f2", "--rebuild-effort", "1", "--rebuild-largest", "20", "--max-flips", "900"],
    ];
    for variant in variants {
        let report = json(&[&start[..], variant].concat());
        let settings = &report["settings"];
        let options: FlipOptions = read(settings);
        // The defaults of the cost are named.
        assert!(options.shape.is_some() && options.max_flips_per_edge.is_some(), "{variant:?}");
        let area: Option<VertexArea> = read(&settings["area"]);
        let cost: CostName = report["cost"].as_str().unwrap().parse().unwrap();
        let mut again = mesh(&input);
        let go_on = &mut |_| ControlFlow::Continue(());
        let flipped = cost.optimise(&mut again, area.unwrap_or_default(), &options, go_on).unwrap();
        assert_eq!(report["flips"], flipped.flips, "{variant:?}");
        assert_eq!(report["cost_after"], flipped.cost_after, "{variant:?}");
        let made = mesh(&output);
        assert!(again.topology().canonical_triangles() == made.topology().canonical_triangles());
    }
}

#[test]
fn curvature() {
    let folder = tempfile::tempdir().unwrap();
    let input = torus(folder.path());
    let original = mesh(&input);
    let run = |more: &[&str]| {
        let report = json(&[&["curvature", &input], more].concat());
        (report["settings"].clone(), report)
    };
    for area in ["voronoi", "barycentric"] {
        let (settings, report) = run(&["--estimator", "vertex", "--area", area]);
        assert!(settings["area"].is_string(), "{settings}");
        let options: CurvatureOptions = read(&settings);
        assert_eq!(report["f1"], Curvatures::of(&original, &options).totals().f1, "{area}");
    }
    let same = |report: &Value, integrals: &Integrals| {
        assert_eq!(report["f1"], integrals.f1);
        assert_eq!(report["integral_gaussian"], integrals.integral_gaussian);
    };
    for more in [&["--preset", "paper"][..], &[], &["--preset", "paper", "--radius", "0.7"]] {
        let (settings, report) = run(&[&["--estimator", "face"], more].concat());
        let (params, size): (Params, DiscSize) =
            (read(&settings["params"]), read(&settings["size"]));
        let radius = if let DiscSize::Radius(radius) = size { Some(radius) } else { None };
        let values = FaceValues::of(&original, params, radius).unwrap();
        assert_eq!(values.size, size);
        same(&report, &values.integrals(&original));
    }
    let (settings, report) = run(&["--estimator", "fit", "--rings", "3"]);
    let fit: JetFitOptions = read(&settings);
    assert_eq!(fit, JetFitOptions::rings(3));
    let values = FrameValues::of(&original, FrameEstimator::Fit(fit)).unwrap();
    assert_eq!(values.fit, Some(fit));
    assert_eq!(settings.as_object().unwrap().len(), 2, "{settings}");
    same(&report, &values.integrals(&original));
    let (settings, report) = run(&["--estimator", "ball"]);
    let radius = read(&settings["radius"]);
    let values = FrameValues::of(&original, FrameEstimator::Ball { radius }).unwrap();
    same(&report, &values.integrals(&original));
    // With `auto`, sums are the discrete ones, and the settings have the noise.
    let (settings, report) = run(&[]);
    assert_eq!(report["f1"], Curvatures::of(&original, &CurvatureOptions::default()).totals().f1);
    assert_eq!(report["noise"], settings["scale"]["noise"]);
}

#[test]
fn patches() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (torus(folder.path()), folder.path().join("cover.json"));
    let original = mesh(&input);
    let face = |settings: &Value| FaceId::from_index(read(&settings["face"]));
    let shapes = |settings: &Value| read::<Vec<Shape>>(&settings["shapes"]);
    let start = ["patch", &input, "-o", output.to_str().unwrap()];
    let variants: [&[&str]; 5] = [
        &[],
        &["--preset", "paper", "--cover", "sequential", "--shape", "ellipse", "--tolerance", "0.1"],
        &["--face", "17", "--no-overhang", "--tolerance", "0.2"],
        &["--face", "17", "--tolerance", "0.2", "--shape", "sagitta"],
        &["--face", "17", "--radius", "0.8", "--preset", "paper"],
    ];
    for variant in variants {
        let report = json(&[&start[..], variant].concat());
        let settings = &report["settings"];
        let params: Params = read(&settings["params"]);
        let estimator = CurvatureEstimator::new(&original, params).unwrap();
        let again = if variant.contains(&"--radius") {
            let radius = read(&settings["radius"]);
            patch_of_radius(&estimator, face(settings), radius, &shapes(settings)).unwrap()
        } else if variant.contains(&"--face") {
            let size: SizeOptions = read(&settings["size"]);
            patch_within(&estimator, face(settings), size, &shapes(settings)).unwrap()
        } else {
            cover(&estimator, &read::<CoverOptions>(settings)).unwrap()
        };
        let record: Value =
            read(&serde_json::from_slice(&std::fs::read(&output).unwrap()).unwrap());
        assert_eq!(record, serde_json::to_value(again.record()).unwrap(), "{variant:?}");
    }
}
