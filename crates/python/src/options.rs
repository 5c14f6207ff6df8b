//! Options shared by several functions.

use std::time::Duration;

use curvpatch::Params;
use dcurv::VertexArea;

use crate::failure::{Failure, choose};

/// An angle in degrees, as radians.
pub(crate) fn angle(option: &str, degrees: Option<f64>) -> Result<Option<f64>, Failure> {
    match degrees {
        Some(degrees) if !(0.0..=180.0).contains(&degrees) => {
            Err(Failure::option(format!("{option} is {degrees}; it must be from 0 to 180 degrees")))
        }
        other => Ok(other.map(f64::to_radians)),
    }
}

/// A number that is finite and not negative.
pub(crate) fn not_negative(option: &str, value: Option<f64>) -> Result<Option<f64>, Failure> {
    match value {
        Some(value) if !(value >= 0.0 && value.is_finite()) => {
            Err(Failure::option(format!("{option} is {value}; it must be at least 0 and finite")))
        }
        other => Ok(other),
    }
}

pub(crate) fn seconds(option: &str, value: Option<f64>) -> Result<Option<Duration>, Failure> {
    let duration = |value| {
        Duration::try_from_secs_f64(value).map_err(|_| {
            Failure::option(format!("{option} is {value}; it must be a time in seconds"))
        })
    };
    value.map(duration).transpose()
}

pub(crate) fn area(name: &str) -> Result<VertexArea, Failure> {
    let choices = [("voronoi", VertexArea::Voronoi), ("barycentric", VertexArea::Barycentric)];
    choose("area", name, &choices)
}

/// How curvature is computed from normal sections.
pub(crate) fn sections(preset: &str) -> Result<Params, Failure> {
    choose("preset", preset, &[("robust", Params::robust()), ("paper", Params::paper())])
}
