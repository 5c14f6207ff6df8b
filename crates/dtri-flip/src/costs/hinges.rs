//! The terms of many edges side by side.
//!
//! One term is a long chain of dependent steps, most of them for an arc tangent. Here the points of
//! up to `N` edges stand in flat arrays, so that a plain loop over them becomes vector instructions,
//! the widest that the processor has. Each term has the bits that it has alone.

use fearless_simd::{Level, dispatch};
use glam::DVec3;

use super::edge_sum::EdgeTerm;

/// The points that the terms of `N` edges depend on; all zero where none were set.
pub(crate) struct Hinges<const N: usize> {
    ends: [Points<N>; 2],
    apexes: [Points<N>; 2],
}

/// Points, coordinate by coordinate.
struct Points<const N: usize>([[f64; N]; 3]);

impl<const N: usize> Points<N> {
    const ZERO: Self = Self([[0.0; N]; 3]);

    #[inline(always)]
    fn set(&mut self, place: usize, point: DVec3) {
        let [x, y, z] = &mut self.0;
        (x[place], y[place], z[place]) = (point.x, point.y, point.z);
    }

    #[inline(always)]
    fn at(&self, place: usize) -> DVec3 {
        let [x, y, z] = &self.0;
        DVec3::new(x[place], y[place], z[place])
    }
}

impl<const N: usize> Hinges<N> {
    pub(crate) fn new() -> Self {
        Self { ends: [Points::ZERO; 2], apexes: [Points::ZERO; 2] }
    }

    /// Sets an edge: its ends, its left and its right apex.
    #[inline(always)]
    pub(crate) fn set(&mut self, place: usize, [a, b, left, right]: [DVec3; 4]) {
        self.ends[0].set(place, a);
        self.ends[1].set(place, b);
        self.apexes[0].set(place, left);
        self.apexes[1].set(place, right);
    }

    /// The terms of all edges; without meaning for those that were not set.
    #[inline]
    pub(crate) fn terms<T: EdgeTerm>(&self, cost: &T) -> [f64; N] {
        dispatch!(Level::new(), _ => self.terms_in_a_row(cost))
    }

    #[inline(always)]
    fn terms_in_a_row<T: EdgeTerm>(&self, cost: &T) -> [f64; N] {
        let [a, b] = &self.ends;
        let [left, right] = &self.apexes;
        let mut terms = [0.0; N];
        for (i, term) in terms.iter_mut().enumerate() {
            *term = cost.term(a.at(i), b.at(i), left.at(i), right.at(i));
        }
        terms
    }
}
