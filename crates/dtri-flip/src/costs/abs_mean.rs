//! F2: the absolute mean curvature.

use dcurv::hinge_angle;
use glam::DVec3;

use super::edge_term::EdgeTerm;

/// `F2 = sum over vertices of |Hbar|`, with `|Hbar| = 1/4 sum of |e| |beta|` (DHKL01 sec. 3).
///
/// Each interior edge counts at both ends, so `F2 = 1/2 sum over edges of |e| |beta|`, with the
/// dihedral angles `beta`. Boundary edges have no dihedral angle. In model units.
///
/// Shape constraint: [`KeepShape`](crate::ShapeConstraint::KeepShape). A face that folds back has a
/// dihedral angle near pi, so F2 rarely prefers it. But F2 is indifferent to slivers in a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AbsMean;

impl EdgeTerm for AbsMean {
    const LENGTH_EXPONENT: i32 = 1;

    #[inline]
    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64 {
        // Not `dihedral_angle`, whose branch for any size keeps the loop over edges from being vectorised. Flips see
        // the mesh at unit size.
        let (edge, right) = (b - a, right - a);
        let length = edge.length();
        0.5 * length * hinge_angle(length, edge.cross(left - a), right.cross(edge), right).abs()
    }
}
