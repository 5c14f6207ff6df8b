//! `view`, `render` and `--view`: their outputs, and the pages in headless Chromium (skipped with a message if it is
//! not available).
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

#[path = "../../mesh-view/tests/browser/mod.rs"]
pub(crate) mod browser;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use browser::Browser;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_curvmesh"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Runs the program, which must succeed.
fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// A bumpy surface of 2 n² faces as a PLY file, with a property.
fn bumps(folder: &Path, name: &str, n: usize) {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\nproperty double height\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        (n + 1) * (n + 1),
        2 * n * n
    );
    for i in 0..=n {
        for j in 0..=n {
            let [x, y] = [i, j].map(|k| 4.0 * k as f64 / n as f64);
            let z = 0.4 * (2.0 * x).sin() * (1.5 * y).cos();
            text += &format!("{x} {y} {z} {z}\n");
        }
    }
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            let b = a + n + 1;
            text += &format!("3 {a} {b} {}\n3 {a} {} {}\n", b + 1, b + 1, a + 1);
        }
    }
    std::fs::write(folder.join(name), text).unwrap();
}

/// Opens a page, which must show something without an error.
fn look(browser: &mut Browser, page: &Path) {
    browser.open_view(page);
    let picture = browser.canvas();
    assert!(picture.inked() > 0.05, "{}: {}", page.display(), picture.inked());
    browser.picture(None).keep(&format!("{}.png", page.file_stem().unwrap().to_string_lossy()));
    assert_eq!(browser.complaints(), Vec::<String>::new(), "{}", page.display());
}

fn text(browser: &mut Browser, selector: &str) -> String {
    browser.text(&format!("document.querySelector('{selector}').textContent"))
}

const LARGE: [u32; 2] = [1280, 860];

