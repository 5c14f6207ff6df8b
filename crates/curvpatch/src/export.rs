//! Data of covers for files: coloured triangles, records from which patches are restored, splats.

use glam::DVec3;
use mesh_core::{TriMesh, as_u32};

use crate::cover::Cover;
use crate::patch::{PatchData, Splat};
use crate::patch_errors::PatchErrors;
use crate::patch_sizer::StopReason;
use crate::shape::Shape;
use crate::tessellate::TessellationError;

/// A cover as triangles: the patches, then the residual triangles. They share no vertices.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CoverMesh {
    /// The vertices.
    pub positions: Vec<DVec3>,
    /// The unit normals of the vertices.
    pub normals: Vec<DVec3>,
    /// The sRGB colours of the vertices: one colour per patch, grey for residual triangles.
    pub colors: Vec<[u8; 3]>,
    /// Index triples, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The patch of each triangle; `None` for residual triangles.
    pub patch_of_triangle: Vec<Option<u32>>,
}

/// A cover as plain data.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CoverRecord {
    /// The tolerance, in model units.
    pub tolerance: f64,
    /// The patches.
    pub patches: Vec<PatchRecord>,
    /// The indices of the faces that no patch covers.
    pub residual: Vec<u32>,
}

/// One patch of a cover as plain data.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PatchRecord {
    /// The index of the base face.
    pub face: u32,
    /// The radius `r_g`.
    pub radius: f64,
    /// The shape.
    pub shape: Shape,
    /// Frame, curvatures, arcs and translation. `Patch::try_from` restores the patch exactly.
    pub patch: PatchData,
    /// The reason why it is not larger.
    pub stop: StopReason,
    /// Its errors, in model units.
    pub errors: PatchErrors,
    /// The indices of the covered faces.
    pub faces: Vec<u32>,
}

/// The colour of residual triangles.
const RESIDUAL: [u8; 3] = [128, 128, 128];

/// Export.
impl Cover {
    /// The cover as triangles: patches triangulated within `tolerance` (model units), and the residual
    /// triangles of `mesh`.
    ///
    /// # Errors
    /// A tolerance that is not positive or too small; more vertices than 32-bit indices can address; or
    /// less memory than twice the size of the result, because a writer needs about as much again.
    pub fn to_mesh(&self, mesh: &TriMesh, tolerance: f64) -> Result<CoverMesh, TessellationError> {
        let mut size = [3 * self.residual.len(), self.residual.len()];
        for patch in &self.patches {
            let [vertices, triangles] = patch.fit.patch.tessellation_size(tolerance)?;
            size = [size[0] + vertices, size[1] + triangles];
        }
        let mut out = CoverMesh::with_capacity(size)?;
        // Tests whether the same amount is available again. `black_box` keeps the allocation.
        core::hint::black_box(CoverMesh::with_capacity(size)?);
        for (patch, index) in self.patches.iter().zip(0_u32..) {
            let part = patch.fit.patch.tessellate(tolerance)?;
            let first = as_u32(out.positions.len());
            out.colors.resize(out.positions.len() + part.positions.len(), patch_color(index));
            out.positions.extend(part.positions);
            out.normals.extend(part.normals);
            out.patch_of_triangle.resize(out.triangles.len() + part.triangles.len(), Some(index));
            out.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
        }
        for &face in &self.residual {
            let first = as_u32(out.positions.len());
            out.positions.extend(mesh.triangle(face));
            out.normals.extend([mesh.face_normal(face); 3]);
            out.colors.extend([RESIDUAL; 3]);
            out.triangles.push([first, first + 1, first + 2]);
            out.patch_of_triangle.push(None);
        }
        Ok(out)
    }

    /// The cover as plain data.
    #[must_use]
    pub fn record(&self) -> CoverRecord {
        let patches = self.patches.iter().map(|patch| PatchRecord {
            face: patch.fit.point.face().get(),
            radius: patch.fit.curvature.radius,
            shape: patch.fit.shape,
            patch: patch.fit.patch.into(),
            stop: patch.stop,
            errors: patch.errors,
            faces: patch.faces.iter().map(|face| face.get()).collect(),
        });
        CoverRecord {
            tolerance: self.tolerance,
            patches: patches.collect(),
            residual: self.residual.iter().map(|face| face.get()).collect(),
        }
    }

    /// The patches as oriented elliptical discs.
    #[must_use]
    pub fn splats(&self) -> Vec<Splat> {
        self.patches.iter().map(|patch| patch.fit.patch.splat()).collect()
    }
}

impl CoverMesh {
    /// An empty mesh with capacity for these numbers of vertices and triangles.
    fn with_capacity([vertices, triangles]: [usize; 2]) -> Result<Self, TessellationError> {
        if u32::try_from(vertices).is_err() {
            return Err(TessellationError::TooManyVertices { vertices });
        }
        let mut new = Self::default();
        new.positions
            .try_reserve_exact(vertices)
            .and_then(|()| new.normals.try_reserve_exact(vertices))
            .and_then(|()| new.colors.try_reserve_exact(vertices))
            .and_then(|()| new.triangles.try_reserve_exact(triangles))
            .and_then(|()| new.patch_of_triangle.try_reserve_exact(triangles))
            .map_err(|_| TessellationError::TooLittleMemory { triangles })?;
        Ok(new)
    }
}

/// The sRGB colour of the patch with this index: hues advance by the golden ratio, in three alternating
/// brightnesses.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
pub fn patch_color(patch: u32) -> [u8; 3] {
    let hue = (f64::from(patch) * 0.618_033_988_749_895).fract();
    let value = [0.95, 0.8, 0.65][patch as usize % 3];
    [5.0, 3.0, 1.0].map(|offset| {
        let k = (offset + 6.0 * hue) % 6.0;
        let dip = k.min(4.0 - k).clamp(0.0, 1.0);
        (255.0 * value * (1.0 - 0.6 * dip)).round() as u8
    })
}
