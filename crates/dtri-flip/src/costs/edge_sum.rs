//! Costs that are sums over the edges between two triangles of a function of their four vertices.

use glam::DVec3;
use mesh_core::{EdgeId, EdgeMap, HalfEdgeId, Handle, TriMesh, parallel};

use crate::cost::{Change, FlipCost, Reach};
use crate::quad::Quad;

/// The term of one edge, from `a`, `b`, the left apex and the right apex.
pub(crate) trait EdgeTerm: Sync {
    /// The power of a length that a term has as its unit.
    const LENGTH_EXPONENT: i32;

    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64;

    /// The term of an edge as it is; 0 for edges that are not between two triangles.
    #[inline]
    fn of_edge(&self, mesh: &TriMesh, edge: EdgeId) -> f64 {
        let topology = mesh.topology();
        if !topology.contains_edge(edge) {
            return 0.0;
        }
        Quad::around(topology, edge).map_or(0.0, |quad| {
            let [a, b, c, d] = corner_points(mesh, &quad);
            self.term(a, b, c, d)
        })
    }

    fn all_terms(&self, mesh: &TriMesh) -> EdgeMap<f64> {
        let count = mesh.topology().edge_capacity();
        EdgeMap::from_vec(parallel::collect(count, |i| self.of_edge(mesh, EdgeId::from_index(i))))
    }

    fn sum(&self, mesh: &TriMesh) -> f64 {
        let count = mesh.topology().edge_capacity();
        parallel::sum(count, |i| self.of_edge(mesh, EdgeId::from_index(i)))
    }

    fn update_terms(&self, mesh: &TriMesh, terms: &mut EdgeMap<f64>, flipped: &Quad) {
        for edge in edges(flipped) {
            terms[edge] = self.of_edge(mesh, edge);
        }
    }

    /// What the flip does to the terms of the edge and of its four sides.
    #[inline]
    fn change_of_terms(&self, mesh: &TriMesh, terms: &EdgeMap<f64>, quad: &Quad) -> Change {
        let before = sum_before(terms, quad);
        let after = self.new_terms(mesh, quad).fold(0.0, |sum, term| sum + term);
        Change { before, after }
    }

    /// The same when it is a gain. Terms are never negative: once those after the flip add up to
    /// more than those before it, the rest does not matter.
    #[inline]
    fn lower_change_of_terms(
        &self,
        mesh: &TriMesh,
        terms: &EdgeMap<f64>,
        quad: &Quad,
    ) -> Option<Change> {
        let before = sum_before(terms, quad);
        let mut after = 0.0;
        for term in self.new_terms(mesh, quad) {
            after += term;
            if after >= before {
                return None;
            }
        }
        Some(Change { before, after })
    }

    /// The terms after the flip: of the edge, then of the sides, each computed when it is asked for.
    #[inline]
    fn new_terms(&self, mesh: &TriMesh, quad: &Quad) -> impl Iterator<Item = f64> {
        let [a, b, c, d] = corner_points(mesh, quad);
        let sides = [([b, c], d), ([c, a], d), ([a, d], c), ([d, b], c)];
        let of_side = move |(side, (ends, inner))| self.side(mesh, side, ends, inner);
        let diagonal = core::iter::once_with(move || self.term(c, d, b, a));
        diagonal.chain(quad.sides.into_iter().zip(sides).map(of_side))
    }

    /// The term of a side of the quadrilateral with this apex inside.
    #[inline]
    fn side(&self, mesh: &TriMesh, side: HalfEdgeId, [from, to]: [DVec3; 2], inner: DVec3) -> f64 {
        mesh.topology()
            .apex(side.twin())
            .map_or(0.0, |outer| self.term(from, to, inner, mesh.position(outer)))
    }
}

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
        self.sum(mesh)
    }

    #[inline]
    fn change(&self, mesh: &TriMesh, cache: &EdgeMap<f64>, quad: &Quad) -> Change {
        self.change_of_terms(mesh, cache, quad)
    }

    #[inline]
    fn change_if_lower(&self, mesh: &TriMesh, cache: &EdgeMap<f64>, quad: &Quad) -> Option<Change> {
        self.lower_change_of_terms(mesh, cache, quad)
    }

    fn reach(&self) -> Reach {
        Reach::AdjacentTriangles
    }

    fn length_exponent(&self) -> i32 {
        T::LENGTH_EXPONENT
    }
}
