//! Numbers in rows and columns, in one allocation.
//!
//! Each column is contiguous, so that a block of consecutive rows is read and written at once.

use core::ops::{Index, IndexMut};

use glam::DVec3;

/// The number of rows that are evaluated together.
pub(super) const LANES: usize = 4;

/// The values of a column in a block of rows.
pub(super) type Lanes = [f64; LANES];

/// The data of an incident edge of a star and of the face between it and the incident edge before.
#[derive(Clone, Copy, Debug)]
pub(super) enum Column {
    /// The share of the bend of the incident edge, or of the link, that each of its ends receives; 0 on the boundary.
    IncidentShare,
    LinkShare,
    /// The angles of the face at the centre, at this neighbour, and at the neighbour of the row before.
    CenterAngle,
    Angle,
    AngleBefore,
    /// A third of the area of the face.
    Third,
    IncidentHinge,
    LinkHinge,
    /// The changes of the angles, of a third of the area, and of the hinge of the link. Before the evaluation, their
    /// current values in the mesh.
    AngleChange,
    AngleBeforeChange,
    ThirdChange,
    LinkChange,
    /// The integrals over the neighbour. Before the evaluation, their current values without the vanishing parts.
    Defect,
    Mean,
    Area,
    /// 0 for neighbours on the boundary, 1 for others.
    Inner,
    Measured,
}

/// Three columns.
#[derive(Clone, Copy, Debug)]
pub(super) enum Vector {
    /// From the centre to the neighbour.
    Along,
    /// From the centre to the vertex on the other side of the link.
    Outer,
    /// The vector area of the face, doubled.
    Normal,
}

/// The first column with single numbers.
const SINGLE: usize = 3 * (Vector::Normal as usize + 1);
const COLUMNS: usize = SINGLE + Column::Measured as usize + 1;

/// Buffer for rows, column after column.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    numbers: Vec<f64>,
    /// The length of a column.
    capacity: usize,
}

impl Rows {
    /// Makes room for at least this many rows. Their contents are unspecified.
    pub(super) fn make_room(&mut self, rows: usize) {
        if self.capacity < rows {
            self.capacity = rows;
            self.numbers.resize(COLUMNS * rows, 0.0);
        }
    }

    /// The index of a number. It wraps instead of checking, because the access checks the bounds.
    #[inline(always)]
    fn place(&self, column: Column, row: usize) -> usize {
        (SINGLE + column as usize).wrapping_mul(self.capacity).wrapping_add(row)
    }

    #[inline(always)]
    fn places(&self, vector: Vector, row: usize) -> [usize; 3] {
        let first = (3 * vector as usize).wrapping_mul(self.capacity).wrapping_add(row);
        let second = first.wrapping_add(self.capacity);
        [first, second, second.wrapping_add(self.capacity)]
    }

    /// The rows from 1 to `count` of a column.
    #[inline(always)]
    pub(super) fn column(&self, column: Column, count: usize) -> &[f64] {
        let first = self.place(column, 1);
        &self.numbers[first..first + count]
    }

    /// A copy of a block of rows: compilers see that copies do not overlap.
    #[inline(always)]
    pub(super) fn lanes(&self, column: Column, first: usize) -> Lanes {
        self.block(self.place(column, first))
    }

    #[inline(always)]
    pub(super) fn store(&mut self, column: Column, first: usize, lanes: &Lanes) {
        self.set_block(self.place(column, first), lanes);
    }

    #[inline(always)]
    pub(super) fn vectors(&self, vector: Vector, first: usize) -> [Lanes; 3] {
        let [x, y, z] = self.places(vector, first);
        [self.block(x), self.block(y), self.block(z)]
    }

    #[inline(always)]
    pub(super) fn store_vectors(&mut self, vector: Vector, first: usize, lanes: &[Lanes; 3]) {
        let [x, y, z] = self.places(vector, first);
        self.set_block(x, &lanes[0]);
        self.set_block(y, &lanes[1]);
        self.set_block(z, &lanes[2]);
    }

    #[inline(always)]
    pub(super) fn set_vector(&mut self, vector: Vector, row: usize, value: DVec3) {
        let [x, y, z] = self.places(vector, row);
        (self.numbers[x], self.numbers[y], self.numbers[z]) = (value.x, value.y, value.z);
    }

    /// Copies a vector from one row to another.
    #[inline(always)]
    pub(super) fn repeat(&mut self, vector: Vector, row: usize, to: usize) {
        let [x, y, z] = self.places(vector, row);
        self.set_vector(vector, to, DVec3::new(self.numbers[x], self.numbers[y], self.numbers[z]));
    }

    #[inline(always)]
    fn block(&self, place: usize) -> Lanes {
        let mut lanes = [0.0; LANES];
        lanes.copy_from_slice(&self.numbers[place..place + LANES]);
        lanes
    }

    #[inline(always)]
    fn set_block(&mut self, place: usize, lanes: &Lanes) {
        self.numbers[place..place + LANES].copy_from_slice(lanes);
    }
}

impl Index<(Column, usize)> for Rows {
    type Output = f64;

    #[inline(always)]
    fn index(&self, (column, row): (Column, usize)) -> &f64 {
        &self.numbers[self.place(column, row)]
    }
}

impl IndexMut<(Column, usize)> for Rows {
    #[inline(always)]
    fn index_mut(&mut self, (column, row): (Column, usize)) -> &mut f64 {
        let place = self.place(column, row);
        &mut self.numbers[place]
    }
}
