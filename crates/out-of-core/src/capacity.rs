//! How many faces fit into memory.

use serde::{Deserialize, Serialize};
use simplify::{Metric, Options};

use crate::error::Error;

/// Limits of the number of faces in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Capacity {
    /// The faces of a region, approximately.
    pub region_faces: u64,
    /// The largest number of faces that is collapsed in memory as one mesh.
    pub in_memory_faces: u64,
    /// Bytes for buffers while faces and vertices are streamed.
    pub stream: u64,
}

/// A memory limit for operations that stream a mesh without changing it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Memory {
    usable: u64,
}

impl Memory {
    pub(crate) fn new(given: u64) -> Result<Self, Error> {
        let usable = tenths(given.saturating_sub(BASE), 8);
        if given < LEAST_MEMORY {
            return Err(Error::TooLittleMemory { given, least: LEAST_MEMORY });
        }
        Ok(Self { usable })
    }

    /// The error of an operation that needs `needed` bytes at the same time.
    pub(crate) fn too_little(self, needed: u64) -> Error {
        let total = |usable: u64| (usable / 8).saturating_mul(10).saturating_add(BASE);
        Error::TooLittleMemory { given: total(self.usable), least: total(needed) }
    }

    /// Bytes for buffers while faces and vertices are streamed.
    pub(crate) fn stream(self) -> u64 {
        self.usable / 4
    }

    /// The binary logarithm of the number of cells for `faces` faces.
    pub(crate) fn depth(self, faces: u64, bytes_per_face: u64) -> Result<u32, Error> {
        let depth = depth_of(faces, self.usable / bytes_per_face);
        let least = || (faces >> DEEPEST).saturating_mul(bytes_per_face);
        if depth <= DEEPEST { Ok(depth) } else { Err(self.too_little(least())) }
    }
}

/// The binary logarithm of the largest number of cells.
const DEEPEST: u32 = 20;

/// The binary logarithm of the number of cells with `of_each` faces each, rounded up.
fn depth_of(faces: u64, of_each: u64) -> u32 {
    let cells = faces.div_ceil(of_each.max(1)).max(1);
    u64::BITS - (cells - 1).leading_zeros()
}

/// `tenths` tenths of a number, ten at most.
fn tenths(number: u64, tenths: u8) -> u64 {
    // Ten tenths are the number itself, so that the quotient fits.
    (u128::from(number) * u128::from(tenths.min(10)) / 10) as u64
}

/// The bytes that the process needs apart from the mesh.
const BASE: u64 = 24 << 20;
/// The bytes per face of a region while it is split off, collapsed, or joined.
const PER_REGION_FACE: u64 = 250;
/// The bytes per face while the mesh is collapsed as a whole: in blocks, and in the order of costs.
const PER_REST_FACE: [u64; 2] = [260, 560];
/// The additional bytes per face when collapses are recorded, as for several results.
const PER_RECORDED_FACE: u64 = 100;
/// No region is smaller than this: it would mostly be boundary.
const LEAST: u64 = 4096;
/// The smallest memory limit.
const LEAST_MEMORY: u64 = BASE + LEAST * PER_REST_FACE[1] * 10 / 4;

impl Capacity {
    /// The capacity within `memory` bytes, for a number of results, with or without proofs of distances.
    ///
    /// # Errors
    /// The smallest regions do not fit.
    pub fn within(
        memory: u64,
        options: &Options,
        results: usize,
        prove: bool,
    ) -> Result<Self, Error> {
        // A proof holds the surface before and after a pass, and a tree over each.
        let share = if prove { 4 } else { 8 };
        let usable = tenths(memory.saturating_sub(BASE), share);
        let rest = PER_REST_FACE[usize::from(options.cost.metric == Metric::Hybrid)]
            + if results > 1 { PER_RECORDED_FACE } else { 0 };
        let region_faces = usable / PER_REGION_FACE;
        if memory < LEAST_MEMORY {
            return Err(Error::TooLittleMemory { given: memory, least: LEAST_MEMORY });
        }
        Ok(Self { region_faces, in_memory_faces: usable / rest, stream: usable / 2 })
    }

    /// The binary logarithm of the number of cells for `faces` faces.
    pub(crate) fn depth(&self, faces: u64) -> u32 {
        depth_of(faces, self.region_faces)
    }

    /// As [`Capacity::depth`], for an input.
    pub(crate) fn checked_depth(&self, faces: u64) -> Result<u32, Error> {
        let depth = self.depth(faces);
        let region_faces = self.region_faces;
        if depth <= DEEPEST {
            Ok(depth)
        } else {
            Err(Error::TooManyRegions { faces, region_faces })
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn no_number_overflows() {
        for memory in [LEAST_MEMORY, 1 << 40, u64::MAX] {
            let options = Options::default();
            let capacity = Capacity::within(memory, &options, 3, true).unwrap();
            assert!(capacity.region_faces <= memory / PER_REGION_FACE);
            let streaming = Memory::new(memory).unwrap();
            assert!(streaming.usable < memory && streaming.depth(100, 330).unwrap() == 0);
            assert!(matches!(streaming.too_little(u64::MAX), Error::TooLittleMemory { .. }));
        }
        let small = Capacity { region_faces: 1, in_memory_faces: 1, stream: 0 };
        assert_eq!([1, 2, 3, 1024].map(|faces| small.depth(faces)), [0, 1, 2, 10]);
        assert!(matches!(small.checked_depth(u64::MAX), Err(Error::TooManyRegions { .. })));
        assert!(Memory::new(LEAST_MEMORY).unwrap().depth(u64::MAX, 330).is_err());
    }
}
