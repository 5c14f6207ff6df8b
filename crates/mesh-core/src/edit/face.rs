//! Adding and removing single faces.

use crate::edit::links::NoRoom;
use crate::topology::Topology;
use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId, VertexId};
use crate::topology::revision::State;

/// Why a face cannot be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum FaceRefusal {
    /// A corner is not in the mesh.
    #[error("{0:?} is not in the mesh")]
    VertexNotInMesh(VertexId),
    /// Two corners are the same vertex.
    #[error("the face uses {0:?} twice")]
    RepeatedVertex(VertexId),
    /// There is a face on this side of an edge already: the edge would have three faces, or two with opposite
    /// orientations.
    #[error("{0:?} has a face already")]
    SideTaken(HalfEdgeId),
    /// A corner is an interior vertex.
    #[error("{0:?} is an interior vertex")]
    InteriorVertex(VertexId),
    /// The face would touch the surface only at this vertex.
    #[error("the face would touch the surface only at {0:?}, which would be non-manifold")]
    Pinches(VertexId),
    /// The face would lie back to back with this one, which has the same corners.
    #[error("the face has the same vertices as {0:?}; the two would lie back to back")]
    Pillow(FaceId),
    /// The arrays are as long as 32-bit indices allow; compacting may make room.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
}

/// Why a face cannot be removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum RemovalRefusal {
    /// The face is not in the mesh.
    #[error("{0:?} is not in the mesh")]
    NotInMesh(FaceId),
    /// The remaining faces at this vertex would touch only there.
    #[error("the remaining faces at {0:?} would touch only there, which would be non-manifold")]
    Pinches(VertexId),
}

/// A face that may be added; see [`Topology::check_add_face`].
#[derive(Debug)]
#[must_use = "a checked face does nothing until it is added"]
pub struct LegalFace {
    corners: [VertexId; 3],
    /// The sides that are there already, from each corner to the next.
    sides: [Option<HalfEdgeId>; 3],
    state: State,
}

/// The removal of a face that has been checked; see [`Topology::check_remove_face`].
#[derive(Debug)]
#[must_use = "a checked removal does nothing until it is applied"]
pub struct LegalRemoval {
    face: FaceId,
    state: State,
}

/// The elements that adding a face made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AddedFace {
    /// The new face; it starts at the first corner given.
    pub face: FaceId,
    /// Of its three sides, from each corner to the next, those whose edge is new.
    pub new_edges: [Option<EdgeId>; 3],
}

/// The elements that removing a face removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RemovedFace {
    /// The removed face.
    pub face: FaceId,
    /// Per side, the edge that was removed because it had no other face.
    pub removed_edges: [Option<EdgeId>; 3],
    /// Its corners that no face uses any more. They stay in the mesh as isolated vertices.
    pub isolated: [Option<VertexId>; 3],
}

impl Topology {
    /// Adds an isolated vertex.
    ///
    /// # Errors
    /// The mesh has as many elements as 32-bit indices allow.
    pub fn add_vertex(&mut self) -> Result<VertexId, NoRoom> {
        self.check_room(1, 0, 0)?;
        self.revision.advance();
        Ok(self.push_vertex())
    }

    /// Removes all vertices without edges, and returns their number.
    pub fn remove_isolated_vertices(&mut self) -> usize {
        let before = self.live_vertices;
        for slot in self.vertex_half_edge.iter_mut().filter(|slot| slot.is_none()) {
            *slot = Some(HalfEdgeId::REMOVED);
            self.live_vertices -= 1;
        }
        if self.live_vertices < before {
            self.revision.advance();
        }
        before - self.live_vertices
    }

