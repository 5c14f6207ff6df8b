//! Costs that are sums over interior edges of a function of the four vertices of each edge.

use core::iter::zip;

use glam::DVec3;
use mesh_core::{EdgeId, EdgeMap, HalfEdgeId, Handle, Topology, TriMesh, VertexId, parallel};

use super::edge_term::EdgeTerm;
use super::simd_batch::{EdgeBatch, QuadBatch};
use crate::cost::{Change, FlipCost, Stencil};
use crate::quad::Quad;

/// The terms of all edges, and their change by a flip.
pub(crate) trait EdgeSum: EdgeTerm {
    /// The current terms of up to `N` edges; 0 for boundary edges.
    #[inline]
    fn terms_of<const N: usize>(
        &self,
        mesh: &TriMesh,
        edges: impl Iterator<Item = EdgeId>,
    ) -> [f64; N] {
        let topology = mesh.topology();
        let mut batch = EdgeBatch::<N>::new();
        let mut counts = [0.0; N];
        for (place, edge) in edges.enumerate().take(N) {
            if topology.contains_edge(edge)
                && let Some(quad) = Quad::around(topology, edge)
            {
                batch.set(place, corner_points(mesh, &quad));
                let [a, b, ..] = quad.corners;
                counts[place] = count::<Self>(topology, [a, b]);
            }
        }
        let mut terms = batch.terms(self);
        for (term, count) in zip(&mut terms, counts) {
            *term = if count > 0.0 { *term * count } else { 0.0 };
        }
        terms
    }

    fn all_terms(&self, mesh: &TriMesh) -> EdgeMap<f64> {
        const BLOCK: usize = 64;
        let count = mesh.topology().edge_capacity();
        EdgeMap::from_vec(parallel::collect_blocks(
            count,
            || (),
            |(), edges| self.terms_of::<BLOCK>(mesh, edges.map(EdgeId::from_index)),
        ))
    }

    /// Updates the terms of the edge and its four sides.
    fn update_terms(&self, mesh: &TriMesh, terms: &mut EdgeMap<f64>, flipped: &Quad) {
        let edges = edges(flipped);
        let new_terms = self.terms_of::<8>(mesh, edges.into_iter());
        for (edge, term) in zip(edges, new_terms) {
            terms[edge] = term;
        }
    }

    /// Change of the terms of the edge and its four sides.
    #[inline]
    fn change_of_terms(&self, mesh: &TriMesh, terms: &EdgeMap<f64>, quad: &Quad) -> Change {
        let before = sum_before(terms, quad);
        Change { before, after: self.terms_after(mesh, quad).iter().sum() }
    }

    /// The terms after the flip: the edge, then the sides. 0 for boundary edges.
    #[inline]
    fn terms_after(&self, mesh: &TriMesh, quad: &Quad) -> [f64; 5] {
        let [a, b, c, d] = corner_points(mesh, quad);
        let side = |side: HalfEdgeId, from, to, inner| {
            let outer = mesh.topology().apex(side.twin());
            outer.map_or(0.0, |outer| self.term(from, to, inner, mesh.position(outer)))
        };
        let [bc, ca, ad, db] = quad.sides;
        let turned = self.term(c, d, b, a);
        let mut terms =
            [turned, side(bc, b, c, d), side(ca, c, a, d), side(ad, a, d, c), side(db, d, b, c)];
        for (term, count) in zip(&mut terms, counts_after::<Self>(mesh.topology(), quad)) {
            *term *= count;
        }
        terms
    }

    /// [`EdgeSum::terms_after`] of up to [`QUADS`] quadrilaterals, vectorised.
    #[inline]
    fn all_terms_after(&self, mesh: &TriMesh, quads: &[Option<Quad>]) -> [[f64; QUADS]; 5] {
        let mut block = QuadBatch::<QUADS>::new();
        for (place, quad) in quads.iter().enumerate().take(QUADS) {
            let Some(quad) = quad else { continue };
            block.set(place, corner_points(mesh, quad));
            for (side, half_edge) in quad.sides.into_iter().enumerate() {
                if let Some(apex) = mesh.topology().apex(half_edge.twin()) {
                    block.set_outer(place, side, mesh.position(apex));
                }
            }
        }
        let mut terms = block.terms_after(self);
        for (place, quad) in quads.iter().enumerate().take(QUADS) {
            let Some(quad) = quad else { continue };
            for (terms, count) in zip(&mut terms, counts_after::<Self>(mesh.topology(), quad)) {
                terms[place] *= count;
            }
        }
        terms
    }
}

