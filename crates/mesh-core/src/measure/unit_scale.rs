//! Meshes of extreme size, brought to unit size by a power of two.
//!
//! Algorithms multiply lengths. With coordinates of 1e80, such products overflow; with 1e-100, they vanish. A factor
//! that is a power of two changes no digit, so the results for a scaled mesh are the scaled results, bit for bit.

use glam::DVec3;

use crate::measure::bounding_box::BoundingBox;
use crate::mesh::TriMesh;
use crate::topology::handle::{Handle, VertexId};

/// A power of two that brings a mesh to a size between 1 and 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitScale {
    factor: f64,
}

/// The size of a mesh leaves too few digits.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScaleError {
    /// Coordinates are close to the smallest or to the largest numbers.
    #[error(
        "the largest coordinate is {largest:e}; meshes need a size between 1e-288 and 1e300; scale the mesh"
    )]
    Range {
        /// The largest coordinate.
        largest: f64,
    },
    /// The coordinates of one mesh differ in size by more than numbers can express.
    #[error(
        "{vertex:?} is at {position:?}, but the largest coordinate is {largest:e}; numbers cannot hold both at one scale; remove the vertex, or set its small coordinates to 0"
    )]
    Spread {
        /// The vertex.
        vertex: VertexId,
        /// Its position.
        position: DVec3,
        /// The largest coordinate.
        largest: f64,
    },
    /// Areas and curvatures of the mesh are not numbers.
    #[error(
        "the largest coordinate is {largest:e}; areas and curvatures need a size between 1e-150 and 1e150; scale the mesh"
    )]
    Areas {
        /// The largest coordinate.
        largest: f64,
    },
}

/// Meshes whose largest coordinate has a binary exponent up to this, in absolute value, are not scaled.
const ORDINARY: i32 = 40;
/// The smallest binary exponent of the largest coordinate at which all coordinates have their digits.
const SMALLEST: i32 = -957;
/// The largest one at which results may lie outside the bounding box.
const LARGEST: i32 = 997;
/// The largest binary exponent, in absolute value, at which areas and their reciprocals are numbers.
const LARGEST_OF_AREAS: i32 = 500;

impl UnitScale {
    /// The scale of a mesh, from the vertices with faces. `None` if its size is ordinary, up to 1e12 and down to 1e-12,
    /// or zero.
    ///
    /// # Errors
    /// The coordinates are too small to be exact, or too large for results.
    pub fn of(mesh: &TriMesh) -> Result<Option<Self>, ScaleError> {
        let Some(bounds) = mesh.bounding_box() else { return Ok(None) };
        let (largest, exponent) = size(bounds);
        match exponent {
            _ if exponent.abs() <= ORDINARY => Ok(None),
            SMALLEST..=LARGEST => Ok(Some(Self { factor: f64::from(-exponent).exp2() })),
            _ => Err(ScaleError::Range { largest }),
        }
    }

    /// As [`UnitScale::of`], for results with areas or curvatures.
    ///
    /// # Errors
    /// Areas or curvatures of a mesh of this size overflow or vanish.
    pub fn with_areas(mesh: &TriMesh) -> Result<Option<Self>, ScaleError> {
        let scale = Self::of(mesh)?;
        match mesh.bounding_box().map(size) {
            Some((largest, exponent)) if exponent.abs() > LARGEST_OF_AREAS => {
                Err(ScaleError::Areas { largest })
            }
            _ => Ok(scale),
        }
    }

    /// The scaled mesh, with the handles of the original.
    ///
    /// # Errors
    /// A coordinate has no exact scaled value.
    pub fn mesh(self, mesh: &TriMesh) -> Result<TriMesh, ScaleError> {
        let mut scaled = mesh.clone();
        self.apply(scaled.positions_mut(), mesh)?;
        Ok(scaled)
    }

    fn apply(self, scaled: &mut [DVec3], mesh: &TriMesh) -> Result<(), ScaleError> {
        for (index, p) in scaled.iter_mut().enumerate() {
            let position = *p;
            *p *= self.factor;
            if !p.is_finite() || self.original_point(*p) != position {
                let vertex = VertexId::from_index(index);
                // Removed vertices keep stale positions.
                if mesh.topology().contains_vertex(vertex) {
                    let largest = mesh.bounding_box().map_or(0.0, |bounds| size(bounds).0);
                    return Err(ScaleError::Spread { vertex, position, largest });
                }
                *p = DVec3::ZERO;
            }
        }
        Ok(())
    }