    /// Checks whether a face may be added between three vertices, counter-clockwise seen from
    /// outside.
    ///
    /// The surface stays an oriented 2-manifold: sides that are edges already must be free on the face's side, and
    /// corners must be isolated, or joined to the face by a side. Time: the number of edges at the corners.
    ///
    /// # Errors
    /// The reason why the result would not be a mesh.
    pub fn check_add_face(&self, corners: [VertexId; 3]) -> Result<LegalFace, FaceRefusal> {
        if let Some(&vertex) = corners.iter().find(|&&v| !self.contains_vertex(v)) {
            return Err(FaceRefusal::VertexNotInMesh(vertex));
        }
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            return Err(FaceRefusal::RepeatedVertex(if b == c { b } else { a }));
        }
        let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| self.find_half_edge(from, to));
        if let Some(side) = sides.into_iter().flatten().find(|&h| !self.is_exterior(h)) {
            return Err(FaceRefusal::SideTaken(side));
        }
        for (i, vertex) in corners.into_iter().enumerate() {
            let is_joined = sides[i].or(sides[(i + 2) % 3]).is_some();
            if !is_joined && !self.is_isolated_vertex(vertex) {
                return Err(if self.is_boundary_vertex(vertex) {
                    FaceRefusal::Pinches(vertex)
                } else {
                    FaceRefusal::InteriorVertex(vertex)
                });
            }
        }
        if let [Some(first), Some(second), Some(third)] = sides
            && let [Some(face), across, opposite] =
                [first, second, third].map(|h| self.face(h.twin()))
            && across == Some(face)
            && opposite == Some(face)
        {
            return Err(FaceRefusal::Pillow(face));
        }
        self.check_room(0, 3, 1)?;
        Ok(LegalFace { corners, sides, state: self.revision.state() })
    }

    /// Adds a face. Handles of everything else stay valid.
    ///
    /// # Panics
    /// When the mesh was edited after the face was checked.
    pub fn add_face(&mut self, face: LegalFace) -> AddedFace {
        self.advance(face.state);
        let LegalFace { corners, sides: given, .. } = face;
        let neighbours: [_; 3] = core::array::from_fn(|i| self.exterior_neighbours(given, i));
        let sides: [HalfEdgeId; 3] = core::array::from_fn(|i| {
            given[i].unwrap_or_else(|| self.push_edge(corners[i], corners[(i + 1) % 3]))
        });
        for (i, corner) in corners.into_iter().enumerate() {
            // The boundary runs along the new sides: `out` outwards, `back` towards the corner.
            let (entering, leaving) = (sides[(i + 2) % 3].twin(), sides[i].twin());
            match (given[(i + 2) % 3], given[i]) {
                (Some(_), Some(_)) => continue,
                (Some(_), None) => neighbours[i].iter().for_each(|&h| self.link(leaving, h)),
                (None, Some(_)) => neighbours[i].iter().for_each(|&h| self.link(h, entering)),
                (None, None) => self.link(leaving, entering),
            }
            if given[(i + 2) % 3].is_none() {
                self.vertex_half_edge[corner.index()] = Some(entering);
            }
        }
        let face = self.push_circuit(sides);
        let is_new = |i: usize| given[i].is_none().then(|| sides[i].edge());
        AddedFace { face, new_edges: core::array::from_fn(is_new) }
    }

    /// At the corner where side `i` starts, if one of the two sides there is given: the exterior
    /// half-edge that follows the given one, or comes before it.
    fn exterior_neighbours(&self, given: [Option<HalfEdgeId>; 3], i: usize) -> Option<HalfEdgeId> {
        match (given[(i + 2) % 3], given[i]) {
            (Some(before), None) => Some(self.next(before)),
            (None, Some(after)) => Some(self.previous(after)),
            _ => None,
        }
    }

    /// Checks whether a face may be removed.
    ///
    /// The face is not in the mesh, or the surface would be pinched at one of its corners: a boundary vertex where the
    /// face has neighbours on both sides.
    pub fn check_remove_face(&self, face: FaceId) -> Result<LegalRemoval, RemovalRefusal> {
        if !self.contains_face(face) {
            return Err(RemovalRefusal::NotInMesh(face));
        }
        let sides = self.face_half_edges(face);
        let is_edge_of_surface = sides.map(|h| self.is_exterior(h.twin()));
        for (i, &side) in sides.iter().enumerate() {
            let corner = self.origin(side);
            let is_last = is_edge_of_surface[i] || is_edge_of_surface[(i + 2) % 3];
            if self.is_boundary_vertex(corner) && !is_last {
                return Err(RemovalRefusal::Pinches(corner));
            }
        }
        Ok(LegalRemoval { face, state: self.revision.state() })
    }

    /// Removes a face and its edges that have no other face. Handles of everything else stay valid.
    ///
    /// # Panics
    /// When the mesh was edited after the removal was checked.
    pub fn remove_face(&mut self, removal: LegalRemoval) -> RemovedFace {
        self.advance(removal.state);
        let sides = self.face_half_edges(removal.face);
        let corners = self.face_vertices(removal.face);
        let goes = sides.map(|h| self.is_exterior(h.twin()));
        // At each corner, the boundary links that are not between sides of the face.
        let links: [_; 3] = core::array::from_fn(|i| {
            let (before, after) = ((i + 2) % 3, i);
            match (goes[before], goes[after]) {
                (true, true) | (false, false) => None,
                (true, false) => Some((self.previous(sides[before].twin()), sides[after])),
                (false, true) => Some((sides[before], self.next(sides[after].twin()))),
            }
        });
        for h in sides {
            self.half_edges[h.index()].face = None;
        }
        let mut isolated = [None; 3];
        for (i, corner) in corners.into_iter().enumerate() {
            if let Some((previous, next)) = links[i] {
                self.link(previous, next);
            }
            if !goes[i] {
                self.vertex_half_edge[corner.index()] = Some(sides[i]);
            } else if goes[(i + 2) % 3] {
                self.vertex_half_edge[corner.index()] = None;
                isolated[i] = Some(corner);
            }
        }
        self.face_half_edge[removal.face.index()] = HalfEdgeId::REMOVED;
        self.live_faces -= 1;
        let removed_edges = core::array::from_fn(|i| goes[i].then(|| sides[i].edge()));
        sides
            .into_iter()
            .zip(goes)
            .filter(|(_, goes)| *goes)
            .for_each(|(h, _)| self.remove_edge(h));
        RemovedFace { face: removal.face, removed_edges, isolated }
    }
}
