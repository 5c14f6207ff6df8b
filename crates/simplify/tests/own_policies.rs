//! Policies from outside this crate, in all stages of `simplify`.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::{Remap, TriMesh, VertexMap};
use mesh_shapes::{Irregular, Sphere};
use simplify::{
    AnnealOptions, Collapse, Constraint, Cost, EdgePatch, ErrorCheck, Hybrid, Memoryless, Metric,
    Optimal, Options, Place, Placement, PlacementRule, Policies, Policy, Preset, Protect, Quadric,
    Rejection, Schedule, Scratch, Simplified, SimplifyError, Target, collapse_edges, simplify,
    simplify_with,
};
use std::collections::HashSet;
use std::ops::ControlFlow;
use std::time::Duration;

/// Painted vertices stay, and no other vertex is collapsed into them.
#[derive(Clone)]
struct Painted(VertexMap<bool>);

impl Policy for Painted {
    fn collapsed(&mut self, _: &TriMesh, collapse: &Collapse) {
        assert!(!self.0.get(collapse.removed).is_some_and(|&painted| painted));
    }

    fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
        self.0 = self.0.compact(remap);
    }
}

impl Constraint for Painted {
    fn check(&self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
        let is_painted = |v| self.0.get(v).is_some_and(|&painted| painted);
        let any = is_painted(patch.removed()) || is_painted(patch.kept());
        if any { Err(Rejection::Other) } else { Ok(()) }
    }
}

fn ball() -> TriMesh {
    let sphere = Sphere { radius: 1.0 };
    let soup = sphere.irregular_icosphere(3, Irregular { jitter: 0.2, seed: 7 }).unwrap();
    TriMesh::from_soup(&soup).unwrap()
}

fn painted(mesh: &TriMesh) -> VertexMap<bool> {
    let mut painted = mesh.topology().vertex_map(false);
    mesh.topology().vertices().for_each(|v| painted[v] = mesh.position(v).z > 0.7);
    painted
}

fn guarded<C: Cost, P: Placement>(
    mesh: &TriMesh,
    mut policies: Policies<C, P>,
    options: &Options,
) -> Result<Simplified, SimplifyError> {
    policies.constraints.push(Painted(painted(mesh)));
    simplify_with(mesh, policies, &options.clone().custom(), &mut |_| ControlFlow::Continue(()))
}

/// All painted vertices are still present and separate, also after the steps that follow the collapses.
#[test]
fn a_guard_from_outside_holds_in_all_steps() {
    let mesh = ball();
    let painted = painted(&mesh);
    let mut extreme = Options::preset(Preset::Extreme).to_faces(500);
    extreme.refine.tuning.anneal = AnnealOptions { rounds: 4, ..AnnealOptions::default() };
    let max_error_only = {
        let mut options = Options::preset(Preset::Quality).to_faces(500);
        options.refine.fit = false;
        options.refine.anneal = false;
        options
    };
    let within = Options::default().within(0.05, ErrorCheck::Sampled);
    assert!(within.tolerance.decimate);
    let mut levels = Options::preset(Preset::Fast);
    levels.target.time = Some(Duration::from_secs(3600));
    let levels = levels.within(0.05, ErrorCheck::Certified);
    assert!(!levels.tolerance.decimate);
    for options in [extreme, max_error_only, within, levels] {
        let policies = Policies::new(Hybrid::default(), Optimal::default());
        let result = guarded(&mesh, policies, &options).unwrap();
        assert!(result.mesh.topology().face_count() < mesh.topology().face_count() / 2);
        let vertex_map: HashSet<_> = painted
            .iter()
            .filter(|(_, painted)| **painted)
            .map(|(v, _)| result.vertex_map[v].unwrap())
            .collect();
        let count = painted.iter().filter(|(_, painted)| **painted).count();
        assert_eq!(vertex_map.len(), count, "{options:?}");
        assert!(result.rejections.of(Rejection::Other) > 0);
    }
}

/// Policies passed as values act like the same policies named by options.
#[test]
fn policies_by_hand_are_those_by_name() {
    let mesh = ball();
    let mut options = Options::preset(Preset::Fast).to_faces(300);
    options.cost.metric = Metric::Memoryless;
    let named = simplify(&mesh, &options).unwrap();
    let policies = Policies::new(Memoryless, Optimal::default());
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let by_hand = simplify_with(&mesh, policies, &options.custom(), go_on).unwrap();
    assert_eq!(named.log, by_hand.log);
    assert_eq!(named.mesh.positions(), by_hand.mesh.positions());
}

