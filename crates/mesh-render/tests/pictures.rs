//! Pictures with known pixels: areas, colours, depth, lines, and refusals.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

use core::f64::consts::PI;

use glam::DVec3;
use mesh_core::{FaceMap, TriMesh, VertexMap};
use mesh_render::{
    Drawing, LABEL_COLORS, Labels, Legend, Paint, Picture, RenderError, ScaleOptions, Scene, Side,
    Stroke, Style, Texture, View, draw_svg, render,
};
use mesh_shapes::{Sphere, Torus, inset_cube};

fn mesh(soup: &mesh_core::PolygonSoup) -> TriMesh {
    mesh_core::build(soup, &mesh_core::Repair::strict()).unwrap().mesh
}

fn cube() -> TriMesh {
    mesh(&inset_cube(0.25).unwrap())
}

fn covered(picture: &Picture) -> f64 {
    picture.pixels().iter().map(|p| f64::from(p[3]) / 255.0).sum()
}

const CLEAR: Style = Style { size: [400, 300], background: None, margin: 0.0, ..Style::DEFAULT };

#[test]
fn a_sphere_covers_a_disc_and_a_torus_a_ring() {
    let ball = mesh(&Sphere { radius: 3.0 }.icosphere(5).unwrap());
    for &side in Side::ALL {
        let view = View::of_side(&ball, side).unwrap();
        let area = covered(&render(&Scene::of(&ball), &view, &CLEAR).unwrap());
        let disc = PI * 150.0 * 150.0;
        assert!((area / disc - 1.0).abs() < 5e-3, "{side:?}: {area} of {disc}");
    }
    let torus = mesh(&Torus { major: 5.0, minor: 2.0 }.mesh(240, 60).unwrap());
    let view = View::of(&torus, DVec3::Z, DVec3::Y).unwrap();
    let area = covered(&render(&Scene::of(&torus), &view, &CLEAR).unwrap());
    let unit = 300.0 / 14.0;
    let ring = PI * (49.0 - 9.0) * unit * unit;
    assert!((area / ring - 1.0).abs() < 5e-3, "{area} of {ring}");
}

#[test]
fn the_same_view_shows_two_meshes_at_one_scale() {
    let large = mesh(&Sphere { radius: 2.0 }.icosphere(4).unwrap());
    let small = mesh(&Sphere { radius: 1.0 }.icosphere(4).unwrap());
    let view = View::of_side(&large, Side::Left).unwrap();
    let areas = [&large, &small].map(|m| covered(&render(&Scene::of(m), &view, &CLEAR).unwrap()));
    assert!((areas[0] / areas[1] - 4.0).abs() < 0.02, "{areas:?}");
}

/// From the front of a cube, only the colours of its front faces are visible.
#[test]
fn face_colours_keep_to_their_faces_and_depth() {
    let mesh = cube();
    let color = |face| if mesh.face_normal(face).z > 0.5 { [0, 200, 0] } else { [200, 0, 0] };
    let colors = FaceMap::from_vec(mesh.topology().faces().map(color).collect());
    let scene = Scene { paint: Paint::Faces(&colors), ..Scene::of(&mesh) };
    let view = View::of_side(&mesh, Side::Front).unwrap();
    let picture = render(&scene, &view, &CLEAR).unwrap();
    let inside: Vec<_> = picture.pixels().iter().filter(|p| p[3] == 255).collect();
    assert!(inside.len() > 85_000);
    assert!(inside.iter().all(|p| p[0] == 0 && p[1] > 100 && p[2] == 0));
}

#[test]
fn vertex_colours_are_blended() {
    let triangle =
        TriMesh::from_triangles(&[DVec3::ZERO, DVec3::X, DVec3::new(0.0, 1.0, 0.0)], &[[0, 1, 2]])
            .unwrap();
    let colors = VertexMap::from_vec(vec![[0, 0, 0], [200, 0, 0], [0, 200, 0]]);
    let scene = Scene { paint: Paint::Vertices(&colors), ..Scene::of(&triangle) };
    let view = View::of_side(&triangle, Side::Front).unwrap();
    let style = Style { size: [300, 300], ..CLEAR };
    let picture = render(&scene, &view, &style).unwrap();
    let light = f64::from(picture.pixel(299, 299).unwrap()[0]) / 200.0;
    for (x, y) in [(30, 250), (100, 150), (10, 20), (200, 280)] {
        let [r, g, b, _] = picture.pixel(x, y).unwrap();
        let expected =
            [f64::from(x) + 0.5, 300.0 - f64::from(y) - 0.5].map(|t| 200.0 * light * t / 300.0);
        assert!((f64::from(r) - expected[0]).abs() < 3.0 && b == 0, "{x} {y}: {r}");
        assert!((f64::from(g) - expected[1]).abs() < 3.0, "{x} {y}: {g}");
    }
}

