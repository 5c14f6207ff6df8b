//! The position at which the collapse costs least, found by a search.

use glam::DVec3;

use super::{ButterflyPoint, Placement};
use crate::geometry::edge_patch::{EdgePatch, Place};
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy};

/// Puts the vertex where the cost of the collapse has a local minimum.
///
/// With [`CurvatureNorm`](crate::CurvatureNorm), this is the position that changes the curvature
/// norm least: KKL02 section 5 leaves it as future work to "find the optimal position of a new vertex
/// resulting from an edge collapse with respect to discrete curvatures".
///
/// The cost is not smooth, so derivatives are of no use. The best of the butterfly point, the
/// midpoint and the two ends is the start of a compass search: if one of the six axis-parallel steps
/// lowers the cost, the best of them is made; otherwise steps are halved. They begin at a quarter of
/// the edge and end below a hundredth of it, and stay in the ball that has the edge as diameter: far away
/// there are other positions that hardly change the norm and are of no use. Of equal costs, the first
/// position stays. A search evaluates the cost about fifty times.
#[derive(Clone, Copy, Debug, Default)]
pub struct LeastCost;

/// The first and the last step, in lengths of the edge.
const FIRST_STEP: f64 = 0.25;
const LAST_STEP: f64 = 0.01;
/// The largest distance from the middle of the edge that a step may lead to, in lengths of the edge.
const FARTHEST: f64 = 0.5;
/// Steps of one search at most.
const STEPS: usize = 24;

impl Policy for LeastCost {}

impl Placement for LeastCost {
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        let length = patch.squared_length().sqrt();
        let butterfly = patch.offset(ButterflyPoint.place(patch, quadric, cost));
        let mut at = butterfly;
        let mut least = cost(at);
        let others = [DVec3::ZERO, patch.offset(Place::Removed), patch.offset(Place::Kept)];
        for x in others {
            let value = cost(x);
            if value < least {
                (at, least) = (x, value);
            }
        }
        let mut step = FIRST_STEP * length;
        for _ in 0..STEPS {
            if least <= 0.0 || step < LAST_STEP * length {
                break;
            }
            let start = at;
            for direction in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
                let x = start + step * direction;
                if x.length() > FARTHEST * length {
                    continue;
                }
                let value = cost(x);
                if value < least {
                    (at, least) = (x, value);
                }
            }
            if at == start {
                step *= 0.5;
            }
        }
        Place::At(at)
    }

    fn needs(&self) -> Needs {
        Needs::Ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::TriMesh;
    use mesh_shapes::Sphere;

    #[test]
    fn the_minimum_of_a_bowl_is_found_and_no_start_is_better() {
        let soup = Sphere { radius: 1.0 }.random_hull(60, 2).unwrap();
        let mesh = TriMesh::from_soup(&soup).unwrap();
        let mut faces = Vec::new();
        for h in mesh.topology().half_edges() {
            let patch = EdgePatch::gather(&mesh, h, &mut faces);
            let length = patch.squared_length().sqrt();
            let bottom = length * DVec3::new(0.3, -0.2, 0.1);
            let found =
                patch.offset(LeastCost.place(&patch, None, &mut |x| 1.0 + x.distance(bottom)));
            assert!(found.distance(bottom) < 0.03 * length, "{found} {bottom} {length}");
            let away = &mut |x: DVec3| 1.0 / (1.0 + x.length());
            let start = patch.offset(ButterflyPoint.place(&patch, None, away)).length();
            let farthest = start.max(0.5 * length) * (1.0 + 1e-9);
            assert!(patch.offset(LeastCost.place(&patch, None, away)).length() <= farthest);
            let flat = LeastCost.place(&patch, None, &mut |_| 1.0);
            let butterfly = ButterflyPoint.place(&patch, None, &mut |_| 1.0);
            assert_eq!(patch.offset(flat), patch.offset(butterfly));
        }
    }
}
