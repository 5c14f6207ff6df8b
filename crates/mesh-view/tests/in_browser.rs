//! Pages in headless Chromium: they open from a file without requests, show the mesh, rotate it, and report the input
//! correctly. Without Chromium the tests are skipped, and print the reason.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

mod browser;

use std::path::PathBuf;

use browser::Browser;
use glam::DVec3;
use mesh_core::TriMesh;
use mesh_io::{Alpha, Model, Picture, PictureFormat, Pictures, Scalars};
use mesh_shapes::{Sphere, Torus};
use mesh_view::{
    Directions, Exhibit, Field, Layout, Lines, Materials, On, Page, Section, Surface, Up,
};
use serde_json::Value;

fn torus() -> TriMesh {
    TriMesh::from_soup(&Torus { major: 5.0, minor: 2.0 }.mesh(64, 32).unwrap()).unwrap()
}

/// A torus with a property of vertices and one of faces.
fn exhibit(name: &str) -> Exhibit {
    let mesh = torus();
    let mut exhibit = Exhibit::of_mesh(name, &mesh);
    let wave = mesh.positions().iter().map(|p| (0.7 * p.x).sin() * 1.234_567_891 + p.z / 7.0);
    exhibit.fields.push(Field::new("wave", On::Vertices, wave.collect()));
    let area = mesh.topology().faces().map(|f| mesh.face_area(f)).collect();
    exhibit.fields.push(Field::new("area", On::Faces, area));
    exhibit
}

/// The page as a file; the folder is removed when the value is dropped.
fn file(page: &Page) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("page.html");
    std::fs::write(&path, page.to_html().unwrap()).unwrap();
    (folder, path)
}

const LARGE: [u32; 2] = [1200, 800];

#[test]
fn the_axis_that_points_up_is_chosen() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let mut page = Page::new("A torus", vec![exhibit("torus")]);
    page.start.up = Up::MinusX;
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    // The direction of the model that is up on the screen, from the front, by key and by button.
    let up =
        "(([x, y, z, w]) => [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)]
               .map(t => Math.round(100 * t)).join())(curvmesh.state.turn)";
    browser.press("1");
    assert_eq!(browser.text(up), "-100,0,0");
    let units = ["100,0,0", "0,100,0", "0,0,100", "-100,0,0", "0,-100,0", "0,0,-100"];
    for (axis, unit) in Up::ALL.into_iter().zip(units) {
        browser.set("up", axis.name());
        let first: Vec<f64> =
            browser.text(up).split(',').map(|number| number.parse().unwrap()).collect();
        let wanted: Vec<f64> = unit.split(',').map(|number| number.parse().unwrap()).collect();
        // At first, it is seen from a little above.
        let dot: f64 = first.iter().zip(&wanted).map(|(a, b)| a * b).sum();
        assert!(dot > 9000.0, "{first:?} {unit}");
        browser.press("1");
        assert_eq!(browser.text(up), unit);
    }
}

