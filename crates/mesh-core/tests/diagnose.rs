//! Counts of defects, on soups small enough to count by hand.
#![allow(clippy::unwrap_used)]

use mesh_core::{Diagnosis, PolygonSoup, diagnose};

fn diagnosis(positions: &[[f64; 3]], faces: &[&[u32]]) -> Diagnosis {
    let mut soup = PolygonSoup::new();
    positions.iter().for_each(|&position| soup.push_vertex(position));
    faces.iter().for_each(|face| soup.push_face(face).unwrap());
    diagnose(&soup).unwrap()
}

fn moment_curve(count: usize) -> Vec<[f64; 3]> {
    (0..count).map(|i| i as f64).map(|t| [t, t * t, t * t * t]).collect()
}

#[test]
fn a_cube_has_no_defects() {
    let corner = |i: u32| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)];
    let positions: Vec<[f64; 3]> = (0..8).map(corner).collect();
    let d = diagnosis(
        &positions,
        &[&[0, 2, 3, 1], &[4, 5, 7, 6], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 4, 6, 2], &[1, 3, 7, 5]],
    );
    assert_eq!((d.vertices, d.quadrilaterals, d.faces, d.edges), (8, 6, 12, 18));
    assert_eq!((d.euler_characteristic, d.components, d.edge_components), (2, 1, 1));
    assert!(d.is_closed() && d.is_manifold() && d.is_oriented());
    assert_eq!(d.degenerate_faces() + d.slivers + d.duplicate_faces, 0);
}

#[test]
fn three_faces_on_an_edge() {
    let d = diagnosis(&moment_curve(5), &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]]);
    assert_eq!((d.non_manifold_edges, d.non_manifold_vertices), (1, 0));
    assert_eq!((d.boundary_edges, d.boundary_loops, d.euler_characteristic), (6, 1, 1));
    assert!(!d.is_manifold() && !d.is_closed() && d.is_oriented());
}

#[test]
fn a_bow_tie() {
    let d = diagnosis(&moment_curve(6), &[&[0, 1, 2], &[2, 3, 4]]);
    assert_eq!((d.non_manifold_vertices, d.components, d.edge_components), (1, 1, 2));
    assert_eq!((d.boundary_edges, d.boundary_loops, d.unreferenced_vertices), (6, 1, 1));
}

#[test]
fn a_moebius_strip() {
    let d =
        diagnosis(&moment_curve(5), &[&[0, 1, 2], &[1, 3, 2], &[2, 3, 4], &[3, 0, 4], &[4, 0, 1]]);
    assert_eq!((d.inconsistent_edges, d.boundary_loops, d.euler_characteristic), (1, 1, 0));
    assert!(d.is_manifold() && !d.is_oriented());
}

#[test]
fn bad_faces_and_coordinates_are_counted_and_left_out() {
    let mut positions = moment_curve(6);
    positions[5] = [f64::NAN, f64::INFINITY, 0.0];
    positions[4] = [0.5, 0.5, 0.5];
    let d = diagnosis(
        &positions,
        &[&[0, 1, 2], &[2, 1, 0], &[0, 9, 1], &[1, 2], &[3, 3, 1], &[0, 1, 4], &[3, 5, 2]],
    );
    assert_eq!((d.faces, d.duplicate_faces, d.repeated_vertex_faces), (5, 1, 1));
    assert_eq!((d.out_of_range_faces, d.too_small_faces, d.non_finite_vertices), (1, 1, 1));
    assert_eq!((d.zero_area_faces, d.slivers, d.degenerate_faces()), (1, 0, 2));
    assert_eq!(d.non_manifold_edges, 1);
}

#[test]
fn slivers_are_low_but_not_flat() {
    let height = |h: f64| {
        let positions = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, h, 0.0]];
        let d = diagnosis(&positions, &[&[0, 1, 2]]);
        (d.slivers, d.zero_area_faces)
    };
    assert_eq!(height(0.0), (0, 1));
    assert_eq!(height(0.0019), (1, 0));
    assert_eq!(height(0.0021), (0, 0));
}

#[test]
fn nothing_is_neither_closed_nor_broken() {
    let d = diagnosis(&[], &[]);
    let mut nothing = Diagnosis::default();
    nothing.inside_out = Some(0);
    assert_eq!(d, nothing);
    assert!(!d.is_closed() && d.is_manifold() && d.is_oriented());
}
