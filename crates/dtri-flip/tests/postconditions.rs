//! Flips by any cost keep the shape of a mesh: no folded faces, no new slivers, no larger flat sheets.
#![allow(clippy::unwrap_used)]

use core::ops::ControlFlow;

use dcurv::VertexArea;
use dtri_flip::{Anneal, CostName, FlipOptions, FlipReport, Rebuild, ShapeConstraint};
use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use proptest::prelude::*;

fn run(mesh: &mut TriMesh, cost: CostName, options: &FlipOptions) -> FlipReport {
    cost.optimise(mesh, VertexArea::Voronoi, options, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// A triangulation of random points in the unit square, by insertion into triangles: full of slivers and of
/// quadrilaterals that are not convex. Lifted by `height`.
fn sheet(inner: usize, seed: u64, height: impl Fn(f64, f64) -> f64) -> TriMesh {
    let mut random = SplitMix64::new(seed);
    let mut points = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut triangles: Vec<[u32; 3]> = vec![[0, 1, 2], [0, 2, 3]];
    let cross = |o: [f64; 2], p: [f64; 2], q: [f64; 2]| {
        (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0])
    };
    for _ in 0..inner {
        let point = [random.uniform(), random.uniform()];
        let sides = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| points[v as usize]);
            [cross(a, b, point), cross(b, c, point), cross(c, a, point)]
        };
        let Some(at) = triangles.iter().position(|t| sides(t).iter().all(|&s| s > 0.0)) else {
            continue;
        };
        let new = points.len() as u32;
        points.push(point);
        let [a, b, c] = triangles.swap_remove(at);
        triangles.extend([[a, b, new], [b, c, new], [c, a, new]]);
    }
    let lifted: Vec<[f64; 3]> = points.iter().map(|&[x, y]| [x, y, height(x, y)]).collect();
    TriMesh::from_triangles(&lifted, &triangles).unwrap()
}

/// An extruded polygon: walls finely divided, caps as fans around their first corner.
fn extrusion(outline: &[[f64; 2]], depth: f64, divisions: u32) -> TriMesh {
    let sides = outline.len() as u32;
    let mut points: Vec<[f64; 3]> = Vec::new();
    for level in 0..=divisions {
        let z = depth * f64::from(level) / f64::from(divisions);
        points.extend(outline.iter().map(|&[x, y]| [x, y, z]));
    }
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for level in 0..divisions {
        for i in 0..sides {
            let [a, b] = [level * sides + i, level * sides + (i + 1) % sides];
            triangles.extend([[a, b, b + sides], [a, b + sides, a + sides]]);
        }
    }
    let top = divisions * sides;
    for i in 1..sides - 1 {
        triangles.extend([[0, i + 1, i], [top, top + i, top + i + 1]]);
    }
    TriMesh::from_triangles(&points, &triangles).unwrap()
}

/// A regular polygon, stretched.
fn ellipse(sides: u32, stretch: f64) -> Vec<[f64; 2]> {
    let angle = |i: u32| core::f64::consts::TAU * f64::from(i) / f64::from(sides);
    (0..sides).map(|i| [stretch * angle(i).cos(), angle(i).sin()]).collect()
}

/// Faces of a prism can be exactly perpendicular to the normal of a vertex, up to rounding.
const ROUNDING: f64 = 1e-12;

fn slivers(mesh: &TriMesh) -> usize {
    let is_sliver = |[a, b, c]: [DVec3; 3]| {
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        (b - a).cross(c - a).length() < 1e-3 * longest * longest
    };
    mesh.topology().faces().filter(|&f| is_sliver(mesh.triangle(f))).count()
}

fn normals(mesh: &TriMesh) -> Vec<DVec3> {
    mesh.topology().faces().map(|f| mesh.face_cross(f)).collect()
}

/// The number of faces whose normal makes more than a right angle with the normal that one of their
/// vertices has in the input mesh, by a margin of the cosine.
fn reversed(mesh: &TriMesh, input: &TriMesh, margin: f64) -> usize {
    let normals = input.vertex_normals();
    let is_reversed = |&f: &mesh_core::FaceId| {
        let normal = mesh.face_cross(f);
        let below = -margin * normal.length();
        mesh.topology().face_vertices(f).iter().any(|&v| normal.dot(normals[v]) < below)
    };
    mesh.topology().faces().filter(is_reversed).count()
}

fn strategies(index: usize, seed: u64) -> FlipOptions {
    let default = FlipOptions::default();
    match index {
        0 => default,
        1 => FlipOptions { look_ahead: 2, ..default },
        2 => {
            let anneal = Anneal { seed, rounds: 1, steps_per_edge: 10, ..Anneal::default() };
            FlipOptions { anneal: Some(anneal), ..default }
        }
        _ => {
            let rebuild = Rebuild { seed, effort: 1, largest: 12 };
            FlipOptions { rebuild: Some(rebuild), time_limit: None, ..default }
        }
    }
}

