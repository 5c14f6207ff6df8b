//! Fig. 4: seven points in convex position, where single flips and pairs of them get stuck.

use dcurv::VertexArea;
use dtri_flip::{Anneal, CostName, FlipOptions};
use glam::DVec3;
use mesh_core::TriMesh;
use mesh_shapes::seven_points;

use super::super::flips::optimise;
use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of, view_of};
use mesh_render::Style;
use xtask_common::Failure;

/// The costs of both triangulations, and where every strategy ends that starts from the given one.
pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Seven points on their convex hull, in a triangulation that is not the hull but a local \
         minimum of all three costs. Single flips and pairs of flips stay there. Rows of three \
         flips and annealing reach the hull for F2 and F3, whose least value it has; for F1 the \
         given triangulation is the better one. The total absolute extrinsic curvature of Alboul and \
         van Damme is 4π for the hull, and greedy flips by it reach the hull. The paper prints the \
         points and no costs.",
    );
    item.how(
        &["dtri_flip::CostName::total", "dtri_flip::optimise"],
        &["curvmesh flip IN -o OUT --cost f2 --shape-constraint unrestricted --look-ahead 3"],
    );
    let [given, convex] = [mesh_of(&seven_points::given())?, mesh_of(&seven_points::convex())?];
    item.number("vertices", given.topology().vertex_count() as f64);
    item.number("triangles", given.topology().face_count() as f64);
    let mut lines = Vec::new();
    let mut stuck = true;
    let costs = [
        ("F1", CostName::F1),
        ("F2", CostName::F2),
        ("F3", CostName::F3),
        ("extrinsic", CostName::GaussExtrinsic),
    ];
    for (name, cost) in costs {
        let mut line = vec![name.to_owned()];
        let mut add = |quantity: &str, value: f64| {
            item.number(format!("{name}, {quantity}"), value);
            line.push(format!("{value:.6}"));
        };
        let at_start = cost.total(&given, VertexArea::Voronoi);
        add("given triangulation", at_start);
        add("convex triangulation", cost.total(&convex, VertexArea::Voronoi));
        for (strategy, options) in strategies() {
            let mut mesh = given.clone();
            let report = optimise(&mut mesh, cost, VertexArea::Voronoi, &options)?;
            add(&format!("{strategy} ends at"), report.cost_after);
        }
        stuck &= cost == CostName::GaussExtrinsic || is_stuck(&given, cost)?;
        lines.push(line);
    }
    item.claim(
        "local minimum",
        Outcome::of(stuck),
        match stuck {
            true => "neither single flips nor pairs of flips lower F1, F2 or F3",
            false => "single flips or pairs of flips lower one of F1, F2 and F3",
        },
    );
    let header = ["cost", "given", "convex", "greedy", "look-ahead 2", "look-ahead 3", "annealing"];
    item.table("Cost of the two triangulations, and where each strategy ends.", header, lines);
    let view = view_of(&given, DVec3::new(0.25, -0.7, 1.0), DVec3::new(0.0, 1.0, 0.2))?;
    let style = Style { size: [900, 560], edge_width: 2.5, ..Style::DEFAULT };
    let draw = |mesh, name, caption| run.picture(mesh, &view, &style, name, caption);
    item.side_by_side([
        draw(&given, "dhkl01-seven-points-given", "given: concave along the edge in its middle")?,
        draw(&convex, "dhkl01-seven-points-convex", "convex: the least value of F2 and F3")?,
    ]);
    Ok(())
}

fn strategies() -> [(&'static str, FlipOptions); 4] {
    let look_ahead = |look_ahead| FlipOptions { look_ahead, ..FlipOptions::default() };
    let anneal = FlipOptions { anneal: Some(Anneal::default()), ..FlipOptions::default() };
    [
        ("greedy", look_ahead(1)),
        ("look-ahead 2", look_ahead(2)),
        ("look-ahead 3", look_ahead(3)),
        ("annealing", anneal),
    ]
}

/// Whether neither single flips nor pairs of flips change the triangulation.
fn is_stuck(mesh: &TriMesh, cost: CostName) -> Result<bool, Failure> {
    for look_ahead in [1, 2] {
        let options = FlipOptions { look_ahead, ..FlipOptions::default() };
        if optimise(&mut mesh.clone(), cost, VertexArea::Voronoi, &options)?.flips > 0 {
            return Ok(false);
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every triangulation that is one flip away is left again, so it is no local minimum.
    #[test]
    fn another_triangulation_turns_the_verdict() {
        let given = mesh_of(&seven_points::given()).unwrap();
        let mut others = 0;
        for cost in [CostName::F1, CostName::F2, CostName::F3] {
            assert!(is_stuck(&given, cost).unwrap(), "{cost}");
            for edge in given.topology().edges() {
                let mut mesh = given.clone();
                let Ok(legal) = mesh.topology().check_flip(edge) else { continue };
                mesh.flip(legal);
                assert!(!is_stuck(&mesh, cost).unwrap(), "{cost} {edge:?}");
                others += 1;
            }
        }
        assert!(others > 0);
    }
}
