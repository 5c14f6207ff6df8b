//! Why a mesh cannot be simplified.

use glam::DVec3;
use mesh_core::VertexId;
use mesh_core::edit::CollapseRefusal;
use mesh_metric::SurfaceError;

/// Why a mesh cannot be simplified as asked.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimplifyError {
    /// An option has a value that makes no sense.
    #[error("{option} is {value}, but it must be {expected}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        expected: &'static str,
    },
    /// Two options exclude each other.
    #[error("{option} does not go with {with}: {cure}")]
    Conflict {
        /// The option.
        option: &'static str,
        /// What it does not go with.
        with: &'static str,
        /// What would help.
        cure: &'static str,
    },
    /// A position is infinite or not a number.
    #[error("{vertex:?} is at {position}, which is not finite; remove it or give it a place")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
        /// Its position.
        position: DVec3,
    },
    /// The distance between the surfaces cannot be measured.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A log of collapses cannot be replayed.
    #[error("the collapses are those of another mesh; give the one that they were made on: {0}")]
    OtherMesh(#[from] CollapseRefusal),
}
