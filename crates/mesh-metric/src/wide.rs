//! Eight vectors, or eight triangles, side by side.

use core::ops::{Mul, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8};
use glam::DVec3;

use crate::closest::THIN;

/// How many there are.
pub(crate) const LANES: usize = 8;

/// Eight vectors, coordinate by coordinate.
#[derive(Clone, Copy)]
pub(crate) struct Wide<S: Simd> {
    pub(crate) x: f64x8<S>,
    pub(crate) y: f64x8<S>,
    pub(crate) z: f64x8<S>,
}

/// Eight vectors at rest.
pub(crate) type Columns = [[f64; LANES]; 3];

impl<S: Simd> Wide<S> {
    #[inline(always)]
    pub(crate) fn splat(simd: S, v: DVec3) -> Self {
        let (x, y, z) = (f64x8::splat(simd, v.x), f64x8::splat(simd, v.y), f64x8::splat(simd, v.z));
        Self { x, y, z }
    }

    #[inline(always)]
    pub(crate) fn load(simd: S, [x, y, z]: &Columns) -> Self {
        Self { x: (*x).simd_into(simd), y: (*y).simd_into(simd), z: (*z).simd_into(simd) }
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> f64x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        let (x, y, z) = (self.x.max(other.x), self.y.max(other.y), self.z.max(other.z));
        Self { x, y, z }
    }

    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        let (x, y, z) = (self.x.min(other.x), self.y.min(other.y), self.z.min(other.z));
        Self { x, y, z }
    }

    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    #[inline(always)]
    pub(crate) fn squared(self) -> f64x8<S> {
        self.dot(self)
    }

    /// Of each two vectors, the first where the mask is set.
    #[inline(always)]
    pub(crate) fn select(mask: mask64x8<S>, then: Self, or: Self) -> Self {
        Self {
            x: mask.select(then.x, or.x),
            y: mask.select(then.y, or.y),
            z: mask.select(then.z, or.z),
        }
    }

    /// The vectors from the origin to the segments from here along `along`.
    #[inline(always)]
    fn to_segment(self, along: Self) -> Self {
        let squared = along.squared();
        let t = -self.dot(along);
        let (zero, one) = (f64x8::splat(squared.simd, 0.0), f64x8::splat(squared.simd, 1.0));
        let part = t.simd_ge(squared).select(one, t / squared);
        let part = t.simd_le(zero).select(zero, part);
        Self { x: self.x + along.x * part, y: self.y + along.y * part, z: self.z + along.z * part }
    }
}

impl<S: Simd> Sub for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<S: Simd> Mul<f64x8<S>> for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64x8<S>) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

/// The vectors from points to the closest points of triangles, with the same bits as those of
/// [`closest_on_triangle`](crate::closest_on_triangle()), and the squares of their lengths.
#[inline(always)]
pub(crate) fn closest_on_triangles<S: Simd>(
    point: Wide<S>,
    triangles: [Wide<S>; 3],
) -> (Wide<S>, f64x8<S>) {
    let [a, b, c] = triangles;
    let (a, b, c) = (a - point, b - point, c - point);
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let normal = ab.cross(Wide { x: -ca.x, y: -ca.y, z: -ca.z });
    let squared = normal.squared();
    let thin = squared.simd_le(ab.squared() * (THIN * THIN) * ca.squared());
    let over_ab = normal.dot(ab.cross(a)).simd_gt(0.0) | thin;
    let over_bc = normal.dot(bc.cross(b)).simd_gt(0.0) | thin;
    let over_ca = normal.dot(ca.cross(c)).simd_gt(0.0) | thin;
    let perpendicular = normal * (normal.dot(a) / squared);
    let far = f64x8::splat(squared.simd, f64::INFINITY);
    let over_any = over_ab | over_bc | over_ca;
    let mut best = (perpendicular, over_any.select(far, perpendicular.squared()));
    best = nearer(best, over_ab, a.to_segment(ab));
    best = nearer(best, over_bc, b.to_segment(bc));
    nearer(best, over_ca, c.to_segment(ca))
}

/// The candidate, with its squared length, where the mask is set and it is shorter than the best.
#[inline(always)]
fn nearer<S: Simd>(
    best: (Wide<S>, f64x8<S>),
    mask: mask64x8<S>,
    candidate: Wide<S>,
) -> (Wide<S>, f64x8<S>) {
    let squared = candidate.squared();
    let is_nearer = mask & squared.simd_lt(best.1);
    (Wide::select(is_nearer, candidate, best.0), is_nearer.select(squared, best.1))
}

/// The squared distances between boxes, given by their smallest and largest coordinates.
#[inline(always)]
pub(crate) fn squared_gaps<S: Simd>(a: [Wide<S>; 2], b: [Wide<S>; 2]) -> f64x8<S> {
    let zero = Wide::splat(a[0].x.simd, DVec3::ZERO);
    (b[0] - a[1]).max(a[0] - b[1]).max(zero).squared()
}
