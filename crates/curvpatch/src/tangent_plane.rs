//! The tangent plane of a surface point, with a frame for directions.

use glam::{DVec2, DVec3};
use mesh_core::{FaceId, TriMesh};

use crate::curvature_error::CurvatureError;
use crate::direction::Direction;
use crate::section_plane::SectionPlane;
use crate::surface_point::SurfacePoint;

/// A point with a normal n and orthonormal tangents t₀ and t₁ = n × t₀.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TangentPlane {
    pub(crate) face: FaceId,
    pub(crate) origin: DVec3,
    pub(crate) tangents: [DVec3; 2],
    pub(crate) normal: DVec3,
}

impl TangentPlane {
    fn new(face: FaceId, origin: DVec3, normal: DVec3, tangent: DVec3) -> Self {
        Self { face, origin, tangents: [tangent, normal.cross(tangent)], normal }
    }

    /// The plane of the face itself, with t₀ along its first edge.
    pub(crate) fn of_face(mesh: &TriMesh, point: SurfacePoint) -> Result<Self, CurvatureError> {
        let face = point.face();
        if !mesh.topology().contains_face(face) {
            return Err(CurvatureError::NotInMesh { face });
        }
        let [a, b, c] = mesh.triangle(face);
        let cross = (b - a).cross(c - a);
        let longest = (b - a).length_squared().max((c - a).length_squared());
        // A smaller cross product consists of rounding errors.
        let has_area = cross.length() > 4.0 * f64::EPSILON * longest;
        let tangent = (b - a).try_normalize();
        let (Some(normal), Some(tangent), true) = (cross.try_normalize(), tangent, has_area) else {
            return Err(CurvatureError::DegenerateFace { face });
        };
        Ok(Self::new(face, point.position(mesh), normal, tangent))
    }

    /// The plane through the same point in which the gradient of the surface, given in this plane,
    /// vanishes: its normal is n - g. `None` if rounding or overflow leaves no normal.
    pub(crate) fn tilted(&self, gradient: DVec2) -> Option<Self> {
        let [t0, t1] = self.tangents;
        let normal = (self.normal - gradient.x * t0 - gradient.y * t1).try_normalize()?;
        let tangent = (t0 - t0.dot(normal) * normal).try_normalize()?;
        Some(Self::new(self.face, self.origin, normal, tangent))
    }

    pub(crate) fn tangent(&self, cos: f64, sin: f64) -> DVec3 {
        cos * self.tangents[0] + sin * self.tangents[1]
    }

    pub(crate) fn section_plane(&self, direction: &Direction) -> SectionPlane {
        SectionPlane::new(self.origin, self.normal, self.tangent(direction.cos, direction.sin))
    }
}
