//! Edge collapse: the two ends of an edge become one vertex.
//!
//! ```text
//!            c                          c
//!          / | \                        |
//!        ca  |  bc                      | bc
//!       /    |    \                     |
//!  --- a --- h --> b ---      --->  ----b----
//!       \    |    /                     |
//!        ad  |  db                      | db
//!          \ | /                        |
//!            d                          d
//! ```
//!
//! The half-edge `h` runs from `a`, which is removed, to `b`, which stays. Both faces of the edge are removed, and with
//! each of them its edge at `a`: `bc` takes the place of `ca`, and `db` the place of `ad`.

use crate::topology::Topology;
use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId, VertexId};
use crate::topology::revision::State;

/// Why an edge cannot be collapsed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum CollapseRefusal {
    /// The half-edge is not in the mesh.
    #[error("{0:?} is not in the mesh")]
    NotInMesh(HalfEdgeId),
    /// The link condition fails: the ends share a neighbour that is not an apex of the edge's
    /// faces, so that the collapse would glue edges together.
    #[error("the ends of the edge share the neighbour {0:?}, which is not opposite to the edge")]
    LinkCondition(VertexId),
    /// An interior edge joins two boundary vertices; the collapse would pinch the surface.
    #[error("the edge crosses the surface from boundary to boundary")]
    JoinsBoundaries,
    /// A face of the edge has nothing but boundary on its other two sides; the collapse would
    /// leave an edge without a face.
    #[error("{0:?} has no other neighbour, the collapse would leave an edge without a face")]
    LastFace(FaceId),
    /// The component is a tetrahedron; the collapse would leave two faces back to back.
    #[error("the component is a tetrahedron")]
    Tetrahedron,
}

/// A collapse that has been checked; see [`Topology::check_collapse`].
#[derive(Debug)]
#[must_use = "a checked collapse does nothing until it is applied"]
pub struct LegalCollapse {
    half_edge: HalfEdgeId,
    removed: VertexId,
    kept: VertexId,
    state: State,
}

impl LegalCollapse {
    /// The half-edge that is collapsed.
    #[must_use]
    pub fn half_edge(&self) -> HalfEdgeId {
        self.half_edge
    }

    /// The removed vertex: the origin of the half-edge.
    #[must_use]
    pub fn removed(&self) -> VertexId {
        self.removed
    }

    /// The remaining vertex: the target of the half-edge.
    #[must_use]
    pub fn kept(&self) -> VertexId {
        self.kept
    }
}

/// The elements that a collapse removed and replaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Collapsed {
    /// The vertex that is gone.
    pub removed_vertex: VertexId,
    /// The vertex that took its edges.
    pub kept_vertex: VertexId,
    /// The edge that is gone.
    pub removed_edge: EdgeId,
    /// The faces that are gone, left and right of the half-edge.
    pub removed_faces: [Option<FaceId>; 2],
    /// On each side, the edge that is gone and the one that took its place.
    pub merged_edges: [Option<(EdgeId, EdgeId)>; 2],
}

impl Topology {
    /// Checks whether the origin of a half-edge may be merged into its target.
    ///
    /// The link condition, in the form that includes boundaries: the two ends have no common neighbours except the
    /// apexes of the edge's faces, an interior edge does not join two boundary vertices, and the component is neither a
    /// single triangle nor a tetrahedron. Time: the number of neighbours of the end with fewer edges, times the number
    /// of their edges.
    ///
    /// # Errors
    /// The reason why the collapse would not leave a mesh.
    pub fn check_collapse(&self, half_edge: HalfEdgeId) -> Result<LegalCollapse, CollapseRefusal> {
        if !self.contains_half_edge(half_edge) {
            return Err(CollapseRefusal::NotInMesh(half_edge));
        }
        let twin = half_edge.twin();
        let (removed, kept) = (self.origin(half_edge), self.target(half_edge));
        let apexes = [self.apex(half_edge), self.apex(twin)];
        if let Some(vertex) = self.shared_neighbour(removed, kept, apexes) {
            return Err(CollapseRefusal::LinkCondition(vertex));
        }
        if let [Some(c), Some(d)] = apexes {
            if self.is_boundary_vertex(removed) && self.is_boundary_vertex(kept) {
                return Err(CollapseRefusal::JoinsBoundaries);
            }
            // The link condition between edges: `c` and `d` joined by an edge of a face at each
            // end. With no other common neighbours that is the tetrahedron.
            if self.has_valence_three(half_edge) && self.has_valence_three(twin) {
                let closes = |v: VertexId| !self.is_boundary_vertex(v);
                if closes(removed) && closes(kept) && self.find_half_edge(c, d).is_some() {
                    return Err(CollapseRefusal::Tetrahedron);
                }
            }
        }
        for side in [half_edge, twin] {
            let Some(face) = self.face(side) else { continue };
            let second = self.next(side);
            let third = self.next(second);
            if self.is_exterior(second.twin()) && self.is_exterior(third.twin()) {
                return Err(CollapseRefusal::LastFace(face));
            }
        }
        Ok(LegalCollapse { half_edge, removed, kept, state: self.revision.state() })
    }

