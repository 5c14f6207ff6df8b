//! A technical part with sharp edges, on a grid whose cells are cut at random: the edges of the part
//! run through grid points, but the triangles do not follow them.

use glam::{DVec2, DVec3};
use mesh_core::PolygonSoup;
use mesh_core::SplitMix64;

use xtask_common::Failure;

/// Cells along a side.
const CELLS: usize = 56;

/// A plate of four units a side with a truncated pyramid and a cone on it.
pub(super) fn part() -> Result<PolygonSoup, Failure> {
    let random = &mut SplitMix64::new(2001);
    let mut soup = PolygonSoup::new();
    let coordinate = |i: usize| 4.0 * i as f64 / CELLS as f64 - 2.0;
    for row in 0..=CELLS {
        for column in 0..=CELLS {
            let (x, y) = (coordinate(column), coordinate(row));
            soup.push_vertex(DVec3::new(x, y, height(x, y)));
        }
    }
    let vertex = |row: usize, column: usize| (row * (CELLS + 1) + column) as u32;
    for row in 0..CELLS {
        for column in 0..CELLS {
            let [a, b] = [vertex(row, column), vertex(row, column + 1)];
            let [d, c] = [vertex(row + 1, column), vertex(row + 1, column + 1)];
            let cut = if random.uniform() < 0.5 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            for triangle in cut {
                soup.push_face(&triangle).map_err(Failure::mesh)?;
            }
        }
    }
    Ok(soup)
}

pub(super) fn height(x: f64, y: f64) -> f64 {
    // Ridges along the diagonals of the grid.
    let pyramid = (1.0 - (x + 0.5).abs().max((y + 0.5).abs())).clamp(0.0, 0.6);
    let cone = (0.7 - DVec2::new(x - 1.1, y - 1.1).length()).clamp(0.0, 0.5);
    pyramid + cone
}