#[test]
fn options_that_exclude_each_other_are_errors() {
    let mesh = ball();
    let conflict = |change: fn(&mut Options)| {
        let mut options = Options::default().within(0.1, ErrorCheck::Sampled);
        change(&mut options);
        match simplify(&mesh, &options) {
            Err(SimplifyError::Conflict { option, with, .. }) => (option, with),
            other => panic!("{other:?}"),
        }
    };
    let time = |o: &mut Options| o.target.time = Some(Duration::from_secs(1));
    assert_eq!(conflict(time), ("tolerance.decimate", "target.time"));
    assert_eq!(
        conflict(|o| o.tolerance.check = None),
        ("tolerance.distance", "tolerance.check = None")
    );
    assert_eq!(
        conflict(|o| o.tolerance.distance = None),
        ("tolerance.decimate", "tolerance.distance = None")
    );
    let anneal = |o: &mut Options| {
        o.refine.anneal = true;
        o.refine.fit = false;
    };
    assert_eq!(conflict(anneal), ("refine.anneal", "refine.fit = false"));
    let norm = |o: &mut Options| o.cost.metric = Metric::CurvatureL1;
    assert_eq!(conflict(norm).0, "cost.curvature_weight");
}

/// Policies chosen at run time act like those chosen at compile time.
#[test]
fn policies_in_boxes_do_the_same() {
    let mesh = ball();
    let metrics = [
        Metric::Quadric,
        Metric::IncrementalQuadric,
        Metric::Memoryless,
        Metric::Hybrid,
        Metric::CurvatureL1,
        Metric::CurvatureL2,
    ];
    let rules = [
        PlacementRule::OptimalVolume,
        PlacementRule::Optimal,
        PlacementRule::Endpoint,
        PlacementRule::Midpoint,
        PlacementRule::Butterfly,
        PlacementRule::CurvatureOptimal,
    ];
    for metric in metrics {
        for placement in rules {
            let mut options = Options::preset(Preset::Fast).to_faces(400);
            options.cost.metric = metric;
            options.placement = placement;
            options.cost.curvature_weight = 0.0;
            options.cost.schedule = Schedule::Lazy;
            if placement == PlacementRule::CurvatureOptimal && !metric.is_norm() {
                assert!(simplify(&mesh, &options).is_err(), "{metric:?}");
                continue;
            }
            let named = simplify(&mesh, &options).unwrap();
            let (cost, placement) = (metric.cost().unwrap(), placement.placement().unwrap());
            let policies = Policies::new(cost, placement);
            let go_on = &mut |_: &_| ControlFlow::Continue(());
            let boxed = simplify_with(&mesh, policies, &options.custom(), go_on).unwrap();
            assert_eq!(named.mesh.positions(), boxed.mesh.positions(), "{metric:?}");
            assert_eq!(named.mesh.to_soup().corners(), boxed.mesh.to_soup().corners());
        }
    }
}

/// A placement at one end, which its check rejects, with the midpoint as the alternative.
struct NotAtEnds;

impl Policy for NotAtEnds {}

impl Placement for NotAtEnds {
    fn place(
        &self,
        _: &EdgePatch<'_>,
        _: Option<&Quadric>,
        _: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        Place::Kept
    }

    fn check(&self, patch: &EdgePatch<'_>, x: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
        if patch.ends().contains(&x) { Err(Rejection::Other) } else { Ok(()) }
    }

    fn instead(&self, refused: usize) -> Option<Place> {
        (refused == 0).then_some(Place::At(DVec3::ZERO))
    }
}

/// A locked vertex must keep its position, so no alternative position is tried.
#[test]
fn locked_vertices_do_not_go_to_another_place_instead() {
    let original = ball();
    let locked = painted(&original);
    for schedule in [Schedule::Lazy, Schedule::Exact] {
        let mut mesh = original.clone();
        let policies = Policies { schedule, ..Policies::new(Memoryless, NotAtEnds) };
        let protect = Protect { locked: Some(locked.clone()), ..Protect::default() };
        let limits = Target { faces: Some(500), ..Target::default() };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let run = collapse_edges(&mut mesh, policies, &protect, &limits, go_on);
        assert!(run.log.len() > 100 && run.rejections.of(Rejection::Other) > 0);
        for (v, _) in locked.iter().filter(|(_, locked)| **locked) {
            assert!(mesh.topology().contains_vertex(v), "{v:?}");
            assert_eq!(mesh.position(v), original.position(v), "{v:?}");
        }
    }
}
