//! Errors of rendering.

/// The reason why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The picture has no pixels, or too many.
    #[error(
        "a picture of {width} by {height} pixels cannot be made; both sides take from 1 to {largest}"
    )]
    Size {
        /// Its width in pixels.
        width: u64,
        /// Its height in pixels.
        height: u64,
        /// The longest side.
        largest: u32,
    },
    /// Samples per pixel and direction out of range.
    #[error("{0} samples per pixel and direction; give from 1 to 8")]
    Supersampling(u32),
    /// A strength of the ambient occlusion out of range.
    #[error("an occlusion of {0}; give from 0 to 1")]
    Occlusion(f64),
    /// A width or a margin that is not a number, or negative.
    #[error("{what} is {value}; give a number that is not negative")]
    Measure {
        /// The name of the measure.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// A map has too few entries.
    #[error("{what} has {found} entries, but the mesh has {expected} {of}")]
    Length {
        /// The map.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The kind of element that it describes.
        of: &'static str,
        /// The number of such elements.
        expected: usize,
    },
    /// A sheet without pictures.
    #[error("a sheet needs at least one picture")]
    NoPictures,
    /// A picture of a material is broken, or larger than its header states.
    #[error("the texture {name:?} cannot be read: {source}")]
    Texture {
        /// The name or the location of the picture.
        name: String,
        /// The cause.
        source: Box<image::ImageError>,
    },
    /// The picture could not be encoded.
    #[error("the picture cannot be encoded: {0}")]
    Encode(#[from] Box<image::ImageError>),
}
