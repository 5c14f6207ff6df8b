//! Vertices with very many edges, vertices that no face uses, and limits that hold from the start.
#![allow(clippy::unwrap_used)]

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crate::common::mesh_of;
use dcurv::VertexArea;
use dtri_flip::{
    Change, CostName, FlipCost, FlipError, FlipOptions, FlipReport, Quad, ShapeConstraint, Stencil,
    Stop, VertexCost, VertexFunction, optimise,
};
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use mesh_shapes::{Sphere, scramble};

/// A cone with one face for each of many points on an uneven rim.
fn cone(faces: u32) -> TriMesh {
    let mut random = SplitMix64::new(u64::from(faces));
    let rim = |i: u32| {
        let angle = core::f64::consts::TAU * f64::from(i) / f64::from(faces);
        let radius = 1.0 + 0.1 * random.symmetric();
        [radius * angle.cos(), radius * angle.sin(), 0.1 * random.symmetric()]
    };
    let mut points: Vec<[f64; 3]> = (0..faces).map(rim).collect();
    points.push([0.0, 0.0, 1.0]);
    let triangles: Vec<[u32; 3]> = (0..faces).map(|i| [i, (i + 1) % faces, faces]).collect();
    TriMesh::from_triangles(&points, &triangles).unwrap()
}

/// A cost that counts the flips it evaluates.
struct Counted {
    cost: VertexCost,
    asked: AtomicU64,
}

impl FlipCost for Counted {
    type Cache = <VertexCost as FlipCost>::Cache;

    fn prepare(&self, mesh: &TriMesh) -> Self::Cache {
        self.cost.prepare(mesh)
    }

    fn update(&self, mesh: &TriMesh, cache: &mut Self::Cache, flipped: &Quad) {
        self.cost.update(mesh, cache, flipped);
    }

    fn total(&self, mesh: &TriMesh) -> f64 {
        self.cost.total(mesh)
    }

    fn change(&self, mesh: &TriMesh, cache: &Self::Cache, quad: &Quad) -> Change {
        self.asked.fetch_add(1, Ordering::Relaxed);
        self.cost.change(mesh, cache, quad)
    }

    fn stencil(&self) -> Stencil {
        self.cost.stencil()
    }

    fn length_exponent(&self) -> i32 {
        self.cost.length_exponent()
    }
}

/// New faces between neighbours on the uneven rim may have any normal.
fn unrestricted() -> FlipOptions {
    FlipOptions { shape: Some(ShapeConstraint::Unrestricted), ..FlipOptions::default() }
}

const FUNCTIONS: [VertexFunction; 3] =
    [VertexFunction::SquaredMean, VertexFunction::AbsPrincipal, VertexFunction::AbsGaussian];

#[test]
fn flips_of_a_cone_are_asked_about_a_bounded_number_of_times_each() {
    for function in FUNCTIONS {
        let asked = [1500, 6000].map(|faces| {
            let mut mesh = cone(faces);
            let cost = VertexCost { function, area: VertexArea::Voronoi };
            let counted = Counted { cost, asked: AtomicU64::new(0) };
            let report = optimise(&mut mesh, &counted, &unrestricted()).unwrap();
            assert_eq!(report.stop, Stop::LocalMinimum);
            assert!(report.flips > u64::from(faces) / 4, "{function:?}: {report:?}");
            assert!(report.cost_after < report.cost_before);
            assert!((cost.total(&mesh) - report.cost_after).abs() <= 1e-12 * report.cost_after);
            counted.asked.into_inner() as f64 / report.flips as f64
        });
        // Evaluating the whole star of the apex for each flip would take thousands, and four times as many.
        assert!(asked[1] < 600.0 && asked[1] < 2.0 * asked[0], "{function:?}: {asked:?}");
    }
}

#[test]
fn a_cone_ends_in_a_local_minimum() {
    for function in FUNCTIONS {
        let cost = VertexCost { function, area: VertexArea::Voronoi };
        let mut mesh = cone(3000);
        optimise(&mut mesh, &cost, &unrestricted()).unwrap();
        let again = optimise(&mut mesh, &cost, &unrestricted()).unwrap();
        assert_eq!(again.flips, 0, "{function:?}: {again:?}");
    }
}

