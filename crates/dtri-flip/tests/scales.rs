//! Flips in very small and very large meshes.
#![allow(clippy::unwrap_used)]

use core::ops::ControlFlow;

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipError, FlipOptions, feature_edges};
use mesh_core::TriMesh;
use proptest::prelude::*;

use crate::common::{face_set, paper_torus};

fn torus(scale: f64) -> TriMesh {
    let mut mesh = paper_torus();
    mesh.positions_mut().iter_mut().for_each(|p| *p *= scale);
    mesh
}

/// The faces after the run, the number of flips, and the number of calls of the observer, which counts the work.
fn flipped(scale: f64, cost: CostName, options: &FlipOptions) -> (Vec<[u32; 3]>, u64, usize) {
    let (mut mesh, mut calls) = (torus(scale), 0);
    let area = VertexArea::default();
    let report = cost
        .optimise(&mut mesh, area, options, &mut |_| {
            calls += 1;
            ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(mesh.positions(), torus(scale).positions());
    (face_set(&mesh), report.flips, calls)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn flips_do_not_depend_on_the_size(kind in 0..CostName::ALL.len(), strong in any::<bool>(), exponent in -954_i32..=994) {
        let options = FlipOptions {
            look_ahead: 1 + usize::from(strong),
            forbid_intersections: strong,
            feature_angle: strong.then_some(0.5),
            ..FlipOptions::default()
        };
        let cost = CostName::ALL[kind];
        let unit = flipped(1.0, cost, &options);
        prop_assert_eq!(flipped(f64::from(exponent).exp2(), cost, &options), unit, "{}", cost);
    }
}

#[test]
fn costs_have_the_size_of_the_mesh() {
    let cost = |name: CostName, scale: f64| {
        let mut mesh = torus(scale);
        let area = VertexArea::default();
        let report = name
            .optimise(&mut mesh, area, &FlipOptions::default(), &mut |_| ControlFlow::Continue(()));
        report.unwrap().cost_after
    };
    // Half the absolute dihedral angle times length: a length. The integral of H squared has no unit.
    for exponent in [-900, -300, 300, 900] {
        let scale = f64::from(exponent).exp2();
        assert_eq!(cost(CostName::F2, scale), scale * cost(CostName::F2, 1.0));
        assert_eq!(cost(CostName::F1, scale), cost(CostName::F1, 1.0));
    }
}

#[test]
fn sizes_that_leave_too_few_digits_are_refused() {
    let mut mesh = torus(f64::from(-1000).exp2());
    let found = CostName::F2.optimise(
        &mut mesh,
        VertexArea::default(),
        &FlipOptions::default(),
        &mut |_| ControlFlow::Continue(()),
    );
    assert!(matches!(found, Err(FlipError::Scale(_))), "{found:?}");
}

#[test]
fn feature_edges_do_not_depend_on_the_size() {
    let features =
        |exponent: i32| feature_edges(&torus(f64::from(exponent).exp2()), 0.3).into_vec();
    let unit = features(0);
    assert!(unit.contains(&true) && unit.contains(&false));
    for exponent in (-1000..=1000).step_by(50) {
        assert!(features(exponent) == unit, "2^{exponent}");
    }
}
