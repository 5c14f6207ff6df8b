//! Eight three-dimensional vectors in SIMD registers, one coordinate per register.

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8};
use glam::DVec3;

/// Number of vectors per group.
pub(crate) const LANES: usize = 8;

/// Eight vectors in memory, one array per coordinate.
pub(crate) type Vec3Lanes = [[f64; LANES]; 3];

/// Eight vectors in registers, one register per coordinate.
#[derive(Clone, Copy)]
pub(crate) struct Vec3x8<S: Simd> {
    pub(crate) x: f64x8<S>,
    pub(crate) y: f64x8<S>,
    pub(crate) z: f64x8<S>,
}

impl<S: Simd> Vec3x8<S> {
    #[inline(always)]
    pub(crate) fn splat(simd: S, v: DVec3) -> Self {
        let (x, y, z) = (f64x8::splat(simd, v.x), f64x8::splat(simd, v.y), f64x8::splat(simd, v.z));
        Self { x, y, z }
    }

    #[inline(always)]
    pub(crate) fn load(simd: S, [x, y, z]: &Vec3Lanes) -> Self {
        Self { x: (*x).simd_into(simd), y: (*y).simd_into(simd), z: (*z).simd_into(simd) }
    }

    #[inline(always)]
    pub(crate) fn gather(simd: S, [a, b, c, d, e, f, g, h]: [DVec3; LANES]) -> Self {
        Self {
            x: [a.x, b.x, c.x, d.x, e.x, f.x, g.x, h.x].simd_into(simd),
            y: [a.y, b.y, c.y, d.y, e.y, f.y, g.y, h.y].simd_into(simd),
            z: [a.z, b.z, c.z, d.z, e.z, f.z, g.z, h.z].simd_into(simd),
        }
    }

    #[inline(always)]
    pub(crate) fn store(self, [x, y, z]: &mut Vec3Lanes) {
        self.x.store_slice(x);
        self.y.store_slice(y);
        self.z.store_slice(z);
    }

    /// The eight dot products, summed in the order that [`DVec3::dot`] uses, so that the bits agree.
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> f64x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn plus(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }

    #[inline(always)]
    pub(crate) fn minus(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    #[inline(always)]
    pub(crate) fn times(self, factor: f64x8<S>) -> Self {
        Self { x: factor * self.x, y: factor * self.y, z: factor * self.z }
    }

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Lane by lane, `then` where the mask is set and `or` elsewhere.
    #[inline(always)]
    pub(crate) fn select(mask: mask64x8<S>, then: Self, or: Self) -> Self {
        Self {
            x: mask.select(then.x, or.x),
            y: mask.select(then.y, or.y),
            z: mask.select(then.z, or.z),
        }
    }
}

/// Stores a vector in one lane.
#[inline(always)]
pub(crate) fn put(columns: &mut Vec3Lanes, lane: usize, v: DVec3) {
    let [x, y, z] = columns;
    (x[lane], y[lane], z[lane]) = (v.x, v.y, v.z);
}

/// Loads the vector of one lane.
#[inline(always)]
pub(crate) fn take(columns: &Vec3Lanes, lane: usize) -> DVec3 {
    let [x, y, z] = columns;
    DVec3::new(x[lane], y[lane], z[lane])
}

/// Iterates over the lanes whose bit is set, in ascending order.
#[derive(Clone, Copy)]
pub(crate) struct LaneBits(pub(crate) u64);

impl Iterator for LaneBits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    }
}