#[test]
fn a_page_opens_turns_and_tells_values() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let shown = exhibit("torus");
    let mut page = Page::new("A torus", vec![shown.clone()]);
    page.report.push(Section::of_rows("Report", [("faces", "many")]));
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    // The focus outline and the hints, which fold, would count as a difference.
    browser.eval("canvas.style.outline = 'none'; document.getElementById('hints').open = false; 1");
    let first = browser.canvas();
    assert!(first.inked() > 0.15 && first.colors() > 20, "{} {}", first.inked(), first.colors());

    // Rotation by pointer and by key.
    browser.drag([400.0, 400.0], [520.0, 430.0]);
    let turned = browser.canvas();
    assert!(turned.difference(&first) > 0.02);
    browser.press("ArrowLeft");
    assert!(browser.canvas().difference(&turned) > 0.02);
    browser.press("0");
    assert!(browser.canvas().difference(&first) < 0.01);

    // Another property.
    browser.set("color", "face:area");
    let by_area = browser.canvas();
    assert!(by_area.difference(&first) > 0.05);
    let quantity = browser.text("document.getElementById('quantity').textContent");
    assert_eq!(quantity, "area");

    // Other ranges: set by hand, by percentiles, logarithmic.
    browser.set("low", "0.5");
    browser.set("high", "0.6");
    assert_eq!(browser.text("curvmesh.state.range"), "given");
    let narrow = browser.canvas();
    assert!(narrow.difference(&by_area) > 0.02);
    browser.set("range", "full");
    let full: Vec<f64> =
        serde_json::from_value(browser.eval("[curvmesh.state.low, curvmesh.state.high]")).unwrap();
    let areas = &shown.fields[1].values;
    let least = areas.iter().copied().fold(f64::INFINITY, f64::min);
    let most = areas.iter().copied().fold(0.0, f64::max);
    assert!((full[0] / least - 1.0).abs() < 1e-6 && (full[1] / most - 1.0).abs() < 1e-6);
    browser.set("log", "on");
    assert!(browser.eval("curvmesh.state.log") == true);
    browser.set("low", "-1");
    let invalid = browser.text("document.getElementById('low').getAttribute('aria-invalid')");
    assert_eq!(invalid, "true", "a logarithm has no negative end");

    // The precision of the page is about as stated.
    browser.set("color", "vertex:wave");
    browser.press("0");
    let mut found = 0;
    for (x, y) in [(250, 300), (420, 420), (150, 400), (600, 350), (300, 520), (500, 250)] {
        let hit = browser.eval(&format!("curvmesh.point({x}, {y})"));
        if hit.is_null() {
            continue;
        }
        found += 1;
        let (vertex, face) = (index(&hit["vertex"]), index(&hit["face"]));
        assert!(shown.triangles[face].contains(&(vertex as u32)));
        let rows = rows(&hit);
        let wave = &rows.iter().find(|(name, _)| name == "wave").unwrap().1;
        let printed: f64 = wave.split(' ').next().unwrap().parse().unwrap();
        same_digits(printed, shown.fields[0].values[vertex]);
        let area = &rows.iter().find(|(name, _)| name == "area").unwrap().1;
        same_digits(area.parse().unwrap(), shown.fields[1].values[face]);
        let place: Vec<f64> = serde_json::from_value(hit["world"].clone()).unwrap();
        let place = DVec3::from_slice(&place);
        let corners = shown.triangles[face].map(|v| shown.positions[v as usize]);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        assert!((place - corners[0]).dot(normal).abs() < 1e-3, "on the face");
        let nearest = corners.map(|p| p.distance(place)).into_iter().fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.5, "{nearest}");
    }
    assert!(found >= 2, "{found}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Presses and releases the button at a place of the window.
fn click(browser: &mut Browser, place: [f64; 2]) {
    browser.mouse("mousePressed", place, true);
    browser.mouse("mouseReleased", place, false);
    browser.settle();
}

fn index(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

fn rows(hit: &Value) -> Vec<(String, String)> {
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    hit["rows"].as_array().unwrap().iter().map(|row| (text(&row[0]), text(&row[1]))).collect()
}

/// Whether a printed number agrees with the value to seven digits.
fn same_digits(printed: f64, value: f64) {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap();
    assert!((printed - rounded).abs() <= 1e-15 * rounded.abs(), "{printed} for {value}");
}

#[test]
fn two_views_are_in_step() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    // The same mesh twice: for any camera, both halves show the same.
    let page = Page::new("Twice", vec![exhibit("one"), exhibit("other")]);
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    // The names above the pictures differ, and the focus outline surrounds both.
    browser.eval("canvas.style.outline = 'none'; 1");
    browser.eval("document.getElementById('names').hidden = true; document.getElementById('bar').hidden = true; document.getElementById('hints').hidden = true; 1");
    for step in 0..3 {
        if step > 0 {
            browser.drag([200.0, 400.0], [260.0, 380.0]);
            browser.press("+");
        }
        let canvas = browser.canvas();
        let half = canvas.width / 2;
        let [left, right] = [0, half].map(|x| canvas.part([x, 0, half, canvas.height]));
        assert!(left.inked() > 0.1);
        assert!(left.difference(&right) < 0.01, "{}", left.difference(&right));
    }
    // The pointer refers to the same position in both halves.
    browser.press("0");
    let hits = browser.eval(
        "(() => { const w = canvas.clientWidth / 2; return [curvmesh.point(w * 0.3, 400), curvmesh.point(w * 1.3, 400)]; })()",
    );
    assert_eq!(hits[0]["face"], hits[1]["face"]);
    assert_eq!((index(&hits[0]["mesh"]), index(&hits[1]["mesh"])), (0, 1));
    for layout in ["wipe", "blink", "one", "side"] {
        browser.set("layout", layout);
        assert!(browser.canvas().inked() > 0.1, "{layout}");
    }
    browser.set("layout", "wipe");
    for border in ["0", "0.5", "1"] {
        browser.set("wipe", border);
        assert!(browser.canvas().inked() > 0.1, "{border}");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn levels_change_with_the_size_on_the_screen() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let level = |n: u32, coverage| {
        let mesh = TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(n).unwrap()).unwrap();
        let name = format!("{} faces", mesh.topology().face_count());
        Exhibit { coverage: Some(coverage), ..Exhibit::of_mesh(name, &mesh) }
    };
    let mut page = Page::new("Levels", vec![level(4, 0.6), level(2, 0.2), level(1, 0.0)]);
    page.layout = Layout::Distance;
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    let mut seen = Vec::new();
    for _ in 0..24 {
        let text = browser.text("document.getElementById('level').textContent");
        let name = text.split(": ").nth(1).unwrap().split('.').next().unwrap().to_owned();
        if seen.last() != Some(&name) {
            seen.push(name);
        }
        browser.press("-");
    }
    assert_eq!(seen, ["5120 faces", "320 faces", "80 faces"]);
    // The number is that of the pixels, at another size, too.
    browser.press("0");
    browser.set("edges", "off");
    for size in [LARGE, [500, 800]] {
        browser.resize(size);
        browser.wait_for(&format!("innerWidth === {}", size[0]));
        for _ in 0..3 {
            browser.settle();
        }
        let text = browser.text("document.getElementById('level').textContent");
        let pixels = text.split('(').nth(1).unwrap().split(' ').next().unwrap();
        let pixels: f64 = pixels.parse().unwrap();
        let tall = browser.number(
            "(() => { const gl = canvas.getContext('webgl2'), { width, height } = canvas, p = new Uint8Array(4 * width * height); \
             curvmesh.time(); gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, p); const rows = new Set(); \
             for (let i = 0; i < width * height; i++) if (p[4 * i] < 235) rows.add(Math.floor(i / width)); return rows.size; })()",
        );
        assert!((pixels / tall - 1.0).abs() < 0.03, "{text} {tall}");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// A part of a mesh is framed alone, and the others are arranged without it.
#[test]
fn parts_are_shown_alone() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let mesh = torus();
    let whole = |name: &str| Exhibit::of_mesh(name, &mesh);
    let mut part = whole("part");
    part.triangles.truncate(4);
    part.is_part = true;
    let mut page = Page::new("Parts", vec![whole("one"), whole("two"), part]);
    page.layout = Layout::One;
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    let half = browser.number("curvmesh.state.half");
    browser.set("one", "2");
    let of_part = browser.number("curvmesh.state.half");
    assert!(of_part < 0.6 * half, "{of_part} {half}");
    assert!(browser.canvas().inked() > 0.0);
    browser.set("one", "1");
    assert_eq!(browser.number("curvmesh.state.half"), half);
    let names = "[...document.querySelectorAll('#names bdi')].map(name => name.textContent).join()";
    for (layout, shown) in [("side", "one,two"), ("wipe", "one,two"), ("blink", "one")] {
        browser.set("blink", "off");
        browser.set("layout", layout);
        assert_eq!(browser.text(names), shown, "{layout}");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// A view that nobody turned is the same through its link, in any arrangement.
#[test]
fn a_link_without_a_camera_frames_as_the_page_did() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("Link", vec![exhibit("one"), exhibit("two")]));
    let camera = "JSON.stringify([curvmesh.state.target, curvmesh.state.half])";
    for layout in ["wipe", "one"] {
        browser.open_view(&path);
        browser.set("layout", layout);
        browser.wait_for(&format!("location.hash === '#layout={layout}'"));
        let (address, wanted) = (browser.text("location.href"), browser.text(camera));
        for address in ["about:blank", &address] {
            browser.call("Page.navigate", serde_json::json!({ "url": address }));
        }
        browser.wait_for("Boolean(window.curvmesh && curvmesh.ready)");
        assert_eq!(browser.text(camera), wanted, "{layout}");
    }
}

/// The inner side of a surface is violet, but not where values are shown.
#[test]
fn values_are_not_tinted_from_behind() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let mut shown = exhibit("torus");
    for triangle in &mut shown.triangles {
        triangle.swap(0, 1);
    }
    let (_folder, path) = file(&Page::new("Inside out", vec![shown]));
    browser.open_view(&path);
    for (color, is_violet) in [("vertex:wave", false), ("plain", true)] {
        browser.set("color", color);
        let said = browser.text("document.getElementById('names').textContent");
        assert!(said.contains("Inside out"), "{said}");
        assert_eq!(said.contains("violet"), is_violet, "{said}");
        let tinted = browser.canvas();
        browser.set("backs", "off");
        let change = browser.canvas().difference(&tinted);
        assert_eq!(change > 0.05, is_violet, "{color}: {change}");
        browser.set("backs", "on");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Lines, dots, directions, boundaries, non-manifold and sharp edges are drawn only when requested.
#[test]
fn overlays_are_drawn() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    // Three squares with a common edge: 9 boundary edges, and 1 edge with three faces.
    let positions: Vec<DVec3> = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 0.0, 0.3],
        [-1.0, 1.0, 0.3],
        [0.0, 0.0, -1.0],
        [0.0, 1.0, -1.0],
    ]
    .map(DVec3::from_array)
    .into();
    let triangles = vec![[0, 2, 3], [0, 3, 1], [0, 1, 5], [0, 5, 4], [0, 6, 7], [0, 7, 1]];
    let mut shown = Exhibit { name: "fan".into(), positions, triangles, ..Exhibit::default() };
    shown.directions.push(Directions {
        name: "along x".into(),
        color: [0, 0, 200],
        vectors: vec![Some(DVec3::X); 8],
        shown: false,
    });
    let mut line = Lines::through("a line", [200, 0, 0], &[DVec3::ZERO, DVec3::new(1.0, 1.0, 0.1)]);
    line.shown = false;
    shown.lines.push(line);
    let dots =
        Lines { shown: false, ..Lines::dots("a dot", [0, 120, 0], &[DVec3::new(0.5, 0.5, 0.1)]) };
    shown.lines.push(dots);
    let (_folder, path) = file(&Page::new("Lines", vec![shown]));
    browser.open_view(&path);
    browser.set("edges", "off");
    let bare = browser.canvas();
    for name in ["Boundary", "Non-manifold edges", "Sharp edges", "a line", "a dot", "along x"] {
        let click = format!("document.querySelector('[data-overlay=\"{name}\"]').click()");
        browser.eval(&click);
        browser.settle();
        let with = browser.canvas();
        if name == "Sharp edges" {
            // The only inner edges are flat, and the edge with three faces is not sharp.
            assert_eq!(with.difference(&bare), 0.0);
        } else {
            assert!(with.difference(&bare) > 1e-4, "{name}: {}", with.difference(&bare));
        }
        browser.eval(&click);
        browser.settle();
        assert_eq!(browser.canvas().difference(&bare), 0.0, "{name}");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// A square with a picture of four colours shows each colour in its corner.
#[test]
fn textures_are_where_they_belong() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let uv = |v: u32| corners[v as usize].map(|x: f64| x as f32);
    let quarter = |x: u32, y: u32| match (x < 8, y < 8) {
        (true, true) => [255, 0, 0],
        (false, true) => [0, 255, 0],
        (true, false) => [0, 0, 255],
        (false, false) => [255, 255, 0],
    };
    let image = image::RgbImage::from_fn(16, 16, |x, y| image::Rgb(quarter(x, y)));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let shown = Exhibit {
        name: "square".into(),
        positions: corners.map(|[x, y]| DVec3::new(x, y, 0.0)).into(),
        materials: Some(Materials {
            surfaces: vec![Surface {
                color: [1.0; 4],
                picture: Some(0),
                alpha: Alpha::Opaque,
                ..Surface::default()
            }],
            of_face: vec![0; 2],
            uvs: Some(triangles.iter().map(|t: &[u32; 3]| t.map(uv)).collect()),
            pictures: vec![Picture {
                name: "square".into(),
                is_file: false,
                format: PictureFormat::Png,
                size: [image.width(), image.height()],
                bytes: bytes.into_inner(),
            }],
            left_out: Vec::new(),
        }),
        triangles,
        ..Exhibit::default()
    };
    let (_folder, path) = file(&Page::new("Texture", vec![shown]));
    browser.open_view(&path);
    // The first picture has the texture.
    assert_eq!(browser.number("curvmesh.meshes[0].cache.images.length"), 1.0);
    assert!(browser.eval("document.getElementById('loading').hidden") == true);
    browser.press("1");
    browser.set("edges", "off");
    browser.settle();
    let canvas = browser.canvas();
    let middle = [canvas.width / 2, canvas.height / 2];
    let at = |dx: i32, dy: i32| {
        let x = middle[0].saturating_add_signed(dx);
        let y = middle[1].saturating_add_signed(dy);
        let i = 4 * (y * canvas.width + x) as usize;
        [canvas.rgba[i], canvas.rgba[i + 1], canvas.rgba[i + 2]].map(|c| c > 110)
    };
    let d = 60;
    assert_eq!(at(-d, -d), [true, false, false], "red at the upper left");
    assert_eq!(at(d, -d), [false, true, false]);
    assert_eq!(at(-d, d), [false, false, true]);
    assert_eq!(at(d, d), [true, true, false]);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// All pictures are squares of one size: a large one must not make thousands of small ones large.
#[test]
fn the_size_of_pictures_follows_their_number() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("t", vec![Exhibit::of_mesh("t", &torus())]));
    browser.open_view(&path);
    let mut side = |large: usize, small: usize, limit: usize| {
        browser.number(&format!(
            "curvmesh.sideOfPictures([...Array({large}).fill([2000, 3]), ...Array({small}).fill([8, 8])], {limit})"
        ))
    };
    assert_eq!(side(1, 0, 16384), 2048.0);
    assert_eq!(side(1, 60, 16384), 2048.0);
    assert_eq!(side(60, 0, 1024), 1024.0);
    assert_eq!(side(1, 5000, 16384), 128.0);
    assert_eq!(side(0, 100_000, 16384), 8.0);
    let many = "curvmesh.sideOfPictures(Array(200).fill([2048, 2048]), 16384)";
    assert_eq!(browser.number(many), 2048.0);
}