    /// A scaled length.
    #[must_use]
    pub fn length(self, length: f64) -> f64 {
        length * self.factor
    }

    /// A scaled power of a length, such as an area (2) or a curvature (-1).
    #[must_use]
    pub fn power(self, value: f64, exponent: i32) -> f64 {
        // One factor after the other: a power of the factor may overflow although the product does not.
        (0..exponent.unsigned_abs()).fold(value, |value, _| match exponent > 0 {
            true => value * self.factor,
            false => value / self.factor,
        })
    }

    /// The length in the original mesh of a length in the scaled mesh.
    #[must_use]
    pub fn original_length(self, scaled: f64) -> f64 {
        scaled / self.factor
    }

    /// The value in the original mesh of a power of a length in the scaled mesh.
    #[must_use]
    pub fn original_power(self, scaled: f64, exponent: i32) -> f64 {
        self.power(scaled, -exponent)
    }

    /// The point in the original mesh.
    #[must_use]
    pub fn original_point(self, scaled: DVec3) -> DVec3 {
        scaled / self.factor
    }

    /// Brings a result from the scaled mesh back to the size of the original.
    pub fn restore(self, positions: &mut [DVec3]) {
        positions.iter_mut().for_each(|p| *p = self.original_point(*p));
    }
}

/// The largest coordinate and its binary exponent; 0 for a box at the origin.
fn size(bounds: BoundingBox) -> (f64, i32) {
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    // Exact, unlike the logarithm. Numbers without a leading digit have exponent -1023.
    #[allow(clippy::cast_possible_truncation, reason = "11 bits")]
    let exponent = ((largest.to_bits() >> 52) & 0x7FF) as i32 - 1023;
    (largest, if largest > 0.0 { exponent } else { 0 })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn mesh(scale: f64, z: f64) -> TriMesh {
        let at = |x: f64, y: f64, z: f64| [x * scale, y * scale, z];
        let positions = [at(0.1, 0.2, z), at(1.7, 0.3, 0.0), at(0.4, 1.1, 0.0)];
        TriMesh::from_triangles(&positions, &[[0, 1, 2]]).unwrap()
    }

    #[test]
    fn a_scaled_mesh_has_the_digits_of_the_original() {
        let unit = mesh(1.0, 0.0);
        for exponent in SMALLEST..=LARGEST {
            let original = mesh(f64::from(exponent).exp2(), 0.0);
            let Some(scale) = UnitScale::of(&original).unwrap() else {
                assert!(exponent.abs() <= ORDINARY, "{exponent}");
                continue;
            };
            let scaled = scale.mesh(&original).unwrap();
            assert_eq!(scaled.positions(), unit.positions(), "{exponent}");
            let mut back = scaled.positions().to_vec();
            scale.restore(&mut back);
            assert_eq!(back, original.positions());
            let length = scale.length(original.position(VertexId::new(1)).x);
            assert_eq!(scale.original_length(length), original.position(VertexId::new(1)).x);
            assert_eq!(scale.power(scale.original_power(3.0, -1), -1), 3.0);
        }
    }

    #[test]
    fn what_has_no_exact_scaled_value_is_refused() {
        for exponent in [SMALLEST - 1, LARGEST + 1] {
            let found = UnitScale::of(&mesh(f64::from(exponent).exp2(), 0.0));
            assert!(matches!(found, Err(ScaleError::Range { .. })), "{found:?}");
        }
        let spread = mesh(f64::from(900).exp2(), 1.0 + f64::EPSILON);
        assert!(UnitScale::of(&spread).unwrap().unwrap().mesh(&spread).is_ok());
        let spread = mesh(f64::from(900).exp2(), f64::from(-300).exp2());
        let error = UnitScale::of(&spread).unwrap().unwrap().mesh(&spread).unwrap_err();
        assert!(matches!(error, ScaleError::Spread { vertex, .. } if vertex.index() == 0));
        for exponent in [-501, 501] {
            let far = UnitScale::with_areas(&mesh(f64::from(exponent).exp2(), 0.0));
            assert!(matches!(far, Err(ScaleError::Areas { .. })), "{far:?}");
        }
        assert!(UnitScale::with_areas(&mesh(1e150, 0.0)).unwrap().is_some());
    }
}
