//! The terms of many edges, or of the edges of many quadrilaterals, side by side.
//!
//! One term is a long chain of dependent steps, most of them for an arc tangent. Here the points of
//! up to `N` of them stand in flat arrays, so that a plain loop over them becomes vector instructions,
//! the widest that the processor has. Each term has the bits that it has alone.

use core::iter::zip;

use fearless_simd::{Level, dispatch};
use glam::DVec3;

use super::edge_term::EdgeTerm;

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

/// `N` quadrilaterals and the apexes beyond their sides; all zero where none was set.
pub(crate) struct Quads<const N: usize> {
    corners: [Points<N>; 4],
    /// Beyond `b -> c`, `c -> a`, `a -> d` and `d -> b`.
    outer: [Points<N>; 4],
    is_inner: [[bool; N]; 4],
}

impl<const N: usize> Quads<N> {
    pub(crate) fn new() -> Self {
        Self { corners: [Points::ZERO; 4], outer: [Points::ZERO; 4], is_inner: [[false; N]; 4] }
    }

    /// Sets the corners of a quadrilateral.
    #[inline(always)]
    pub(crate) fn set(&mut self, place: usize, corners: [DVec3; 4]) {
        for (points, corner) in zip(&mut self.corners, corners) {
            points.set(place, corner);
        }
    }

    /// Sets the apex beyond a side that is not a boundary edge.
    #[inline(always)]
    pub(crate) fn set_outer(&mut self, place: usize, side: usize, apex: DVec3) {
        self.outer[side].set(place, apex);
        self.is_inner[side][place] = true;
    }

    /// The terms after the flip, of the edges and of each of their sides; 0 for boundary edges,
    /// without meaning for quadrilaterals that were not set.
    #[inline]
    pub(crate) fn terms_after<T: EdgeTerm>(&self, cost: &T) -> [[f64; N]; 5] {
        dispatch!(Level::new(), _ => self.terms_in_a_row(cost))
    }

    #[inline(always)]
    fn terms_in_a_row<T: EdgeTerm>(&self, cost: &T) -> [[f64; N]; 5] {
        let [a, b, c, d] = &self.corners;
        let mut turned = [0.0; N];
        for (i, term) in turned.iter_mut().enumerate() {
            *term = cost.term(c.at(i), d.at(i), b.at(i), a.at(i));
        }
        let side = |side: usize| (&self.outer[side], &self.is_inner[side]);
        [
            turned,
            side_terms(cost, [b, c, d], side(0)),
            side_terms(cost, [c, a, d], side(1)),
            side_terms(cost, [a, d, c], side(2)),
            side_terms(cost, [d, b, c], side(3)),
        ]
    }
}

/// The terms of one side of each quadrilateral, with its ends and the apex inside.
#[inline(always)]
fn side_terms<const N: usize, T: EdgeTerm>(
    cost: &T,
    [from, to, inner]: [&Points<N>; 3],
    (outer, is_inner): (&Points<N>, &[bool; N]),
) -> [f64; N] {
    let mut terms = [0.0; N];
    for (i, term) in terms.iter_mut().enumerate() {
        let value = cost.term(from.at(i), to.at(i), inner.at(i), outer.at(i));
        *term = if is_inner[i] { value } else { 0.0 };
    }
    terms
}