/// Material numbers beyond 16 bits, and more materials than a texture has rows.
#[test]
fn every_face_has_its_own_of_many_materials() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut surfaces = vec![Surface { color: [0.0, 1.0, 0.0, 1.0], ..Surface::default() }; 70_000];
    surfaces[69_999] =
        Surface { name: "last\n".into(), color: [1.0, 0.0, 0.0, 1.0], ..Surface::default() };
    let shown = Exhibit {
        name: "square".into(),
        positions: square.map(|[x, y]| DVec3::new(x, y, 0.0)).into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        materials: Some(Materials { surfaces, of_face: vec![69_999; 2], ..Materials::default() }),
        ..Exhibit::default()
    };
    let (_folder, path) = file(&Page::new("Materials", vec![shown]));
    browser.open_view(&path);
    browser.press("1");
    browser.set("edges", "off");
    browser.settle();
    let canvas = browser.canvas();
    let at = 4 * (canvas.height / 2 * canvas.width + canvas.width / 2) as usize;
    let [r, g] = [canvas.rgba[at], canvas.rgba[at + 1]];
    assert!(r > 110 && g < 60, "{r} {g}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn hostile_names_do_nothing() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let names = [
        "</script><script>window.hacked = 1</script>",
        "<img src=x onerror='window.hacked = 1'>",
        "\"><svg onload=window.hacked=1>",
        "<!-- <script>",
        "'+alert(1)+'",
        "\u{202e}txet desrever\u{2066}",
        "${window.hacked = 1}\0\u{2028}",
    ];
    let mesh = torus();
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    let soup = mesh_core::PolygonSoup::from_triangles(mesh.positions(), &triangles).unwrap();
    let values: Vec<f64> = mesh.positions().iter().map(|p| p.x).collect();
    let scalars = names.map(|name| Scalars::new(name, values.clone()));
    let model = Model { vertex_scalars: scalars.into(), ..Model::from(soup) };
    let mut page = Page::new(names.join(" "), vec![]);
    for name in names {
        page.exhibits.push(Exhibit::of_model(name, &model, Pictures::default()).unwrap());
        page.report.push(Section::of_rows(name, [(name, name)]));
    }
    let html = page.to_html().unwrap();
    assert!(!html.contains('\u{202e}') && !html.contains('\0'));
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    for key in ["x", "c", "c", "a", "b"] {
        browser.press(key);
    }
    assert_eq!(browser.eval("window.hacked"), Value::Null);
    assert_eq!(browser.number("document.querySelectorAll('img, iframe, object').length"), 0.0);
    assert!(browser.text("document.title").contains("<img src=x"));
    let options =
        browser.eval("[...document.querySelectorAll('#color option')].map(o => o.textContent)");
    let options: Vec<String> = serde_json::from_value(options).unwrap();
    assert!(options.iter().any(|o| o.contains("⟨U+202E⟩txet")), "{options:?}");
    // Nothing can be requested, not even by an injected script.
    let blocked = browser.eval("fetch('http://127.0.0.1:9/').then(() => 'sent', () => 'blocked')");
    assert_eq!(blocked, "blocked");
    browser.eval("{ const s = document.createElement('script'); s.textContent = 'window.hacked = 2'; document.body.append(s); 1 }");
    assert_eq!(browser.eval("window.hacked"), Value::Null);
}

