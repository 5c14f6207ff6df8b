//! Costs that are sums over faces: the total area and the harmonic index.

use mesh_core::{FaceId, Handle, TriMesh, VertexId, parallel};

use crate::cost::{Change, FlipCost, Stencil};
use crate::quad::Quad;
use crate::shape::ShapeConstraint;

/// Sum over the faces of a function of their corners.
///
/// Shape constraint: [`ShapeConstraint::Convex`]. Both functions compare the two diagonals of a
/// quadrilateral. In a quadrilateral that is not convex, the second diagonal is outside. The two new
/// triangles then overlap and may have smaller terms than the old ones although they fold the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FaceCost(pub FaceFunction);

/// The summand of a [`FaceCost`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FaceFunction {
    /// Area. Minimises the total area. In squares of the model unit.
    Area,
    /// Sum of the cotangents of the three angles, `(a² + b² + c²) / (4 area)`: the harmonic index.
    /// No unit. At most 10¹⁵, the value for faces without area.
    ///
    /// In the plane, the flip of a convex quadrilateral lowers the sum exactly if the edge violates the
    /// Delaunay criterion, so the Delaunay triangulation is the only local minimum (Musin 1997). On a
    /// surface it differs from the intrinsic criterion: the flipped edge is a straight segment.
    Cotangents,
}

const COTANGENTS_WITHOUT_AREA: f64 = 1e15;

impl FaceFunction {
    #[inline]
    fn of(self, mesh: &TriMesh, corners: [VertexId; 3]) -> f64 {
        let [a, b, c] = corners.map(|v| mesh.position(v));
        let (u, w) = (b - a, c - a);
        let twice_area = u.cross(w).length();
        match self {
            Self::Area => 0.5 * twice_area,
            Self::Cotangents => {
                let squares = u.length_squared() + w.length_squared() + (w - u).length_squared();
                let sum = squares / (2.0 * twice_area);
                // Also for 0 / 0.
                if sum < COTANGENTS_WITHOUT_AREA { sum } else { COTANGENTS_WITHOUT_AREA }
            }
        }
    }

    fn sum(self, mesh: &TriMesh, triangles: [[VertexId; 3]; 2]) -> f64 {
        triangles.map(|corners| self.of(mesh, corners)).iter().sum()
    }
}

impl FlipCost for FaceCost {
    type Cache = ();

    fn prepare(&self, _: &TriMesh) {}

    fn total(&self, mesh: &TriMesh) -> f64 {
        let topology = mesh.topology();
        parallel::sum(topology.face_capacity(), |index| {
            let face = FaceId::from_index(index);
            if topology.contains_face(face) {
                self.0.of(mesh, topology.face_vertices(face))
            } else {
                0.0
            }
        })
    }

    #[inline]
    fn change(&self, mesh: &TriMesh, _: &(), quad: &Quad) -> Change {
        Change {
            before: self.0.sum(mesh, quad.triangles()),
            after: self.0.sum(mesh, quad.flipped_triangles()),
        }
    }

    fn stencil(&self) -> Stencil {
        Stencil::Triangles
    }

    fn shape_constraint(&self) -> ShapeConstraint {
        ShapeConstraint::Convex
    }

    fn length_exponent(&self) -> i32 {
        match self.0 {
            FaceFunction::Area => 2,
            FaceFunction::Cotangents => 0,
        }
    }
}
