//! Sec. 2 and 3: the properties of the Willmore energy that the paper builds on.

use dcurv::{VertexArea, intersection_angle, total_willmore_energy, willmore_energies};
use dtri_flip::{CostName, FlipOptions};
use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use mesh_shapes::{Irregular, Sphere, Torus, scramble};

use super::super::flips::optimise;
use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of};
use xtask_common::Failure;

const QUADRILATERALS: usize = 1000;
const POINTS: usize = 200;
/// Angles and energies below this are zero but for rounding.
const ZERO: f64 = 1e-9;

pub(super) fn compute(_: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The energy of a vertex is the sum of the angles beta at its edges less 2 pi. The paper \
         quotes three properties of it and builds its virtual points on the third.",
    );
    item.how(
        &["dcurv::intersection_angle", "dcurv::willmore_energies", "dcurv::total_willmore_energy"],
        &["curvmesh curvature IN -o OUT --quantity willmore"],
    );
    add_sign(item)?;
    add_flipped_angle(item);
    add_invariance(item)
}

/// W(v) is not negative, and zero where a convex vertex and its neighbours lie on a sphere.
fn add_sign(item: &mut Item) -> Result<(), Failure> {
    let hull = mesh_of(&Sphere { radius: 1.0 }.random_hull(POINTS, 1).map_err(Failure::mesh)?)?;
    let on_sphere = extreme(&hull, f64::max);
    let mut scrambled = hull;
    scramble(&mut scrambled, 300, &mut SplitMix64::new(1), |_, _| true);
    let torus = Torus { major: 5.0, minor: 2.0 };
    let torus =
        mesh_of(&torus.irregular_mesh(40, 20, Irregular::default()).map_err(Failure::mesh)?)?;
    let least = extreme(&scrambled, f64::min).min(extreme(&torus, f64::min));
    item.claim(
        "not negative",
        Outcome::of(least > -ZERO && on_sphere < ZERO),
        format!(
            "on the hull of {POINTS} random points of a sphere no vertex has more than 1e-9; on that \
             hull after 300 random flips, and on an irregular torus, none has less than -1e-9"
        ),
    );
    Ok(())
}

fn extreme(mesh: &TriMesh, choose: fn(f64, f64) -> f64) -> f64 {
    let energies = willmore_energies(mesh);
    mesh.topology().vertices().map(|v| energies[v]).reduce(choose).unwrap_or(0.0)
}

/// beta(e) = beta(e').
fn add_flipped_angle(item: &mut Item) {
    let random = &mut SplitMix64::new(7);
    let mut largest = 0.0_f64;
    for _ in 0..QUADRILATERALS {
        let mut point = || DVec3::from_array(core::array::from_fn(|_| random.uniform()));
        let [a, b, c, d] = core::array::from_fn(|_| point());
        largest =
            largest.max((intersection_angle(a, b, c, d) - intersection_angle(d, c, a, b)).abs());
    }
    item.claim(
        "same angle",
        Outcome::of(largest < ZERO),
        format!("for {QUADRILATERALS} random quadrilaterals the two angles agree within 1e-9 rad"),
    );
}

/// W may be invariant under flips, says the paper: it is not.
fn add_invariance(item: &mut Item) -> Result<(), Failure> {
    let torus = Torus { major: 5.0, minor: 2.0 };
    let mut mesh = mesh_of(&torus.shifted_mesh(12, 6).map_err(Failure::mesh)?)?;
    let before = total_willmore_energy(&mesh);
    let report = optimise(
        &mut mesh,
        CostName::WillmorePotential,
        VertexArea::Voronoi,
        &FlipOptions::default(),
    )?;
    let after = total_willmore_energy(&mesh);
    item.number("torus 12 x 6, W before", before);
    item.number("torus 12 x 6, W after flips by W itself", after);
    item.number("torus 12 x 6, flips", report.flips as f64);
    item.claim(
        "invariant under flips",
        Outcome::of((before - after).abs() < ZERO),
        format!(
            "the angle at the flipped edge stays, but the four sides get other triangles and so other \
             angles: on the torus of 12 x 6 points, {} flips that lower W take it from {before:.2} to \
             {after:.2}",
            report.flips
        ),
    );
    Ok(())
}
