//! The properties of a streamed mesh that a writer needs in advance.

/// The properties of a mesh that must be known before it is streamed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Passing {
    /// The number of vertices.
    pub vertices: u64,
    /// The number of faces.
    pub faces: u64,
    /// The number of triangles that the faces are cut into: for each face, its number of corners minus two.
    pub triangles: u64,
    /// The largest number of corners of a face.
    pub longest: u32,
    /// Whether each coordinate is exact with 32 bits.
    pub single: bool,
    /// Whether vertices have colours.
    pub colors: bool,
    /// The names of the named numbers of vertices, each with a flag whether all of them are exact with 32 bits. Names
    /// must be single words, and must not be names that PLY uses for other data.
    pub scalars: Vec<(String, bool)>,
}

/// The colour of vertices without a colour.
pub const NO_COLOR: [u8; 4] = [0; 4];