#[test]
fn edges_outlines_and_strokes_darken_what_they_should() {
    let mesh = cube();
    let view = View::of_side(&mesh, Side::Front).unwrap();
    let dark = |style: &Style| {
        let picture = render(&Scene::of(&mesh), &view, style).unwrap();
        picture.pixels().iter().filter(|p| p[3] > 200 && p[0] < 60).count()
    };
    assert_eq!(dark(&CLEAR), 0);
    let edged = dark(&Style { edge_width: 2.0, ..CLEAR });
    assert!(edged > 1200, "{edged}");
    // The front of the cube is a square of 300 pixels, cut through at the top and the bottom.
    let outlined = dark(&Style { silhouette_width: 4.0, ..CLEAR });
    assert!((3400..3650).contains(&outlined), "{outlined}");
    let creased = dark(&Style { silhouette_width: 4.0, crease: Some(0.1), margin: 0.1, ..CLEAR });
    assert!(creased > outlined, "{creased}");

    let half = 0.5 * mesh.bounding_box().unwrap().extent().z;
    let line = |z: f64| Stroke {
        points: vec![DVec3::new(-0.2, 0.0, z), DVec3::new(0.2, 0.0, z)],
        color: [0, 0, 255],
        width: 3.0,
    };
    let blue = |stroke: Stroke| {
        let strokes = [stroke];
        let scene = Scene { strokes: &strokes, ..Scene::of(&mesh) };
        let picture = render(&scene, &view, &CLEAR).unwrap();
        picture.pixels().iter().filter(|p| p[2] > 200 && p[0] < 60).count()
    };
    assert!(blue(line(1.01 * half)) > 100);
    assert_eq!(blue(line(-1.01 * half)), 0, "behind the cube");
    let dot = Stroke { points: vec![DVec3::Z * half], color: [0, 0, 255], width: 9.0 };
    assert!((60..110).contains(&blue(dot)));
}

#[test]
fn a_chessboard_shows_texture_coordinates() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let positions = corners.map(|[x, y]: [f64; 2]| DVec3::new(x, y, 0.0));
    let mesh = TriMesh::from_triangles(&positions, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let uv = |i: usize| corners[i].map(|x| x as f32);
    let texture = Texture::chessboard(2, [[uv(0), uv(1), uv(2)], [uv(0), uv(2), uv(3)]]);
    let scene = Scene { paint: Paint::Texture(&texture), ..Scene::of(&mesh) };
    let view = View::of_side(&mesh, Side::Front).unwrap();
    let style = Style { size: [200, 200], ..CLEAR };
    let picture = render(&scene, &view, &style).unwrap();
    let green = |x, y| picture.pixel(x, y).unwrap()[1];
    assert_eq!(green(50, 50), green(150, 150));
    assert_eq!(green(50, 150), green(150, 50));
    assert!(green(50, 50) > green(150, 50) + 50);
}

#[test]
fn the_background_is_what_was_asked_for() {
    let mesh = cube();
    let view = View::of_side(&mesh, Side::Corner).unwrap();
    let corner = |background| {
        let style = Style { background, ..CLEAR };
        render(&Scene::of(&mesh), &view, &style).unwrap().pixel(0, 0).unwrap()
    };
    assert_eq!(corner(None)[3], 0);
    assert_eq!(corner(Some([9, 8, 7])), [9, 8, 7, 255]);
}

