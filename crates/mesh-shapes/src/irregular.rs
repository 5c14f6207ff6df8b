//! How the irregular families of meshes are made irregular.

use crate::error::ShapeError;
use mesh_core::SplitMix64;

/// The disorder of an irregular mesh, the same for the same seed.
///
/// On shapes meshed over a lattice of parameters every vertex is moved by up to `jitter` lattice
/// steps in both parameters (vertices on a border only along it) and every cell gets a random
/// diagonal. On the icosphere every vertex is moved by up to `jitter` mean edge lengths in each
/// coordinate and put back on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Irregular {
    /// Largest displacement, in lattice steps or mean edge lengths, from 0 to
    /// [`Irregular::MAX_JITTER`].
    pub jitter: f64,
    /// Seed of the [`SplitMix64`] generator.
    pub seed: u64,
}

impl Default for Irregular {
    fn default() -> Self {
        Self { jitter: Self::MAX_JITTER, seed: 1 }
    }
}

impl Irregular {
    /// The largest jitter. Moving the corners of a unit right triangle by j in both directions
    /// leaves it at least 1 - 4j of its area, and one of a row staggered by half a step
    /// 1 - 5j: no triangle of the parameters turns over below one fifth.
    pub const MAX_JITTER: f64 = 0.2;

    /// Refuses a jitter outside the allowed range.
    pub(crate) fn checked(self) -> Result<Self, ShapeError> {
        if (0.0..=Self::MAX_JITTER).contains(&self.jitter) {
            return Ok(self);
        }
        Err(ShapeError::OutOfRange {
            what: "jitter",
            value: self.jitter,
            least: 0.0,
            upper: "at most",
            limit: Self::MAX_JITTER,
        })
    }

    /// The generator at its start.
    pub(crate) fn random(self) -> SplitMix64 {
        SplitMix64::new(self.seed)
    }
}