    /// A common neighbour of two vertices other than the apexes: the first one in the one-ring of the vertex
    /// with fewer edges.
    fn shared_neighbour(
        &self,
        a: VertexId,
        b: VertexId,
        apexes: [Option<VertexId>; 2],
    ) -> Option<VertexId> {
        /// More than the valence of most vertices.
        const FEW: usize = 16;
        let (few, many) = if self.has_fewer_edges(b, a) { (b, a) } else { (a, b) };
        let mut others = self.one_ring(few).filter(|&v| v != many && !apexes.contains(&Some(v)));
        let (mut ring, mut of_many) = ([many; FEW], self.one_ring(many));
        for (slot, v) in ring.iter_mut().zip(&mut of_many) {
            *slot = v;
        }
        if of_many.next().is_none() {
            return others.find(|v| ring.contains(v));
        }
        others.find(|&v| self.find_half_edge(v, many).is_some())
    }

    /// Whether `a` has fewer edges than `b`. Time: proportional to the smaller valence.
    fn has_fewer_edges(&self, a: VertexId, b: VertexId) -> bool {
        let (mut a, mut b) = (self.outgoing(a), self.outgoing(b));
        loop {
            match (a.next(), b.next()) {
                (_, None) => return false,
                (None, Some(_)) => return true,
                _ => {}
            }
        }
    }

    /// Merges the origin of a half-edge into its target and removes the edge and its faces.
    ///
    /// Handles of everything else stay valid.
    ///
    /// # Panics
    /// When the mesh was edited after the collapse was checked.
    pub fn collapse(&mut self, collapse: LegalCollapse) -> Collapsed {
        self.advance(collapse.state);
        let LegalCollapse { half_edge: h, removed: a, kept: b, .. } = collapse;
        let removed_faces = [self.face(h), self.face(h.twin())];
        let anchors = [a, b].map(|v| self.vertex_half_edge[v.index()]);
        self.redirect(a, b);
        let left = self.close_left_of(h);
        let right = self.close_right_of(h.twin());
        let outgoing = left.map(|(_, bc)| bc).or(right.map(|(_, db)| db.twin()));
        self.remove_edge(h);
        self.vertex_half_edge[a.index()] = Some(HalfEdgeId::REMOVED);
        self.live_vertices -= 1;
        if let Some(outgoing) = outgoing {
            // An exterior half-edge that starts at `b` now started at `a` or `b` before, or replaced one that did.
            let merged = [left.map(|(_, bc)| bc), right.map(|(_, db)| db.twin())];
            self.anchor_vertex(b, outgoing, anchors.into_iter().chain(merged).flatten());
        }
        Collapsed {
            removed_vertex: a,
            kept_vertex: b,
            removed_edge: h.edge(),
            removed_faces,
            merged_edges: [left, right]
                .map(|side| side.map(|(gone, kept)| (gone.edge(), kept.edge()))),
        }
    }

    /// Makes every half-edge that points to `from` point to `to`.
    fn redirect(&mut self, from: VertexId, to: VertexId) {
        let Some(first) = self.half_edge_of_vertex(from) else { return };
        let mut outgoing = first;
        loop {
            self.half_edges[outgoing.twin().index()].target = to;
            outgoing = self.next(outgoing.twin());
            if outgoing == first {
                break;
            }
        }
    }

    /// Removes the face (h, bc, ca) and lets `bc` take the place of the other side of `ca`.
    /// At the boundary it only takes `h` out of its loop. Returns the edge sides `(ca, bc)`.
    fn close_left_of(&mut self, h: HalfEdgeId) -> Option<(HalfEdgeId, HalfEdgeId)> {
        let Some(face) = self.face(h) else {
            self.unlink(h);
            return None;
        };
        let bc = self.next(h);
        let ca = self.next(bc);
        self.replace(ca.twin(), bc);
        self.finish_face(face, ca, bc.twin());
        Some((ca, bc))
    }

    /// Removes the face (t, ad, db) and lets `db` take the place of the other side of `ad`.
    /// At the boundary it only takes `t` out of its loop. Returns the edge sides `(ad, db)`.
    fn close_right_of(&mut self, t: HalfEdgeId) -> Option<(HalfEdgeId, HalfEdgeId)> {
        let Some(face) = self.face(t) else {
            self.unlink(t);
            return None;
        };
        let ad = self.next(t);
        let db = self.next(ad);
        self.replace(ad.twin(), db);
        self.finish_face(face, ad.twin(), db);
        Some((ad, db))
    }

    /// Puts `stand_in` in the place of `gone` in its circuit.
    fn replace(&mut self, gone: HalfEdgeId, stand_in: HalfEdgeId) {
        let previous = self.previous(gone);
        let next = self.next(gone);
        self.link(previous, stand_in);
        self.link(stand_in, next);
        self.half_edges[stand_in.index()].face = self.face(gone);
        if let Some(face) = self.face(gone)
            && self.half_edge_of_face(face) == gone
        {
            self.face_half_edge[face.index()] = stand_in;
        }
    }

    /// Removes a face and the edge of `gone`. If the apex stored that edge, it gets `stand_in`,
    /// which starts at the apex too.
    fn finish_face(&mut self, face: FaceId, gone: HalfEdgeId, stand_in: HalfEdgeId) {
        let apex = self.origin(stand_in);
        let slot = &mut self.vertex_half_edge[apex.index()];
        if *slot == Some(gone) {
            *slot = Some(stand_in);
        }
        self.remove_edge(gone);
        self.face_half_edge[face.index()] = HalfEdgeId::REMOVED;
        self.live_faces -= 1;
    }

    /// Takes an exterior half-edge out of its loop.
    fn unlink(&mut self, exterior: HalfEdgeId) {
        let previous = self.previous(exterior);
        self.link(previous, self.next(exterior));
    }
}
