//! Costs that are sums over the edges between two triangles of a function of their four vertices.

use core::iter::zip;

use glam::DVec3;
use mesh_core::{EdgeId, EdgeMap, HalfEdgeId, Handle, TriMesh, parallel};

use super::hinges::Hinges;
use crate::cost::{Change, FlipCost, Reach};
use crate::quad::Quad;

/// The term of one edge, from `a`, `b`, the left apex and the right apex.
pub(crate) trait EdgeTerm: Sync + Sized {
    /// The power of a length that a term has as its unit.
    const LENGTH_EXPONENT: i32;

    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64;

    /// The terms of up to `N` edges as they are; 0 for edges that are not between two triangles.
    #[inline]
    fn terms_of<const N: usize>(
        &self,
        mesh: &TriMesh,
        edges: impl Iterator<Item = EdgeId>,
    ) -> [f64; N] {
        let topology = mesh.topology();
        let mut hinges = Hinges::<N>::new();
        let mut inside = [false; N];
        for (place, edge) in edges.enumerate().take(N) {
            if topology.contains_edge(edge)
                && let Some(quad) = Quad::around(topology, edge)
            {
                hinges.set(place, corner_points(mesh, &quad));
                inside[place] = true;
            }
        }
        let mut terms = hinges.terms(self);
        for (term, inside) in zip(&mut terms, inside) {
            *term = if inside { *term } else { 0.0 };
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

    /// Computes the terms of the edge and of the four sides anew.
    fn update_terms(&self, mesh: &TriMesh, terms: &mut EdgeMap<f64>, flipped: &Quad) {
        let edges = edges(flipped);
        let new_terms = self.terms_of::<8>(mesh, edges.into_iter());
        for (edge, term) in zip(edges, new_terms) {
            terms[edge] = term;
        }
    }

    /// What the flip does to the terms of the edge and of its four sides.
    #[inline]
    fn change_of_terms(&self, mesh: &TriMesh, terms: &EdgeMap<f64>, quad: &Quad) -> Change {
        let before = sum_before(terms, quad);
        Change { before, after: self.terms_after(mesh, quad).iter().sum() }
    }

    /// The terms after the flip: of the edge, then of the sides; 0 for boundary edges.
    #[inline]
    fn terms_after(&self, mesh: &TriMesh, quad: &Quad) -> [f64; 5] {
        let mut terms = [0.0; 5];
        for_hinges_after(mesh, quad, |kind, [a, b, left, right]| {
            terms[kind] = self.term(a, b, left, right);
        });
        terms
    }

    /// [`EdgeTerm::terms_after`] of up to [`QUADS`] quadrilaterals side by side.
    #[inline]
    fn all_terms_after(&self, mesh: &TriMesh, quads: &[Option<Quad>]) -> [[f64; 5]; QUADS] {
        let mut hinges = Hinges::<{ 5 * QUADS }>::new();
        let mut present = [false; 5 * QUADS];
        for (place, quad) in quads.iter().enumerate().take(QUADS) {
            let Some(quad) = quad else { continue };
            for_hinges_after(mesh, quad, |kind, points| {
                hinges.set(5 * place + kind, points);
                present[5 * place + kind] = true;
            });
        }
        let mut terms = hinges.terms(self);
        for (term, present) in zip(&mut terms, present) {
            *term = if present { *term } else { 0.0 };
        }
        let (terms, _) = terms.as_chunks();
        let mut by_quad = [[0.0; 5]; QUADS];
        by_quad.copy_from_slice(terms);
        by_quad
    }
}

/// Calls a function for each edge whose term the flip changes, as it is after the flip: 0 is the
/// edge, 1 to 4 are the sides that are not boundary edges.
#[inline(always)]
fn for_hinges_after(mesh: &TriMesh, quad: &Quad, mut call: impl FnMut(usize, [DVec3; 4])) {
    let topology = mesh.topology();
    let [a, b, c, d] = corner_points(mesh, quad);
    let [bc, ca, ad, db] = quad.sides;
    call(0, [c, d, b, a]);
    if let Some(outer) = topology.apex(bc.twin()) {
        call(1, [b, c, d, mesh.position(outer)]);
    }
    if let Some(outer) = topology.apex(ca.twin()) {
        call(2, [c, a, d, mesh.position(outer)]);
    }
    if let Some(outer) = topology.apex(ad.twin()) {
        call(3, [a, d, c, mesh.position(outer)]);
    }
    if let Some(outer) = topology.apex(db.twin()) {
        call(4, [d, b, c, mesh.position(outer)]);
    }
}

/// How many quadrilaterals are evaluated side by side: a flip affects 12 others that share an edge
/// with a face of its own, and itself.
pub(crate) const QUADS: usize = 16;

#[inline]
fn sum_before(terms: &EdgeMap<f64>, quad: &Quad) -> f64 {
    let [bc, ca, ad, db] = quad.sides;
    terms[quad.edge] + terms[bc.edge()] + terms[ca.edge()] + terms[ad.edge()] + terms[db.edge()]
}

/// Written out, since the compiler keeps a map over the array as a call.
#[inline]
fn corner_points(mesh: &TriMesh, quad: &Quad) -> [DVec3; 4] {
    let [a, b, c, d] = quad.corners;
    [mesh.position(a), mesh.position(b), mesh.position(c), mesh.position(d)]
}

/// The edge and the four sides of the quadrilateral.
#[inline]
pub(crate) fn edges(quad: &Quad) -> [EdgeId; 5] {
    let [bc, ca, ad, db] = quad.sides.map(HalfEdgeId::edge);
    [quad.edge, bc, ca, ad, db]
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

    fn prepared_total(&self, _: &TriMesh, terms: &EdgeMap<f64>) -> f64 {
        let terms = terms.as_slice();
        parallel::sum(terms.len(), |i| terms[i])
    }

    #[inline]
    fn change(&self, mesh: &TriMesh, cache: &EdgeMap<f64>, quad: &Quad) -> Change {
        self.change_of_terms(mesh, cache, quad)
    }

    /// Terms are never negative: once those after the flip add up to more than those before it, the
    /// rest does not matter.
    #[inline]
    fn change_if_lower(&self, mesh: &TriMesh, cache: &EdgeMap<f64>, quad: &Quad) -> Option<Change> {
        let before = sum_before(cache, quad);
        let mut after = 0.0;
        for_hinges_after(mesh, quad, |_, [a, b, left, right]| {
            if after < before {
                after += self.term(a, b, left, right);
            }
        });
        (after < before).then_some(Change { before, after })
    }

    fn changes_if_lower(
        &self,
        mesh: &TriMesh,
        cache: &EdgeMap<f64>,
        quads: &[Option<Quad>],
        changes: &mut [Option<Change>],
    ) {
        for (quads, changes) in zip(quads.chunks(QUADS), changes.chunks_mut(QUADS)) {
            let terms_after = self.all_terms_after(mesh, quads);
            for ((change, quad), terms) in zip(zip(changes, quads), terms_after) {
                let change_of =
                    |quad| Change { before: sum_before(cache, quad), after: terms.iter().sum() };
                *change = quad.as_ref().map(change_of);
            }
        }
    }

    fn reach(&self) -> Reach {
        Reach::AdjacentTriangles
    }

    fn length_exponent(&self) -> i32 {
        T::LENGTH_EXPONENT
    }
}
