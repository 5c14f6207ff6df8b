//! Rebuilding: its results, and the constraints it keeps.
#![allow(clippy::unwrap_used)]

use core::ops::ControlFlow;
use core::time::Duration;

use crate::common::{face_set, mesh_of, paper_torus};
use dcurv::VertexArea;
use dtri_flip::{
    AbsMean, Anneal, CostName, FlipCost, FlipError, FlipOptions, FlipReport, Phase, Rebuild,
    ShapeConstraint, Stop, optimise, optimise_with,
};
use mesh_core::SplitMix64;
use mesh_core::{EdgeId, PolygonSoup, TriMesh, triangles_cross};
use mesh_shapes::{Sphere, scramble};

fn rebuilding(seed: u64) -> FlipOptions {
    FlipOptions { rebuild: Some(Rebuild { seed, ..Rebuild::default() }), ..FlipOptions::default() }
}

/// The hull of random points, and the mesh after many random flips.
fn tangled(points: usize, flips: usize, seed: u64) -> (TriMesh, TriMesh) {
    let hull = mesh_of(&Sphere { radius: 1.0 }.random_hull(points, seed).unwrap());
    let mut mesh = hull.clone();
    scramble(&mut mesh, flips, &mut SplitMix64::new(1000 + seed), |_, _| true);
    (hull, mesh)
}

fn run(mesh: &mut TriMesh, cost: CostName, options: &FlipOptions) -> FlipReport {
    let go_on = &mut |_| ControlFlow::Continue(());
    cost.optimise(mesh, VertexArea::Voronoi, options, go_on).unwrap()
}

/// From such starts, greedy descent and annealing end at two to six times the cost of the hull. A tangle has no shape
/// to keep.
#[test]
fn the_hull_is_found_from_a_tangle() {
    for (seed, cost) in [(0, CostName::F2), (1, CostName::F2), (2, CostName::F2), (3, CostName::F3)]
    {
        let (hull, start) = tangled(36, 400, seed);
        let mut annealed = start.clone();
        let shape = Some(ShapeConstraint::Unrestricted);
        let anneal = FlipOptions { shape, anneal: Some(Anneal::default()), ..Default::default() };
        let best = cost.total(&hull, VertexArea::Voronoi);
        assert!(run(&mut annealed, cost, &anneal).cost_after > 1.2 * best);
        let mut mesh = start.clone();
        let report = run(&mut mesh, cost, &FlipOptions { shape, ..rebuilding(seed) });
        mesh.topology().validate().unwrap();
        assert_eq!(face_set(&mesh), face_set(&hull), "seed {seed}");
        assert_eq!(mesh.positions(), hull.positions());
        assert!(report.rebuilt > 0 && (report.cost_after - best).abs() < 1e-9 * best);
    }
}

#[test]
fn it_is_never_worse_than_greedy_and_repeats_itself() {
    let mut greedy = paper_torus();
    let plain = optimise(&mut greedy, &AbsMean, &FlipOptions::default()).unwrap();
    for seed in 0..3 {
        let (mut mesh, mut again) = (paper_torus(), paper_torus());
        let report = optimise(&mut mesh, &AbsMean, &rebuilding(seed)).unwrap();
        assert!(report.cost_after <= plain.cost_after);
        assert!((report.cost_after - AbsMean.total(&mesh)).abs() < 1e-9);
        assert_eq!(optimise(&mut again, &AbsMean, &rebuilding(seed)).unwrap(), report);
        assert_eq!(face_set(&mesh), face_set(&again));
        assert_eq!(mesh.positions(), paper_torus().positions());
    }
}

/// A grid over a bumpy function, with a boundary.
fn hills() -> TriMesh {
    let mut soup = PolygonSoup::new();
    let side = 9_u32;
    for i in 0..side * side {
        let (x, y) = (f64::from(i % side), f64::from(i / side));
        soup.push_vertex([x, y, (1.3 * x).sin() * (0.9 * y).cos()]);
    }
    let quads = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    for v in quads {
        soup.push_face(&[v, v + 1, v + side + 1]).unwrap();
        soup.push_face(&[v, v + side + 1, v + side]).unwrap();
    }
    mesh_of(&soup)
}

