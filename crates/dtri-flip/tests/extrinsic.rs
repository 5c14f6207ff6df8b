//! The cost of Alboul and van Damme.
#![allow(clippy::unwrap_used)]

use core::f64::consts::PI;

use crate::common::{face_set, mesh_of};
use dcurv::total_extrinsic_curvature;
use dtri_flip::{AbsExtrinsic, Change, FlipCost, FlipOptions, Quad, Stop, optimise};
use mesh_core::SplitMix64;
use mesh_shapes::{Sphere, scramble, seven_points};

#[test]
fn seven_points_of_dhkl01_become_convex_in_three_greedy_flips() {
    let mut mesh = mesh_of(&seven_points::given());
    let report = optimise(&mut mesh, &AbsExtrinsic, &FlipOptions::default()).unwrap();
    assert!((report.cost_before - 12.6279).abs() < 5e-5, "{report:?}");
    assert!((report.cost_after - 4.0 * PI).abs() < 1e-12, "{report:?}");
    assert_eq!((report.flips, report.stop), (3, Stop::LocalMinimum));
    assert_eq!(face_set(&mesh), face_set(&mesh_of(&seven_points::convex())));
}

#[test]
fn changes_are_differences_of_the_total() {
    let mut mesh = mesh_of(&Sphere { radius: 1.0 }.random_hull(60, 3).unwrap());
    scramble(&mut mesh, 60, &mut SplitMix64::new(5), |_, _| true);
    let cache = AbsExtrinsic.prepare(&mesh);
    let total = total_extrinsic_curvature(&mesh).value();
    let mut checked = 0;
    for edge in mesh.topology().edges() {
        let Some(quad) = Quad::around(mesh.topology(), edge) else { continue };
        let Change { before, after } = AbsExtrinsic.change(&mesh, &cache, &quad);
        let mut flipped = mesh.clone();
        let Ok(flip) = flipped.topology().check_flip(edge) else { continue };
        flipped.flip(flip);
        let expected = total_extrinsic_curvature(&flipped).value() - total;
        assert!((after - before - expected).abs() < 1e-9, "{edge:?}");
        checked += 1;
    }
    assert!(checked > 100);
}
