//! Why a mesh cannot be simplified.

use glam::DVec3;
use mesh_collapse::ReplayError;
use mesh_core::{ScaleError, VertexId};
use mesh_metric::SurfaceError;
use mesh_refine::RefineError;

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
        /// The allowed values.
        expected: &'static str,
    },
    /// Two options exclude each other.
    #[error("{option} does not go with {with}: {cure}")]
    Conflict {
        /// The option.
        option: &'static str,
        /// The conflicting option.
        with: &'static str,
        /// How to resolve the conflict.
        cure: &'static str,
    },
    /// The system has less memory than the collapses need.
    #[error(
        "this takes about {} MiB beside the mesh, but there are {} MiB; ask for fewer faces, take the preset draft, or free memory",
        needed.div_ceil(1 << 20),
        available >> 20
    )]
    Memory {
        /// The bytes that are needed, about; see [`memory_needed`](crate::memory_needed).
        needed: u64,
        /// The bytes that can be had.
        available: u64,
    },
    /// A position is infinite or not a number.
    #[error("{vertex:?} is at {position}, which is not finite; remove it or give it a place")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
        /// Its position.
        position: DVec3,
    },
    /// The importance of a vertex is negative, infinite or not a number.
    #[error("the importance of {vertex:?} is {importance}, but it must be at least 0 and finite")]
    Importance {
        /// The vertex.
        vertex: VertexId,
        /// Its importance.
        importance: f64,
    },
    /// The size of the mesh leaves too few digits.
    #[error(transparent)]
    Scale(#[from] ScaleError),
    /// The distance between the surfaces cannot be measured.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A log of collapses cannot be replayed.
    #[error(transparent)]
    OtherMesh(#[from] ReplayError),
    /// Refinement cannot be carried out as asked.
    #[error(transparent)]
    Refine(RefineError),
}

impl From<RefineError> for SimplifyError {
    fn from(error: RefineError) -> Self {
        match error {
            RefineError::Option { option, value, expected } => {
                Self::Option { option, value, expected }
            }
            RefineError::Surface(error) => Self::Surface(error),
            other => Self::Refine(other),
        }
    }
}

impl SimplifyError {
    /// An error unless the value of an option is as expected.
    pub(crate) fn unless(
        fits: bool,
        option: &'static str,
        value: f64,
        expected: &'static str,
    ) -> Result<(), Self> {
        if fits { Ok(()) } else { Err(Self::Option { option, value, expected }) }
    }
}