fn costs() -> impl Strategy<Value = CostName> {
    prop::sample::select(CostName::ALL.to_vec())
}

#[test]
fn delaunay_does_not_flip_four_points_that_are_not_convex() {
    // The quadrilateral a, d, b, c has a reflex corner at b.
    let points = [[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [4.0, 4.0, 0.0], [4.0, -4.0, 0.0]];
    let start = TriMesh::from_triangles(&points, &[[0, 1, 2], [1, 0, 3]]).unwrap();
    for &cost in CostName::ALL {
        let mut mesh = start.clone();
        let report = run(&mut mesh, cost, &FlipOptions::default());
        assert_eq!(report.flips, 0, "{cost}");
    }
    let shape = Some(ShapeConstraint::Unrestricted);
    let options = FlipOptions { shape, ..FlipOptions::default() };
    let folds = run(&mut start.clone(), CostName::Delaunay, &options).flips;
    assert_eq!(folds, 1, "the example tests nothing");
}

#[test]
fn delaunay_triangulates_a_sheet_of_random_points() {
    let start = sheet(400, 1, |_, _| 0.0);
    let mut mesh = start.clone();
    let report = run(&mut mesh, CostName::Delaunay, &FlipOptions::default());
    assert!(report.flips > 100);
    assert!((mesh.area() - 1.0).abs() < 1e-12);
    let topology = mesh.topology();
    for edge in topology.edges().filter(|&e| !topology.is_boundary_edge(e)) {
        let opposite =
            edge.half_edges().map(|h| mesh.corner_angle(topology.next(topology.next(h))));
        // The guard against slivers may keep an edge of a thin triangle.
        let thin = edge.half_edges().iter().any(|&h| {
            let [a, b, c] = mesh.triangle(topology.face(h).unwrap());
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            (b - a).cross(c - a).length() < 4e-3 * longest * longest
        });
        assert!(thin || opposite[0] + opposite[1] <= core::f64::consts::PI + 1e-9);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn flat_sheets_stay_flat(
        inner in 3_usize..60, seed: u64, cost in costs(), strategy in 0_usize..4,
        tilt in prop::array::uniform3(-1.0_f64..1.0),
    ) {
        let mut start = sheet(inner, seed, |_, _| 0.0);
        let axis = DVec3::from(tilt);
        if axis.length() > 0.1 && seed % 2 == 0 {
            let turn = glam::DQuat::from_axis_angle(axis.normalize(), 0.7);
            start.positions_mut().iter_mut().for_each(|p| *p = turn * *p);
        }
        let mut mesh = start.clone();
        run(&mut mesh, cost, &strategies(strategy, seed));
        prop_assert!(mesh.area() <= start.area() * (1.0 + 1e-9), "{} {}", cost, mesh.area());
        let up = normals(&start)[0];
        prop_assert!(normals(&mesh).iter().all(|n| n.dot(up) > 0.0), "{}", cost);
        prop_assert!(slivers(&mesh) <= slivers(&start), "{}", cost);
    }

    #[test]
    fn height_fields_stay_height_fields(
        inner in 3_usize..60, seed: u64, cost in costs(), strategy in 0_usize..4,
        amplitude in 0.0_f64..0.15, waves in 1.0_f64..6.0,
    ) {
        let start = sheet(inner, seed, |x, y| amplitude * (waves * x).sin() * (waves * y).cos());
        let mut mesh = start.clone();
        run(&mut mesh, cost, &strategies(strategy, seed));
        prop_assert!(reversed(&mesh, &start, ROUNDING) <= reversed(&start, &start, 0.0), "{}", cost);
        prop_assert!(slivers(&mesh) <= slivers(&start), "{}", cost);
    }

    #[test]
    fn extrusions_keep_their_sides(
        sides in 3_u32..14, stretch in 0.2_f64..5.0, depth in 0.1_f64..10.0, divisions in 1_u32..8,
        cost in costs(), strategy in 0_usize..4, seed: u64,
    ) {
        let start = extrusion(&ellipse(sides, stretch), depth, divisions);
        let mut mesh = start.clone();
        run(&mut mesh, cost, &strategies(strategy, seed));
        prop_assert!(mesh.volume() > 0.0);
        prop_assert!(reversed(&mesh, &start, ROUNDING) <= reversed(&start, &start, 0.0), "{}", cost);
        prop_assert!(slivers(&mesh) <= slivers(&start), "{}", cost);
    }
}
