//! Table 1 of DHKL01.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common::{TORUS, paper_torus};
use dcurv::VertexArea;
use dtri_flip::{
    AbsMean, FlipCost, FlipOptions, LatticeError, Stop, Ties, Update, VertexCost, VertexFunction,
    lattice_error, optimise,
};
use mesh_core::TriMesh;
use mesh_shapes::SignedDistance;

fn error(mesh: &TriMesh) -> LatticeError {
    lattice_error(mesh, 100, |p| TORUS.signed_distance(p))
}

fn is_row(error: &LatticeError, row: [f64; 3], tolerance: f64) -> bool {
    let found = [error.mean, error.rms, error.max];
    found.iter().zip(row).all(|(x, y)| (x - y).abs() < tolerance)
}

const F1: VertexCost =
    VertexCost { function: VertexFunction::SquaredMean, area: VertexArea::Voronoi };
const F3_BARYCENTRIC: VertexCost =
    VertexCost { function: VertexFunction::AbsPrincipal, area: VertexArea::Barycentric };
const F3_VORONOI: VertexCost =
    VertexCost { function: VertexFunction::AbsPrincipal, area: VertexArea::Voronoi };

fn greedy<C: FlipCost>(cost: &C, ties: Ties) -> (dtri_flip::FlipReport, LatticeError) {
    let mut mesh = paper_torus();
    let report = optimise(&mut mesh, cost, &FlipOptions { ties, ..Default::default() }).unwrap();
    mesh.topology().validate().unwrap();
    assert_eq!(report.stop, Stop::LocalMinimum);
    (report, error(&mesh))
}

#[test]
fn initial_row() {
    let found = error(&paper_torus());
    println!("initial {found:?}");
    assert!(is_row(&found, [0.2342743546, 0.2824122092, 0.7939588898], 2e-7));
}

#[test]
fn f2_row_for_every_tie_order() {
    for seed in 0..100 {
        let ties = if seed == 0 { Ties::EdgeId } else { Ties::Seeded(seed) };
        let (report, found) = greedy(&AbsMean, ties);
        assert!((report.cost_before - 220.300037).abs() < 1e-6);
        assert!((report.cost_after - 138.196323).abs() < 1e-6, "{report:?}");
        assert_eq!(report.flips, 54);
        assert!(is_row(&found, [0.1640362102, 0.1931971435, 0.4019238949], 2e-7), "{found:?}");
    }
}

#[test]
fn f3_row_with_barycentric_area() {
    let (report, found) = greedy(&F3_BARYCENTRIC, Ties::EdgeId);
    println!("{report:?} {found:?}");
    assert_eq!(report.flips, 48);
    assert!((report.cost_after - 290.953006).abs() < 1e-6);
    assert!(is_row(&found, [0.1660948138, 0.1945930432, 0.3892151477], 2e-7));
    let (report, found) = greedy(&F3_VORONOI, Ties::EdgeId);
    assert!((report.cost_before - 457.569662).abs() < 1e-6);
    assert!((report.cost_after - 299.705744).abs() < 1e-6);
    assert!(is_row(&found, [0.1617127, 0.1913810, 0.3892151], 2e-7));
}

#[test]
fn f1_row_for_a_share_of_the_tie_orders() {
    let orders = 400;
    let (mut paper, mut other) = (0, 0);
    for seed in 0..orders {
        let (report, found) = greedy(&F1, Ties::Seeded(seed));
        assert!((report.cost_before - 130.173069).abs() < 1e-6);
        if is_row(&found, [0.1581226238, 0.1887044119, 0.4019238949], 2e-7) {
            assert!((report.cost_after - 55.601396).abs() < 1e-6);
            assert_eq!(report.flips, 42);
            paper += 1;
        } else if is_row(&found, [0.1610962, 0.1909262, 0.4019238], 2e-7) {
            assert!((report.cost_after - 55.532737).abs() < 1e-6);
            other += 1;
        } else {
            println!("seed {seed}: {report:?} {found:?}");
        }
    }
    println!("F1: the paper's row for {paper} of {orders} tie orders, the other for {other}");
    assert_eq!(paper + other, orders);
    assert!(paper * 100 > 15 * orders && paper * 100 < 40 * orders);
}

#[test]
fn look_ahead_totals() {
    let options = FlipOptions { look_ahead: 2, ..Default::default() };
    let mut mesh = paper_torus();
    let report = optimise(&mut mesh, &AbsMean, &options).unwrap();
    println!("{report:?} {:?}", error(&mesh));
    assert!((report.cost_after - 134.960327).abs() < 1e-6);
    assert!(is_row(&error(&mesh), [0.1660948, 0.1945930, 0.3892151], 2e-7));
    for seed in 0..20 {
        let mut mesh = paper_torus();
        let options = FlipOptions { ties: Ties::Seeded(seed), ..options.clone() };
        let report = optimise(&mut mesh, &F1, &options).unwrap();
        println!("F1 {} {}", report.cost_after, report.flips);
        let known = [53.825286, 53.860117].iter().any(|x| (report.cost_after - x).abs() < 1e-6);
        assert!(known, "{report:?}");
    }
}

#[test]
fn the_papers_update_never_raises_the_cost() {
    for cost in [F1, F3_BARYCENTRIC, F3_VORONOI] {
        let mut mesh = paper_torus();
        let options = FlipOptions { update: Update::TwoNeighbourhood, ..Default::default() };
        let report = optimise(&mut mesh, &cost, &options).unwrap();
        println!("{cost:?} {report:?} {:?}", error(&mesh));
        assert!(report.cost_after < report.cost_before);
    }
    let mut mesh = paper_torus();
    let options = FlipOptions { update: Update::TwoNeighbourhood, ..Default::default() };
    let report = optimise(&mut mesh, &AbsMean, &options).unwrap();
    assert!((report.cost_after - 138.196323).abs() < 1e-6, "the paper's update is exact for F2");
}