#[test]
fn every_command_has_its_page() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bumps(folder, "a.ply", 40);
    bumps(folder, "b.ply", 31);
    let pages: [(&str, &[&str]); 10] = [
        ("view.html", &["view", "a.ply", "b.ply", "-o", "view.html"]),
        ("k.html", &["view", "a.ply", "--curvature", "-o", "k.html"]),
        (
            "simplify.html",
            &["simplify", "a.ply", "-o", "s.ply", "--ratio", "0.2", "--view", "simplify.html"],
        ),
        ("lod.html", &["lod", "a.ply", "-o", "l.glb", "--levels", "0.5,0.1", "--view", "lod.html"]),
        ("flip.html", &["flip", "a.ply", "--cost", "f2", "--view", "flip.html"]),
        ("curvature.html", &["curvature", "a.ply", "--view", "curvature.html"]),
        ("face.html", &["curvature", "a.ply", "--estimator", "face", "--view", "face.html"]),
        (
            "patch.html",
            &["patch", "a.ply", "-o", "cover.ply", "--tolerance", "0.05", "--view", "patch.html"],
        ),
        ("compare.html", &["compare", "a.ply", "b.ply", "--view", "compare.html"]),
        (
            "distance.html",
            &["distance", "a.ply", "b.ply", "--samples", "20000", "--view", "distance.html"],
        ),
    ];
    for (_, arguments) in pages {
        done(folder, arguments);
    }
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let mut open = |name: &str| -> PathBuf {
        let path = folder.join(name);
        look(&mut browser, &path);
        path
    };
    for (name, _) in pages {
        open(name);
    }
    // Features of each page.
    let page = |name: &str| folder.join(name);
    browser.open_view(&page("simplify.html"));
    assert_eq!(text(&mut browser, "#quantity"), "distance");
    assert!(text(&mut browser, "#facts").contains("faces out"), "the report");
    let parts = "[...document.querySelectorAll('#facts > details')].map(d => [d.open, d.textContent.includes('seed')])";
    assert_eq!(
        browser.eval(parts),
        serde_json::json!([[true, false], [false, true], [false, false]])
    );
    browser.open_view(&page("lod.html"));
    assert!(text(&mut browser, "#layout").contains("By size on the screen"));
    assert!(text(&mut browser, "#facts").contains("Levels"));
    browser.open_view(&page("flip.html"));
    let flipped = browser.number("curvmesh.meshes[1].source.lines.length");
    assert_eq!(flipped, 1.0);
    assert!(text(&mut browser, "#controls").contains("Flipped edges"));
    browser.open_view(&page("curvature.html"));
    assert_eq!(text(&mut browser, "#quantity"), "mean curvature");
    assert_eq!(browser.text("document.getElementById('quantity').title"), "mean_curvature");
    assert!(browser.number("document.querySelectorAll('#histogram rect').length") > 10.0);
    assert!(text(&mut browser, "#controls").contains("Direction of k1"));
    browser.open_view(&page("patch.html"));
    assert!(text(&mut browser, "#one").contains("patch 0"));
    assert!(text(&mut browser, "#controls").contains("Arcs of k1"));
    assert_eq!(browser.text("curvmesh.meshes[0].source.name"), "mesh");
    assert_eq!(browser.number("curvmesh.state.overlays.size"), 0.0);
    assert!(browser.number("document.querySelectorAll('#swatches span').length") > 1.0);
    // A row for each patch; its number shows it alone.
    let rows = browser.number("document.querySelectorAll('#facts .wide button').length");
    let listed = browser.number("document.querySelectorAll('#swatches button').length");
    // Faces without a patch have a label too.
    assert!(rows > 1.0 && (rows == listed || rows + 1.0 == listed), "{rows} {listed}");
    let press = "document.querySelectorAll('#facts .wide button')[1].click(); curvmesh.state.only";
    assert_eq!(browser.number(press), 1.0);
    let pressed =
        "[...document.querySelectorAll('[aria-pressed=\"true\"]')].map(b => b.textContent).join()";
    assert_eq!(browser.text(pressed), "1,1", "in the legend and in the table");
    assert!(browser.eval(press).is_null());
    browser.open_view(&page("compare.html"));
    assert_eq!(text(&mut browser, "#quantity"), "largest distance in face");
    assert_eq!(text(&mut browser, "#unit"), "% of the diagonal");
    assert_eq!(browser.number("document.querySelectorAll('#facts .wide tr').length"), 2.0);
    browser.open_view(&page("distance.html"));
    assert_eq!(text(&mut browser, "#unit"), "model units");
    assert!(text(&mut browser, "#controls").contains("Largest distance"));
    assert_eq!(browser.number("curvmesh.meshes.length"), 2.0);
}

#[test]
fn the_axis_that_points_up_follows_format_and_shape() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bumps(folder, "sheet.ply", 6);
    let body = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    std::fs::write(folder.join("body.off"), body).unwrap();
    for name in ["body.stl", "body.glb"] {
        done(folder, &["convert", "body.off", "-o", name]);
    }
    let is_up = |arguments: &[&str], axis: &str| {
        done(folder, &[&["view", "-o", "page.html"], arguments].concat());
        let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
        assert!(page.contains(&format!("\"up\":\"{axis}\"")), "{arguments:?}");
    };
    is_up(&["sheet.ply"], "z");
    is_up(&["body.off"], "y");
    is_up(&["body.stl"], "z");
    is_up(&["body.glb"], "y");
    is_up(&["body.glb", "--up", "-x"], "-x");
    is_up(&["body.off", "--up=-z"], "-z");
    done(
        folder,
        &["simplify", "body.stl", "-o", "small.stl", "--ratio", "1", "--view", "page.html"],
    );
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(page.contains("\"up\":\"z\""));
    let refused = run(folder, &["view", "body.off", "-o", "page.html", "--up", "w"]);
    assert_eq!(refused.status.code(), Some(2));
}

