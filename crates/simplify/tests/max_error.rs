//! Constraints that hold during the reduction of the largest errors.
#![allow(clippy::unwrap_used)]

use crate::common::joined;
use glam::DVec3;
use mesh_core::{TriMesh, triangles_cross};
use mesh_metric::Surface;
use simplify::{FitConstraints, MaxErrorOptions, reduce_max_error};

/// A flat grid around `center` with this half width.
fn grid(center: DVec3, half: f64, cells: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let at = |i: u32| half * (2.0 * f64::from(i) / f64::from(cells) - 1.0);
    let places = (0..=cells).flat_map(|j| (0..=cells).map(move |i| (i, j)));
    let points = places.map(|(i, j)| center + DVec3::new(at(i), at(j), 0.0)).collect();
    let number = |i: u32, j: u32| j * (cells + 1) + i;
    let squares = (0..cells).flat_map(|j| (0..cells).map(move |i| (i, j)));
    let halves = squares.flat_map(|(i, j)| {
        let (a, b) = (number(i, j), number(i + 1, j));
        let (c, d) = (number(i + 1, j + 1), number(i, j + 1));
        [[a, b, c], [a, c, d]]
    });
    (points, halves.collect())
}

/// A plate of two triangles below an upright flat sheet, and a grid far away whose faces can be collapsed. In the
/// original, a pyramid replaces the plate and passes through the sheet.
fn plate_under_a_sheet() -> (TriMesh, TriMesh) {
    let sheet = [DVec3::new(0.8, 0.0, 0.2), DVec3::new(1.9, 0.0, 0.2), DVec3::new(1.3, 0.0, 0.3)];
    let sheet = (sheet.to_vec(), vec![[0, 1, 2]]);
    let spare = grid(20.0 * DVec3::X, 2.0, 6);
    let plate = grid(DVec3::ZERO, 2.0, 1);
    let mut pyramid = plate.clone();
    pyramid.0.push(DVec3::Z);
    pyramid.1 = vec![[0, 1, 4], [1, 3, 4], [3, 2, 4], [2, 0, 4]];
    (joined(&[plate, sheet.clone(), spare.clone()]), joined(&[pyramid, sheet, spare]))
}

fn crossings(mesh: &TriMesh) -> usize {
    let topology = mesh.topology();
    let faces: Vec<_> =
        topology.faces().map(|f| (topology.face_vertices(f), mesh.triangle(f))).collect();
    let before = |i: usize| {
        let face = faces[i];
        faces[..i].iter().filter(move |&&other| triangles_cross(face, other))
    };
    (0..faces.len()).map(|i| before(i).count()).sum()
}

#[test]
fn peaks_are_not_cut_through_other_faces_when_that_is_forbidden() {
    let (start, original) = plate_under_a_sheet();
    let original = Surface::new(&original).unwrap();
    assert_eq!(crossings(&start), 0);
    for forbid_intersections in [false, true] {
        let mut mesh = start.clone();
        let options = MaxErrorOptions { forbid_intersections, ..MaxErrorOptions::default() };
        let mut protect = FitConstraints::default();
        let report = reduce_max_error(&mut mesh, &original, &mut protect, &options).unwrap();
        assert_eq!(report.largest_before, 1.0);
        assert_eq!(report.kept > 0, !forbid_intersections);
        assert_eq!(crossings(&mesh) == 0, forbid_intersections);
    }
}

#[test]
fn vertices_are_not_brought_back_through_other_faces_when_that_is_forbidden() {
    // The tip of a tent belongs below the floor, but an upright sheet blocks its faces.
    let mut tent = grid(DVec3::ZERO, 2.0, 2);
    tent.0[4].z = 1.0;
    let sheet =
        [DVec3::new(0.3, 0.1, -0.2), DVec3::new(0.6, 0.1, -0.2), DVec3::new(0.45, 0.1, -0.02)];
    let sheet = (sheet.to_vec(), vec![[0, 1, 2]]);
    let spare = grid(20.0 * DVec3::X, 2.0, 6);
    let start = joined(&[tent, sheet.clone(), spare.clone()]);
    let below = grid(-0.1 * DVec3::Z, 2.0, 2);
    let original = Surface::new(&joined(&[below, sheet, spare])).unwrap();
    assert_eq!(crossings(&start), 0);
    for forbid_intersections in [false, true] {
        let mut mesh = start.clone();
        let options = MaxErrorOptions { forbid_intersections, ..MaxErrorOptions::default() };
        let mut protect = FitConstraints::default();
        reduce_max_error(&mut mesh, &original, &mut protect, &options).unwrap();
        assert_eq!(crossings(&mesh) == 0, forbid_intersections);
    }
}

#[test]
fn locked_boundaries_are_neither_split_nor_moved_by_cutting_peaks() {
    let start = joined(&[grid(DVec3::ZERO, 1.0, 6)]);
    let topology = start.topology();
    // The original is larger than the mesh, so that its farthest points are closest to the boundary of the mesh.
    let original = Surface::new(&joined(&[grid(DVec3::ZERO, 1.5, 12)])).unwrap();
    let mut locked = topology.vertex_map(false);
    topology.vertices().filter(|&v| topology.is_boundary_vertex(v)).for_each(|v| locked[v] = true);
    let ends = |mesh: &TriMesh| {
        let topology = mesh.topology();
        let edges = topology.edges().filter(|&e| topology.is_boundary_edge(e));
        let ends = edges.map(|e| topology.edge_vertices(e).map(|v| mesh.position(v).to_array()));
        let mut ends: Vec<[[f64; 3]; 2]> = ends.collect();
        ends.sort_by(|a, b| a.partial_cmp(b).unwrap());
        ends
    };
    let mut mesh = start.clone();
    let mut protect = FitConstraints { fixed: Some(locked), ..FitConstraints::default() };
    let options = MaxErrorOptions { rounds: 8, ..MaxErrorOptions::default() };
    reduce_max_error(&mut mesh, &original, &mut protect, &options).unwrap();
    assert_eq!(ends(&mesh), ends(&start));
}
