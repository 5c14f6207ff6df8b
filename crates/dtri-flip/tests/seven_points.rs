//! The convex set of seven points of DHKL01 Fig. 4, a local minimum of all three costs.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use crate::common::{face_set, mesh_of};
use dcurv::VertexArea;
use dtri_flip::{Anneal, CostName, FlipOptions, Stop};
use mesh_core::TriMesh;
use mesh_shapes::seven_points;

const COSTS: [(CostName, f64, f64); 3] = [
    (CostName::F1, 31.369089, 32.958906),
    (CostName::F2, 89.381538, 88.960816),
    (CostName::F3, 178.763077, 177.921633),
];

fn run(cost: CostName, options: &FlipOptions) -> (TriMesh, dtri_flip::FlipReport) {
    let mut mesh = mesh_of(&seven_points::given());
    let report = cost
        .optimise(&mut mesh, VertexArea::Voronoi, options, &mut |_| {
            std::ops::ControlFlow::Continue(())
        })
        .unwrap();
    (mesh, report)
}

#[test]
fn costs_are_those_of_the_reference() {
    for (cost, given, convex) in COSTS {
        let total = |soup| cost.total(&mesh_of(&soup), VertexArea::Voronoi);
        assert!((total(seven_points::given()) - given).abs() < 1e-6);
        assert!((total(seven_points::convex()) - convex).abs() < 1e-6);
    }
}

#[test]
fn greedy_and_pairs_stay() {
    for (cost, given, _) in COSTS {
        for look_ahead in [1, 2] {
            let (mesh, report) = run(cost, &FlipOptions { look_ahead, ..Default::default() });
            assert_eq!((report.flips, report.stop), (0, Stop::LocalMinimum));
            assert!((report.cost_after - given).abs() < 1e-6);
            assert_eq!(face_set(&mesh), face_set(&mesh_of(&seven_points::given())));
        }
    }
}

#[test]
fn depth_three_and_annealing_reach_the_hull() {
    let convex = face_set(&mesh_of(&seven_points::convex()));
    let given = face_set(&mesh_of(&seven_points::given()));
    let escapes = (0..20)
        .map(|seed| FlipOptions {
            anneal: Some(Anneal { seed, ..Default::default() }),
            ..Default::default()
        })
        .chain([FlipOptions { look_ahead: 3, ..Default::default() }]);
    for options in escapes {
        for (cost, ..) in COSTS {
            let (mesh, report) = run(cost, &options);
            let expected = if cost == CostName::F1 { &given } else { &convex };
            assert_eq!(&face_set(&mesh), expected, "{cost} {options:?} {report:?}");
            // Undone flips leave other start corners, and sums in another order are rounded differently.
            let rounding = 1e-14 * report.cost_before;
            assert!(report.cost_after <= report.cost_before + rounding, "{cost} {report:?}");
        }
    }
}

#[test]
fn brute_force_confirms_the_global_minima() {
    let start = mesh_of(&seven_points::given());
    let mut known: BTreeMap<Vec<[u32; 3]>, TriMesh> = BTreeMap::new();
    let mut front = vec![start.clone()];
    known.insert(face_set(&start), start);
    for _ in 0..12 {
        let mut next = Vec::new();
        for mesh in front {
            for edge in mesh.topology().edges() {
                let mut flipped = mesh.clone();
                let Ok(flip) = flipped.topology().check_flip(edge) else { continue };
                flipped.flip(flip);
                let faces = face_set(&flipped);
                if let Entry::Vacant(place) = known.entry(faces) {
                    place.insert(flipped.clone());
                    next.push(flipped);
                }
            }
        }
        front = next;
    }
    // Flips can turn a small closed mesh inside out: each triangulation occurs with both orientations.
    println!("{} oriented triangulations", known.len());
    assert_eq!(known.len(), 2 * 5712);
    for (cost, given, convex) in COSTS {
        let totals = known.values().map(|mesh| cost.total(mesh, VertexArea::Voronoi));
        let least = totals.fold(f64::INFINITY, f64::min);
        let expected = if cost == CostName::F1 { given } else { convex };
        assert!((least - expected).abs() < 1e-6, "{cost}: {least}");
    }
}