/// The value under the pointer equals the number in the file.
#[test]
fn values_are_those_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    bumps(folder.path(), "a.ply", 20);
    done(folder.path(), &["view", "a.ply", "-o", "p.html", "--color", "height"]);
    let Some(mut browser) = Browser::start(LARGE) else { return };
    browser.open_view(&folder.path().join("p.html"));
    let hit = browser.eval("curvmesh.point(canvas.clientWidth / 2, canvas.clientHeight / 2)");
    let vertex = hit["vertex"].as_u64().unwrap() as usize;
    let file = std::fs::read_to_string(folder.path().join("a.ply")).unwrap();
    let line = file.lines().skip_while(|l| *l != "end_header").nth(1 + vertex).unwrap();
    let height: f64 = line.split(' ').nth(3).unwrap().parse().unwrap();
    let shown = hit["rows"][0][1].as_str().unwrap().split(' ').next().unwrap();
    let rounded: f64 = format!("{height:.6e}").parse().unwrap();
    assert_eq!(shown.parse::<f64>().unwrap(), rounded, "{height}");
}

/// A body that is turned has the same picture if the axis that was up is named.
#[test]
fn pictures_turn_with_the_axis_that_points_up() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let body = |name: &str, place: fn([f64; 3]) -> [f64; 3]| {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.5]];
        let rows = corners.map(place).map(|[x, y, z]| format!("{x} {y} {z}\n")).concat();
        let text = format!("OFF\n4 4 0\n{rows}3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
        std::fs::write(folder.join(name), text).unwrap();
    };
    body("y.off", |p| p);
    body("z.off", |[x, y, z]| [x, -z, y]);
    let picture = |input: &str, more: &[&str]| {
        let arguments = ["render", input, "-o", "p.png", "--size", "60,60"];
        done(folder, &[&arguments, more].concat());
        image::open(folder.join("p.png")).unwrap().to_rgba8().into_raw()
    };
    let difference =
        |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 3).count();
    for more in [&[][..], &["--direction", "front,left,top"]] {
        let upright = picture("y.off", more);
        let turned = picture("z.off", &[more, &["--up", "z"]].concat());
        assert!(difference(&upright, &turned) < 40, "{more:?}");
        assert!(difference(&upright, &picture("z.off", more)) > 400, "{more:?}");
        assert_eq!(upright, picture("y.off", &[more, &["--up", "auto"]].concat()));
        done(folder, &["convert", "z.off", "-o", "z.stl"]);
        assert!(difference(&upright, &picture("z.stl", &[more, &["--up", "auto"]].concat())) < 40);
    }
    // Numbers are directions of the model.
    let side = ["--direction", "0,-1,0.5"];
    let by_name = picture("z.off", &[&side[..], &["--up", "z"]].concat());
    assert_eq!(by_name, picture("z.off", &[&side[..], &["--up", "0,0,1"]].concat()));
    let refused = ["render", "z.off", "-o", "p.png", "--up", "0,0,1", "--direction", "front"];
    assert_eq!(run(folder, &refused).status.code(), Some(2));
    let refused = ["render", "z.off", "-o", "p.png", "--up", "w"];
    assert_eq!(run(folder, &refused).status.code(), Some(2));
}

/// Two walls that form a valley are darker near its bottom with occlusion; an SVG file has flat colours.
#[test]
fn valleys_are_dark_with_occlusion() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let corners = "-1 0 1\n-1 2 1\n0 0 0\n0 2 0\n1 0 1\n1 2 1\n";
    let faces = "3 0 2 1\n3 1 2 3\n3 2 4 3\n3 3 4 5\n";
    std::fs::write(folder.join("valley.off"), format!("OFF\n6 4 0\n{corners}{faces}")).unwrap();
    let brightness = |more: &[&str]| {
        let start =
            ["render", "valley.off", "-o", "p.png", "--direction", "0,0,1", "--size", "100,100"];
        done(folder, &[&start, more].concat());
        let picture = image::open(folder.join("p.png")).unwrap().to_rgba8();
        [10, 48].map(|x| i32::from(picture.get_pixel(x, 50).0[0]))
    };
    let [rim, bottom] = brightness(&["--up", "y"]);
    assert_eq!(rim, bottom);
    let [dark_rim, dark_bottom] = brightness(&["--up", "y", "--occlusion", "1"]);
    assert!(dark_bottom + 20 < bottom && dark_rim >= rim - 3, "{rim} {dark_rim} {dark_bottom}");
    for refused in [["p.svg", "0.5"], ["p.png", "1.5"]] {
        let [output, strength] = refused;
        let arguments = ["render", "valley.off", "-o", output, "--occlusion", strength];
        assert_eq!(run(folder, &arguments).status.code(), Some(2), "{refused:?}");
    }
}

