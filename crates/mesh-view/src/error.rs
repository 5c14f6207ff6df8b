//! Why there is no page.

/// What is wrong with what was to be shown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// Nothing to show.
    #[error("a page needs at least one mesh")]
    NoMeshes,
    /// A mesh without a face that can be drawn.
    #[error("{name}: there are no faces to show")]
    NoFaces {
        /// The mesh.
        name: String,
    },
    /// A list is longer or shorter than what it describes.
    #[error("{name}: {what} has {found} entries, but there are {expected} {of}")]
    Length {
        /// The mesh.
        name: String,
        /// The list.
        what: String,
        /// Its length.
        found: usize,
        /// What it describes.
        of: &'static str,
        /// How many there are of those.
        expected: usize,
    },
    /// A face refers to a vertex, or to a material or picture, that is not there.
    #[error("{name}: {what} {index} refers to number {value}, but there are only {count}")]
    Index {
        /// The mesh.
        name: String,
        /// What refers.
        what: &'static str,
        /// Which one of them.
        index: usize,
        /// To what.
        value: u32,
        /// How many there are.
        count: usize,
    },
    /// The content of a file contradicts itself.
    #[error("{name}: {source}")]
    Model {
        /// The mesh.
        name: String,
        /// The contradiction.
        source: mesh_io::ModelError,
    },
}
