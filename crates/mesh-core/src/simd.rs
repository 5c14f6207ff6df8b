//! Eight vectors side by side, for loops that compute with the widest instructions of the processor.
//!
//! All functions are inlined into the caller, which chooses the instructions with `fearless_simd::dispatch`.
//! Sums are added in the same order as for a single vector, so results have the same bits.

use core::ops::{Add, Mul, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8};
use glam::DVec3;

/// Number of vectors side by side.
pub const LANES: usize = 8;

/// Eight vectors in memory, coordinate by coordinate.
pub type Columns = [[f64; LANES]; 3];

/// Eight vectors in registers, coordinate by coordinate.
#[derive(Clone, Copy)]
pub struct Vec3x8<S: Simd> {
    /// The x coordinates.
    pub x: f64x8<S>,
    /// The y coordinates.
    pub y: f64x8<S>,
    /// The z coordinates.
    pub z: f64x8<S>,
}

impl<S: Simd> Vec3x8<S> {
    /// The same vector eight times.
    #[inline(always)]
    pub fn splat(simd: S, v: DVec3) -> Self {
        let (x, y, z) = (f64x8::splat(simd, v.x), f64x8::splat(simd, v.y), f64x8::splat(simd, v.z));
        Self { x, y, z }
    }

    /// Reads eight vectors from memory.
    #[inline(always)]
    pub fn load(simd: S, [x, y, z]: &Columns) -> Self {
        Self { x: (*x).simd_into(simd), y: (*y).simd_into(simd), z: (*z).simd_into(simd) }
    }

    /// Takes eight single vectors.
    #[inline(always)]
    pub fn gather(simd: S, [a, b, c, d, e, f, g, h]: [DVec3; LANES]) -> Self {
        Self {
            x: [a.x, b.x, c.x, d.x, e.x, f.x, g.x, h.x].simd_into(simd),
            y: [a.y, b.y, c.y, d.y, e.y, f.y, g.y, h.y].simd_into(simd),
            z: [a.z, b.z, c.z, d.z, e.z, f.z, g.z, h.z].simd_into(simd),
        }
    }

    /// Writes the vectors to memory.
    #[inline(always)]
    pub fn store(self, [x, y, z]: &mut Columns) {
        self.x.store_slice(x);
        self.y.store_slice(y);
        self.z.store_slice(z);
    }

    /// One of the vectors.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Dot products.
    #[inline(always)]
    pub fn dot(self, other: Self) -> f64x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Squared lengths.
    #[inline(always)]
    pub fn length_squared(self) -> f64x8<S> {
        self.dot(self)
    }

    /// Cross products.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// The smaller one of each pair of coordinates.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        let (x, y, z) = (self.x.min(other.x), self.y.min(other.y), self.z.min(other.z));
        Self { x, y, z }
    }

    /// The larger one of each pair of coordinates.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        let (x, y, z) = (self.x.max(other.x), self.y.max(other.y), self.z.max(other.z));
        Self { x, y, z }
    }

    /// The vectors of `then` in the lanes where the mask is set, and of `or` in the others.
    #[inline(always)]
    pub fn select(mask: mask64x8<S>, then: Self, or: Self) -> Self {
        Self {
            x: mask.select(then.x, or.x),
            y: mask.select(then.y, or.y),
            z: mask.select(then.z, or.z),
        }
    }
}

impl<S: Simd> Add for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<S: Simd> Sub for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<S: Simd> Mul<f64x8<S>> for Vec3x8<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64x8<S>) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

/// Writes one vector among eight in memory.
#[inline(always)]
pub fn put(columns: &mut Columns, lane: usize, v: DVec3) {
    let [x, y, z] = columns;
    (x[lane], y[lane], z[lane]) = (v.x, v.y, v.z);
}

/// Reads one of eight vectors in memory.
#[inline(always)]
#[must_use]
pub fn take(columns: &Columns, lane: usize) -> DVec3 {
    let [x, y, z] = columns;
    DVec3::new(x[lane], y[lane], z[lane])
}

/// Iterates over the lanes whose bit is set, in ascending order.
#[derive(Clone, Copy, Debug)]
pub struct SetLanes(pub u64);

impl Iterator for SetLanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    }
}
