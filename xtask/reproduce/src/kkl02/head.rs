//! A head with curly hair, made of formulas: it stands for the scan of a statue's head.

use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_shapes::Sphere;

use xtask_common::Failure;

/// Subdivisions of the icosahedron: 20 * 4^5 = 20,480 faces.
const LEVELS: u32 = 5;

/// The head looks along z, up is y; about two units high.
pub(super) fn head() -> Result<PolygonSoup, Failure> {
    of_levels(LEVELS)
}

/// The same with 5,120 faces, for what takes long.
pub(super) fn small_head() -> Result<PolygonSoup, Failure> {
    of_levels(LEVELS - 1)
}

fn of_levels(levels: u32) -> Result<PolygonSoup, Failure> {
    let sphere = Sphere::UNIT.icosphere(levels).map_err(Failure::mesh)?;
    let mut soup = PolygonSoup::new();
    for &p in sphere.positions() {
        soup.push_vertex(point(p));
    }
    for face in sphere.faces() {
        soup.push_face(face).map_err(Failure::mesh)?;
    }
    Ok(soup)
}

/// Where the point of the unit sphere in this direction goes.
fn point(direction: DVec3) -> DVec3 {
    let base = DVec3::new(0.78, 1.05, 0.92) * direction;
    base + direction * relief(direction)
}

/// How far the surface stands out from an ellipsoid.
fn relief(direction: DVec3) -> f64 {
    let (x, y) = (direction.x, direction.y);
    let front = smooth_step(0.1, 0.45, direction.z);
    let bump = |cx: f64, cy: f64, sx: f64, sy: f64| {
        (-((x - cx) / sx).powi(2) - ((y - cy) / sy).powi(2)).exp()
    };
    let both = |cx: f64, cy: f64, sx: f64, sy: f64| bump(cx, cy, sx, sy) + bump(-cx, cy, sx, sy);
    let along = ((0.3 - y) / 0.42).clamp(0.0, 1.0);
    let nose_end = smooth_step(-0.2, -0.1, y);
    let nose = 0.3 * along * nose_end * (-(x / (0.07 + 0.05 * along)).powi(2)).exp();
    let eyes = 0.06 * both(0.27, 0.2, 0.1, 0.05) - 0.13 * both(0.27, 0.2, 0.19, 0.12);
    let brows = 0.05 * both(0.28, 0.36, 0.2, 0.05);
    let lips = 0.07 * bump(0.0, -0.33, 0.18, 0.035) + 0.08 * bump(0.0, -0.43, 0.15, 0.04)
        - 0.05 * bump(0.0, -0.38, 0.2, 0.018);
    let chin = 0.1 * bump(0.0, -0.66, 0.22, 0.13);
    let face = front * (nose + eyes + brows + lips + chin);
    // Curls where there is no face.
    let hair = (1.0 - front.max(smooth_step(-0.35, -0.65, y))) * smooth_step(-0.7, -0.3, y)
        + front * smooth_step(0.55, 0.72, y);
    let (longitude, latitude) = (direction.x.atan2(direction.z), direction.y.asin());
    let curls =
        0.045 * (22.0 * longitude + 3.0 * (9.0 * latitude).sin()).sin() * (17.0 * latitude).cos();
    face + hair.clamp(0.0, 1.0) * (0.06 + curls * latitude.cos())
}

/// From 0 at `from` to 1 at `to`.
fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
