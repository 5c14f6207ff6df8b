//! Elements of a streamed file.

use crate::error::ReadErrorKind;
use glam::DVec3;
use std::ops::ControlFlow;

/// An element of a file, in the order of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Item<'a> {
    /// A vertex; numbers start at 0. Faces may come before their vertices.
    Vertex(DVec3),
    /// A face, given by the numbers of its three or more vertices.
    Face(&'a [u64]),
    /// A face of STL, which has no vertices, or of glTF, which duplicates them, given by the positions of its corners.
    /// Equal positions are one vertex; 0 and -0 are equal.
    Facet(&'a [DVec3]),
}

/// The receiver of the items; `Break` ends the scan.
pub(crate) type Visit<'v> = dyn FnMut(Item<'_>) -> ControlFlow<()> + 'v;

/// The error that ends the reading early because the receiver wants no more; never visible outside.
pub(crate) fn stopped() -> ReadErrorKind {
    ReadErrorKind::Io(std::io::ErrorKind::Interrupted.into())
}
