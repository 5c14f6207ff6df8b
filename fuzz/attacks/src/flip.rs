//! Flips for every cost.

use core::ops::ControlFlow;
use std::collections::BTreeSet;

use arbitrary::{Result, Unstructured};
use dcurv::VertexArea;
use dtri_flip::{Anneal, CostName, FlipOptions, Ties, Update};
use mesh_core::{TriMesh, VertexId};

use crate::shape::{assert_sound, mesh};

/// Optimises a mesh. Vertices and boundary must stay and the cost must not rise.
pub fn attack(data: &[u8]) {
    // Too few bytes are not an error.
    let _ = run(&mut Unstructured::new(data));
}

fn run(u: &mut Unstructured<'_>) -> Result<()> {
    let cost = *u.choose(CostName::ALL)?;
    let area = *u.choose(&[VertexArea::Voronoi, VertexArea::Barycentric])?;
    let options = options(u)?;
    let before = mesh(u)?;
    let mut after = before.clone();
    let patience = u.int_in_range(0..=200)?;
    let mut asked = 0;
    let result = cost.optimise(&mut after, area, &options, &mut |_| {
        asked += 1;
        if asked > patience { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_sound(&after);
    assert_eq!(after.positions(), before.positions(), "flips move no vertex");
    assert_eq!(after.topology().face_count(), before.topology().face_count());
    assert_eq!(boundary(&after), boundary(&before), "flips keep the boundary");
    match result {
        Ok(report) => {
            let [old, new] = [report.cost_before, report.cost_after];
            assert!(!old.is_nan() && !new.is_nan(), "{cost}: {old} -> {new}");
            // Sums in another order differ in the last digits.
            let rounding = 1e-9 * (1.0 + old.abs());
            let is_promised = cost.is_potential() && options.update == Update::Exact;
            assert!(!is_promised || new <= old + rounding, "{cost}: {old} -> {new}");
            if report.flips == 0 {
                assert_eq!(
                    after.topology().canonical_triangles(),
                    before.topology().canonical_triangles()
                );
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    Ok(())
}

fn options(u: &mut Unstructured<'_>) -> Result<FlipOptions> {
    let angle = |u: &mut Unstructured<'_>| -> Result<Option<f64>> {
        Ok(if u.ratio(1, 2)? { None } else { Some(f64::from(u.int_in_range(0..=34)?) / 10.0) })
    };
    let anneal = Anneal { seed: 7, rounds: 2, steps_per_edge: 2, ..Anneal::default() };
    Ok(FlipOptions {
        look_ahead: u.int_in_range(0..=3)?,
        anneal: u.ratio(1, 4)?.then_some(anneal),
        feature_angle: angle(u)?,
        max_fold: angle(u)?,
        forbid_intersections: u.arbitrary()?,
        ties: if u.arbitrary()? { Ties::EdgeId } else { Ties::Seeded(3) },
        update: if u.ratio(1, 4)? { Update::TwoNeighbourhood } else { Update::Exact },
        max_flips: if u.ratio(1, 4)? { Some(u.int_in_range(0..=9)?) } else { None },
        ..FlipOptions::default()
    })
}

fn boundary(mesh: &TriMesh) -> BTreeSet<[VertexId; 2]> {
    let topology = mesh.topology();
    let edges = topology.edges().filter(|&edge| topology.is_boundary_edge(edge));
    let sorted = edges.map(|edge| {
        let [a, b] = topology.edge_vertices(edge);
        [a.min(b), a.max(b)]
    });
    sorted.collect()
}