#[test]
fn png_files_hold_the_pixels() {
    let mesh = cube();
    let view = View::of_side(&mesh, Side::Corner).unwrap();
    for background in [None, Some([255; 3])] {
        let style = Style { size: [61, 47], background, ..Style::default() };
        let picture = render(&Scene::of(&mesh), &view, &style).unwrap();
        let decoded = image::load_from_memory(&picture.to_png().unwrap()).unwrap().to_rgba8();
        assert_eq!(decoded.as_raw(), picture.pixels().as_flattened());
        assert_eq!(decoded.dimensions(), (61, 47));
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let mesh = cube();
    let view = View::of_side(&mesh, Side::Front).unwrap();
    let refused = |style: Style| render(&Scene::of(&mesh), &view, &style).unwrap_err();
    assert!(matches!(refused(Style { size: [0, 5], ..CLEAR }), RenderError::Size { .. }));
    assert!(matches!(refused(Style { size: [5, 20_000], ..CLEAR }), RenderError::Size { .. }));
    assert!(matches!(refused(Style { supersampling: 0, ..CLEAR }), RenderError::Supersampling(0)));
    for width in [-1.0, f64::NAN, f64::INFINITY] {
        let error = refused(Style { edge_width: width, ..CLEAR });
        assert!(matches!(error, RenderError::Measure { .. }), "{error}");
    }
    let short = VertexMap::from_vec(vec![[0; 3]; 2]);
    let scene = Scene { paint: Paint::Vertices(&short), ..Scene::of(&mesh) };
    assert!(matches!(render(&scene, &view, &CLEAR), Err(RenderError::Length { found: 2, .. })));
}

/// Flat, a single point, or far away: an empty picture is no error.
#[test]
fn ugly_meshes_are_drawn() {
    let with = |positions: [DVec3; 3]| TriMesh::from_triangles(&positions, &[[0, 1, 2]]).unwrap();
    let far = 1e300;
    let meshes = [
        with([DVec3::ZERO, DVec3::X, DVec3::X * 2.0]),
        with([DVec3::ONE; 3]),
        with([DVec3::splat(far), DVec3::new(-far, far, 0.0), DVec3::ZERO]),
        with([DVec3::splat(1e-300), DVec3::ZERO, DVec3::X * 1e-300]),
    ];
    for mesh in meshes {
        for &side in Side::ALL {
            let view = View::of_side(&mesh, side).unwrap();
            let style = Style { smooth: true, edge_width: 1.0, silhouette_width: 1.0, ..CLEAR };
            assert!(render(&Scene::of(&mesh), &view, &style).is_ok());
            let drawing = draw_svg(&Scene::of(&mesh), &view, &style, None).unwrap();
            check_xml(&drawing.svg);
            assert!(
                !drawing.svg.contains("NaN") && !drawing.svg.contains("inf"),
                "{}",
                drawing.svg
            );
        }
    }
}

/// A quarter of a triangle's corner, seen from the front, belongs to the label of that corner.
#[test]
fn labels_are_never_blended() {
    let positions = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let triangle = TriMesh::from_triangles(&positions, &[[0, 1, 2]]).unwrap();
    let colors = VertexMap::from_vec(vec![LABEL_COLORS[0], LABEL_COLORS[1], LABEL_COLORS[2]]);
    let scene = Scene { paint: Paint::Labels(&colors), ..Scene::of(&triangle) };
    let view = View::of_side(&triangle, Side::Front).unwrap();
    for smooth in [false, true] {
        let style = Style { size: [300, 300], supersampling: 1, smooth, ..CLEAR };
        let picture = render(&scene, &view, &style).unwrap();
        let mut counts = std::collections::BTreeMap::new();
        for pixel in picture.pixels().iter().filter(|p| p[3] > 0) {
            *counts.entry(*pixel).or_insert(0_u32) += 1;
        }
        // A third of 45,150 pixels each.
        assert_eq!(counts.len(), 3, "{counts:?}");
        assert!(counts.values().all(|n| n.abs_diff(15_050) < 320), "{counts:?}");
    }
}

/// The attributes `d` and `fill` of the faces in a drawing.
fn faces_of(drawing: &Drawing) -> Vec<(Vec<[f64; 2]>, String)> {
    let (_, faces) = drawing.svg.split_once("<g id=\"faces\"").unwrap();
    let (faces, _) = faces.split_once("<g id=\"lines\"").unwrap();
    let read = |line: &str| {
        let (_, rest) = line.split_once("<path d=\"M")?;
        let (path, rest) = rest.split_once("Z\" fill=\"")?;
        let number = |x: &str| x.parse::<f64>().unwrap();
        let point = |p: &str| p.split_once(' ').map(|(x, y)| [number(x), number(y)]).unwrap();
        Some((path.split('L').map(point).collect(), rest[..7].to_owned()))
    };
    faces.lines().filter_map(read).collect()
}

/// Every tag is closed in its order, and every attribute quoted.
fn check_xml(text: &str) {
    let mut open = Vec::new();
    for part in text.split('<').skip(1) {
        let (tag, content) = part.split_once('>').expect("every tag ends");
        assert!(!content.contains(['"', '\u{202e}', '\0']) || !tag.ends_with('/'), "{content}");
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop().as_deref(), Some(name)),
            None if tag.ends_with('/') => {}
            None => open.push(tag.split(' ').next().unwrap().to_owned()),
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

/// A cube within a sphere: no face of the cube is seen. What is seen of the sphere is counted from a picture in which
/// every face has a colour of its own.
#[test]
fn drawings_hold_the_faces_that_are_seen() {
    let ball = mesh(&Sphere { radius: 3.0 }.icosphere(3).unwrap());
    let positions = [ball.positions(), cube().positions()].concat();
    let first = ball.positions().len() as u32;
    let inner: Vec<[u32; 3]> = cube().topology().triangles().collect();
    let inner = inner.into_iter().map(|corners| corners.map(|v| v + first));
    let triangles: Vec<[u32; 3]> = ball.topology().triangles().chain(inner).collect();
    let mesh = TriMesh::from_triangles(&positions, &triangles).unwrap();
    let count = mesh.topology().face_count();
    let own = |i: usize| [1 + (i % 250) as u8, 1 + (i / 250) as u8, 200];
    let colors = FaceMap::from_vec((0..count).map(own).collect());
    let scene = Scene { paint: Paint::Faces(&colors), ..Scene::of(&mesh) };
    for (direction, smooth) in [(DVec3::new(0.3, 0.5, 1.0), false), (DVec3::Z, true)] {
        let view = View::of(&mesh, direction, DVec3::Y).unwrap();
        let style = Style { size: [500, 400], smooth, ..CLEAR };
        let drawing = draw_svg(&scene, &view, &style, None).unwrap();
        check_xml(&drawing.svg);
        let faces = faces_of(&drawing);
        assert_eq!(faces.len(), drawing.faces);
        assert!(drawing.svg.len() < 600 + 110 * faces.len(), "{}", drawing.svg.len());
        assert!(!drawing.svg.contains("<rect"), "the background is transparent");
        // About half of a sphere is seen.
        assert!((600..700).contains(&faces.len()), "{}", faces.len());
        // The middle of every face has its colour in the picture, except where it is as small as a pixel.
        let picture = render(&scene, &view, &style).unwrap();
        let mut same = 0;
        for (points, fill) in &faces {
            let middle = [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / 3.0);
            let [r, g, b, _] = picture.pixel(middle[0] as u32, middle[1] as u32).unwrap();
            let channel = |i: usize| u8::from_str_radix(&fill[i..i + 2], 16).unwrap();
            let fill = [channel(1), channel(3), channel(5)];
            same += u32::from([r, g, b].iter().zip(fill).all(|(a, b)| a.abs_diff(b) < 4));
        }
        assert!(f64::from(same) > 0.85 * faces.len() as f64, "{same} of {}", faces.len());
    }
}

/// The number of faces that are nearest to the camera, which looks along -z, at the middle of any pixel.
fn seen_from_the_front(mesh: &TriMesh, [width, height]: [u32; 2]) -> usize {
    let bounds = mesh.bounding_box().unwrap();
    let (center, half) = (bounds.center(), 0.5 * bounds.extent());
    let [w, h] = [width, height].map(f64::from);
    let scale = (0.5 * h / half.y).min(0.5 * w / half.x);
    let flat = |p: DVec3| {
        DVec3::new(0.5 * w + scale * (p.x - center.x), 0.5 * h - scale * (p.y - center.y), p.z)
    };
    let faces: Vec<[DVec3; 3]> = mesh
        .topology()
        .triangles()
        .map(|t| t.map(|v| flat(mesh.positions()[v as usize])))
        .collect();
    let cross = |a: DVec3, b: DVec3, c: DVec3| (b - a).truncate().perp_dot((c - a).truncate());
    let mut seen = std::collections::BTreeSet::new();
    for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
        let p = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 0.0);
        let depth = |&[a, b, c]: &[DVec3; 3]| {
            let weights =
                [cross(p, b, c), cross(p, c, a), cross(p, a, b)].map(|w| w / cross(a, b, c));
            let depth = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
            weights.iter().all(|&w| w >= 0.0).then_some(depth)
        };
        let hits = faces.iter().enumerate().filter_map(|(i, face)| Some((i, depth(face)?)));
        seen.extend(hits.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i));
    }
    seen.len()
}