fn crosses_itself(mesh: &TriMesh) -> bool {
    let triangle = |f| (mesh.topology().face_vertices(f), mesh.triangle(f));
    let faces: Vec<_> = mesh.topology().faces().map(triangle).collect();
    (0..faces.len()).any(|i| (0..i).any(|j| triangles_cross(faces[i], faces[j])))
}

#[test]
fn boundaries_and_locked_edges_stay() {
    let start = hills();
    let locked_ends: Vec<_> = start
        .topology()
        .edges()
        .filter(|e| e.get() % 11 == 0)
        .map(|e| start.topology().edge_vertices(e))
        .collect();
    let mut options = rebuilding(5);
    let mut locked = start.topology().edge_map(false);
    start.topology().edges().filter(|e| e.get() % 11 == 0).for_each(|e: EdgeId| locked[e] = true);
    options.locked = Some(locked);
    let mut greedy = start.clone();
    let plain = FlipOptions { rebuild: None, ..options.clone() };
    let plain = optimise(&mut greedy, &AbsMean, &plain).unwrap();
    let mut mesh = start.clone();
    let report = optimise(&mut mesh, &AbsMean, &options).unwrap();
    mesh.topology().validate().unwrap();
    assert!(report.cost_after <= plain.cost_after);
    for [a, b] in locked_ends {
        assert!(mesh.topology().find_half_edge(a, b).is_some());
    }
    for e in start.topology().edges().filter(|&e| start.topology().is_boundary_edge(e)) {
        let [a, b] = start.topology().edge_vertices(e);
        let same = mesh.topology().find_half_edge(a, b);
        assert!(same.is_some_and(|h| mesh.topology().is_boundary_edge(h.edge())));
    }
}

#[test]
fn nothing_comes_to_cross_when_that_is_forbidden() {
    let mut mesh = hills();
    assert!(!crosses_itself(&mesh));
    let options = FlipOptions { forbid_intersections: true, ..rebuilding(2) };
    optimise(&mut mesh, &AbsMean, &options).unwrap();
    assert!(!crosses_itself(&mesh));
}

#[test]
fn stopped_at_any_time_it_leaves_a_whole_mesh_that_is_no_worse() {
    let (_, start) = tangled(40, 300, 7);
    let before = AbsMean.total(&start);
    for stop_at in [1, 2, 7, 40, 150] {
        let mut mesh = start.clone();
        let mut looks = 0;
        let report = optimise_with(&mut mesh, &AbsMean, &rebuilding(1), &mut |now| {
            looks += usize::from(now.phase == Phase::Rebuilding);
            if looks >= stop_at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap();
        assert_eq!(report.stop, Stop::Cancelled);
        mesh.topology().validate().unwrap();
        assert_eq!(mesh.positions(), start.positions());
        assert!(report.cost_after < before);
    }
    let mut mesh = start.clone();
    let options = FlipOptions { time_limit: Some(Duration::ZERO), ..rebuilding(1) };
    assert_eq!(optimise(&mut mesh, &AbsMean, &options).unwrap().stop, Stop::TimeLimit);
    let mut mesh = start.clone();
    let options = FlipOptions { max_flips: Some(100), ..rebuilding(1) };
    let report = optimise(&mut mesh, &AbsMean, &options).unwrap();
    assert!(report.flips <= 100 && report.stop == Stop::FlipLimit);
}

#[test]
fn a_patch_of_two_is_an_error() {
    let mut mesh = paper_torus();
    let rebuild = Some(Rebuild { largest: 2, ..Rebuild::default() });
    let options = FlipOptions { rebuild, ..FlipOptions::default() };
    let error = optimise(&mut mesh, &AbsMean, &options).unwrap_err();
    assert!(matches!(error, FlipError::OutOfRange { option: "rebuild.largest", .. }));
}