#[test]
fn pictures_have_their_size_and_bar() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bumps(folder, "a.ply", 20);
    let size = |name: &str| {
        let picture = image::open(folder.join(name)).unwrap();
        (picture.width(), picture.height(), picture.to_rgba8().get_pixel(0, 0).0)
    };
    done(folder, &["render", "a.ply", "-o", "a.png", "--size", "300,200", "--edges", "1"]);
    assert_eq!(size("a.png"), (300, 200, [255; 4]));
    let transparent = ["render", "a.ply", "-o", "t.png", "--size", "300,200", "--transparent"];
    done(folder, &transparent);
    assert_eq!(size("t.png").2[3], 0);
    let bar = ["render", "a.ply", "-o", "b.png", "--size", "300,200", "--property", "height"];
    done(folder, &bar);
    assert!(size("b.png").0 > 300);
    let sheet =
        ["render", "a.ply", "-o", "s.png", "--size", "100,100", "--direction", "front,left,top"];
    done(folder, &sheet);
    assert!(size("s.png").0 > 200 && size("s.png").1 > 200);
}

/// Two triangles with labels of vertices and of faces, and a component apart.
const LABELLED: &str = "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\nproperty int zone\nelement face 3\nproperty list uchar int vertex_indices\nproperty uchar part\nend_header\n0 0 0 1\n1 0 0 1\n1 1 0 -70000\n0 1 0 1\n3 0 0 1\n4 0 0 1\n3 1 0 1\n3 0 1 2 2\n3 0 2 3 5\n3 4 5 6 5\n";

#[test]
fn integers_are_labels() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("l.ply"), LABELLED).unwrap();
    let report = |arguments: &[&str]| -> serde_json::Value {
        let size = ["--size", "300,300", "--direction", "front", "--json"];
        serde_json::from_str(&done(folder, &[&["render", "l.ply"], arguments, &size].concat()))
            .unwrap()
    };
    let has = |name: &str, color: [u8; 3]| {
        let picture = image::open(folder.join(name)).unwrap().to_rgb8();
        picture.pixels().filter(|pixel| pixel.0 == color).count() > 100
    };
    let [orange, blue, green, rust] = [[230, 159, 0], [86, 180, 233], [0, 158, 115], [213, 94, 0]];
    // Labels from 0 to 19 have the colour of their number: 2 is green, 5 is a red brown.
    let part = report(&["--property", "part", "-o", "part.png"]);
    assert_eq!(part["labels"], 2);
    assert!(part["range"].is_null());
    assert!(has("part.png", green) && has("part.png", rust) && !has("part.png", orange));
    // Others have the colours in their order.
    assert_eq!(report(&["--property", "zone", "-o", "zone.png"])["labels"], 2);
    assert!(has("zone.png", orange) && has("zone.png", blue));
    assert_eq!(report(&["--paint", "components", "-o", "c.png"])["labels"], 2);
    assert!(has("c.png", orange) && has("c.png", blue));
    let scaled = report(&["--property", "part", "-o", "s.png", "--colormap", "viridis"]);
    assert!(scaled["labels"].is_null() && !has("s.png", green));
    assert_eq!(scaled["range"], serde_json::json!([2.0, 5.0]));
    done(folder, &["view", "l.ply", "-o", "l.html"]);
    let Some(mut browser) = Browser::start(LARGE) else { return };
    browser.open_view(&folder.join("l.html"));
    assert_eq!(browser.complaints(), Vec::<String>::new());
    assert_eq!(text(&mut browser, "#quantity"), "zone");
    assert_eq!(text(&mut browser, "#swatches"), "-700001");
    browser.set("color", "face:component");
    assert_eq!(text(&mut browser, "#swatches"), "01");
    done(folder, &["view", "l.ply", "-o", "c.html", "--color", "component"]);
    browser.open_view(&folder.join("c.html"));
    assert_eq!(text(&mut browser, "#quantity"), "component");
    done(folder, &["view", "l.ply", "-o", "m.html", "--colormap", "magma"]);
    browser.open_view(&folder.join("m.html"));
    assert!(browser.eval("document.getElementById('swatches').hidden") == true);
}

