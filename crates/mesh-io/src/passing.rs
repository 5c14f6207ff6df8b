//! What has to be known of a mesh that passes by while it is written.

/// What has to be known of a mesh before it passes by.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Passing {
    /// The vertices.
    pub vertices: u64,
    /// The faces.
    pub faces: u64,
    /// The triangles that these are cut into: two fewer than a face has corners.
    pub triangles: u64,
    /// The most corners that a face has.
    pub longest: u32,
    /// Whether each coordinate is a number of 32 bits.
    pub single: bool,
    /// Whether vertices have colours.
    pub colors: bool,
    /// The named numbers of vertices, and whether all of one are numbers of 32 bits. Names are words, and none
    /// is one that PLY has for something else.
    pub scalars: Vec<(String, bool)>,
}

/// The colour of vertices that have none.
pub const NO_COLOR: [u8; 4] = [0; 4];
