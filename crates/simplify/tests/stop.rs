//! Why a run stops.
#![allow(clippy::unwrap_used)]

use std::ops::ControlFlow;

use crate::common::joined;
use glam::DVec3;
use mesh_core::TriMesh;
use mesh_shapes::Sphere;
use simplify::{
    BestEndpoint, Collapse, Cost, EdgePatch, Policies, Policy, Quadric, Schedule, Scratch,
    StopReason, Target, collapse_edges,
};

/// One edge costs nothing. Until it is gone, all other edges cost too much; after that, the edges of the second of two
/// spheres do not. They are not neighbours of that edge.
struct Unlocking(bool);

/// The vertices of the first sphere.
const FIRST: u32 = 642;

impl Policy for Unlocking {
    fn collapsed(&mut self, _: &TriMesh, _: &Collapse) {
        self.0 = true;
    }
}

impl Cost for Unlocking {
    fn cost(&self, patch: &EdgePatch<'_>, _: Option<&Quadric>, _: DVec3, _: &mut Scratch) -> f64 {
        let is_second = patch.removed().get() >= FIRST;
        match (self.0, patch.half_edge().edge().index()) {
            (false, 100) => 0.0,
            (true, _) if is_second => 0.5,
            _ => 10.0,
        }
    }
}

#[test]
fn a_limit_of_the_cost_ends_a_run_only_when_every_edge_costs_more_by_then() {
    let first = TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(3).unwrap()).unwrap();
    assert_eq!(first.topology().vertex_count() as u32, FIRST);
    let triangles: Vec<[u32; 3]> = first.topology().triangles().collect();
    let places = [0.0, 3.0].map(|x| first.positions().iter().map(|&p| p + x * DVec3::X).collect());
    let spheres = joined(&places.map(|points| (points, triangles.clone())));
    for schedule in [Schedule::Lazy, Schedule::Exact] {
        let mut mesh = spheres.clone();
        let policies = Policies { schedule, ..Policies::new(Unlocking(false), BestEndpoint) };
        let limits = Target { cost: Some(1.0), ..Target::default() };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let run = collapse_edges(&mut mesh, policies, &Default::default(), &limits, go_on);
        assert_eq!(run.stop, StopReason::Cost, "{} collapses, {:?}", run.log.len(), run.rejections);
        assert!(run.log.len() > 100, "{} collapses", run.log.len());
        assert!(run.max_cost <= 1.0);
        let topology = mesh.topology();
        let mut legal = topology.edges().filter(|e| topology.check_collapse(e.half_edge()).is_ok());
        assert!(legal.all(|e| topology.edge_vertices(e).iter().all(|v| v.get() < FIRST)));
    }
}

/// All edges cost the same.
struct Same;

impl Policy for Same {}

impl Cost for Same {
    fn cost(&self, _: &EdgePatch<'_>, _: Option<&Quadric>, _: DVec3, _: &mut Scratch) -> f64 {
        1.0
    }
}

#[test]
fn an_edge_may_cost_as_much_as_the_limit() {
    let sphere = TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(2).unwrap()).unwrap();
    for schedule in [Schedule::Lazy, Schedule::Exact] {
        let mut mesh = sphere.clone();
        let policies = Policies { schedule, ..Policies::new(Same, BestEndpoint) };
        let limits = Target { cost: Some(1.0), faces: Some(100), ..Target::default() };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let run = collapse_edges(&mut mesh, policies, &Default::default(), &limits, go_on);
        assert_eq!(run.stop, StopReason::Faces, "{schedule:?}");
    }
}