/// Every control can be reached with the Tab key, has a name, and shows the focus.
#[test]
fn the_keyboard_reaches_everything() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("Keys", vec![exhibit("one"), exhibit("other")]));
    browser.open_view(&path);
    browser.eval("document.querySelectorAll('details').forEach(d => { d.open = true; }); 1");
    let wanted = browser.eval(
        "[...document.querySelectorAll('canvas, button, select, input, summary')].filter(e => e.offsetParent !== null).length",
    );
    let mut reached = std::collections::HashSet::new();
    browser.eval("window.all = [...document.querySelectorAll('*')]; 1");
    for _ in 0..90 {
        browser.press("Tab");
        let here = browser.eval(
            "(() => { const e = document.activeElement; if (!e.matches('canvas, button, select, input, summary')) return null;
               const style = getComputedStyle(e);
               const name = e.getAttribute('aria-label') || e.textContent.trim() || (e.labels && e.labels[0] && e.labels[0].textContent.trim());
               return [all.indexOf(e), Boolean(name), style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2, e.outerHTML.slice(0, 80)]; })()",
        );
        if here.is_null() {
            continue;
        }
        assert!(here[1] == true, "no name: {here}");
        assert!(here[2] == true, "no outline: {here}");
        reached.insert(here[0].as_u64().unwrap());
    }
    assert_eq!(reached.len() as u64, wanted.as_u64().unwrap());
    // Every listed key has an effect.
    browser.eval("document.getElementById('canvas').focus(); 1");
    browser.press("x");
    assert!(browser.eval("document.getElementById('live').textContent.length > 5") == true);
    for (key, state) in
        [("g", "smooth"), ("e", "edges"), ("o", "perspective"), ("a", "layout"), ("c", "color")]
    {
        let before = browser.eval(&format!("curvmesh.state.{state}"));
        browser.press(key);
        assert_ne!(browser.eval(&format!("curvmesh.state.{state}")), before, "{key}");
    }
    // What a key has changed is told.
    let told = "document.getElementById('live').textContent";
    let edges = if browser.eval("curvmesh.state.edges") == true { "off" } else { "on" };
    browser.press("e");
    assert_eq!(browser.text(told), format!("Edges: {edges}"));
    for (key, id, label) in [("a", "layout", "Arrange"), ("c", "color", "Colour by")] {
        browser.press(key);
        let chosen = format!("document.getElementById('{id}').selectedOptions[0].textContent");
        let wanted = format!("{label}: {}", browser.text(&chosen));
        assert_eq!(browser.text(told), wanted);
    }
    let theme = browser.text("document.documentElement.dataset.theme");
    browser.press("d");
    assert_ne!(browser.text("document.documentElement.dataset.theme"), theme);
    browser.press("s");
    browser.wait_for("curvmesh.saved > 1000");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn zoom_goes_to_the_pointer_and_double_clicks_centre() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("Camera", vec![exhibit("torus")]));
    browser.open_view(&path);
    let corner = browser.eval(
        "(() => { const r = canvas.getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()",
    );
    let corner: Vec<f64> = serde_json::from_value(corner).unwrap();
    // The middle of what is hit first from the left: the surface there faces the camera.
    let find = "(() => { let from = null; for (let x = 200; x < 900; x += 7) { const hit = curvmesh.point(x, 300); \
                if (hit && from === null) from = x; if (!hit && from !== null) return Math.round((from + x) / 2); } })()";
    let distance = |a: &Value, b: &Value| {
        let pairs = (0..3).map(|i| a[i].as_f64().unwrap() - b[i].as_f64().unwrap());
        pairs.map(|d| d * d).sum::<f64>().sqrt()
    };
    for perspective in ["on", "off"] {
        browser.press("0");
        browser.set("perspective", perspective);
        let x = browser.number(find);
        let before = browser.eval(&format!("curvmesh.point({x}, 300).world"));
        let half = browser.number("curvmesh.state.half");
        for _ in 0..8 {
            browser.call(
                "Input.dispatchMouseEvent",
                serde_json::json!({ "type": "mouseWheel", "x": corner[0] + x, "y": corner[1] + 300.0, "deltaX": 0, "deltaY": -60 }),
            );
        }
        browser.settle();
        assert!(browser.number("curvmesh.state.half") < 0.5 * half);
        let after = browser.eval(&format!("curvmesh.point({x}, 300).world"));
        // A pixel is about 0.03 wide at first.
        assert!(distance(&before, &after) < 0.05, "{perspective}: {before} {after}");
    }
    // F shows all of it again and leaves the direction alone.
    browser.press("0");
    browser.press("ArrowLeft");
    let (turned, half) =
        (browser.eval("curvmesh.state.turn"), browser.number("curvmesh.state.half"));
    for _ in 0..5 {
        browser.press("+");
    }
    assert!(browser.number("curvmesh.state.half") < 0.6 * half);
    browser.press("f");
    assert_eq!(browser.eval("curvmesh.state.turn"), turned);
    assert!((browser.number("curvmesh.state.half") / half - 1.0).abs() < 0.1);
    // The clicked point comes to the middle.
    let x = browser.number(find);
    let clicked = browser.eval(&format!("curvmesh.point({x}, 300).world"));
    for clicks in [1, 2] {
        for kind in ["mousePressed", "mouseReleased"] {
            browser.call(
                "Input.dispatchMouseEvent",
                serde_json::json!({ "type": kind, "x": corner[0] + x, "y": corner[1] + 300.0, "button": "left", "clickCount": clicks }),
            );
        }
    }
    browser.settle();
    let middle = format!("curvmesh.point({}, {}).world", corner[2] / 2.0, corner[3] / 2.0);
    let middle = browser.eval(&middle);
    assert!(distance(&middle, &clicked) < 0.05, "{middle} {clicked}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn keys_belong_to_the_picture() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("Keys", vec![exhibit("torus")]));
    browser.open_view(&path);
    let state = "JSON.stringify(curvmesh.state)";
    for place in ["document.activeElement.blur()", "document.getElementById('edges').focus()"] {
        browser.eval(&format!("{place}; 1"));
        let before = browser.text(state);
        for key in ["e", "g", "d", "1", "+", "ArrowLeft"] {
            browser.press(key);
        }
        assert_eq!(browser.text(state), before, "{place}");
    }
    browser.drag([300.0, 400.0], [301.0, 400.0]);
    let before = browser.text(state);
    browser.press("e");
    assert_ne!(browser.text(state), before, "a click gives the keys to the picture");
}

/// A copied link shows the same picture in a new window; a damaged one does no harm.
#[test]
fn a_link_restores_the_view() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("Link", vec![exhibit("one"), exhibit("two")]));
    browser.open_view(&path);
    assert_eq!(browser.text("location.hash"), "");
    browser.set("up", "z");
    browser.set("smooth", "on");
    browser.set("color", "face:area");
    browser.set("map", "magma");
    browser.set("low", "0.4");
    browser.set("high", "0.6");
    browser.set("layout", "one");
    browser.set("one", "1");
    browser.set("theme", "dark");
    browser.eval("document.querySelector('[data-overlay=\"Sharp edges\"]').click(); 1");
    browser.drag([400.0, 400.0], [500.0, 430.0]);
    browser.press("+");
    browser.mouse("mouseMoved", [5.0, 5.0], false);
    browser.eval("canvas.style.outline = 'none'; curvmesh.point(1, 1); 1");
    browser.settle();
    browser.eval("Object.defineProperty(navigator, 'clipboard', { value: { writeText: async text => { window.copied = text; } } }); document.getElementById('link').click(); 1");
    browser.wait_for("Boolean(window.copied)");
    assert!(browser.text("copied").starts_with("file://"));
    let hash = browser.text("copied.split('#')[1]");
    assert_eq!(browser.text("location.hash.slice(1)"), hash);
    let first = browser.canvas();
    let state = "(({ picked, low, high, turn, ...rest }) => JSON.stringify([rest.up, rest.smooth, rest.color, rest.map, rest.layout, rest.one, rest.theme, low, high, [...rest.overlays]]))(curvmesh.state)";
    let wanted = browser.text(state);
    drop(browser);

    let mut browser = Browser::start(LARGE).unwrap();
    let address = format!("file://{}#{hash}", path.canonicalize().unwrap().display());
    let open = |browser: &mut Browser, address: &str| {
        browser.call("Page.navigate", serde_json::json!({ "url": "about:blank" }));
        browser.call("Page.navigate", serde_json::json!({ "url": address }));
        browser.wait_for("Boolean(window.curvmesh && (curvmesh.ready || curvmesh.error))");
        assert_eq!(browser.eval("curvmesh.error"), Value::Null);
        browser.eval(
            "canvas.style.outline = 'none'; document.getElementById('hints').open = false; canvas.focus(); 1",
        );
        browser.settle();
    };
    open(&mut browser, &address);
    assert_eq!(browser.text(state), wanted);
    assert!(browser.canvas().difference(&first) < 0.002);
    for (id, value) in [("up", "z"), ("color", "face:area"), ("one", "1"), ("range", "given")] {
        assert_eq!(browser.text(&format!("document.getElementById('{id}').value")), value);
    }
    assert!(browser.eval("document.getElementById('smooth').checked") == true);
    // Another link in the same window.
    browser.eval("location.hash = ''; 1");
    browser.wait_for("curvmesh.state.layout === 'side' && curvmesh.state.map === 'auto'");

    // Without a camera in the link, the mesh is framed, whatever else the link sets.
    open(
        &mut browser,
        &format!(
            "file://{}#up=x&perspective=0&color=face:area",
            path.canonicalize().unwrap().display()
        ),
    );
    let before = browser.text("JSON.stringify([curvmesh.state.turn, curvmesh.state.half])");
    browser.press("0");
    assert_eq!(browser.text("JSON.stringify([curvmesh.state.turn, curvmesh.state.half])"), before);
    browser.settle();
    assert!(!browser.text("location.hash").contains("turn"));
    // It follows the window until it is moved.
    let half = browser.number("curvmesh.state.half");
    browser.resize([700, 900]);
    browser.wait_for(&format!("curvmesh.state.half !== {half}"));
    browser.press("+");
    let half = browser.number("curvmesh.state.half");
    browser.resize(LARGE);
    browser.settle();
    assert_eq!(browser.number("curvmesh.state.half"), half);
    browser.wait_for("location.hash.includes('turn') && location.hash.includes('half')");

    let damaged = "measured=0,1,2;9,1,2,3;0,0,a,0&turn=0,0,0,0&target=1,2&half=-3&up=w&color=no&layout=<b>&level=9&lines=7&sharp=NaN&ends=1&wipe=1e999&map=%00";
    open(&mut browser, &format!("file://{}#{damaged}", path.canonicalize().unwrap().display()));
    assert_eq!(browser.text("curvmesh.state.layout"), "side");
    assert!(browser.canvas().inked() > 0.1);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// The length beside the measured line.
fn length_of(browser: &mut Browser) -> f64 {
    let text = browser.text("document.getElementById('length-of').textContent");
    text.strip_suffix(" model units").unwrap().parse().unwrap()
}

