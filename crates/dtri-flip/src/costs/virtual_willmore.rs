//! The virtual Willmore energy of BAR06.

use dcurv::{intersection_angle, total_willmore_energy};
use glam::DVec3;
use mesh_core::{TriMesh, VertexId};

use crate::cost::{Change, FlipCost, Stencil};
use crate::quad::Quad;

/// Cost reduction of BAR06 sec. 3: the Willmore energy with the edge split at its midpoint, minus the
/// energy with the flipped edge split at *its* midpoint.
///
/// This is not the difference of one energy, so a run may cycle. It then ends by
/// [`FlipOptions::max_flips_per_edge`](crate::FlipOptions::max_flips_per_edge), with
/// [`Stop::CycleGuard`](crate::Stop::CycleGuard) in the report. The reported cost is the Willmore energy
/// of the mesh without virtual points; it may rise. For a true potential, see
/// [`Willmore`](crate::Willmore).
///
/// Shape constraint: [`KeepShape`](crate::ShapeConstraint::KeepShape). Angles between circumcircles do
/// not tell a folded face from an unfolded one. BAR06 has no constraint
/// ([`Unrestricted`](crate::ShapeConstraint::Unrestricted)).
///
/// Boundary: as for [`Willmore`](crate::Willmore). Boundary sides of a quadrilateral have no intersection
/// angle, and an interior edge counts once for each interior end. Virtual points are interior. No unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VirtualWillmore;

impl FlipCost for VirtualWillmore {
    type Cache = ();

    fn prepare(&self, _: &TriMesh) {}

    fn total(&self, mesh: &TriMesh) -> f64 {
        total_willmore_energy(mesh)
    }

    fn change(&self, mesh: &TriMesh, _: &(), quad: &Quad) -> Change {
        let [a, b, c, d] = quad.corners;
        let outer = quad.sides.map(|side| mesh.topology().apex(side.twin()));
        let [bc, ca, ad, db] = outer;
        // The flipped edge runs from d to c, with a to its left.
        Change {
            before: split_energy(mesh, [a, b, c, d], [bc, ca, ad, db]),
            after: split_energy(mesh, [d, c, a, b], [ca, ad, db, bc]),
        }
    }

    fn stencil(&self) -> Stencil {
        Stencil::AdjacentTriangles
    }

    fn length_exponent(&self) -> i32 {
        0
    }

    fn is_potential(&self) -> bool {
        false
    }
}

/// Willmore energy of the four inner and four outer edges of the quadrilateral with the edge from a to b
/// split at its midpoint. `outer` has the apexes beyond bc, ca, ad, db.
fn split_energy(mesh: &TriMesh, corners: [VertexId; 4], outer: [Option<VertexId>; 4]) -> f64 {
    let [a, b, c, d] = corners.map(|v| mesh.position(v));
    let middle = 0.5 * (a + b);
    let is_interior = |v| if mesh.topology().is_boundary_vertex(v) { 0.0 } else { 1.0 };
    let [at_a, at_b, at_c, at_d] = corners.map(is_interior);
    let inner = (1.0 + at_a) * intersection_angle(a, middle, c, d)
        + (1.0 + at_b) * intersection_angle(middle, b, c, d)
        + (1.0 + at_c) * intersection_angle(c, middle, a, b)
        + (1.0 + at_d) * intersection_angle(d, middle, b, a);
    let side = |from: DVec3, to: DVec3, apex: Option<VertexId>| {
        apex.map_or(0.0, |v| intersection_angle(from, to, middle, mesh.position(v)))
    };
    inner
        + (at_b + at_c) * side(b, c, outer[0])
        + (at_c + at_a) * side(c, a, outer[1])
        + (at_a + at_d) * side(a, d, outer[2])
        + (at_d + at_b) * side(d, b, outer[3])
}
