//! Texture coordinates, normals and colours at the corners of faces.
//!
//! **In:** values at the corners of the original, and the seams where they jump.
//! **Out:** a cost modifier by which a run respects them, and for each corner of a result the point of the
//! original whose values it takes.
//!
//! Invariants:
//!
//! - Corners of one wedge have one value; a collapse joins wedges only where they meet in a face of
//!   the edge.
//! - Nothing is mixed across a seam: not by the run, and not by the transfer.
//! - Values are scaled to model units, so that they add up with distances.
//!
//! Uses the `collapse` room and `mesh-metric`. What a fit must not do to a texture is told by the
//! `finish` room, which is above this one.
//!
//! From the bottom: `wedges`, with `attribute_deviation` on top, which steers a run; and beside them
//! `transfer`, which looks at its result.

pub(crate) mod attribute_deviation;
pub(crate) mod transfer;
pub(crate) mod wedges;
