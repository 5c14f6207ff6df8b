//! How much memory the content of a file may take.

use crate::error::{Location, ReadErrorKind};

/// What every file may take, however small.
pub(crate) const FLOOR: u64 = 64 << 20;
/// What each byte of the file, and of the files that it refers to, may take beside.
pub(crate) const PER_BYTE: u64 = 60;
/// A list that grows has twice the room that it needs, and its old place while it moves to it.
pub(crate) const GROWING: u64 = 3;

/// The account of the memory that a model takes, kept by the readers as they go.
pub(crate) struct Budget {
    /// The limit that the caller has set.
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

    /// Takes note of memory that is needed, before it is taken; `size` are the bytes of the file.
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

    /// Whether there is room for memory that will be taken note of as it is filled.
    pub(crate) fn require(
        &self,
        bytes: u64,
        size: u64,
        at: impl FnOnce() -> Location,
    ) -> Result<(), ReadErrorKind> {
        let needed = self.spent.saturating_add(bytes);
        let by_size =
            || FLOOR.saturating_add(size.saturating_add(self.others).saturating_mul(PER_BYTE));
        let limit = self.limit.unwrap_or_else(by_size);
        if needed <= limit {
            return Ok(());
        }
        Err(ReadErrorKind::Memory { at: at(), needed, limit })
    }
}
