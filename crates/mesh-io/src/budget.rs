//! Limits of the memory for the content of a file.

use crate::error::{Location, ReadErrorKind};

/// The memory that any file may use, independent of its size.
pub(crate) const FLOOR: u64 = 64 << 20;
/// The additional memory for each byte of the file and of the files that it refers to.
pub(crate) const PER_BYTE: u64 = 60;
/// A growing list has twice its needed capacity, and its old memory while it is moved.
pub(crate) const GROWING: u64 = 3;

/// The memory account of a model, updated by the readers.
pub(crate) struct Budget {
    /// The limit set by the caller.
    limit: Option<u64>,
    spent: u64,
    /// The bytes of the files that the content refers to.
    others: u64,
}

impl Budget {
    pub(crate) fn new(limit: Option<u64>) -> Self {
        Self { limit, spent: 0, others: 0 }
    }

    /// Counts a file that the content refers to.
    #[cfg(any(feature = "obj", feature = "gltf"))]
    pub(crate) fn add_file(&mut self, bytes: u64) {
        self.others = self.others.saturating_add(bytes);
    }

    /// Records memory before it is allocated; `size` is the size of the file.
    pub(crate) fn spend(
        &mut self,
        bytes: u64,
        size: u64,
        at: impl FnOnce() -> Location,
    ) -> Result<(), ReadErrorKind> {
        self.require(bytes, size, at)?;
        self.spent = self.spent.saturating_add(bytes);
        Ok(())
    }

    fn limit(&self, size: u64) -> u64 {
        let by_size =
            || FLOOR.saturating_add(size.saturating_add(self.others).saturating_mul(PER_BYTE));
        self.limit.unwrap_or_else(by_size)
    }

    /// The memory that a file of this size may still use.
    #[cfg(feature = "gltf")]
    pub(crate) fn left(&self, size: u64) -> u64 {
        self.limit(size).saturating_sub(self.spent)
    }

    /// Checks that memory is available which will be recorded as it is filled.
    pub(crate) fn require(
        &self,
        bytes: u64,
        size: u64,
        at: impl FnOnce() -> Location,
    ) -> Result<(), ReadErrorKind> {
        let (needed, limit) = (self.spent.saturating_add(bytes), self.limit(size));
        if needed <= limit {
            return Ok(());
        }
        Err(ReadErrorKind::Memory { at: at(), needed, limit })
    }
}
