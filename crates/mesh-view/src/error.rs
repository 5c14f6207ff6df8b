//! Errors of pages.

/// The reason why a page cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// There is no mesh.
    #[error("a page needs at least one mesh")]
    NoMeshes,
    /// A mesh has no face that can be drawn.
    #[error(
        "{name}: there are no faces to show: it has none, or each has a vertex that is not finite"
    )]
    NoFaces {
        /// The mesh.
        name: String,
    },
    /// The length of a list does not match the elements that it describes.
    #[error("{name}: {what} has {found} entries, but there are {expected} {of}")]
    Length {
        /// The mesh.
        name: String,
        /// The list.
        what: String,
        /// Its length.
        found: usize,
        /// The elements that it describes.
        of: &'static str,
        /// The number of elements of this kind.
        expected: usize,
    },
    /// A face refers to a missing vertex, material or picture.
    #[error("{name}: {what} {index} refers to number {value}, but there are only {count}")]
    Index {
        /// The mesh.
        name: String,
        /// The kind of element that holds the reference.
        what: &'static str,
        /// The index of this element.
        index: usize,
        /// The value of the reference.
        value: u32,
        /// The number of elements that it could refer to.
        count: usize,
    },
    /// The content of a file is inconsistent.
    #[error("{name}: {source}")]
    Model {
        /// The mesh.
        name: String,
        /// The inconsistency.
        source: mesh_io::ModelError,
    },
}
