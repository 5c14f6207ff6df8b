//! A face as a height field, sampled and triangulated as a scanner's software might.

use glam::{DVec2, DVec3};
use mesh_core::PolygonSoup;
use mesh_core::SplitMix64;
use spade::{DelaunayTriangulation, Point2, Triangulation};

use xtask_common::Failure;

/// Half the width and half the height of the scanned rectangle.
const HALF: DVec2 = DVec2::new(1.0, 1.25);
/// Sample points across and up.
const COLUMNS: usize = 52;
const ROWS: usize = 66;
/// How far points are off their place on the grid, in steps.
const JITTER: f64 = 0.42;
/// How much the parameters shorten the vertical. Delaunay triangulation of parameters that are
/// squeezed like this prefers vertical edges: the artefact of the paper's figure.
const SQUEEZE: f64 = 3.0;

/// The height of the face over the plane.
pub(crate) fn height(x: f64, y: f64) -> f64 {
    let bump = |cx: f64, cy: f64, sx: f64, sy: f64| {
        (-((x - cx) / sx).powi(2) - ((y - cy) / sy).powi(2)).exp()
    };
    let both = |cx: f64, cy: f64, sx: f64, sy: f64| bump(cx, cy, sx, sy) + bump(-cx, cy, sx, sy);
    let head = 0.95 * (-((x / 0.95).powi(2) + (y / 1.3).powi(2)).powf(1.4)).exp();
    // The nose rises from the brow to its tip and ends there.
    let along = ((0.34 - y) / 0.5).clamp(0.0, 1.0);
    let end = 1.0 / (1.0 + ((-y - 0.16) / 0.035).exp());
    let nose = 0.34 * along * end * (-(x / (0.09 + 0.05 * along)).powi(2)).exp();
    let wings = 0.09 * both(0.13, -0.1, 0.07, 0.07);
    let eyes = 0.1 * both(0.36, 0.3, 0.13, 0.06) - 0.2 * both(0.36, 0.29, 0.24, 0.14);
    let brows = 0.07 * both(0.36, 0.47, 0.26, 0.06);
    let lips = 0.12 * bump(0.0, -0.42, 0.26, 0.05) + 0.13 * bump(0.0, -0.56, 0.22, 0.06)
        - 0.07 * bump(0.0, -0.485, 0.3, 0.025);
    let chin = 0.16 * bump(0.0, -0.88, 0.26, 0.17) - 0.06 * bump(0.0, -0.7, 0.3, 0.06);
    let cheeks = 0.08 * both(0.5, -0.05, 0.22, 0.2);
    head + nose + wings + eyes + brows + lips + chin + cheeks
}

/// Points of the face, joined by Delaunay triangulation of their squeezed parameters.
pub(crate) fn scan() -> Result<PolygonSoup, Failure> {
    let points = sample_points();
    let parameters = points.iter().map(|p| Point2::new(p.x, p.y / SQUEEZE)).collect();
    let delaunay = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(parameters)
        .map_err(Failure::mesh)?;
    let triangles: Vec<[u32; 3]> = delaunay
        .inner_faces()
        .map(|face| face.vertices().map(|vertex| vertex.index() as u32))
        .collect();
    PolygonSoup::from_triangles(&points, &triangles).map_err(Failure::mesh)
}

/// A grid with jitter; points of the border stay on it.
fn sample_points() -> Vec<DVec3> {
    let random = &mut SplitMix64::new(2006);
    let mut points = Vec::with_capacity((COLUMNS + 1) * (ROWS + 1));
    for row in 0..=ROWS {
        for column in 0..=COLUMNS {
            let [dx, dy] = [JITTER * random.symmetric(), JITTER * random.symmetric()];
            let place = |i: usize, steps: usize, off: f64| {
                let off = if i == 0 || i == steps { 0.0 } else { off };
                2.0 * (i as f64 + off) / steps as f64 - 1.0
            };
            let x = HALF.x * place(column, COLUMNS, dx);
            let y = HALF.y * place(row, ROWS, dy);
            points.push(DVec3::new(x, y, height(x, y)));
        }
    }
    points
}
