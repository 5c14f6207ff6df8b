//! Texture coordinates, normals and colours at the corners of faces.
//!
//! **Input:** values at the corners of the original, and the seams where they jump.
//! **Output:** a cost modifier for the run, and for each corner of a result the point of the original whose values it
//! takes.
//!
//! Invariants:
//!
//! - The corners of a wedge share one value. A collapse joins wedges only if they meet in a face of the edge.
//! - Values are never mixed across a seam, neither by the run nor by the transfer.
//! - Values are scaled to model units, so that they can be added to distances.
//!
//! Uses `mesh-collapse` and `mesh-metric`. The module `texture_folds`, one layer above, keeps a fit from folding the
//! texture.
//!
//! Layers, lowest first: `wedges`; `attribute_deviation`, which guides a run, and `transfer`, which evaluates its
//! result.

pub(crate) mod attribute_deviation;
pub(crate) mod transfer;
pub(crate) mod wedges;
