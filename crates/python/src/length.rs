//! Lengths: numbers in model units, or shares of the diagonal of the bounding box.

use mesh_core::TriMesh;
use mesh_work::{Length, NoExtent, parse_length};
use pyo3::prelude::*;

use crate::failure::Failure;

/// A length as it is given: a number, or a text such as `"0.2%"`.
#[derive(FromPyObject)]
pub(crate) enum Given {
    Number(f64),
    Text(String),
}

impl Given {
    /// The parsed length.
    pub(crate) fn length(&self, option: &str) -> Result<Length, Failure> {
        let length = match self {
            Self::Number(number) if *number > 0.0 && number.is_finite() => {
                return Ok(Length::Plain(*number));
            }
            Self::Number(number) => Err(format!("expected a length above zero, not {number}")),
            Self::Text(text) => parse_length(text),
        };
        length.map_err(|message| Failure::option(format!("{option}: {message}")))
    }
}

/// The length of an option, if given.
pub(crate) fn length(option: &str, given: Option<Given>) -> Result<Option<Length>, Failure> {
    given.map(|given| given.length(option)).transpose()
}

/// The length in model units.
pub(crate) fn units(
    length: Option<Length>,
    mesh: &TriMesh,
    relative: bool,
) -> Result<Option<f64>, NoExtent> {
    length.map(|length| length.on(mesh, relative)).transpose()
}