/// A square of side 3 and one in front of it: lengths and cuts are known.
#[test]
fn distances_are_measured_and_planes_cut() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let square = |z: f64, half: f64| {
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| DVec3::new(half * x, half * y, z))
    };
    let positions = [square(0.0, 1.5), square(2.0, 0.5)].concat();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let shown = Exhibit { name: "squares".into(), positions, triangles, ..Exhibit::default() };
    let (_folder, path) = file(&Page::new("Squares", vec![shown]));
    browser.open_view(&path);
    browser.press("1");
    browser.set("perspective", "off");
    browser.press("f");
    let middle: Vec<f64> = serde_json::from_value(browser.eval(
        "(() => { const r = canvas.getBoundingClientRect(); return [r.width / 2, r.height / 2, r.x, r.y, r.height / 2 / curvmesh.state.half]; })()",
    ))
    .unwrap();
    // The place of the window where a point of the model is seen.
    let at = |x: f64, y: f64| {
        [middle[2] + middle[0] + x * middle[4], middle[3] + middle[1] - y * middle[4]]
    };
    browser.press("m");
    assert_eq!(
        browser.text("document.getElementById('measure').getAttribute('aria-pressed')"),
        "true"
    );
    let bare = browser.canvas();
    click(&mut browser, at(-1.0, -1.0));
    click(&mut browser, at(1.0, 1.0));
    let length = length_of(&mut browser);
    // A click is exact to half a pixel, which is about 0.005 here.
    assert!((length - 8.0_f64.sqrt()).abs() < 0.02, "{length}");
    let line = browser.canvas();
    assert!(line.difference(&bare) > 1e-3, "{}", line.difference(&bare));
    // From the back square to the front one: the depth counts.
    click(&mut browser, at(-1.0, 0.0));
    click(&mut browser, at(0.0, 0.0));
    let length = length_of(&mut browser);
    assert!((length - 5.0_f64.sqrt()).abs() < 0.02, "{length}");
    let said = browser.text("document.getElementById('live').textContent");
    assert!(said.starts_with("Distance 2.2"), "{said}");
    // The link holds both points, and the cutting plane.
    browser.set("cut", "view");
    browser.set("cut-at", "0.25");
    browser.wait_for("location.hash.includes('measured') && location.hash.includes('cutAt=0.25')");
    let measured = "JSON.stringify([document.getElementById('length-of').textContent, curvmesh.state.cut, curvmesh.state.cutAt, curvmesh.state.measuring])";
    let (link, wanted) = (browser.text("location.hash"), browser.text(measured));
    let address = format!("file://{}{link}", path.canonicalize().unwrap().display());
    for address in ["about:blank", &address] {
        browser.call("Page.navigate", serde_json::json!({ "url": address }));
    }
    browser.wait_for("Boolean(window.curvmesh && curvmesh.ready)");
    browser.settle();
    assert_eq!(browser.text(measured), wanted);
    browser.eval("document.getElementById('canvas').focus(); 1");
    browser.set("cut", "none");
    browser.set("cut-at", "0");
    browser.press("m");
    assert!(browser.eval("document.getElementById('length-of').hidden") == true);

    // A plane across z between both leaves the back one, the other side the front one.
    let depth = |browser: &mut Browser| {
        browser.number(&format!("curvmesh.point({}, {})?.world[2] ?? -9", middle[0], middle[1]))
    };
    assert!((depth(&mut browser) - 2.0).abs() < 1e-3);
    let whole = browser.canvas();
    browser.set("cut", "z");
    assert!(depth(&mut browser).abs() < 1e-3, "the front square is cut off");
    browser.set("cut-other", "on");
    assert!((depth(&mut browser) - 2.0).abs() < 1e-3);
    let corner = browser.eval(&format!(
        "curvmesh.point({}, {})",
        middle[0] - middle[4],
        middle[1] - middle[4]
    ));
    assert!(corner.is_null(), "the back square is cut off: {corner}");
    assert!(browser.canvas().difference(&whole) > 0.1);
    // Across x, a third of the way from the middle to the right end.
    browser.set("cut-other", "off");
    browser.set("cut", "x");
    browser.set("cut-at", "0.335");
    for (x, there) in [(0.45, true), (0.55, false), (1.2, false), (-1.2, true)] {
        let hit =
            browser.eval(&format!("curvmesh.point({}, {})", middle[0] + x * middle[4], middle[1]));
        assert_eq!(!hit.is_null(), there, "{x}");
    }
    // Along the view, the plane turns with the camera.
    browser.set("cut", "view");
    browser.set("cut-at", "0");
    assert!(depth(&mut browser).abs() < 1e-3);
    browser.press("2");
    assert!((depth(&mut browser) - 2.0).abs() < 1e-3, "from behind, the back one is nearer");
    browser.set("cut", "none");
    assert!(depth(&mut browser).abs() < 1e-3);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// The legend stands beside the picture, has the whole name, and says where values leave its range.
#[test]
fn the_legend_stands_beside_the_mesh() {
    let Some(mut browser) = Browser::start([1280, 800]) else { return };
    let mut shown = exhibit("torus");
    let name = "a_property_with_a_name_that_is_much_longer_than_the_legend_is_wide";
    let values = shown.positions.iter().map(|p| p.x.powi(3)).collect();
    shown.fields.insert(0, Field::new(name, On::Vertices, values));
    let (_folder, path) = file(&Page::new("Legend", vec![shown]));
    for (size, file) in [([1280, 800], "legend-wide.png"), ([390, 780], "legend-phone.png")] {
        browser.resize(size);
        browser.open_view(&path);
        browser.settle();
        browser.picture(None).keep(file);
        let apart = "(() => { const [a, b] = ['canvas', 'bar'].map(id => document.getElementById(id).getBoundingClientRect());
            return b.width > 50 && b.height > 30 && (a.right <= b.left || a.bottom <= b.top); })()";
        assert!(browser.eval(apart) == true, "{size:?}");
        let whole = "(() => { const q = document.getElementById('quantity'); return q.scrollWidth <= q.clientWidth && q.textContent; })()";
        assert_eq!(browser.text(whole), name);
        let ends = "['below', 'above'].map(id => getComputedStyle(document.getElementById(id)).visibility).join()";
        let label = "document.getElementById('bar').getAttribute('aria-label')";
        assert_eq!(browser.text(ends), "visible,visible");
        assert!(browser.text(label).ends_with("some values are below or above"));
        browser.set("range", "full");
        assert_eq!(browser.text(ends), "hidden,hidden");
        browser.set("high", "0.5");
        assert_eq!(browser.text(ends), "hidden,visible");
        assert!(browser.text(label).ends_with("some values are above"));
        // All of the mesh is in the picture, beside the legend.
        let canvas = browser.eval("canvas.style.outline = 'none'; document.getElementById('hints').hidden = true; [canvas.clientWidth, canvas.clientHeight]");
        let (width, height) = (index(&canvas[0]) as u32, index(&canvas[1]) as u32);
        let picture = browser.canvas();
        for edge in [[0, 0, 4, height], [width - 4, 0, 4, height], [0, height - 4, width, 4]] {
            assert_eq!(picture.part(edge).inked(), 0.0, "{size:?} {edge:?}");
        }
    }
}

/// The numbers of pixels in the first colour of labels, in the second, and in others.
fn hues(browser: &mut Browser) -> [f64; 3] {
    let count = "(() => { const gl = canvas.getContext('webgl2'); curvmesh.time(); const n = canvas.width * canvas.height, p = new Uint8Array(4 * n); \
                 gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, p); const found = [0, 0, 0]; \
                 for (let i = 0; i < 4 * n; i += 4) { const [r, g, b] = p.subarray(i, i + 3); if (r > 250 && g > 250 && b > 250) continue; \
                 found[Math.abs(g / r - 159 / 230) < 0.06 && b < 12 ? 0 : Math.abs(r / b - 86 / 233) < 0.06 && Math.abs(g / b - 180 / 233) < 0.06 ? 1 : 2]++; } return found; })()";
    serde_json::from_value(browser.eval(count)).unwrap()
}

