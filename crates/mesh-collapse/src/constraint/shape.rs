//! A constraint against slivers.

use glam::DVec3;

use super::Constraint;
use crate::geometry::edge_patch::EdgePatch;
use crate::policy::{Policy, Scratch};
use crate::rejection::Rejection;

/// Rejects collapses that make the worst face worse and leave it a sliver.
///
/// The shape of a face is its area divided by the area of an equilateral triangle with the same sum of squared sides: 1
/// for that triangle, 0 for a face without area. A sliver is rejected only if it is worse than the worst face of the
/// patch before by more than one percent, because a mesh with slivers must be able to lose them: on a cylinder of needles,
/// each collapse along the rim makes the needles beside it oblique, and so a little worse.
#[derive(Clone, Copy, Debug)]
pub struct ShapeConstraint {
    /// Faces with at least this shape are always allowed.
    pub min_shape: f64,
}

/// A face with this part of a shape counts as no worse.
pub(crate) const STILL_AS_GOOD: f64 = 0.99;

impl Default for ShapeConstraint {
    fn default() -> Self {
        Self { min_shape: 0.01 }
    }
}

impl Policy for ShapeConstraint {}

impl Constraint for ShapeConstraint {
    fn check(&self, patch: &EdgePatch<'_>, x: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
        let remaining = patch.remaining_faces().iter();
        let worst = remaining.map(|f| shape(x, f.corners[1], f.corners[2], f.cross_with(x)));
        let worst = worst.fold(1.0, f64::min);
        if worst >= self.min_shape {
            return Ok(());
        }
        let before = patch.faces().iter().map(|f| {
            let [a, b, c] = f.corners;
            shape(a, b, c, f.cross)
        });
        if worst > 0.0 && worst >= STILL_AS_GOOD * before.fold(1.0, f64::min) {
            Ok(())
        } else {
            Err(Rejection::Sliver)
        }
    }
}

fn shape(a: DVec3, b: DVec3, c: DVec3, cross: DVec3) -> f64 {
    let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    // Twice the area of an equilateral triangle is sqrt(3)/2 times a squared side.
    let equilateral = sides * (0.5 / 3.0_f64.sqrt());
    if equilateral > 0.0 { cross.length() / equilateral } else { 0.0 }
}
