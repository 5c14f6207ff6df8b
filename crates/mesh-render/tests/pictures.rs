//! Pictures with known pixels: areas, colours, depth, lines, and refusals.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

use core::f64::consts::PI;

use glam::DVec3;
use mesh_core::{FaceMap, TriMesh, VertexMap};
use mesh_render::{Paint, Picture, RenderError, Scene, Side, Stroke, Style, Texture, View, render};
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
        }
    }
}
