//! Elements of a file that is read as a stream.

use glam::DVec3;
use std::ops::ControlFlow;

/// An element of a file, in the order of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Item<'a> {
    /// A vertex: the first is number 0. It need not come before the faces that use it.
    Vertex(DVec3),
    /// A face by the numbers of its three or more vertices.
    Face(&'a [u64]),
    /// A face of a format without vertices of its own, STL, by the positions of its corners. Equal
    /// positions, 0 and -0 included, are one vertex.
    Facet(&'a [DVec3]),
}

/// Where the items go; `Break` ends the scan.
pub(crate) type Visit<'v> = dyn FnMut(Item<'_>) -> ControlFlow<()> + 'v;
