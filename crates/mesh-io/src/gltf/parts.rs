//! Places in a document, items of its lists, and parts of its buffers.

use crate::error::{Location, ReadErrorKind};
use std::sync::Arc;

pub(crate) fn at(path: &str) -> Location {
    Location::Json(path.to_owned())
}

/// The error of an index that is out of range.
pub(crate) fn no_such(path: &str, what: &str, index: u32, count: usize) -> ReadErrorKind {
    ReadErrorKind::malformed(at(path), format!("one of {count} {what}"), index.to_string())
}

/// The element at an index.
pub(crate) fn item<'d, T>(
    all: &'d [T],
    index: u32,
    what: &str,
    path: &str,
) -> Result<&'d T, ReadErrorKind> {
    all.get(index as usize).ok_or_else(|| no_such(path, what, index, all.len()))
}

/// The bytes of a buffer: a prefix of a file, which several buffers may share.
#[derive(Clone, Default)]
pub(crate) struct Bytes {
    pub all: Arc<Vec<u8>>,
    pub length: usize,
}

impl Bytes {
    pub(crate) fn get(&self) -> &[u8] {
        self.all.get(..self.length).unwrap_or_default()
    }
}

/// A part of a buffer.
pub(super) fn part(
    buffer: &[u8],
    start: u64,
    length: u64,
    place: impl FnOnce() -> Location,
) -> Result<&[u8], ReadErrorKind> {
    let bytes = usize::try_from(start)
        .ok()
        .zip(usize::try_from(start.saturating_add(length)).ok())
        .and_then(|(start, end)| buffer.get(start..end));
    bytes.ok_or_else(|| {
        let expected = format!("a view within the {} bytes of its buffer", buffer.len());
        ReadErrorKind::malformed(place(), expected, format!("{length} bytes from {start}"))
    })
}
