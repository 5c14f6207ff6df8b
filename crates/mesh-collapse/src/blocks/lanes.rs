//! Four vectors in parallel.
//!
//! Neither this module nor its users may use closures here: these would be compiled for the baseline processor.

use core::ops::{Add, Mul, Sub};

use fearless_simd::f64x4;
use fearless_simd::prelude::*;
use glam::DVec3;

/// The number of lanes.
pub(super) const LANES: usize = 4;

/// Four numbers in memory.
pub(super) type Row = [f64; LANES];

/// Four vectors, coordinate by coordinate.
#[derive(Clone, Copy)]
pub(super) struct Vectors<S: Simd> {
    pub(super) x: f64x4<S>,
    pub(super) y: f64x4<S>,
    pub(super) z: f64x4<S>,
}

/// The columns of four rows.
#[inline(always)]
pub(super) fn columns<S: Simd>(simd: S, [a, b, c, d]: [&Row; LANES]) -> [f64x4<S>; LANES] {
    let (a, b) = (f64x4::load_array_ref(simd, a), f64x4::load_array_ref(simd, b));
    let (c, d) = (f64x4::load_array_ref(simd, c), f64x4::load_array_ref(simd, d));
    let (even, odd) = ([a.zip_low(c), a.zip_high(c)], [b.zip_low(d), b.zip_high(d)]);
    [
        even[0].zip_low(odd[0]),
        even[0].zip_high(odd[0]),
        even[1].zip_low(odd[1]),
        even[1].zip_high(odd[1]),
    ]
}

impl<S: Simd> Vectors<S> {
    #[inline(always)]
    pub(super) fn splat(simd: S, v: DVec3) -> Self {
        let (x, y, z) = (f64x4::splat(simd, v.x), f64x4::splat(simd, v.y), f64x4::splat(simd, v.z));
        Self { x, y, z }
    }

    /// The first three of four columns.
    #[inline(always)]
    pub(super) fn of([x, y, z, _]: [f64x4<S>; LANES]) -> Self {
        Self { x, y, z }
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> f64x4<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(super) fn squared(self) -> f64x4<S> {
        self.dot(self)
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// The last three of four vectors, followed by the first of the others.
    #[inline(always)]
    pub(super) fn following(self, others: Self) -> Self {
        let (x, y) = (self.x.slide::<1>(others.x), self.y.slide::<1>(others.y));
        Self { x, y, z: self.z.slide::<1>(others.z) }
    }

    /// For each lane, the first vector if the mask is set, otherwise the second.
    #[inline(always)]
    pub(super) fn select(mask: <f64x4<S> as SimdBase<S>>::Mask, then: Self, or: Self) -> Self {
        Self {
            x: mask.select(then.x, or.x),
            y: mask.select(then.y, or.y),
            z: mask.select(then.z, or.z),
        }
    }
}

impl<S: Simd> Add for Vectors<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<S: Simd> Sub for Vectors<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<S: Simd> Mul<f64x4<S>> for Vectors<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64x4<S>) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

/// All levels of vector instructions of this processor.
#[cfg(test)]
pub(super) fn levels() -> Vec<fearless_simd::Level> {
    let best = fearless_simd::Level::new();
    let mut levels = vec![fearless_simd::Level::baseline(), best];
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(best.as_sse4_2().map(Simd::level));
        levels.extend(best.as_avx2().map(Simd::level));
    }
    levels
}
