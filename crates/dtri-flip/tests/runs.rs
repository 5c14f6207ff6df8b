//! Properties of every run, on random small meshes and real ones.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::ops::ControlFlow;

use crate::common::{mesh_of, model};
use dcurv::{CurvatureOptions, Curvatures, VertexArea};
use dtri_flip::{Anneal, CostName, FlipOptions, FlipReport, Stop, Ties, Update};
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use mesh_shapes::{Sphere, scramble};
use proptest::prelude::*;

fn run(mesh: &mut TriMesh, cost: CostName, options: &FlipOptions) -> FlipReport {
    cost.optimise(mesh, VertexArea::Voronoi, options, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// The cost computed with `dcurv` and `mesh-core` alone, if they provide it.
fn independent(mesh: &TriMesh, cost: CostName) -> Option<f64> {
    let options = CurvatureOptions { area: VertexArea::Voronoi };
    let totals = Curvatures::of(mesh, &options).totals();
    match cost {
        CostName::F1 => Some(totals.f1),
        CostName::F2 => Some(totals.f2()),
        CostName::F3 => Some(totals.f3),
        CostName::Gauss => Some(totals.abs_gaussian.value()),
        CostName::Area => Some(mesh.area()),
        CostName::GaussExtrinsic => Some(dcurv::total_extrinsic_curvature(mesh).value()),
        CostName::Willmore | CostName::WillmorePotential => {
            Some(dcurv::total_willmore_energy(mesh))
        }
        _ => None,
    }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + a.abs().max(b.abs()))
}

fn scrambled_sphere(points: usize, seed: u64, flips: usize) -> TriMesh {
    let mut mesh = mesh_of(&Sphere { radius: 1.0 }.random_hull(points, seed).unwrap());
    scramble(&mut mesh, flips, &mut SplitMix64::new(seed), |_, _| true);
    mesh
}

#[test]
fn trap_16_the_energy_never_rises_and_look_ahead_ends_no_worse() {
    for seed in 0..4 {
        let mesh = scrambled_sphere(40, seed, 30);
        for cost in CostName::ALL.iter().copied().filter(|c| c.is_potential()) {
            let mut last = cost.total(&mesh, VertexArea::Voronoi);
            let mut greedy = mesh.clone();
            let flips = run(&mut greedy, cost, &FlipOptions::default()).flips;
            for limit in 0..=flips {
                let mut copy = mesh.clone();
                let options = FlipOptions { max_flips: Some(limit), ..Default::default() };
                let report = run(&mut copy, cost, &options);
                assert_eq!(report.flips, limit);
                let now = cost.total(&copy, VertexArea::Voronoi);
                assert!(now <= last + 1e-12, "{cost} rose from {last} to {now} in flip {limit}");
                if let Some(expected) = independent(&copy, cost) {
                    assert!(close(now, expected), "{cost}: {now} {expected}");
                }
                last = now;
            }
        }
    }
}

#[test]
fn trap_16_rows_continue_where_single_flips_end() {
    for seed in 0..6 {
        let mesh = scrambled_sphere(40, seed, 30);
        for cost in CostName::ALL.iter().copied().filter(|c| c.is_potential()) {
            let mut greedy = mesh.clone();
            let plain = run(&mut greedy, cost, &FlipOptions::default());
            for look_ahead in [2, 3] {
                let options = FlipOptions { look_ahead, ..Default::default() };
                // From the local minimum of the greedy run, and from the start.
                let further = run(&mut greedy.clone(), cost, &options);
                let at_most = |limit: f64| limit + 1e-12 * (1.0 + limit.abs());
                assert!(further.cost_after <= at_most(plain.cost_after), "{cost}");
                let mut copy = mesh.clone();
                let report = run(&mut copy, cost, &options);
                copy.topology().validate().unwrap();
                assert!(report.cost_after <= at_most(plain.cost_after), "{cost} {look_ahead}");
            }
        }
    }
}

#[test]
fn trap_17_one_thread_and_eight_give_the_same_bytes() {
    let mut meshes = vec![scrambled_sphere(2000, 1, 1500)];
    meshes.extend(model("rocker-arm.obj"));
    for mesh in meshes {
        for &cost in CostName::ALL {
            let with_threads = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let mut copy = mesh.clone();
                    let report = run(&mut copy, cost, &FlipOptions::default());
                    let bits = [report.cost_before, report.cost_after].map(f64::to_bits);
                    (copy.topology().triangles().collect::<Vec<_>>(), bits, report.flips)
                })
            };
            assert!(with_threads(1) == with_threads(8), "{cost}");
        }
    }
}

#[test]
fn annealing_is_never_worse_and_repeats_itself() {
    for seed in 0..3 {
        let mesh = scrambled_sphere(40, seed, 60);
        for &cost in CostName::ALL {
            let greedy = run(&mut mesh.clone(), cost, &FlipOptions::default());
            let settings = Anneal { seed, rounds: 2, steps_per_edge: 30, ..Default::default() };
            let options = FlipOptions { anneal: Some(settings), ..Default::default() };
            let (mut first, mut second) = (mesh.clone(), mesh.clone());
            let report = run(&mut first, cost, &options);
            assert_eq!(report, run(&mut second, cost, &options));
            assert!(first.topology().triangles().eq(second.topology().triangles()));
            assert!(report.cost_after <= greedy.cost_after, "{cost}");
        }
    }
}

