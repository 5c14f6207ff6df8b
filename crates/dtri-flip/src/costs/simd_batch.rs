//! Vectorised evaluation of edge terms, for batches of edges or quadrilaterals.
//!
//! A term is a long chain of dependent operations, mostly an arc tangent. Points of up to `N` terms are
//! stored as structure of arrays, so that a plain loop compiles to vector instructions of the widest
//! available kind. Each term has the same bits as in a scalar evaluation.

use core::iter::zip;

use fearless_simd::{Level, dispatch};
use glam::DVec3;

use super::edge_term::EdgeTerm;

/// Points of `N` edges; zero where not set.
pub(crate) struct EdgeBatch<const N: usize> {
    ends: [Points<N>; 2],
    apexes: [Points<N>; 2],
}

/// Points as structure of arrays.
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

impl<const N: usize> EdgeBatch<N> {
    pub(crate) fn new() -> Self {
        Self { ends: [Points::ZERO; 2], apexes: [Points::ZERO; 2] }
    }

    /// Sets the ends, the left apex and the right apex of an edge.
    #[inline(always)]
    pub(crate) fn set(&mut self, place: usize, [a, b, left, right]: [DVec3; 4]) {
        self.ends[0].set(place, a);
        self.ends[1].set(place, b);
        self.apexes[0].set(place, left);
        self.apexes[1].set(place, right);
    }

    /// The terms of all edges; undefined where no edge was set.
    #[inline]
    pub(crate) fn terms<T: EdgeTerm>(&self, cost: &T) -> [f64; N] {
        dispatch!(Level::new(), _ => self.vector_terms(cost))
    }

    #[inline(always)]
    fn vector_terms<T: EdgeTerm>(&self, cost: &T) -> [f64; N] {
        let [a, b] = &self.ends;
        let [left, right] = &self.apexes;
        let mut terms = [0.0; N];
        for (i, term) in terms.iter_mut().enumerate() {
            *term = cost.term(a.at(i), b.at(i), left.at(i), right.at(i));
        }
        terms
    }
}

/// `N` quadrilaterals and the apexes beyond their sides; zero where not set.
pub(crate) struct QuadBatch<const N: usize> {
    corners: [Points<N>; 4],
    /// Beyond `b -> c`, `c -> a`, `a -> d` and `d -> b`.
    outer: [Points<N>; 4],
    is_inner: [[bool; N]; 4],
}

impl<const N: usize> QuadBatch<N> {
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

    /// Sets the apex beyond an interior side.
    #[inline(always)]
    pub(crate) fn set_outer(&mut self, place: usize, side: usize, apex: DVec3) {
        self.outer[side].set(place, apex);
        self.is_inner[side][place] = true;
    }

    /// The terms after the flip: edges, then each side. 0 for boundary edges; undefined where no
    /// quadrilateral was set.
    #[inline]
    pub(crate) fn terms_after<T: EdgeTerm>(&self, cost: &T) -> [[f64; N]; 5] {
        dispatch!(Level::new(), _ => self.vector_terms(cost))
    }

    #[inline(always)]
    fn vector_terms<T: EdgeTerm>(&self, cost: &T) -> [[f64; N]; 5] {
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

/// The terms of one side of each quadrilateral; `inner` is the apex on the inside.
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
