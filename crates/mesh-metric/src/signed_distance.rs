//! Signed distances.

use glam::DVec3;
use mesh_core::closest_point::closest_on_triangle;
use mesh_core::{FaceId, TriMesh, VertexMap, WindingNumbers, parallel, unit_sized};

use crate::surface::{ClosestPoint, Surface, SurfaceError};

/// How the sign of a distance is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum SignRule {
    /// By the winding number of a closed surface: a point is inside where it is not 0. The orientation of the faces does
    /// not matter, and a shell inside another one with the opposite orientation is the wall of a hollow.
    WindingNumber,
    /// By the angle-weighted pseudonormal at the closest point: a point is inside if it lies behind the surface.
    Pseudonormal,
}

impl SignRule {
    /// A short name in lower case, for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::WindingNumber => "winding_number",
            Self::Pseudonormal => "pseudonormal",
        }
    }
}

/// Signed distances to a mesh. From [`SignedDistance::new`], they are positive on the side of the normals, which is the outside if the mesh is closed
/// and its faces are oriented outwards.
///
/// The sign compares the offset with the *angle-weighted pseudonormal* at the closest point: the normal of the
/// face, the sum of the two face normals on an edge, the angle-weighted normal at a vertex. Only this weighting
/// is always right (Bærentzen and Aanæs 2005). Near the boundary of an open mesh there is no inside, and the
/// sign is the side of the nearest face. [`SignedDistance::negative_inside`] takes the winding number instead where the
/// surface is closed.
#[derive(Clone, Debug)]
pub struct SignedDistance<'a> {
    mesh: &'a TriMesh,
    surface: Surface,
    vertex_normals: VertexMap<DVec3>,
    /// The winding numbers, if they decide the sign.
    winding: Option<WindingNumbers<'a>>,
}

/// A smaller barycentric coordinate counts as zero: the closest point lies on an edge or at a vertex. On smooth
/// regions the choice does not matter; at sharp features, closest points are on the feature up to rounding.
const ON_FEATURE: f64 = 1e-9;

impl<'a> SignedDistance<'a> {
    /// Prepares a mesh for queries.
    ///
    /// # Errors
    /// The mesh has no faces, or a position is not finite.
    pub fn new(mesh: &'a TriMesh) -> Result<Self, SurfaceError> {
        let vertex_normals = mesh.vertex_normals();
        Ok(Self { mesh, surface: Surface::new(mesh)?, vertex_normals, winding: None })
    }

    /// Prepares a mesh for queries that are negative inside: by the winding number if the surface is closed, by
    /// pseudonormals otherwise.
    ///
    /// # Errors
    /// As [`SignedDistance::new`].
    pub fn negative_inside(mesh: &'a TriMesh) -> Result<Self, SurfaceError> {
        Ok(Self { winding: WindingNumbers::new(mesh), ..Self::new(mesh)? })
    }

    /// How the sign is decided.
    #[must_use]
    pub fn rule(&self) -> SignRule {
        match self.winding {
            Some(_) => SignRule::WindingNumber,
            None => SignRule::Pseudonormal,
        }
    }

    /// The surface without signs.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The distance from `point`, negative on the side away from the normals.
    #[must_use]
    pub fn distance(&self, point: DVec3) -> f64 {
        self.closest(point).distance
    }

    /// The closest point, with a signed distance.
    #[must_use]
    pub fn closest(&self, point: DVec3) -> ClosestPoint {
        let mut closest = self.surface.closest(point);
        closest.distance = self.with_sign(point, closest);
        closest
    }

    /// The distances from many points, with signs.
    #[must_use]
    pub fn distances(&self, points: &[DVec3]) -> Vec<f64> {
        parallel::concat_blocks(points.len(), |range| {
            let points = &points[range];
            let closest = self.surface.closest_points(points);
            let signed = points.iter().zip(closest).map(|(&p, closest)| self.with_sign(p, closest));
            signed.collect()
        })
    }

    /// The distance of a closest point, with its sign.
    fn with_sign(&self, point: DVec3, closest: ClosestPoint) -> f64 {
        let ClosestPoint { offset, distance, face, .. } = closest;
        let is_inside = match &self.winding {
            Some(winding) => distance > 0.0 && winding.about(point) != 0,
            // From inside, the offset points along the normal.
            None => unit_sized([offset])[0].dot(self.pseudonormal(point, face)) > 0.0,
        };
        if is_inside { -distance } else { distance }
    }

    /// The pseudonormal at the point of `face` that is closest to `point`.
    fn pseudonormal(&self, point: DVec3, face: FaceId) -> DVec3 {
        let topology = self.mesh.topology();
        let sides = topology.face_half_edges(face);
        let [a, b, c] = self.mesh.triangle(face);
        let [a, b, c, point] = unit_sized([a, b, c, point]);
        let touch = closest_on_triangle(point, &[a, b, c]);
        let normal = (b - a).cross(c - a);
        let size = normal.length_squared();
        let [a, b, c] = [a, b, c].map(|corner| corner - point - touch);
        // Twice the area over each side, seen from the closest point: zero when it is on the side.
        let over = [a.cross(b), b.cross(c), c.cross(a)].map(|m| m.dot(normal));
        let on_side = over.map(|weight| weight <= ON_FEATURE * size);
        let across = |side: usize| {
            let own = normal.normalize_or_zero();
            let other = topology.face(sides[side].twin());
            other.map_or(own, |f| own + self.mesh.face_normal(f))
        };
        let at = |corner: usize| self.vertex_normals[topology.origin(sides[corner])];
        match on_side {
            [false, false, false] => normal,
            [true, false, false] => across(0),
            [false, true, false] => across(1),
            [false, false, true] => across(2),
            [true, _, true] => at(0),
            [true, true, false] => at(1),
            [false, true, true] => at(2),
        }
    }
}
