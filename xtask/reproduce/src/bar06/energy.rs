//! Sec. 2 and 3: the properties of the Willmore energy that the paper builds on.

use core::f64::consts::PI;

use dcurv::{
    Integral, VertexArea, edge_mean_curvatures, intersection_angle, total_willmore_energy,
    willmore_energies,
};
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
    add_edge_curvature(item)?;
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

/// M(e) = theta |e| against the integral of mean curvature, which is 4 pi r for a sphere and 2 pi² R for a
/// torus.
fn add_edge_curvature(item: &mut Item) -> Result<(), Failure> {
    let sphere = mesh_of(&Sphere { radius: 3.0 }.icosphere(5).map_err(Failure::mesh)?)?;
    let torus = Torus { major: 5.0, minor: 2.0 };
    let torus = mesh_of(&torus.mesh(240, 96).map_err(Failure::mesh)?)?;
    let ratios = [(&sphere, 4.0 * PI * 3.0), (&torus, 2.0 * PI * PI * 5.0)]
        .map(|(mesh, integral)| total_edge_curvature(mesh) / integral);
    let mean = |mesh: &TriMesh| {
        edge_mean_curvatures(mesh).iter().filter_map(|(_, m)| *m).map(Integral::value).sum::<f64>()
    };
    let factors = [&sphere, &torus].map(|mesh| total_edge_curvature(mesh) / mean(mesh));
    item.number("sphere, sum of M(e) over the integral of H", ratios[0]);
    item.number("torus, sum of M(e) over the integral of H", ratios[1]);
    item.number("sphere, sum of M(e) over that of dcurv", factors[0]);
    item.number("torus, sum of M(e) over that of dcurv", factors[1]);
    item.claim(
        "mean curvature of an edge",
        is_integral(ratios),
        format!(
            "on fine meshes of a sphere and a torus the sum of theta |e| is {:.4} and {:.4} times the integral of \
             H = (k1 + k2) / 2: it is the integral of k1 + k2. dcurv gives an edge half of it, theta |e| / 2 \
             (the factor is {:.6} and {:.6}). Holds if the ratios are 1 within 1 %, in part if they are one other number",
            ratios[0], ratios[1], factors[0], factors[1]
        ),
    );
    Ok(())
}

/// The sum of theta |e| over the edges, from the normals alone.
fn total_edge_curvature(mesh: &TriMesh) -> f64 {
    let topology = mesh.topology();
    let of_edge = |e| {
        let quad = dtri_flip::Quad::around(topology, e)?;
        let [a, b, c, d] = quad.corners.map(|v| mesh.position(v));
        let (left, right) = ((b - a).cross(c - a), (d - a).cross(b - a));
        let angle = left.cross(right).length().atan2(left.dot(right));
        // Positive where the surface is convex: there the other apex lies below the face.
        Some((b - a).length() * angle * -left.dot(d - a).signum())
    };
    topology.edges().filter_map(of_edge).sum()
}

/// Whether sums are the integrals of mean curvature, or at least all the same multiple.
fn is_integral(ratios: [f64; 2]) -> Outcome {
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.01;
    match (ratios.iter().all(|&ratio| near(ratio, 1.0)), near(ratios[0], ratios[1])) {
        (true, _) => Outcome::Holds,
        (false, true) => Outcome::InPart,
        (false, false) => Outcome::Fails,
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_sums_turn_the_verdict() {
        assert_eq!(is_integral([1.001, 0.999]), Outcome::Holds);
        assert_eq!(is_integral([2.0, 2.001]), Outcome::InPart);
        assert_eq!(is_integral([1.0, 2.0]), Outcome::Fails);
    }
}
