//! The smallest closed meshes.

use glam::DVec3;
use mesh_core::PolygonSoup;

/// The regular tetrahedron on four corners of the cube [-1, 1]³.
#[must_use]
pub fn tetrahedron() -> PolygonSoup {
    fixed(
        &[[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]],
        &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    )
}

/// The regular octahedron with corners at ±1 on the axes.
#[must_use]
pub fn octahedron() -> PolygonSoup {
    fixed(
        &[[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]],
        &[[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
    )
}

/// The cube [-1, 1]³ with each side cut into two triangles. Corner `i` has x, y, z = +1 if bit 0, 1, 2 of `i` is set,
/// else -1.
#[must_use]
pub fn cube() -> PolygonSoup {
    let triangles: Vec<[u32; 3]> =
        CUBE_SIDES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    fixed(&CUBE_CORNERS, &triangles)
}

/// The regular icosahedron with corners on the unit sphere.
#[must_use]
pub fn icosahedron() -> PolygonSoup {
    triangles(&icosahedron_corners(), &ICOSAHEDRON_FACES)
}

pub(crate) const CUBE_CORNERS: [[i32; 3]; 8] = [
    [-1, -1, -1],
    [1, -1, -1],
    [-1, 1, -1],
    [1, 1, -1],
    [-1, -1, 1],
    [1, -1, 1],
    [-1, 1, 1],
    [1, 1, 1],
];

/// Sides -x, +x, -y, +y, -z, +z of the cube, counter-clockwise from outside.
pub(crate) const CUBE_SIDES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

pub(crate) const ICOSAHEDRON_FACES: [[u32; 3]; 20] = [
    [0, 11, 5],
    [0, 5, 1],
    [0, 1, 7],
    [0, 7, 10],
    [0, 10, 11],
    [1, 5, 9],
    [5, 11, 4],
    [11, 10, 2],
    [10, 7, 6],
    [7, 1, 8],
    [3, 9, 4],
    [3, 4, 2],
    [3, 2, 6],
    [3, 6, 8],
    [3, 8, 9],
    [4, 9, 5],
    [2, 4, 11],
    [6, 2, 10],
    [8, 6, 7],
    [9, 8, 1],
];

/// Corners of three golden rectangles in the coordinate planes, scaled to the unit sphere.
pub(crate) fn icosahedron_corners() -> [DVec3; 12] {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let long = golden / (1.0 + golden * golden).sqrt();
    let short = 1.0 / (1.0 + golden * golden).sqrt();
    [
        DVec3::new(-short, long, 0.0),
        DVec3::new(short, long, 0.0),
        DVec3::new(-short, -long, 0.0),
        DVec3::new(short, -long, 0.0),
        DVec3::new(0.0, -short, long),
        DVec3::new(0.0, short, long),
        DVec3::new(0.0, -short, -long),
        DVec3::new(0.0, short, -long),
        DVec3::new(long, 0.0, -short),
        DVec3::new(long, 0.0, short),
        DVec3::new(-long, 0.0, -short),
        DVec3::new(-long, 0.0, short),
    ]
}

fn fixed(corners: &[[i32; 3]], faces: &[[u32; 3]]) -> PolygonSoup {
    let corners: Vec<DVec3> = corners.iter().map(|c| DVec3::from(c.map(f64::from))).collect();
    triangles(&corners, faces)
}

/// A soup of a few triangles.
#[expect(clippy::expect_used, reason = "the callers' tables are far below the limit of corners")]
pub(crate) fn triangles(corners: &[DVec3], faces: &[[u32; 3]]) -> PolygonSoup {
    PolygonSoup::from_triangles(corners, faces).expect("a table of a few triangles")
}
