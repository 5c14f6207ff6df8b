//! A vertex of a block mesh.

use glam::DVec3;

use crate::blocks::lanes::Row;
use crate::geometry::quadric::Quadric;
use crate::geometry::symmetric::Symmetric3;

/// A vertex with its quadric. It takes two cache lines; the first one starts with the data that its neighbours need.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct BlockVertex {
    pub(super) position: DVec3,
    /// The number of the last patch that visited it.
    pub(super) met: u32,
    /// Twice the number of its faces, plus 1 if an edge at it was rejected.
    state: u32,
    /// The quadric about the position: the diagonal of the matrix and the constant, the mixed entries, the linear part.
    /// The last numbers of the second and third rows are unused.
    quadric: [Row; 3],
}

impl BlockVertex {
    pub(super) fn new(position: DVec3, quadric: &Quadric) -> Self {
        Self { position, met: 0, state: 0, quadric: rows(quadric) }
    }

    #[inline(always)]
    pub(super) fn quadric(&self) -> Quadric {
        let [[dx, dy, dz, constant], [mx, my, mz, _], [lx, ly, lz, _]] = self.quadric;
        let (diagonal, mixed) = (DVec3::new(dx, dy, dz), DVec3::new(mx, my, mz));
        let linear = DVec3::new(lx, ly, lz);
        Quadric { matrix: Symmetric3 { diagonal, mixed }, linear, constant }
    }

    #[inline(always)]
    pub(super) fn set_quadric(&mut self, quadric: &Quadric) {
        self.quadric = rows(quadric);
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: &[Row; 3]) {
        let numbers = self.quadric.as_flattened_mut().iter_mut();
        numbers.zip(other.as_flattened()).for_each(|(number, more)| *number += more);
    }

    /// The number of its faces.
    #[inline(always)]
    pub(super) fn valence(&self) -> u32 {
        self.state / 2
    }

    #[inline(always)]
    pub(super) fn set_valence(&mut self, valence: u32) {
        self.state = 2 * valence + self.state % 2;
    }

    /// Whether an edge at it was rejected.
    #[inline(always)]
    pub(super) fn has_refused(&self) -> bool {
        self.state % 2 == 1
    }

    #[inline(always)]
    pub(super) fn set_refused(&mut self, has_refused: bool) {
        self.state = 2 * self.valence() + u32::from(has_refused);
    }

    /// The position.
    #[inline(always)]
    pub(super) fn place(&self) -> Row {
        let DVec3 { x, y, z } = self.position;
        [x, y, z, 0.0]
    }

    #[inline(always)]
    pub(super) fn quadric_rows(&self) -> &[Row; 3] {
        &self.quadric
    }
}

/// A quadric in the layout of vertices.
#[inline(always)]
pub(super) fn rows(quadric: &Quadric) -> [Row; 3] {
    let Quadric { matrix: Symmetric3 { diagonal: d, mixed: m }, linear: l, constant } = *quadric;
    [[d.x, d.y, d.z, constant], [m.x, m.y, m.z, 0.0], [l.x, l.y, l.z, 0.0]]
}