#[test]
fn drawings_hold_exactly_the_faces_that_are_seen() {
    let (ring, ball) = (
        mesh(&Torus { major: 5.0, minor: 2.0 }.mesh(40, 20).unwrap()),
        mesh(&Sphere { radius: 2.5 }.icosphere(3).unwrap()),
    );
    // Turned, so that no edge runs through the middle of a pixel.
    let turn = glam::DQuat::from_scaled_axis(DVec3::new(0.9, 0.3, 0.2));
    let positions: Vec<DVec3> =
        ring.positions().iter().chain(ball.positions()).map(|&p| turn * p).collect();
    let first = ring.positions().len() as u32;
    let inner = ball.topology().triangles().map(|corners| corners.map(|v| v + first));
    let triangles: Vec<[u32; 3]> = ring.topology().triangles().chain(inner).collect();
    let both = TriMesh::from_triangles(&positions, &triangles).unwrap();
    let view = View::of_side(&both, Side::Front).unwrap();
    for size in [[120, 90], [60, 100]] {
        let style = Style { size, supersampling: 1, ..CLEAR };
        let drawing = draw_svg(&Scene::of(&both), &view, &style, None).unwrap();
        let seen = seen_from_the_front(&both, size);
        assert_eq!((drawing.faces, faces_of(&drawing).len()), (seen, seen), "{size:?}");
        assert!((400..2000).contains(&seen), "{seen}");
    }
}

