//! Needles round one vertex, and in which directions they lie from there.

use glam::DVec3;

use crate::measure::BoundingBox;
use crate::measure::direction_box::DirectionBox;
use crate::measure::triangle_bounds::TriangleBounds;
use crate::mesh::TriMesh;
use crate::topology::handle::{FaceId, VertexId};

/// Needles with their tips at one vertex. Faces that are no needles are few round a vertex, and their
/// boxes tell them apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fan {
    hub: VertexId,
    /// As they are seen from there.
    directions: DirectionBox,
}

impl Fan {
    /// The faces, if they are needles with a common tip.
    pub(crate) fn new(
        mesh: &TriMesh,
        faces: &(impl Iterator<Item = FaceId> + Clone),
    ) -> Option<Self> {
        let topology = mesh.topology();
        let mut tips = faces.clone().map(|face| {
            let triangle = mesh.triangle(face);
            tip(triangle).map(|corner| (topology.face_vertices(face)[corner], triangle, corner))
        });
        let (hub, triangle, corner) = tips.next()??;
        let mut directions = DirectionBox::from_corner(triangle, corner);
        for tip in tips {
            let (_, triangle, corner) = tip.filter(|&(vertex, ..)| vertex == hub)?;
            directions = directions.union(DirectionBox::from_corner(triangle, corner));
        }
        Some(Self { hub, directions })
    }

    /// All faces of two fans, if these are round one vertex.
    pub(crate) fn join(self, other: Self) -> Option<Self> {
        let directions = self.directions.union(other.directions);
        (self.hub == other.hub).then_some(Self { directions, ..self })
    }

    /// Whether a triangle may cross one of the faces, which are in a box.
    pub(crate) fn may_cross(
        self,
        mesh: &TriMesh,
        bounds: BoundingBox,
        triangle: &TriangleBounds,
    ) -> bool {
        match triangle.seen_from(self.hub) {
            Some(seen) => seen.meet(self.directions),
            None => {
                let hub = mesh.position(self.hub);
                triangle.may_meet(bounds) && !self.directions.are_beside(hub, triangle.triangle.1)
            }
        }
    }
}

/// The corner of a needle that its shortest side is far from.
fn tip([a, b, c]: [DVec3; 3]) -> Option<usize> {
    const SLENDER: f64 = 16.0;
    let [at_a, at_b, at_c] = [(b, c), (c, a), (a, b)].map(|(p, q)| p.distance_squared(q));
    let sides = [(at_a, at_b.min(at_c)), (at_b, at_c.min(at_a)), (at_c, at_a.min(at_b))];
    sides.into_iter().position(|(across, along)| SLENDER * across < along)
}
