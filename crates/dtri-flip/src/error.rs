//! Why a run cannot start.

/// An option that makes no sense, or does not fit the mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlipError {
    /// The map of locked edges does not have one entry per edge.
    #[error(
        "{given} edges are marked as locked or not, but the mesh has room for {edges}; give one mark for each"
    )]
    LockedLength {
        /// The length of the map.
        given: usize,
        /// The mesh's edge capacity.
        edges: usize,
    },
    /// More flips in a row are to be tried than can be.
    #[error(
        "look_ahead is {given}; it must be at most {limit}, for the effort grows sixfold with each step"
    )]
    LookAhead {
        /// What was given.
        given: usize,
        /// What may be given.
        limit: usize,
    },
    /// A number is out of its range.
    #[error("{option} is {value}; it must be {range}")]
    OutOfRange {
        /// The name of the option.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
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
