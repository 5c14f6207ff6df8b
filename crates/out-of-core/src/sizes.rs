//! How much fits into memory.

use serde::{Deserialize, Serialize};
use simplify::{Metric, Options};

use crate::error::Error;

/// How many faces are held at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sizes {
    /// The faces of a region, about.
    pub region_faces: u64,
    /// The faces with which the rest is done in one piece.
    pub rest_faces: u64,
    /// Bytes for what streams by.
    pub stream: u64,
}

/// The bytes that may be taken, for what goes through a mesh without changing it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Memory {
    usable: u64,
}

impl Memory {
    pub(crate) fn new(given: u64) -> Result<Self, Error> {
        let usable = given.saturating_sub(BASE) * 8 / 10;
        if given < LEAST_MEMORY {
            return Err(Error::TooLittleMemory { given, least: LEAST_MEMORY });
        }
        Ok(Self { usable })
    }

    /// The error of what needs so many bytes at a time.
    pub(crate) fn too_little(self, needed: u64) -> Error {
        let total = |usable: u64| BASE + usable / 8 * 10;
        Error::TooLittleMemory { given: total(self.usable), least: total(needed) }
    }

    /// Bytes for what streams by.
    pub(crate) fn stream(self) -> u64 {
        self.usable / 4
    }

    /// The binary logarithm of the number of cells in which so many faces fit.
    pub(crate) fn depth(self, faces: u64, bytes_per_face: u64) -> u32 {
        let each = (self.usable / bytes_per_face).max(1);
        faces.div_ceil(each).next_power_of_two().trailing_zeros()
    }
}

/// What the process takes whatever the mesh is, in bytes.
const BASE: u64 = 24 << 20;
/// The bytes that a face of a region takes while it is split off, collapsed, or joined.
const PER_REGION_FACE: u64 = 250;
/// The bytes that a face of the rest takes: where it goes on in regions, and where it does not.
const PER_REST_FACE: [u64; 2] = [260, 560];
/// What it takes besides where collapses are recorded, since several results are made of them.
const PER_RECORDED_FACE: u64 = 100;
/// No region is smaller than this: rims would be most of it.
const LEAST: u64 = 4096;
/// Nothing is done in less memory.
const LEAST_MEMORY: u64 = BASE + LEAST * PER_REST_FACE[1] * 10 / 4;

impl Sizes {
    /// What fits into so many bytes, with one result or several of them, and distances proved or not.
    ///
    /// # Errors
    /// It is not even enough for the smallest regions.
    pub fn within(
        memory: u64,
        options: &Options,
        results: usize,
        prove: bool,
    ) -> Result<Self, Error> {
        // Proofs have the surface before and after a pass, and the trees over both.
        let share = if prove { 4 } else { 8 };
        let usable = memory.saturating_sub(BASE) * share / 10;
        let rest = PER_REST_FACE[usize::from(options.cost.metric == Metric::Hybrid)]
            + if results > 1 { PER_RECORDED_FACE } else { 0 };
        let region_faces = usable / PER_REGION_FACE;
        if memory < LEAST_MEMORY {
            return Err(Error::TooLittleMemory { given: memory, least: LEAST_MEMORY });
        }
        Ok(Self { region_faces, rest_faces: usable / rest, stream: usable / 2 })
    }

    /// The binary logarithm of the number of cells in which so many faces fit.
    pub(crate) fn depth(&self, faces: u64) -> u32 {
        faces.div_ceil(self.region_faces.max(1)).next_power_of_two().trailing_zeros()
    }
}