/// A label of the legend is shown alone by a click or a key, and all are back by the next one.
#[test]
fn a_label_is_isolated_by_the_legend() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let mesh = torus();
    let mut shown = Exhibit::of_mesh("torus", &mesh);
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    let side = |x: f64| f64::from(u8::from(x >= 0.0));
    let middle = |t: &[u32; 3]| t.iter().map(|&v| mesh.positions()[v as usize].x).sum::<f64>();
    let of_faces = triangles.iter().map(|t| side(middle(t))).collect();
    shown.fields.push(Field::labels("patch", On::Faces, of_faces));
    let of_vertices = mesh.positions().iter().map(|p| side(p.x)).collect();
    shown.fields.push(Field::labels("zone", On::Vertices, of_vertices));
    let (_folder, path) = file(&Page::new("Alone", vec![shown]));
    browser.open_view(&path);
    browser.eval("canvas.style.outline = 'none'; document.getElementById('hints').open = false; 1");
    browser.set("edges", "");
    browser.set("backs", "");
    let pressed = |browser: &mut Browser| {
        browser.text("[...document.querySelectorAll('#swatches button')].map(b => b.getAttribute('aria-pressed')).join()")
    };
    let named = |browser: &mut Browser| {
        browser.text("document.getElementById('bar').getAttribute('aria-label')")
    };
    let press = |browser: &mut Browser, row: usize| {
        let place = format!(
            "(() => {{ const r = document.querySelectorAll('#swatches button')[{row}].getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
        );
        let at: [f64; 2] = serde_json::from_value(browser.eval(&place)).unwrap();
        click(browser, at);
    };
    let role = "document.getElementById('bar').getAttribute('role')";
    assert_eq!(browser.text(role), "group", "buttons are no part of a picture");
    // A point of each label, where nothing of the other is behind it.
    let places = "[[0, 'patch'], [1, 'patch']].map(([label]) => { for (let y = 300; y < 600; y += 7) for (let x = 60; x < 800; x += 7) { const h = curvmesh.point(x, y); \
                  if (h && Number(h.rows.find(r => r[0] === 'patch')[1]) === label) return [x, y]; } })";
    let places: [[f64; 2]; 2] = serde_json::from_value(browser.eval(places)).unwrap();
    let is_hit = |browser: &mut Browser, [x, y]: [f64; 2]| {
        !browser.eval(&format!("curvmesh.point({x}, {y})")).is_null()
    };
    // But for the dot on the last point that was read.
    let is_same = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 300.0);
    for field in ["face:patch", "vertex:zone"] {
        browser.set("color", field);
        let all = hues(&mut browser);
        assert!(all[0] > 20_000.0 && all[1] > 20_000.0, "{field}: {all:?}");
        for row in [0, 1] {
            press(&mut browser, row);
            let one = hues(&mut browser);
            assert!(one[row] > 20_000.0 && one[1 - row] < 50.0, "{field}: {one:?}");
            assert_eq!(pressed(&mut browser), ["true,false", "false,true"][row]);
            assert!(named(&mut browser).ends_with(&format!("; only {row} is shown")));
            assert!(
                browser.text("document.getElementById('live').textContent").starts_with("Only")
            );
            // What is hidden is not under the pointer, unless something was behind it.
            assert!(is_hit(&mut browser, places[row]), "{field}");
            press(&mut browser, row);
            assert!(is_same(hues(&mut browser), all), "{field}");
            assert_eq!(pressed(&mut browser), "false,false");
        }
    }
    // The keyboard does the same, and the focus stays.
    let all = hues(&mut browser);
    browser.eval("document.querySelectorAll('#swatches button')[1].focus(); 1");
    for key in ["Enter", " "] {
        browser.press(key);
        assert_eq!(pressed(&mut browser), "false,true", "{key:?}");
        browser.press(key);
        assert!(is_same(hues(&mut browser), all), "{key:?}");
    }
    assert_eq!(browser.eval("document.activeElement.value"), "1");
    // The frame is that of what is shown, and so are lines on the surface.
    browser.set("color", "face:patch");
    browser.set("sharp", "1");
    browser.eval("document.querySelector('[data-overlay=\"Sharp edges\"]').click(); 1");
    browser.settle();
    press(&mut browser, 0);
    assert_eq!(browser.number("curvmesh.state.only"), 0.0);
    let count = "[...curvmesh.meshes[0].overlays.values()].map(line => line.count).join()";
    let counts = browser.text(count);
    let [whole, part]: [f64; 2] =
        serde_json::from_str(&format!("[{counts}]")).expect("lines of the whole and of a part");
    assert!((0.4..0.6).contains(&(part / whole)), "{counts}");
    browser.eval(
        "document.querySelector('[data-overlay=\"Sharp edges\"]').click(); canvas.focus(); 1",
    );
    browser.press("f");
    let middle = browser.number("curvmesh.state.target[0]");
    assert!(middle < -1.0, "{middle}");
    browser.wait_for("location.hash.includes('only=0')");
    let link = browser.text("location.hash");
    // The link shows the same again; a link to a label that there is not, all.
    browser.press("i");
    assert_eq!(browser.eval("curvmesh.state.only"), Value::Null);
    // The address follows a moment later; a link that it shows already would change nothing.
    browser.wait_for("!location.hash.includes('only')");
    browser.eval(&format!("location.hash = {link:?}; 1"));
    browser.wait_for("curvmesh.state.only === 0");
    browser.settle();
    let one = hues(&mut browser);
    assert!(one[0] > 20_000.0 && one[1] < 50.0, "{one:?}");
    assert_eq!(pressed(&mut browser), "true,false");
    browser.eval("location.hash = '#only=7'; 1");
    browser.wait_for("curvmesh.state.only === null");
    // The label in the middle of the picture.
    browser.press("0");
    let [x, y] = places[1];
    browser.eval(&format!(
        "(() => {{ const r = canvas.getBoundingClientRect(), at = {{ clientX: r.x + {x}, clientY: r.y + {y} }};
           canvas.dispatchEvent(new MouseEvent('dblclick', at)); canvas.focus(); }})()"
    ));
    browser.settle();
    browser.press("i");
    assert_eq!(browser.number("curvmesh.state.only"), 1.0);
    browser.press("Escape");
    assert_eq!(browser.eval("curvmesh.state.only"), Value::Null);
    // Other colours show all.
    press(&mut browser, 1);
    browser.set("map", "viridis");
    assert_eq!(browser.eval("curvmesh.state.only"), Value::Null);
    assert_eq!(browser.text(role), "img");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Every label has a colour of its own, in the picture, in the legend and in the saved settings.
