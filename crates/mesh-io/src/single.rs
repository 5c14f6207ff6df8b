//! Rounding of coordinates to 32 bits.

use crate::error::WriteError;
use crate::format::Format;
use crate::lost::Lost;
use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_core::build::has_zero_area;

/// The largest error of a coordinate when stored in 32 bits.
pub(crate) fn rounding(positions: &[DVec3]) -> f64 {
    positions
        .iter()
        .flat_map(DVec3::to_array)
        .map(|value| (value - f64::from(value as f32)).abs())
        .fold(0.0, f64::max)
}

/// Whether a face has an area, and has none when its coordinates, less an offset, are stored in 32 bits.
pub(crate) fn is_flattened(corners: &[DVec3], offset: DVec3) -> bool {
    let has_area = |at: &dyn Fn(DVec3) -> DVec3| {
        let [first, ref others @ ..] = *corners else { return false };
        others.windows(2).any(|pair| match *pair {
            [a, b] => !has_zero_area([first, a, b].map(at)),
            _ => false,
        })
    };
    has_area(&|p| p) && !has_area(&|p| (p - offset).as_vec3().as_dvec3())
}

/// The number of faces whose area is lost when their coordinates, less an offset, are stored in 32 bits.
pub(crate) fn flattened_faces(soup: &PolygonSoup, offset: DVec3) -> u64 {
    let mut corners = Vec::new();
    let is_flat = |face: &&[u32]| {
        corners.clear();
        corners.extend(face.iter().filter_map(|&vertex| soup.positions().get(vertex as usize)));
        is_flattened(&corners, offset)
    };
    soup.faces().filter(is_flat).count() as u64
}

/// Names the faces that lose their area, if there are any.
pub(crate) fn flattened(count: u64, format: Format) -> Option<Lost> {
    let others = match format {
        Format::Stl | Format::Gltf | Format::Glb => "PLY, OBJ or OFF",
        Format::Obj | Format::Ply | Format::Off => "double precision",
    };
    let why = format!(
        "coordinates are rounded to single precision, which is too coarse for faces of this size at this \
         place; {others} keeps them"
    );
    (count > 0).then(|| Lost::some("the area of faces", count, why))
}

/// The error for a finite coordinate that is beyond the range of 32-bit numbers, if there is one.
pub(crate) fn check_range(positions: &[DVec3], format: Format) -> Result<(), WriteError> {
    let beyond = |value: &f64| value.is_finite() && !(*value as f32).is_finite();
    match find(positions, beyond) {
        Some((vertex, value)) => Err(WriteError::OutOfSingleRange { format, vertex, value }),
        None => Ok(()),
    }
}

/// The error for a coordinate that is not a finite number, if there is one.
#[cfg(feature = "gltf")]
pub(crate) fn check_finite(positions: &[DVec3], format: Format) -> Result<(), WriteError> {
    match find(positions, |value| !value.is_finite()) {
        Some((vertex, value)) => Err(WriteError::NotFinite { format, vertex, value }),
        None => Ok(()),
    }
}

/// The first coordinate with this property, and its vertex.
fn find(positions: &[DVec3], is_so: impl Fn(&f64) -> bool) -> Option<(usize, f64)> {
    positions.iter().enumerate().find_map(|(vertex, position)| {
        Some((vertex, position.to_array().into_iter().find(&is_so)?))
    })
}

/// Replaces missing values, which are NaN, by another number: readers of other programs cannot handle NaN.
pub(crate) fn finite_or<const N: usize>(values: [f32; N], otherwise: f32) -> [f32; N] {
    values.map(|value| if value.is_finite() { value } else { otherwise })
}

/// Whether all numbers are finite. A number that is not finite stands for a missing value.
pub(crate) fn are_finite<const N: usize>(values: &[f32; N]) -> bool {
    values.iter().all(|value| value.is_finite())
}
