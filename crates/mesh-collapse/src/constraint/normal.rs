//! A constraint against faces that fold over.

use glam::DVec3;

use super::Constraint;
use crate::geometry::edge_patch::EdgePatch;
use crate::policy::{Policy, Scratch};
use crate::rejection::Rejection;

/// Rejects collapses after which the normal of a face differs too much from its old normal.
#[derive(Clone, Copy, Debug)]
pub struct NormalConstraint {
    /// The smallest allowed cosine of the angle between old and new normal.
    pub min_cosine: f64,
}

impl Default for NormalConstraint {
    /// 0.2, which is 78 degrees. Chains of turns by nearly 90 degrees can fold a face over.
    fn default() -> Self {
        Self { min_cosine: 0.2 }
    }
}

impl Policy for NormalConstraint {}

impl Constraint for NormalConstraint {
    fn check(&self, patch: &EdgePatch<'_>, x: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
        let turns_too_far = patch.remaining_faces().iter().any(|face| {
            let new = face.cross_with(x);
            let lengths = (face.cross.length_squared() * new.length_squared()).sqrt();
            face.cross.dot(new) < self.min_cosine * lengths
        });
        if turns_too_far { Err(Rejection::NormalTurn) } else { Ok(()) }
    }
}
