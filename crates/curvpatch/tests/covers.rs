//! Covers of analytic meshes: sizes against an independent implementation, and what a cover
//! promises against a test that shares no code with it.
#![allow(clippy::unwrap_used)]

mod common;

use curvpatch::{
    Cover, CoverMethod, CoverOptions, CurvatureEstimator, Params, Patch, Shape, cover,
};
use mesh_core::TriMesh;
use mesh_core::shapes::RowPhase;

/// A row of the reference table: the numbers of patches of the greedy and the sequential cover,
/// with no face left over.
struct Row {
    mesh: Mesh,
    tolerance: f64,
    shapes: &'static [Shape],
    greedy: usize,
    sequential: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mesh {
    Torus,
    Saddle,
    Cylinder,
    Icosphere,
}

fn build(mesh: Mesh) -> TriMesh {
    match mesh {
        Mesh::Torus => common::torus(48, 24),
        Mesh::Saddle => common::saddle(24),
        Mesh::Cylinder => common::cylinder(48, 16, RowPhase::Staggered),
        Mesh::Icosphere => common::icosphere(3),
    }
}

const CIRCLE: &[Shape] = &[Shape::Circle];
const ELLIPSE: &[Shape] = &[Shape::Ellipse];
const SAGITTA: &[Shape] = &[Shape::EqualSagitta];
const ALL: &[Shape] = &Shape::ALL;

const fn row(
    mesh: Mesh,
    tolerance: f64,
    shapes: &'static [Shape],
    greedy: usize,
    sequential: usize,
) -> Row {
    Row { mesh, tolerance, shapes, greedy, sequential }
}

#[rustfmt::skip]
const ROBUST: &[Row] = &[
    row(Mesh::Torus, 0.02, CIRCLE, 132, 162),
    row(Mesh::Torus, 0.02, ALL, 130, 159),
    row(Mesh::Torus, 0.05, CIRCLE, 72, 97),
    row(Mesh::Torus, 0.05, ELLIPSE, 95, 144),
    row(Mesh::Torus, 0.05, SAGITTA, 79, 103),
    row(Mesh::Torus, 0.05, ALL, 64, 83),
    row(Mesh::Saddle, 0.005, CIRCLE, 24, 25),
    row(Mesh::Saddle, 0.005, ELLIPSE, 33, 39),
    row(Mesh::Saddle, 0.005, SAGITTA, 29, 32),
    row(Mesh::Saddle, 0.005, ALL, 23, 25),
    row(Mesh::Saddle, 0.01, CIRCLE, 9, 16),
    row(Mesh::Saddle, 0.01, ELLIPSE, 17, 24),
    row(Mesh::Saddle, 0.01, SAGITTA, 17, 17),
    row(Mesh::Saddle, 0.01, ALL, 9, 17),
    row(Mesh::Saddle, 0.02, CIRCLE, 9, 13),
    row(Mesh::Saddle, 0.02, ELLIPSE, 10, 16),
    row(Mesh::Saddle, 0.02, SAGITTA, 9, 14),
    row(Mesh::Saddle, 0.02, ALL, 9, 13),
    row(Mesh::Cylinder, 0.01, CIRCLE, 38, 57),
    row(Mesh::Cylinder, 0.01, ELLIPSE, 16, 25),
    row(Mesh::Cylinder, 0.01, SAGITTA, 16, 25),
    row(Mesh::Cylinder, 0.01, ALL, 16, 25),
    row(Mesh::Cylinder, 0.02, CIRCLE, 31, 40),
    row(Mesh::Cylinder, 0.02, ELLIPSE, 19, 21),
    row(Mesh::Cylinder, 0.02, SAGITTA, 19, 21),
    row(Mesh::Cylinder, 0.02, ALL, 19, 21),
    row(Mesh::Icosphere, 0.01, CIRCLE, 5, 7),
    row(Mesh::Icosphere, 0.01, ELLIPSE, 5, 7),
    row(Mesh::Icosphere, 0.01, SAGITTA, 5, 7),
    row(Mesh::Icosphere, 0.01, ALL, 5, 7),
    row(Mesh::Icosphere, 0.02, CIRCLE, 5, 7),
    row(Mesh::Icosphere, 0.02, ELLIPSE, 5, 7),
    row(Mesh::Icosphere, 0.02, SAGITTA, 5, 7),
    row(Mesh::Icosphere, 0.02, ALL, 5, 7),
];

#[rustfmt::skip]
const PAPER: &[Row] = &[
    row(Mesh::Saddle, 0.02, CIRCLE, 10, 12),
    row(Mesh::Torus, 0.05, CIRCLE, 103, 126),
    row(Mesh::Cylinder, 0.02, ELLIPSE, 16, 14),
];

fn covered(mesh: &TriMesh, params: Params, row: &Row, method: CoverMethod) -> Cover {
    let estimator = CurvatureEstimator::new(mesh, params).unwrap();
    let mut options = CoverOptions::new(row.tolerance);
    options.shapes = row.shapes.to_vec();
    options.method = method;
    cover(&estimator, &options).unwrap()
}

fn check_rows(rows: &[Row], params: Params) {
    for row in rows {
        let mesh = build(row.mesh);
        for (method, limit) in
            [(CoverMethod::Greedy, row.greedy), (CoverMethod::Sequential, row.sequential)]
        {
            let cover = covered(&mesh, params, row, method);
            let what = format!("{:?} {} {:?} {method:?}", row.mesh, row.tolerance, row.shapes);
            println!("{what}: {} patches, reference {limit}", cover.patches.len());
            assert!(cover.residual.is_empty(), "{what}: {} residual", cover.residual.len());
            assert!(cover.patches.len() as f64 <= 1.2 * limit as f64, "{what}");
            check_promises(&mesh, &cover);
        }
    }
}

/// Every face is covered by a patch or residual, and the vertices of a covered face are within the
/// tolerance of the patch: by search over its parameters, not by its own inverse.
fn check_promises(mesh: &TriMesh, cover: &Cover) {
    for face in mesh.topology().faces() {
        let residual = cover.residual.contains(&face);
        let Some(index) = cover.patch_of_face[face] else {
            assert!(residual);
            continue;
        };
        assert!(!residual);
        let patch = &cover.patches[index as usize];
        assert!(patch.faces.contains(&face));
        for corner in mesh.triangle(face) {
            let distance = searched_distance(&patch.fit.patch, corner);
            assert!(distance <= cover.tolerance * (1.0 + 1e-6), "{face}: {distance}");
        }
    }
    assert_eq!(cover.covered_faces() + cover.residual.len(), mesh.topology().face_count());
    assert!(cover.max_error() <= cover.tolerance * (1.0 + 1e-12));
}

/// The distance of a point from a patch by direct search over its parameters: an upper bound.
fn searched_distance(patch: &Patch, point: glam::DVec3) -> f64 {
    let distance = |at: [f64; 2]| patch.point(at[0], at[1]).distance(point);
    let nearer = |a: &[f64; 2], b: &[f64; 2]| distance(*a).total_cmp(&distance(*b));
    let grid =
        (0..=20).flat_map(|i| (0..40).map(move |j| [0.05 * f64::from(i), 0.16 * f64::from(j)]));
    let mut at = grid.min_by(nearer).unwrap();
    let mut step = 0.05;
    while step > 1e-7 {
        let around = (-2..=2).flat_map(|i| (-2..=2).map(move |j| [i, j]));
        let moved = around.map(|[i, j]| {
            [(at[0] + step * f64::from(i)).clamp(0.0, 1.0), at[1] + 3.0 * step * f64::from(j)]
        });
        let best = moved.min_by(nearer).unwrap();
        if distance(best) < distance(at) {
            at = best;
        } else {
            step *= 0.5;
        }
    }
    distance(at)
}

#[test]
fn robust_covers_need_no_more_patches_than_the_reference() {
    check_rows(ROBUST, Params::robust());
}

#[test]
fn paper_covers_need_no_more_patches_than_the_reference() {
    check_rows(PAPER, Params::paper());
}