#[test]
fn look_ahead_gives_the_same_bits_for_any_number_of_threads() {
    let run = |threads: usize, mesh: &TriMesh, cost: CostName, forbid_intersections: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut mesh = mesh.clone();
            let options =
                FlipOptions { look_ahead: 2, forbid_intersections, ..FlipOptions::default() };
            let report = flip(&mut mesh, cost, &options);
            (mesh.topology().triangles().collect::<Vec<_>>(), report.cost_after.to_bits())
        })
    };
    let mut sphere = mesh_of(&Sphere { radius: 1.0 }.random_hull(300, 5).unwrap());
    scramble(&mut sphere, 400, &mut SplitMix64::new(1), |_, _| true);
    for (mesh, cost, guarded) in [
        (cone(600), CostName::F1, false),
        (sphere.clone(), CostName::F3, true),
        (sphere, CostName::F2, false),
    ] {
        assert_eq!(run(1, &mesh, cost, guarded), run(8, &mesh, cost, guarded), "{cost}");
    }
}

fn flip(mesh: &mut TriMesh, cost: CostName, options: &FlipOptions) -> FlipReport {
    cost.optimise(mesh, VertexArea::Voronoi, options, &mut |_| ControlFlow::Continue(())).unwrap()
}

#[test]
fn a_vertex_that_no_face_uses_may_be_anywhere() {
    let mut near = mesh_of(&Sphere { radius: 1.0 }.random_hull(100, 7).unwrap());
    scramble(&mut near, 60, &mut SplitMix64::new(2), |_, _| true);
    let triangles: Vec<[u32; 3]> = near.topology().triangles().collect();
    let mut points = near.positions().to_vec();
    points.push(glam::DVec3::splat(3e38));
    let mut far = TriMesh::from_triangles(&points, &triangles).unwrap();
    for cost in [CostName::F1, CostName::F2, CostName::Area] {
        let (mut near, mut far) = (near.clone(), far.clone());
        let flips = flip(&mut near, cost, &FlipOptions::default()).flips;
        assert!(flips > 10);
        assert_eq!(flip(&mut far, cost, &FlipOptions::default()).flips, flips);
        assert!(near.topology().triangles().eq(far.topology().triangles()));
    }
    far.compact();
}

#[test]
fn look_ahead_has_a_bound() {
    let mut mesh = cone(12);
    let options = FlipOptions { look_ahead: 9, ..FlipOptions::default() };
    let error = optimise(&mut mesh, &dtri_flip::AbsMean, &options).unwrap_err();
    assert_eq!(error, FlipError::LookAhead { given: 9, limit: FlipOptions::MAX_LOOK_AHEAD });
}

#[test]
fn the_first_look_at_all_rows_can_be_stopped() {
    let mut start = mesh_of(&Sphere { radius: 1.0 }.random_hull(2000, 9).unwrap());
    flip(&mut start, CostName::F2, &FlipOptions::default());
    // All sequences of eight flips from thousands of edges would take hours.
    let options = FlipOptions { look_ahead: 8, ..FlipOptions::default() };
    let limited = FlipOptions { time_limit: Some(Duration::from_millis(50)), ..options.clone() };
    let report = flip(&mut start.clone(), CostName::F2, &limited);
    assert_eq!(report.stop, Stop::TimeLimit);
    assert!(report.cost_after <= report.cost_before);
    let mut calls = 0;
    let mut mesh = start.clone();
    let report = CostName::F2
        .optimise(&mut mesh, VertexArea::Voronoi, &options, &mut |progress| {
            calls += 1;
            assert!(progress.remaining > 0);
            ControlFlow::Break(())
        })
        .unwrap();
    assert_eq!((report.stop, calls), (Stop::Cancelled, 1));
    assert!(mesh.topology().triangles().eq(start.topology().triangles()));
}
