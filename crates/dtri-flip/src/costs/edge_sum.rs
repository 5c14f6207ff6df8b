//! Costs that are sums over the edges between two triangles of a function of their four vertices.

use glam::DVec3;
use mesh_core::{EdgeId, EdgeMap, HalfEdgeId, Handle, TriMesh, parallel};

use crate::cost::Change;
use crate::quad::Quad;

/// The term of one edge, from `a`, `b`, the left apex and the right apex.
pub(crate) trait EdgeTerm: Sync {
    fn term(&self, a: DVec3, b: DVec3, left: DVec3, right: DVec3) -> f64;

    /// The term of an edge as it is; 0 for edges that are not between two triangles.
    #[inline]
    fn of_edge(&self, mesh: &TriMesh, edge: EdgeId) -> f64 {
        let topology = mesh.topology();
        if !topology.contains_edge(edge) {
            return 0.0;
        }
        Quad::around(topology, edge).map_or(0.0, |quad| {
            let [a, b, c, d] = quad.corners.map(|v| mesh.position(v));
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
        let before = edges(quad).map(|e| terms[e]).iter().sum();
        let [a, b, c, d] = quad.corners.map(|v| mesh.position(v));
        let (inner, [bc, ca, ad, db]) = ([d, d, c, c], quad.sides);
        let after = self.term(c, d, b, a)
            + self.side(mesh, bc, [b, c], inner[0])
            + self.side(mesh, ca, [c, a], inner[1])
            + self.side(mesh, ad, [a, d], inner[2])
            + self.side(mesh, db, [d, b], inner[3]);
        Change { before, after }
    }

    /// The term of a side of the quadrilateral with this apex inside.
    #[inline]
    fn side(&self, mesh: &TriMesh, side: HalfEdgeId, [from, to]: [DVec3; 2], inner: DVec3) -> f64 {
        mesh.topology()
            .apex(side.twin())
            .map_or(0.0, |outer| self.term(from, to, inner, mesh.position(outer)))
    }
}

/// The edge and the four sides of the quadrilateral.
#[inline]
pub(crate) fn edges(quad: &Quad) -> [EdgeId; 5] {
    let [bc, ca, ad, db] = quad.sides.map(HalfEdgeId::edge);
    [quad.edge, bc, ca, ad, db]
}