#[test]
fn labels_have_colours_of_their_own() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let mesh = torus();
    let mut shown = Exhibit::of_mesh("torus", &mesh);
    let label = |p: &DVec3| if p.x < 0.0 { 7.0 } else { 2_147_483_647.0 };
    let zones = mesh.positions().iter().map(label).collect();
    shown.fields.push(Field::labels("zone", On::Vertices, zones));
    let many = (0..mesh.topology().face_count()).map(|f| (f / 40) as f64 - 3.0).collect();
    shown.fields.push(Field::labels("many", On::Faces, many));
    // Forty strips side by side: neighbours are twenty labels apart, which is the number of colours.
    let strip = |f: usize| ((f / 103 % 2) * 20 + f / 206) as f64;
    let strips = (0..mesh.topology().face_count()).map(strip).collect();
    shown.fields.push(Field::labels("strip", On::Faces, strips));
    let thirds = mesh.positions().iter().map(|p| (p.x / 3.0).round() + 0.5).collect();
    shown.fields.push(Field::new("thirds", On::Vertices, thirds));
    for value in [1e15, 0.5] {
        assert!(!Field::labels("id", On::Vertices, vec![value]).is_label, "{value}");
    }
    let (_folder, path) = file(&Page::new("Labels", vec![shown]));
    browser.open_view(&path);
    browser.eval("canvas.style.outline = 'none'; document.getElementById('hints').open = false; 1");
    browser.set("edges", "");
    browser.set("backs", "");
    let text = |browser: &mut Browser, id: &str| {
        browser.text(&format!("document.getElementById('{id}').textContent"))
    };
    let is_hidden = |browser: &mut Browser, id: &str| {
        browser.eval(&format!("document.getElementById('{id}').checkVisibility()")) == false
    };
    assert_eq!(text(&mut browser, "swatches"), "72147483647");
    assert!(is_hidden(&mut browser, "scale") && is_hidden(&mut browser, "range"));
    let found = hues(&mut browser);
    assert!(found[0] > 20_000.0 && found[1] > 20_000.0, "{found:?}");
    // Rounded rims of the silhouette, where pixels are half background.
    assert!(found[2] < 0.05 * (found[0] + found[1]), "{found:?}");
    let hit = browser.eval("curvmesh.point(250, 400)");
    assert_eq!(rows(&hit)[0].1, "7 at the vertex");
    // More labels than colours.
    browser.set("color", "face:many");
    let legend = text(&mut browser, "swatches");
    assert!(legend.starts_with("-3-2-10123") && legend.ends_with("99colours repeat"), "{legend}");
    assert!(text(&mut browser, "histogram").contains("103 different values"));
    assert_eq!(browser.number("document.querySelectorAll('#swatches button').length"), 103.0);
    let name = browser.text("document.getElementById('bar').getAttribute('aria-label')");
    assert!(
        name.contains("many: a colour for each label: -3, -2") && name.contains("83 more"),
        "{name}"
    );
    // Colours repeat, but not between neighbours.
    browser.set("color", "face:strip");
    assert!(text(&mut browser, "swatches").ends_with("39colours repeat"));
    let clashes = "(() => { const colors = [...document.querySelectorAll('#swatches span')].map(s => s.style.getPropertyValue('--color')); \
                   const { corners, fields } = curvmesh.meshes[0], { values } = fields.get('face:strip'), seen = new Map(); let near = 0, clashes = 0; \
                   for (let h = 0; h < corners.length; h++) { const ends = [corners[h], corners[h % 3 === 2 ? h - 2 : h + 1]].sort().join(), a = values[Math.floor(h / 3)], b = seen.get(ends); \
                   if (b !== undefined && a !== b) { near++; if (colors[a] === colors[b]) clashes++; } seen.set(ends, a); } return [near > 100, clashes]; })()";
    assert_eq!(browser.eval(clashes), serde_json::json!([true, 0]));
    // Fractions are no labels.
    browser.set("color", "vertex:thirds");
    let offered =
        "[...document.querySelectorAll('#map option')].map(o => o.value).includes('labels')";
    assert!(browser.eval(offered) == false);
    browser.set("color", "face:many");
    assert!(browser.eval(offered) == true);
    // Another map shows amounts.
    browser.set("map", "viridis");
    assert!(!is_hidden(&mut browser, "scale") && is_hidden(&mut browser, "swatches"));
    assert!(!is_hidden(&mut browser, "range"));
    browser.set("map", "labels");
    assert!(is_hidden(&mut browser, "scale") && browser.text("curvmesh.state.map") == "labels");
    browser.eval("curvmesh.save()");
    assert!(browser.number("curvmesh.saved") > 1000.0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Pointing at the surface moves nothing in the panel; hints fold when the mesh is turned.
#[test]
fn pointing_moves_nothing_and_hints_fold() {
    let Some(mut browser) = Browser::start([1280, 800]) else { return };
    let (_folder, path) = file(&Page::new("Still", vec![exhibit("one")]));
    browser.open_view(&path);
    let places = "JSON.stringify(['canvas', 'controls', 'counts', 'bar'].map(id => document.getElementById(id).getBoundingClientRect()))";
    let before = browser.text(places);
    let is_open = "document.getElementById('hints').open";
    assert!(browser.eval(is_open) == false, "they hide no mesh");
    browser.eval("document.getElementById('hints').open = true; 1");
    // Readers of the screen skip what else is in a list of terms.
    assert!(browser.eval("document.querySelector('dl > :not(div, dt, dd)')").is_null());
    let found = "(() => { for (let x = 50; x < 400; x += 10) { const h = curvmesh.point(x, 380); if (h) return true; } })()";
    assert!(browser.eval(found) == true);
    assert!(browser.number("document.querySelectorAll('#picked div').length") >= 5.0);
    browser.settle();
    assert_eq!(browser.text(places), before);
    browser.drag([200.0, 400.0], [230.0, 400.0]);
    assert!(browser.eval(is_open) == false);
    assert_eq!(browser.text(places), before);
    let full = serde_json::json!({ "expression": "document.getElementById('full').click()", "userGesture": true });
    browser.call("Runtime.evaluate", full);
    browser.wait_for("document.fullscreenElement?.tagName === 'MAIN'");
    browser.wait_for("document.getElementById('stage').clientHeight === innerHeight");
    browser.wait_for("document.getElementById('leave').checkVisibility()");
    browser.eval("document.getElementById('leave').click(); 1");
    browser.wait_for("!document.fullscreenElement && document.getElementById('leave').hidden");
}

/// Values stay where they were clicked until Escape or the next click.
#[test]
fn a_click_pins_values() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("Pinned", vec![exhibit("torus")]));
    browser.open_view(&path);
    let places = "(() => { const r = canvas.getBoundingClientRect(), found = []; \
                  for (let x = 200; x < 700; x += 7) if (curvmesh.point(x, 300)) found.push([r.x + x, r.y + 300]); \
                  return [found[1], found.at(-2)]; })()";
    let [first, other]: [[f64; 2]; 2] = serde_json::from_value(browser.eval(places)).unwrap();
    let told = "document.getElementById('picked').textContent";
    let is_pinned = "document.getElementById('pinned').checkVisibility()";
    click(&mut browser, first);
    let pinned = browser.text(told);
    assert!(browser.eval(is_pinned) == true);
    browser.mouse("mouseMoved", other, false);
    browser.settle();
    browser.settle();
    assert_eq!(browser.text(told), pinned);
    click(&mut browser, other);
    assert!(browser.eval(is_pinned) == true);
    assert_ne!(browser.text(told), pinned);
    browser.eval("document.getElementById('values').focus(); 1");
    browser.press("Escape");
    assert!(browser.eval(is_pinned) == false);
    browser.mouse("mouseMoved", first, false);
    browser.wait_for(&format!("{told} === {}", serde_json::json!(pinned)));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// The cross in the corner turns with the camera, and can be hidden.
#[test]
fn the_axes_turn_with_the_camera() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("Axes", vec![exhibit("torus")]));
    browser.open_view(&path);
    let ends = "Object.fromEntries([...document.querySelectorAll('#axes g')].map(g => [g.textContent, ['x2', 'y2'].map(n => Math.round(g.firstChild.getAttribute(n)) + 0)]))";
    // From the front: x to the right, y up, z towards the camera.
    browser.press("1");
    assert_eq!(browser.eval(ends), serde_json::json!({ "x": [22, 0], "y": [0, -22], "z": [0, 0] }));
    browser.press("4");
    assert_eq!(
        browser.eval(ends),
        serde_json::json!({ "x": [0, 0], "y": [0, -22], "z": [-22, 0] })
    );
    browser.set("show-axes", "off");
    assert!(browser.eval("document.getElementById('axes').checkVisibility()") == false);
    browser.wait_for("location.hash.includes('axes=0')");
}

/// The border of a wipe is dragged in the picture.
#[test]
fn the_border_is_dragged() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let mut page = Page::new("Border", vec![exhibit("one"), exhibit("two"), exhibit("three")]);
    page.layout = Layout::Wipe;
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    let place = "(() => { const r = document.getElementById('border').getBoundingClientRect(); return [r.x + r.width / 2, 300]; })()";
    let from: [f64; 2] = serde_json::from_value(browser.eval(place)).unwrap();
    let camera = browser.text("JSON.stringify(curvmesh.state.turn)");
    browser.drag(from, [from[0] - 100.0, 300.0]);
    let to: [f64; 2] = serde_json::from_value(browser.eval(place)).unwrap();
    assert!((from[0] - 100.0 - to[0]).abs() < 2.0, "{from:?} {to:?}");
    // At the end of the picture, the same two meshes stay.
    browser.drag(to, [0.0, 300.0]);
    assert!((0.9..1.0).contains(&browser.number("curvmesh.state.wipe")));
    assert_eq!(browser.text("JSON.stringify(curvmesh.state.turn)"), camera);
    browser.set("layout", "side");
    assert!(browser.eval("document.getElementById('border').hidden") == true);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Two taps bring a point to the middle, as a double click does.
