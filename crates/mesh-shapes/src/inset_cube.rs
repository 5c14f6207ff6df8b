//! The cube with pulled-in face centres of Brink, Alboul and Rodrigues 2006, Fig. 4.

use crate::error::ShapeError;
use crate::polyhedra::{CUBE_CORNERS, CUBE_SIDES, triangles};
use glam::DVec3;
use mesh_core::{PolygonSoup, as_u32};

/// The cube [-1, 1]³ with a vertex at each face's centre, pulled in by `inset`; each face is a
/// fan of four triangles around its centre. Its area is 24 √(1 + inset²).
///
/// Vertices 0 to 7 are the corners as in [`polyhedra::cube`](crate::polyhedra::cube), 8 to 13
/// the centres of the sides -x, +x, -y, +y, -z, +z.
///
/// # Errors
/// An inset below zero, at least one (where the centres meet), or not a number.
pub fn inset_cube(inset: f64) -> Result<PolygonSoup, ShapeError> {
    if !(0.0..1.0).contains(&inset) {
        return Err(ShapeError::OutOfRange {
            what: "the inset of the face centres",
            value: inset,
            least: 0.0,
            upper: "below",
            limit: 1.0,
        });
    }
    let mut points: Vec<DVec3> =
        CUBE_CORNERS.iter().map(|corner| DVec3::from(corner.map(f64::from))).collect();
    let mut faces = Vec::with_capacity(24);
    for side in CUBE_SIDES {
        let centre = as_u32(points.len());
        let middle = side.iter().map(|&corner| points[corner as usize]).sum::<DVec3>() / 4.0;
        points.push((1.0 - inset) * middle);
        for (i, &corner) in side.iter().enumerate() {
            faces.push([corner, side[(i + 1) % 4], centre]);
        }
    }
    Ok(triangles(&points, &faces))
}
