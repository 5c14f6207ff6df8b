//! No face may fold over.

use glam::DVec3;

use super::Guard;
use crate::collapse::patch::EdgePatch;
use crate::collapse::policy::{Policy, Scratch};
use crate::collapse::refusal::Refusal;

/// Refuses collapses after which the normal of a face differs too much from what it was.
#[derive(Clone, Copy, Debug)]
pub struct NormalGuard {
    /// The smallest allowed cosine of the angle between old and new normal.
    pub min_cosine: f64,
}

impl Default for NormalGuard {
    /// 0.2, which is 78 degrees. Chains of turns by nearly 90 degrees can fold a face over.
    fn default() -> Self {
        Self { min_cosine: 0.2 }
    }
}

impl Policy for NormalGuard {}

impl Guard for NormalGuard {
    fn check(&self, patch: &EdgePatch<'_>, x: DVec3, _: &mut Scratch) -> Result<(), Refusal> {
        let turns_too_far = patch.remaining_faces().iter().any(|face| {
            let new = face.cross_with(x);
            let lengths = (face.cross.length_squared() * new.length_squared()).sqrt();
            face.cross.dot(new) < self.min_cosine * lengths
        });
        if turns_too_far { Err(Refusal::NormalTurn) } else { Ok(()) }
    }
}
