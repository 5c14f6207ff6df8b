//! Faces round one vertex, and in which directions they lie from there.

use crate::directions::Directions;
use crate::extent::Extent;
use crate::handle::{FaceId, VertexId};
use crate::measure::BoundingBox;
use crate::mesh::TriMesh;

/// Faces that have a vertex in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fan {
    hub: VertexId,
    /// As they are seen from there.
    directions: Directions,
}

impl Fan {
    /// The faces round the common vertex from which they are seen in the fewest directions, if there is
    /// any.
    pub(crate) fn new(
        mesh: &TriMesh,
        faces: &(impl Iterator<Item = FaceId> + Clone),
    ) -> Option<Self> {
        let topology = mesh.topology();
        let mut others = faces.clone().map(|face| topology.face_vertices(face));
        let mut hubs = others.next()?.map(Some);
        for vertices in others {
            hubs = hubs.map(|hub| hub.filter(|hub| vertices.contains(hub)));
            if hubs == [None; 3] {
                return None;
            }
        }
        let round = |hub: VertexId| {
            let seen = faces.clone().filter_map(|face| {
                let corner = topology.face_vertices(face).iter().position(|&v| v == hub)?;
                Some(Directions::from_corner(mesh.triangle(face), corner))
            });
            Some(Self { hub, directions: seen.reduce(Directions::union)? })
        };
        let size = |fan: &Self| fan.directions.size();
        let fans = hubs.into_iter().flatten().filter_map(round);
        fans.min_by(|a, b| size(a).total_cmp(&size(b)))
    }

    /// All faces of two fans, if these are round one vertex.
    pub(crate) fn join(self, other: Self) -> Option<Self> {
        let directions = self.directions.union(other.directions);
        (self.hub == other.hub).then_some(Self { directions, ..self })
    }

    /// Whether a triangle may cross one of the faces, which are in a box.
    pub(crate) fn may_cross(self, mesh: &TriMesh, bounds: BoundingBox, triangle: &Extent) -> bool {
        match triangle.seen_from(self.hub) {
            Some(seen) => seen.meet(self.directions),
            None => {
                let hub = mesh.position(self.hub);
                triangle.may_meet(bounds) && !self.directions.are_beside(hub, triangle.triangle.1)
            }
        }
    }
}
