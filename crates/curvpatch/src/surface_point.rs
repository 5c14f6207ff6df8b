//! An interior point of a face.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};

use crate::curvature_error::CurvatureError;

/// An interior point of a face, given by barycentric coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Stored"))]
pub struct SurfacePoint {
    face: FaceId,
    barycentric: [f64; 3],
}

/// A stored point, not yet validated.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Stored {
    face: FaceId,
    barycentric: [f64; 3],
}

#[cfg(feature = "serde")]
impl TryFrom<Stored> for SurfacePoint {
    type Error = CurvatureError;

    /// Keeps the bits of coordinates whose sum is 1.
    fn try_from(Stored { face, barycentric }: Stored) -> Result<Self, CurvatureError> {
        let point = Self::new(face, barycentric)?;
        let sum: f64 = barycentric.iter().sum();
        if (sum - 1.0).abs() < 1e-12 { Ok(Self { face, barycentric }) } else { Ok(point) }
    }
}

impl SurfacePoint {
    /// The point of a face with these barycentric coordinates, in the order of its vertices. They are
    /// normalised to the sum 1.
    ///
    /// # Errors
    /// [`CurvatureError::BadPoint`] unless all three are positive and finite.
    pub fn new(face: FaceId, barycentric: [f64; 3]) -> Result<Self, CurvatureError> {
        let sum: f64 = barycentric.iter().sum();
        let barycentric_share = barycentric.map(|weight| weight / sum);
        let inside = barycentric_share.iter().all(|&weight| weight > 0.0 && weight < 1.0);
        if inside && sum > 0.0 && sum.is_finite() {
            return Ok(Self { face, barycentric: barycentric_share });
        }
        Err(CurvatureError::BadPoint { face, barycentric })
    }

    /// The barycentre of a face, which SN10 uses as centre.
    #[must_use]
    pub fn barycentre(face: FaceId) -> Self {
        Self { face, barycentric: [1.0 / 3.0; 3] }
    }

    /// The face.
    #[must_use]
    pub fn face(&self) -> FaceId {
        self.face
    }

    /// The barycentric coordinates: positive, with sum 1.
    #[must_use]
    pub fn barycentric(&self) -> [f64; 3] {
        self.barycentric
    }

    /// The position of the point, in model units.
    ///
    /// # Panics
    /// When the face is not in the mesh.
    #[must_use]
    pub fn position(&self, mesh: &TriMesh) -> DVec3 {
        let [a, b, c] = mesh.triangle(self.face);
        let [_, v, w] = self.barycentric;
        // Relative to one corner, so that a triangle far from the origin keeps its precision.
        a + v * (b - a) + w * (c - a)
    }
}

impl From<FaceId> for SurfacePoint {
    fn from(face: FaceId) -> Self {
        Self::barycentre(face)
    }
}
