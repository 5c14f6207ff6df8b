//! The total absolute extrinsic curvature of Alboul and van Damme.

use dcurv::{VertexStar, extrinsic_curvatures, total_extrinsic_curvature};
use glam::DVec3;
use mesh_core::{TriMesh, VertexId, VertexMap, parallel};

use crate::cost::{Change, FlipCost, Stencil};
use crate::quad::Quad;

/// `sum over vertices of K+ + K-` (Alboul and van Damme 1996), in radians; see [`dcurv::extrinsic`].
///
/// At least `4 pi` on a closed surface, with equality exactly for the convex hull if all vertices are
/// corners of it. Boundary vertices add nothing. Each evaluation computes the hulls of four stars.
///
/// Shape constraint: [`KeepShape`](crate::ShapeConstraint::KeepShape). A folded face raises this cost only
/// if it changes the hull of a star.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AbsExtrinsic;

impl FlipCost for AbsExtrinsic {
    /// The term of each vertex.
    type Cache = VertexMap<f64>;

    fn prepare(&self, mesh: &TriMesh) -> VertexMap<f64> {
        extrinsic_curvatures(mesh).map(|curvature| curvature.absolute().value())
    }

    fn update(&self, mesh: &TriMesh, cache: &mut VertexMap<f64>, flipped: &Quad) {
        let mut ring = Vec::new();
        for vertex in flipped.corners {
            cache[vertex] = term(mesh, vertex, &mut ring, RingChange::None);
        }
    }

    fn total(&self, mesh: &TriMesh) -> f64 {
        total_extrinsic_curvature(mesh).value()
    }

    fn prepared_total(&self, _: &TriMesh, cache: &VertexMap<f64>) -> f64 {
        let terms = cache.as_slice();
        parallel::sum(terms.len(), |index| terms[index])
    }

    fn change(&self, mesh: &TriMesh, cache: &VertexMap<f64>, quad: &Quad) -> Change {
        let [a, b, c, d] = quad.corners;
        let changes = [
            RingChange::Without(b),
            RingChange::Without(a),
            RingChange::Between([a, b], d),
            RingChange::Between([a, b], c),
        ];
        let mut ring = Vec::new();
        let (mut before, mut after) = (0.0, 0.0);
        for (vertex, change) in quad.corners.into_iter().zip(changes) {
            before += cache[vertex];
            after += term(mesh, vertex, &mut ring, change);
        }
        Change { before, after }
    }

    fn stencil(&self) -> Stencil {
        Stencil::CornerStars
    }

    fn length_exponent(&self) -> i32 {
        0
    }
}

/// The change of a one-ring by a flip.
#[derive(Clone, Copy)]
enum RingChange {
    None,
    /// This neighbour is removed.
    Without(VertexId),
    /// A neighbour is added between two consecutive ones.
    Between([VertexId; 2], VertexId),
}

/// `K+ + K-` of a vertex after a change of its one-ring; 0 for boundary vertices.
fn term(mesh: &TriMesh, vertex: VertexId, ring: &mut Vec<DVec3>, change: RingChange) -> f64 {
    let topology = mesh.topology();
    if topology.is_boundary_vertex(vertex) {
        return 0.0;
    }
    ring.clear();
    let mut last = None;
    for neighbour in topology.one_ring(vertex) {
        match change {
            RingChange::Without(removed) if removed == neighbour => continue,
            RingChange::Between([p, q], added)
                if (last, neighbour) == (Some(p), q) || (last, neighbour) == (Some(q), p) =>
            {
                ring.push(mesh.position(added));
            }
            _ => {}
        }
        ring.push(mesh.position(neighbour));
        last = Some(neighbour);
    }
    // The two neighbours may be the last and the first one.
    if let RingChange::Between([p, q], added) = change
        && let Some(first) = topology.one_ring(vertex).next()
        && ((last, first) == (Some(p), q) || (last, first) == (Some(q), p))
        && topology.valence(vertex) > 2
    {
        ring.push(mesh.position(added));
    }
    VertexStar { center: mesh.position(vertex), ring, closed: true }.extrinsic().absolute().value()
}