#[test]
fn limits_and_cancelling_stop_a_run_with_a_valid_mesh() {
    let mesh = scrambled_sphere(500, 2, 400);
    let options = FlipOptions { max_flips: Some(17), ..Default::default() };
    let report = run(&mut mesh.clone(), CostName::F2, &options);
    assert_eq!((report.flips, report.stop), (17, Stop::FlipLimit));
    let options =
        FlipOptions { time_limit: Some(core::time::Duration::ZERO), ..Default::default() };
    let report = run(&mut mesh.clone(), CostName::F2, &options);
    assert_eq!((report.flips, report.stop), (0, Stop::TimeLimit));
    let mut calls = 0;
    let mut copy = mesh.clone();
    let report = CostName::F2
        .optimise(&mut copy, VertexArea::Voronoi, &FlipOptions::default(), &mut |progress| {
            calls += 1;
            assert!(progress.cost.is_finite());
            if calls == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap();
    assert_eq!((calls, report.stop), (2, Stop::Cancelled));
    assert!(report.flips > 0 && report.cost_after < report.cost_before);
    copy.topology().validate().unwrap();
}

#[test]
fn planar_points_become_delaunay() {
    let mut random = SplitMix64::new(3);
    let n = 12;
    let mut points = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let inner = (1..n - 1).contains(&i) && (1..n - 1).contains(&j);
            let shift = if inner { 0.3 } else { 0.0 };
            let [x, y] = [i, j].map(|k| f64::from(k) + shift * random.symmetric());
            points.push([x, y, 0.0]);
        }
    }
    let at = |i: u32, j: u32| i * n as u32 + j;
    let cells = (0..n as u32 - 1).flat_map(|i| (0..n as u32 - 1).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let mut mesh = TriMesh::from_triangles(&points, &triangles).unwrap();
    let report = run(&mut mesh, CostName::Delaunay, &FlipOptions::default());
    println!("{report:?}");
    assert!(report.flips > 0);
    let topology = mesh.topology();
    for edge in topology.edges().filter(|&e| !topology.is_boundary_edge(e)) {
        let opposite =
            edge.half_edges().map(|h| mesh.corner_angle(topology.next(topology.next(h))));
        assert!(opposite[0] + opposite[1] <= core::f64::consts::PI + 1e-9);
    }
}

/// A grid with a hole; its points are moved, and many coincide or are collinear.
fn rough_grid(size: u32, seed: u64, levels: u32) -> TriMesh {
    let mut random = SplitMix64::new(seed);
    let at = |i: u32, j: u32| i * (size + 1) + j;
    let points: Vec<[f64; 3]> = (0..(size + 1) * (size + 1))
        .map(|_| [(); 3].map(|()| (random.uniform() * f64::from(levels)).floor()))
        .collect();
    let cells = (0..size).flat_map(|i| (0..size).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = cells
        .filter(|&(i, j)| size < 3 || (i, j) != (1, 1))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriMesh::from_triangles(&points, &triangles).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_run_keeps_the_mesh_and_lowers_the_cost(
        size in 1_u32..7,
        seed: u64,
        levels in 1_u32..6,
        cost in prop::sample::select(CostName::ALL.to_vec()),
        look_ahead in 1_usize..4,
        anneal in prop::option::of(0_u64..100),
        guards: bool,
        seeded: bool,
        paper: bool,
    ) {
        let mut mesh = rough_grid(size, seed, levels);
        let boundary: Vec<_> = mesh.topology().edges().filter(|&e| mesh.topology().is_boundary_edge(e))
            .map(|e| (e, mesh.topology().edge_vertices(e))).collect();
        let options = FlipOptions {
            look_ahead,
            anneal: anneal.map(|seed| Anneal { seed, rounds: 1, steps_per_edge: 10, ..Default::default() }),
            max_fold: guards.then_some(1.0),
            forbid_intersections: guards,
            ties: if seeded { Ties::Seeded(seed) } else { Ties::EdgeId },
            update: if paper { Update::TwoNeighbourhood } else { Update::Exact },
            ..Default::default()
        };
        let before = independent(&mesh, cost);
        let report = run(&mut mesh, cost, &options);
        mesh.topology().validate().unwrap();
        prop_assert!(report.cost_before.is_finite() && report.cost_after.is_finite());
        if cost.is_potential() {
            prop_assert!(report.cost_after <= report.cost_before + 1e-12 * (1.0 + report.cost_before.abs()));
        }
        if let (Some(before), Some(after)) = (before, independent(&mesh, cost)) {
            prop_assert!(close(before, report.cost_before), "{} {:?}", before, report);
            prop_assert!(close(after, report.cost_after), "{} {:?}", after, report);
        }
        for (edge, ends) in boundary {
            prop_assert_eq!(mesh.topology().edge_vertices(edge), ends);
        }
    }
}
