//! Why a run stops.
#![allow(clippy::unwrap_used)]

use core::cell::Cell;
use std::ops::ControlFlow;

use glam::DVec3;
use mesh_core::TriMesh;
use mesh_core::shapes::Sphere;
use simplify::{
    Collapse, Cost, EdgePatch, Limits, Midpoint, Policies, Quadric, StopReason, Update,
    collapse_edges,
};

/// One edge costs nothing, and as long as it is there all others cost too much.
struct Unlocking(Cell<bool>);

impl Cost for Unlocking {
    fn cost(&self, patch: &EdgePatch<'_>, _: Option<&Quadric>, _: DVec3) -> f64 {
        match (self.0.get(), patch.half_edge().edge().index()) {
            (false, 100) => 0.0,
            (false, _) => 10.0,
            (true, _) => 0.5 + 0.01 * patch.squared_length(),
        }
    }

    fn collapsed(&mut self, _: &TriMesh, _: &Collapse) {
        self.0.set(true);
    }
}

#[test]
fn a_limit_of_the_cost_ends_a_run_only_when_every_edge_costs_more_by_then() {
    let soup = Sphere { radius: 1.0 }.icosphere(3).unwrap();
    let mut mesh = TriMesh::from_soup(&soup).unwrap();
    let before = mesh.topology().face_count();
    let policies = Policies {
        cost: Unlocking(Cell::new(false)),
        placement: Midpoint,
        guards: Vec::new(),
        update: Update::Lazy,
    };
    let limits = Limits { cost: Some(0.502), ..Limits::default() };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let run = collapse_edges(&mut mesh, policies, &Default::default(), &limits, go_on);
    assert_eq!(run.stop, StopReason::Cost);
    assert!(2 * mesh.topology().face_count() < before, "{} collapses", run.log.len());
    assert!(run.max_cost <= 0.502);
    let length = |e| {
        let [a, b] = mesh.topology().edge_vertices(e).map(|v| mesh.position(v));
        a.distance_squared(b)
    };
    let legal = mesh.topology().edges().filter(|e| {
        let topology = mesh.topology();
        topology.check_collapse(e.half_edge()).is_ok()
    });
    assert!(legal.map(length).all(|squared| 0.5 + 0.01 * squared > 0.502));
}