impl<T: EdgeTerm> EdgeSum for T {}

/// How often the term of an interior edge with these ends counts.
#[inline]
fn count<T: EdgeTerm>(topology: &Topology, [a, b]: [VertexId; 2]) -> f64 {
    if !T::COUNTS_AT_INTERIOR_ENDS {
        return 1.0;
    }
    let at = |end| if topology.is_boundary_vertex(end) { 0.0 } else { 1.0 };
    at(a) + at(b)
}

/// The counts of the terms after the flip, in the order of [`EdgeSum::terms_after`].
#[inline]
fn counts_after<T: EdgeTerm>(topology: &Topology, quad: &Quad) -> [f64; 5] {
    let [a, b, c, d] = quad.corners;
    let count = |from, to| count::<T>(topology, [from, to]);
    [count(c, d), count(b, c), count(c, a), count(a, d), count(d, b)]
}

/// Number of quadrilaterals per vectorised evaluation. A flip affects 13 edges.
pub(crate) const QUADS: usize = 16;

#[inline]
fn sum_before(terms: &EdgeMap<f64>, quad: &Quad) -> f64 {
    let [bc, ca, ad, db] = quad.sides;
    terms[quad.edge] + terms[bc.edge()] + terms[ca.edge()] + terms[ad.edge()] + terms[db.edge()]
}

/// Unrolled by hand: the compiler does not inline a map over the array.
#[inline]
fn corner_points(mesh: &TriMesh, quad: &Quad) -> [DVec3; 4] {
    let [a, b, c, d] = quad.corners;
    [mesh.position(a), mesh.position(b), mesh.position(c), mesh.position(d)]
}

/// The edge and the four sides of the quadrilateral.
#[inline]
pub(crate) fn edges(quad: &Quad) -> [EdgeId; 5] {
    let [bc, ca, ad, db] = quad.sides;
    [quad.edge, bc.edge(), ca.edge(), ad.edge(), db.edge()]
}

impl<T: EdgeTerm> FlipCost for T {
    type Cache = EdgeMap<f64>;

    fn prepare(&self, mesh: &TriMesh) -> EdgeMap<f64> {
        self.all_terms(mesh)
    }

    fn update(&self, mesh: &TriMesh, cache: &mut EdgeMap<f64>, flipped: &Quad) {
        self.update_terms(mesh, cache, flipped);
    }

    fn total(&self, mesh: &TriMesh) -> f64 {
        self.prepared_total(mesh, &self.all_terms(mesh))
    }

    fn prepared_total(&self, mesh: &TriMesh, terms: &EdgeMap<f64>) -> f64 {
        let terms = terms.as_slice();
        parallel::sum(terms.len(), |i| terms[i]) + EdgeTerm::constant(self, mesh)
    }

    fn constant(&self, mesh: &TriMesh) -> f64 {
        EdgeTerm::constant(self, mesh)
    }

    #[inline]
    fn change(&self, mesh: &TriMesh, cache: &EdgeMap<f64>, quad: &Quad) -> Change {
        self.change_of_terms(mesh, cache, quad)
    }

    fn changes_if_lower(
        &self,
        mesh: &TriMesh,
        cache: &EdgeMap<f64>,
        quads: &[Option<Quad>],
        changes: &mut [Option<Change>],
    ) {
        for (quads, changes) in zip(quads.chunks(QUADS), changes.chunks_mut(QUADS)) {
            let [turned, bc, ca, ad, db] = self.all_terms_after(mesh, quads);
            for (i, (change, quad)) in zip(changes, quads).enumerate().take(QUADS) {
                let after = [turned[i], bc[i], ca[i], ad[i], db[i]].iter().sum();
                *change =
                    quad.as_ref().map(|quad| Change { before: sum_before(cache, quad), after });
            }
        }
    }

    fn stencil(&self) -> Stencil {
        Stencil::AdjacentTriangles
    }

    fn length_exponent(&self) -> i32 {
        T::LENGTH_EXPONENT
    }
}
