//! Errors of the options.

use mesh_core::ScaleError;

/// An option is out of range or does not fit the mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlipError {
    /// The map of locked edges does not have one entry per edge.
    #[error(
        "the map of locked edges has {given} entries, but the mesh has {edges} edges; give one entry per edge"
    )]
    LockedLength {
        /// The length of the map.
        given: usize,
        /// The mesh's edge capacity.
        edges: usize,
    },
    /// The look-ahead is too large.
    #[error(
        "look_ahead is {given}; it must be at most {limit}, because each step multiplies the effort by 6"
    )]
    LookAhead {
        /// The given value.
        given: usize,
        /// The largest allowed value.
        limit: usize,
    },
    /// A number is out of range.
    #[error("{option} is {value}; it must be {range}")]
    OutOfRange {
        /// Name of the option.
        option: &'static str,
        /// The given value.
        value: f64,
        /// The allowed range.
        range: &'static str,
    },
    /// The size of the mesh leaves too few digits.
    #[error(transparent)]
    Scale(#[from] ScaleError),
}

impl FlipError {
    /// Accepts an angle in radians from 0 to pi.
    pub(crate) fn check_angle(option: &'static str, value: Option<f64>) -> Result<(), Self> {
        match value {
            Some(value) if !(0.0..=core::f64::consts::PI).contains(&value) => {
                Err(Self::OutOfRange { option, value, range: "an angle from 0 to pi" })
            }
            _ => Ok(()),
        }
    }
}
