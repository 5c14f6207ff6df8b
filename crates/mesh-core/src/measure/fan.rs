//! Bounds for long thin faces around one vertex: the directions in which they lie.

use glam::DVec3;

use crate::measure::BoundingBox;
use crate::measure::direction_box::DirectionBox;
use crate::measure::triangle_bounds::TriangleBounds;
use crate::mesh::TriMesh;
use crate::topology::handle::{FaceId, VertexId};

/// Long thin faces with their apex at one vertex. Other faces are few at a vertex, and their boxes separate
/// them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fan {
    hub: VertexId,
    /// Their directions from the apex.
    directions: DirectionBox,
}

impl Fan {
    /// The fan of some faces, if all are long, thin and have a common apex.
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

    /// The union of two fans with the same apex.
    pub(crate) fn join(self, other: Self) -> Option<Self> {
        let directions = self.directions.union(other.directions);
        (self.hub == other.hub).then_some(Self { directions, ..self })
    }

    /// Whether a triangle may cross one of the faces, which lie in `bounds`.
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

/// The apex of a long thin triangle: the corner opposite to a side that is much shorter than the others.
pub(crate) fn tip([a, b, c]: [DVec3; 3]) -> Option<usize> {
    const SLENDER: f64 = 16.0;
    let [at_a, at_b, at_c] = [(b, c), (c, a), (a, b)].map(|(p, q)| p.distance_squared(q));
    let sides = [(at_a, at_b.min(at_c)), (at_b, at_c.min(at_a)), (at_c, at_a.min(at_b))];
    sides.into_iter().position(|(across, along)| SLENDER * across < along)
}
