//! The positions that vertices may take during a fit.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::{PolygonSoup, TriMesh};
use mesh_metric::{CompareOptions, Surface, compare};
use mesh_shapes::{Irregular, Plane, Wave};
use simplify::{
    AnnealOptions, Boundary, Curve, FitOptions, MaxErrorOptions, Options, Preset, Tuning, simplify,
};

fn mesh(soup: &PolygonSoup) -> TriMesh {
    TriMesh::from_soup(soup).unwrap()
}

/// A wave over a disk with a square hole: its boundary is a curve and a polygon.
fn disk() -> TriMesh {
    let wave = Wave { amplitude: 0.15, wavelength: 1.1, half_width: 1.0 };
    let soup = wave.irregular_mesh(40, Irregular { jitter: 0.2, seed: 4 }).unwrap();
    let mesh = mesh(&soup);
    let keep = |t: &[u32; 3]| {
        let inside = |v: u32| mesh.positions()[v as usize].truncate().abs().max_element() < 0.3;
        !t.iter().all(|&v| inside(v))
    };
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().filter(keep).collect();
    // The outer square becomes a disk; the inner square stays a square.
    let round = |p: &DVec3| {
        let square = p.truncate().abs().max_element();
        let shrink = square / p.truncate().length().max(1e-9);
        let part = ((square - 0.4) / 0.6).clamp(0.0, 1.0);
        let scale = 1.0 + part * (shrink - 1.0);
        DVec3::new(scale * p.x, scale * p.y, p.z)
    };
    let points: Vec<DVec3> = mesh.positions().iter().map(round).collect();
    let mut open = TriMesh::from_triangles(&points, &triangles).unwrap();
    open.compact();
    open
}

fn boundary(mesh: &TriMesh) -> Vec<DVec3> {
    let topology = mesh.topology();
    let all = topology.vertices().filter(|&v| topology.is_boundary_vertex(v));
    all.map(|v| mesh.position(v)).collect()
}

#[test]
fn boundary_vertices_slide_along_the_boundary() {
    let original = disk();
    let curve = Curve::boundary(&original).unwrap();
    let options = Options::default().to_faces(400);
    let fitted = simplify(&original, &options).unwrap();
    let mut unfitted = options.clone();
    unfitted.refine.fit = false;
    let collapsed = simplify(&original, &unfitted).unwrap();
    let before = boundary(&collapsed.mesh);
    let moved: Vec<DVec3> =
        boundary(&fitted.mesh).into_iter().filter(|p| !before.contains(p)).collect();
    assert!(2 * moved.len() > before.len(), "{} of {}", moved.len(), before.len());
    assert!(curve.farthest(&moved).unwrap() < 1.01 * curve.farthest(&before).unwrap() + 1e-12);
    // No part of the boundary was cut off.
    let shift = collapsed.boundary_shift.unwrap();
    assert!(fitted.boundary_shift.unwrap() < 1.5 * shift, "{:?}", fitted.boundary_shift);
    let surface = Surface::new(&original).unwrap();
    let mean = |mesh: &TriMesh| {
        let samples = CompareOptions { samples: 100_000, ..Default::default() };
        compare(&surface, &Surface::new(mesh).unwrap(), &samples).mean()
    };
    assert!(mean(&fitted.mesh) < mean(&collapsed.mesh));

    let mut locked = options;
    locked.protect.boundary = Boundary::Lock;
    let stays = simplify(&original, &locked).unwrap();
    let all = boundary(&original);
    assert!(boundary(&stays.mesh).iter().all(|p| all.contains(p)));
}

#[test]
fn corners_of_a_curve_are_where_it_turns() {
    let square = mesh(&Plane { half_width: 1.0 }.mesh(6, Default::default()).unwrap());
    let mut corners = Curve::boundary(&square).unwrap().corners().to_vec();
    corners.sort_by(|a, b| (a.x, a.y).partial_cmp(&(b.x, b.y)).unwrap());
    let expected = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
    assert_eq!(corners, expected.map(|(x, y)| DVec3::new(x, y, 0.0)));
    // Lines that end inside the mesh.
    let topology = square.topology();
    let inner = topology.edges().find(|&e| !topology.is_boundary_edge(e)).unwrap();
    let line = Curve::of_edges(&square, |e| e == inner).unwrap();
    assert_eq!(line.corners().len(), 2);
    assert!(Curve::of_edges(&square, |_| false).is_none());
}

#[test]
fn the_last_seed_is_as_good_as_any() {
    let soup = mesh_shapes::Sphere { radius: 1.0 }.icosphere(2).unwrap();
    let original = mesh(&soup);
    let mut options = Options::preset(Preset::Extreme).to_faces(60);
    options.refine.seed = u64::MAX;
    let fit = FitOptions { rounds: 3, seed: u64::MAX, ..FitOptions::default() };
    let anneal = AnnealOptions { rounds: 2, fit, ..AnnealOptions::default() };
    let tailed = FitOptions { tail: 300.0, ..fit };
    let max_error = MaxErrorOptions { fit: tailed, ..MaxErrorOptions::default() };
    options.refine.tuning = Tuning { fit, anneal, max_error };
    let result = simplify(&original, &options).unwrap();
    assert_eq!(result.mesh.topology().face_count(), 60);
    assert_eq!(result.fit.unwrap().rounds, 3);
}

/// More samples per face have no effect if the original has few triangles.
#[test]
fn samples_are_limited_by_the_triangles_of_the_original() {
    let original = disk();
    let surface = Surface::new(&original).unwrap();
    let rms = |samples_per_face, samples_per_triangle| {
        let fit = FitOptions { samples_per_face, samples_per_triangle, ..FitOptions::default() };
        let mut options = Options::default().to_faces(1000);
        (options.refine.tuning.fit, options.refine.max_error) = (fit, false);
        let result = simplify(&original, &options).unwrap();
        let fitted = Surface::new(&result.mesh).unwrap();
        compare(&surface, &fitted, &CompareOptions::default()).rms()
    };
    let limited = rms(40, 3);
    // The same points with the same total weight.
    assert!((rms(400, 3) / limited - 1.0).abs() < 1e-6);
    let many = rms(40, 100);
    assert!(many != limited && limited < 1.03 * many, "{limited}, with all samples {many}");
}
