//! Why a mesh cannot be refined.

use mesh_metric::SurfaceError;

/// Why a mesh cannot be refined as asked.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RefineError {
    /// An option is out of range.
    #[error("{option} is {value}, but it must be {expected}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// Value that was given.
        value: f64,
        /// Range of valid values.
        expected: &'static str,
    },
    /// The reference surface cannot be searched for closest points.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// There are more attribute values per corner than the crate can track.
    #[error(
        "there are {channels} values per corner, but at most {most} are supported; leave some out"
    )]
    Channels {
        /// Values per corner.
        channels: usize,
        /// Largest supported number, [`MAX_CHANNELS`](crate::MAX_CHANNELS).
        most: usize,
    },
}

impl RefineError {
    /// An error unless the value of an option is in range.
    ///
    /// # Errors
    /// `fits` is false.
    pub fn unless(
        fits: bool,
        option: &'static str,
        value: f64,
        expected: &'static str,
    ) -> Result<(), Self> {
        if fits { Ok(()) } else { Err(Self::Option { option, value, expected }) }
    }
}