#[test]
fn double_taps_centre() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("Taps", vec![exhibit("torus")]));
    browser.open_view(&path);
    let find = "(() => { const r = canvas.getBoundingClientRect(); \
                for (let x = 200; x < 700; x += 7) { const hit = curvmesh.point(x + 7, 300); if (curvmesh.point(x, 300) && hit) return [x + 7 + r.x, 300 + r.y, hit.world]; } })()";
    let found = browser.eval(find);
    let now = browser.number("Date.now() / 1000");
    for (time, is_down) in [(0.0, true), (0.05, false), (0.2, true), (0.25, false)] {
        let (kind, points) = match is_down {
            true => ("touchStart", serde_json::json!([{ "x": found[0], "y": found[1] }])),
            false => ("touchEnd", serde_json::json!([])),
        };
        browser.call(
            "Input.dispatchTouchEvent",
            serde_json::json!({ "type": kind, "touchPoints": points, "timestamp": now + time }),
        );
    }
    browser.settle();
    let middle =
        browser.eval("curvmesh.point(canvas.clientWidth / 2, canvas.clientHeight / 2).world");
    for i in 0..3 {
        let [wanted, seen] = [&found[2], &middle].map(|place| place[i].as_f64().unwrap());
        assert!((wanted - seen).abs() < 0.05, "{found} {middle}");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Nothing starts by itself for people who asked their system for less motion.
#[test]
fn reduced_motion_is_respected() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let mut page = Page::new("Still", vec![exhibit("one"), exhibit("two")]);
    page.layout = Layout::Blink;
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    assert!(browser.eval("document.getElementById('hints').open") == false, "they hide no mesh");
    for (wish, moves) in [("no-preference", true), ("reduce", false)] {
        let features = serde_json::json!([{ "name": "prefers-reduced-motion", "value": wish }]);
        browser.call("Emulation.setEmulatedMedia", serde_json::json!({ "features": features }));
        browser.open_view(&path);
        assert_eq!(browser.eval("document.getElementById('blink').checked"), moves, "{wish}");
        assert_eq!(browser.eval("curvmesh.state.blink"), moves, "{wish}");
    }
    browser.press("b");
    assert_eq!(browser.number("curvmesh.state.shown"), 1.0);
    // A link starts nothing, and a wish that comes later stops what moves.
    let is_moving = "curvmesh.state.blink || document.getElementById('blink').checked";
    browser.eval("location.hash = '#blink=1&shown=1'; 1");
    browser.settle();
    assert_eq!(browser.eval(is_moving), false);
    for (wish, moves) in [("no-preference", true), ("reduce", false)] {
        let features = serde_json::json!([{ "name": "prefers-reduced-motion", "value": wish }]);
        browser.call("Emulation.setEmulatedMedia", serde_json::json!({ "features": features }));
        if moves {
            browser.set("blink", "on");
        }
        browser.wait_for(&format!("({is_moving}) === {moves}"));
    }
}

/// WCAG 2.1: contrast of text at least 4.5 to 1, of control borders and focus at least 3 to 1.
#[test]
fn contrast_is_enough() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&Page::new("Contrast", vec![exhibit("one")]));
    browser.open_view(&path);
    for theme in ["light", "dark"] {
        browser.set("theme", theme);
        let colors = browser.eval(
            "Object.fromEntries(['ground', 'panel', 'ink', 'soft', 'line', 'field', 'mark', 'wrong'].map(n => [n, getComputedStyle(document.documentElement).getPropertyValue('--' + n).trim()]))",
        );
        let light = |name: &str| luminance(colors[name].as_str().unwrap());
        let contrast = |a: &str, b: &str| {
            let (a, b) = (light(a), light(b));
            (a.max(b) + 0.05) / (a.min(b) + 0.05)
        };
        for behind in ["ground", "panel", "field"] {
            for words in ["ink", "soft"] {
                assert!(contrast(words, behind) >= 4.5, "{theme} {words} on {behind}");
            }
            for borders in ["line", "mark", "wrong"] {
                assert!(contrast(borders, behind) >= 3.0, "{theme} {borders} on {behind}");
            }
        }
    }
}

fn luminance(color: &str) -> f64 {
    let channel = |i: usize| {
        let c = f64::from(u8::from_str_radix(&color[2 * i + 1..2 * i + 3], 16).unwrap()) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    };
    0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2)
}

/// On a phone nothing is wider than the window, and a finger rotates the mesh.
#[test]
fn a_phone_shows_everything() {
    let Some(mut browser) = Browser::start([390, 780]) else { return };
    let (_folder, path) = file(&Page::new("Phone", vec![exhibit("one"), exhibit("other")]));
    browser.open_view(&path);
    assert!(browser.number("document.documentElement.scrollWidth") <= 390.0);
    assert!(browser.eval("document.getElementById('hints').open") == false, "the mesh is in sight");
    let first = browser.canvas();
    assert!(first.inked() > 0.1);
    let touch = |browser: &mut Browser, kind: &str, points: Value| {
        browser.call(
            "Input.dispatchTouchEvent",
            serde_json::json!({ "type": kind, "touchPoints": points }),
        );
    };
    let one = |x: f64| serde_json::json!([{ "x": x, "y": 300.0 }]);
    touch(&mut browser, "touchStart", one(150.0));
    for x in [170.0, 190.0, 210.0] {
        touch(&mut browser, "touchMove", one(x));
    }
    touch(&mut browser, "touchEnd", serde_json::json!([]));
    browser.settle();
    let turned = browser.canvas();
    assert!(turned.difference(&first) > 0.02);
    // Two fingers moving apart zoom in.
    let before = browser.number("curvmesh.state.half");
    let two = |d: f64| serde_json::json!([{ "x": 180.0 - d, "y": 300.0, "id": 1 }, { "x": 180.0 + d, "y": 300.0, "id": 2 }]);
    touch(&mut browser, "touchStart", two(30.0));
    for d in [40.0, 50.0, 60.0] {
        touch(&mut browser, "touchMove", two(d));
    }
    touch(&mut browser, "touchEnd", serde_json::json!([]));
    assert!(browser.number("curvmesh.state.half") < 0.8 * before);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// A mesh above the limit is shown with fewer faces, says so, and keeps its numbers.
#[test]
fn large_meshes_are_simplified_and_say_so() {
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let shown = exhibit("large");
    let mut page = Page::new("Large", vec![shown.clone()]);
    page.most_faces = 1500;
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    assert!(browser.number("curvmesh.meshes[0].faces") <= 1500.0);
    let said = browser.text("document.getElementById('names').textContent");
    assert!(said.contains("of 4,096 faces"), "{said}");
    let found = browser.eval(
        "(() => { for (let x = 100; x < 700; x += 20) { const h = curvmesh.point(x, 420); if (h) return h; } })()",
    );
    let rows = rows(&found);
    let value = |name: &str| rows.iter().find(|(n, _)| n == name).unwrap().1.clone();
    let vertex: usize = value("vertex").replace(',', "").parse().unwrap();
    let wave: f64 = value("wave").split(' ').next().unwrap().parse().unwrap();
    same_digits(wave, shown.fields[0].values[vertex]);
}

/// A real mesh from the folder in `CURVMESH_MODELS`, if it is set.
fn model(name: &str) -> Option<Model> {
    let Some(folder) = std::env::var_os("CURVMESH_MODELS") else {
        eprintln!("skipped: CURVMESH_MODELS names no folder");
        return None;
    };
    Some(mesh_io::read(PathBuf::from(folder).join(name)).unwrap())
}

/// Igea with three properties: less than 25 bytes per face, and an early first picture. (Less than three seconds on an
/// idle machine was measured separately; test machines are shared.)
#[test]
fn a_scan_takes_few_bytes() {
    let Some(model) = model("igea.ply") else { return };
    let mut shown = Exhibit::of_model("igea", &model, Pictures::default()).unwrap();
    shown.fields.clear();
    for (i, name) in ["x", "y", "z"].into_iter().enumerate() {
        let values = shown.positions.iter().map(|p| (p[i] * 0.37).sin()).collect();
        shown.fields.push(Field::new(name, On::Vertices, values));
    }
    let faces = shown.triangles.len();
    let page = Page::new("igea", vec![shown]);
    let html = page.to_html().unwrap();
    assert!(html.len() < 8_000_000, "{}", html.len());
    assert!(html.len() < 25 * faces, "{} bytes for {faces} faces", html.len());
    let Some(mut browser) = Browser::start(LARGE) else { return };
    let (_folder, path) = file(&page);
    browser.open_view(&path);
    assert!(browser.canvas().inked() > 0.15);
    eprintln!(
        "{} bytes; ready after {:.0} ms, a frame takes {:.0} ms",
        html.len(),
        browser.number("curvmesh.first"),
        browser.number("curvmesh.time()")
    );
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