/// Only the nearer of two squares is drawn over the other, and lines behind it are left out.
#[test]
fn drawings_are_ordered_by_depth() {
    let square = |z: f64, half: f64| {
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]: [f64; 2]| DVec3::new(half * x, half * y, z))
    };
    let positions = [square(1.0, 0.5), square(0.0, 1.0), square(0.5, 0.4)].concat();
    let faces: Vec<[u32; 3]> =
        (0..3).flat_map(|i| [[0, 1, 2], [0, 2, 3]].map(|f| f.map(|v| v + 4 * i))).collect();
    let mesh = TriMesh::from_triangles(&positions, &faces).unwrap();
    let colors = FaceMap::from_vec((0..6).map(|f| LABEL_COLORS[f / 2]).collect());
    let line = |z: f64| Stroke {
        points: vec![DVec3::new(-0.2, 0.0, z), DVec3::new(0.2, 0.0, z)],
        color: [1, 2, 3],
        width: 2.0,
    };
    let strokes = [line(0.8), line(1.5)];
    let scene = Scene { paint: Paint::Faces(&colors), strokes: &strokes, ..Scene::of(&mesh) };
    let view = View::of_side(&mesh, Side::Front).unwrap();
    let style = Style { edge_width: 1.0, background: Some([255, 0, 1]), ..CLEAR };
    let drawing = draw_svg(&scene, &view, &style, None).unwrap();
    check_xml(&drawing.svg);
    assert_eq!((drawing.faces, drawing.lines), (4, 1), "the small square and a line are hidden");
    let widths: Vec<f64> = faces_of(&drawing)
        .iter()
        .map(|(points, _)| points.iter().map(|p| (p[0] - 200.0).abs()).fold(0.0, f64::max))
        .collect();
    assert_eq!(widths, [150.0, 150.0, 75.0, 75.0], "the far square is written first");
    assert!(drawing.svg.contains("fill=\"#ff0001\"") && drawing.svg.contains("#010203"));
    assert!(drawing.svg.contains("stroke=\"#1f1f24\""), "edges");
}

#[test]
fn drawings_have_legends() {
    let mesh = cube();
    let view = View::of_side(&mesh, Side::Corner).unwrap();
    let name = "a <b> & \u{202e}c\0 of everything";
    let scale = ScaleOptions::default().fit([0.0, 50.0]);
    for legend in [Legend::Scale(scale), Legend::Labels(Labels::of((0..30).map(f64::from)))] {
        let drawing = draw_svg(&Scene::of(&mesh), &view, &CLEAR, Some((&legend, name))).unwrap();
        check_xml(&drawing.svg);
        assert!(drawing.size[0] > 400 && drawing.size[1] == 300, "{:?}", drawing.size);
        assert!(drawing.svg.contains(">a &lt;b&gt; &amp; ?c? of everything<"), "the full name");
        match legend {
            Legend::Labels(_) => {
                assert!(drawing.svg.contains("#e69f00") && drawing.svg.contains("colours repeat"));
            }
            _ => assert!(drawing.svg.contains(">20<") && drawing.svg.contains("#440154")),
        }
    }
    let mixed = VertexMap::from_vec(
        (0..mesh.topology().vertex_count()).map(|v| LABEL_COLORS[v % 3]).collect(),
    );
    let scene = Scene { paint: Paint::Labels(&mixed), ..Scene::of(&mesh) };
    let drawing = draw_svg(&scene, &view, &CLEAR, None).unwrap();
    check_xml(&drawing.svg);
    let divided = drawing.svg.lines().filter(|&line| line == "<g>").count();
    let (parts, whole) = (faces_of(&drawing).len(), drawing.faces - divided);
    assert!(divided > 0 && parts == whole + 3 * divided, "{divided} {whole} {parts}");
}
