//! Slabs along bundles of long thin triangles: bounds that are tighter than boxes.
//!
//! The box of a section of a long thin triangle is as wide as the section is long, so a point near one such
//! triangle is in the boxes of many others. Two parallel planes along the triangles bound the distance better.

use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use glam::DVec3;
use mesh_core::Slab;
use mesh_core::simd::{Columns, LANES, Vec3x8};

/// A slab that contains all triangles, along the longest side of the first one.
pub(crate) fn slab_of<const N: usize>(triangles: [[DVec3; 3]; N]) -> Slab {
    let first = triangles.first().copied().unwrap_or_default();
    // Zero without such a direction; then the slab is all of space.
    Slab::around(Slab::across(first), triangles.into_iter().flatten())
}

/// Eight slabs side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Slabs {
    normals: Columns,
    low: [f64; LANES],
    high: [f64; LANES],
}

impl Slabs {
    /// Missing slabs are all of space.
    pub(crate) fn new(slabs: impl Iterator<Item = Slab>) -> Self {
        let mut all = Self { normals: [[0.0; LANES]; 3], low: [0.0; LANES], high: [0.0; LANES] };
        for (lane, slab) in slabs.take(LANES).enumerate() {
            for (column, coordinate) in all.normals.iter_mut().zip(slab.normal.to_array()) {
                column[lane] = coordinate;
            }
            (all.low[lane], all.high[lane]) = (slab.low, slab.high);
        }
        all
    }

    /// Lower bounds of the squared distances from a point to the triangles.
    #[inline(always)]
    pub(crate) fn squared_gaps<S: Simd>(&self, simd: S, point: Vec3x8<S>) -> f64x8<S> {
        let heights = Vec3x8::load(simd, &self.normals).dot(point);
        let low: f64x8<S> = self.low.simd_into(simd);
        let high: f64x8<S> = self.high.simd_into(simd);
        let rounding = (point.x.abs() + point.y.abs() + point.z.abs()) * Slab::ROUNDING;
        let gaps = (low - heights).max(heights - high) - rounding;
        gaps.simd_gt(0.0).select(gaps * gaps, f64x8::splat(simd, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use mesh_core::SplitMix64;

    use mesh_core::closest_point::closest_on_triangle;

    /// The distance of a point from a slab, computed with the slab as the last of eight; the other seven are all of
    /// space.
    fn gap(slab: Slab, point: DVec3) -> f64 {
        let slabs = Slabs::new([Slab::default(); LANES - 1].into_iter().chain([slab]));
        let squares = dispatch!(Level::new(), simd => {
            <[f64; LANES]>::from(slabs.squared_gaps(simd, Vec3x8::splat(simd, point)))
        });
        assert_eq!(squares[..LANES - 1], [0.0; LANES - 1]);
        squares[LANES - 1].sqrt()
    }

    #[test]
    fn triangles_are_not_nearer_than_their_slab() {
        let mut random = SplitMix64::new(1);
        let mut beside = 0;
        for round in 0..5000 {
            let mut point =
                || DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
            let (from, tip, base) = (point(), point(), point());
            let width = [1e-3, 1.0, 0.0][round % 3];
            let triangles = [(); 4].map(|()| [tip, base + width * point(), base + width * point()]);
            let gap = gap(slab_of(triangles), from);
            let distance = |t: &[DVec3; 3]| closest_on_triangle(from, t).length();
            let nearest = triangles.iter().map(distance).fold(f64::INFINITY, f64::min);
            assert!(gap <= nearest, "{round}: {gap} {nearest}");
            beside += usize::from(gap > 0.1 * nearest);
        }
        assert!(beside > 1000, "{beside}");
    }

    #[test]
    fn needles_next_to_each_other_are_in_thin_slabs() {
        let rim = |i: f64| DVec3::new((1e-4 * i).cos(), (1e-4 * i).sin(), 0.0);
        let slab = slab_of([0.0, 1.0, 2.0, 3.0].map(|i| [DVec3::Z, rim(i), rim(i + 1.0)]));
        // The point is in the box around the needles, and far from them compared with their width.
        let beside = 0.5 * (DVec3::Z + rim(100.0));
        assert!(gap(slab, beside) > 0.004, "{}", gap(slab, beside));
        assert_eq!(gap(slab, 0.5 * (DVec3::Z + rim(2.0))), 0.0);
    }
}
