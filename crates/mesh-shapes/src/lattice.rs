//! Triangle meshes over a lattice of two parameters, each open or closed.

use crate::error::{ShapeError, fits};
use crate::irregular::Irregular;
use glam::DVec3;
use mesh_core::{PolygonSoup, as_u32};

/// The diagonal that halves the cell a, b, c, d.
#[derive(Clone, Copy)]
pub(crate) enum Diagonal {
    /// (a, b, c) and (a, c, d).
    AC,
    /// (a, b, d) and (b, c, d).
    BD,
}

impl Diagonal {
    /// The first kind if `first`, otherwise the second.
    fn either(first: bool) -> Self {
        if first { Self::AC } else { Self::BD }
    }
}

/// One direction of the lattice.
#[derive(Clone, Copy)]
pub(crate) struct Axis {
    /// Number of cells.
    pub(crate) cells: usize,
    /// Whether the last cell is adjacent to the first.
    pub(crate) closed: bool,
}

impl Axis {
    fn vertices(self) -> usize {
        if self.closed { self.cells } else { self.cells + 1 }
    }

    /// The vertex one step further.
    fn next(self, index: usize) -> usize {
        if self.closed && index + 1 == self.cells { 0 } else { index + 1 }
    }

    fn is_border(self, index: usize) -> bool {
        !self.closed && (index == 0 || index == self.cells)
    }
}

/// A lattice of vertices, row after row. `a`, `b`, `c`, `d` of a cell are (row, column),
/// (row, column + 1), (row + 1, column + 1), (row + 1, column) when the surface's normal is
/// columns x rows; `transposed`, when it is rows x columns, exchanges `b` and `d`.
pub(crate) struct Lattice {
    pub(crate) rows: Axis,
    pub(crate) columns: Axis,
    pub(crate) transposed: bool,
}

impl Lattice {
    /// The mesh whose vertex (row, column) is `point(row + jitter, column + jitter)`. Without `irregular` there is no
    /// jitter and cells are cut by `diagonal(row, column)`.
    pub(crate) fn mesh(
        &self,
        irregular: Option<Irregular>,
        point: impl Fn(usize, f64, f64) -> DVec3,
        diagonal: impl Fn(usize, usize) -> Diagonal,
    ) -> Result<PolygonSoup, ShapeError> {
        let irregular = irregular.map(Irregular::checked).transpose()?;
        let cells = self.rows.cells.checked_mul(self.columns.cells);
        let triangles = fits(cells.and_then(|cells| cells.checked_mul(2)))?;
        // An open lattice has fewer than two vertices per cell, plus the vertices of a single row.
        let vertices = self.rows.vertices() * self.columns.vertices();
        let mut soup = PolygonSoup::with_capacity(vertices, triangles, 3 * triangles);
        let mut random = irregular.map(|irregular| (irregular.jitter, irregular.random()));

        for row in 0..self.rows.vertices() {
            for column in 0..self.columns.vertices() {
                let (mut r, mut c) = (row as f64, column as f64);
                if let Some((jitter, random)) = &mut random {
                    let shift = [*jitter * random.symmetric(), *jitter * random.symmetric()];
                    r += if self.rows.is_border(row) { 0.0 } else { shift[0] };
                    c += if self.columns.is_border(column) { 0.0 } else { shift[1] };
                }
                soup.push_vertex(point(row, r, c));
            }
        }
        for row in 0..self.rows.cells {
            for column in 0..self.columns.cells {
                let cut = match &mut random {
                    Some((_, random)) => Diagonal::either(random.uniform() < 0.5),
                    None => diagonal(row, column),
                };
                self.push_cell(&mut soup, row, column, cut)?;
            }
        }
        Ok(soup)
    }

    fn push_cell(
        &self,
        soup: &mut PolygonSoup,
        row: usize,
        column: usize,
        cut: Diagonal,
    ) -> Result<(), ShapeError> {
        let (row_after, column_after) = (self.rows.next(row), self.columns.next(column));
        let vertex = |row: usize, column: usize| as_u32(row * self.columns.vertices() + column);
        let (a, c) = (vertex(row, column), vertex(row_after, column_after));
        let (mut b, mut d) = (vertex(row, column_after), vertex(row_after, column));
        if self.transposed {
            (b, d) = (d, b);
        }
        let triangles = match cut {
            Diagonal::AC => [[a, b, c], [a, c, d]],
            Diagonal::BD => [[a, b, d], [b, c, d]],
        };
        for triangle in triangles {
            soup.push_face(&triangle)?;
        }
        Ok(())
    }
}
