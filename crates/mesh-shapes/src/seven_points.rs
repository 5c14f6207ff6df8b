//! The seven points in convex position of Dyn, Hormann, Kim and Levin 2001, Fig. 4.
//!
//! The ten triangles of the figure are not the convex hull, but a local minimum of the costs F1, F2 and F3 under single
//! flips. (The minus signs and fractions of the coordinates are hard to read in print; with these coordinates, the
//! statement holds.)

use crate::polyhedra::triangles;
use glam::DVec3;
use mesh_core::PolygonSoup;

const POINTS: [DVec3; 7] = [
    DVec3::new(-12.0, 0.0, 0.0),
    DVec3::new(-10.0, -2.0, -0.1),
    DVec3::new(0.0, -2.5, -0.5),
    DVec3::new(10.0, -2.0, -0.2),
    DVec3::new(12.0, 0.0, 0.0),
    DVec3::new(0.0, 2.5, -0.5),
    DVec3::new(0.0, 0.0, -10.0),
];

/// The triangulation of the figure's upper half, which is not convex. Vertex `i` is the paper's
/// v(i + 1).
#[must_use]
pub fn given() -> PolygonSoup {
    triangles(
        &POINTS,
        &[
            [0, 1, 2],
            [2, 3, 4],
            [0, 2, 5],
            [2, 4, 5],
            [6, 1, 0],
            [6, 2, 1],
            [6, 3, 2],
            [6, 4, 3],
            [6, 5, 4],
            [6, 0, 5],
        ],
    )
}

/// The convex hull, three flips away from [`given`].
#[must_use]
pub fn convex() -> PolygonSoup {
    triangles(
        &POINTS,
        &[
            [0, 1, 4],
            [0, 4, 5],
            [0, 5, 6],
            [0, 6, 1],
            [1, 2, 3],
            [1, 3, 4],
            [1, 6, 2],
            [2, 6, 3],
            [3, 6, 4],
            [4, 6, 5],
        ],
    )
}
