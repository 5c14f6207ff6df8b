//! Parameters of irregular meshes.

use crate::error::ShapeError;
use mesh_core::SplitMix64;

/// The irregularity of a mesh, reproducible from the seed.
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
    /// The largest jitter. Moving the corners of a unit right triangle by j in both directions keeps at least 1 - 4j of
    /// its area, and in a row staggered by half a step at least 1 - 5j: below one fifth, no triangle of the parameters
    /// is reversed.
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

    /// The generator with its initial state.
    pub(crate) fn random(self) -> SplitMix64 {
        SplitMix64::new(self.seed)
    }
}