#[test]
fn figures_are_vectors() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bumps(folder, "a.ply", 20);
    let arguments = [
        "render",
        "a.ply",
        "-o",
        "a.svg",
        "--property",
        "height",
        "--edges",
        "1",
        "--direction=1,0.4,0.3",
        "--json",
    ];
    let report: serde_json::Value = serde_json::from_str(&done(folder, &arguments)).unwrap();
    let figure = std::fs::read_to_string(folder.join("a.svg")).unwrap();
    let count = figure.matches("Z\" fill=").count();
    assert_eq!(report["drawn_faces"], count);
    // Some faces are hidden by others.
    assert!((400..800).contains(&count), "{count}");
    assert!(figure.len() < 6_000 + 110 * count, "{}", figure.len());
    assert!(figure.contains(">height<") && !figure.contains("width=\"100%\""));
    let several = ["render", "a.ply", "-o", "b.svg", "--direction", "front,left"];
    let output = run(folder, &several);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("one view"));
    let Some(mut browser) = Browser::start(LARGE) else { return };
    std::fs::write(folder.join("empty.html"), "<!DOCTYPE html><title>a</title>").unwrap();
    browser.open(&folder.join("empty.html"), "document.readyState === 'complete'");
    let parsed = format!(
        "(d => d.querySelector('parsererror') ? 'broken' : d.documentElement.localName + ' ' + d.querySelectorAll('#faces > *').length)(new DOMParser().parseFromString({}, 'image/svg+xml'))",
        serde_json::json!(figure)
    );
    assert_eq!(browser.text(&parsed), format!("svg {count}"));
}

#[test]
fn what_makes_no_sense_is_a_usage_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bumps(folder, "a.ply", 4);
    let wrong: [&[&str]; 7] = [
        &["view", "a.ply", "-o", "x.html", "--color", "component"],
        &["render", "a.ply", "-o", "x.png", "--property", "none"],
        &["render", "a.ply", "-o", "x.png", "--range", "0,1"],
        &["render", "a.ply", "-o", "x.png", "--size", "0,9"],
        &["render", "a.ply", "-o", "x.png", "--direction", "above"],
        &["view", "a.ply", "-o", "x.html", "--color", "none"],
        &["flip", "a.ply", "a.ply", "-o", "out/", "--cost", "f2", "--view", "x.html"],
    ];
    for arguments in wrong {
        let output = run(folder, arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty());
    }
    assert!(!folder.join("x.png").exists() && !folder.join("x.html").exists());
}

/// The page of a file with hostile names, made by the program.
#[test]
fn hostile_property_names_do_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let file = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float <script>window.hacked=1</script>\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n";
    let name = "<img src=x onerror=window.hacked=1>.ply";
    std::fs::write(folder.path().join(name), file).unwrap();
    done(folder.path(), &["view", name, "-o", "p.html"]);
    let Some(mut browser) = Browser::start(LARGE) else { return };
    look(&mut browser, &folder.path().join("p.html"));
    assert!(browser.eval("window.hacked").is_null());
    assert!(text(&mut browser, "h1").contains("<img"));
    assert!(text(&mut browser, "#color").contains("<script>"));
}
