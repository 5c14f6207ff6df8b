//! Single patches, and patch covers as the content of files.

use std::borrow::Cow;

use curvpatch::{
    Cover, CoverMethod, CoverPatch, CurvatureEstimator, FitError, FitTest, OptionError, Patch,
    PatchData, PatchErrors, PatchFit, PatchSizer, Shape, SizeOptions, SizedPatch, Splat,
    StopReason, TessellationError, Unfit, patch_color,
};
use mesh_core::soup::TooManyCorners;
use mesh_core::{FaceId, PolygonSoup, ScaleError, TriMesh, UnitScale};
use mesh_io::{Model, Scalars};

use crate::face_curvature::restored_disc;

/// Why there is no patch, or no file of patches.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PatchWorkError {
    /// An option is out of its range.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// There is no patch at this face.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// There is no patch within the tolerance at this face.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// The patches are not cut into triangles.
    #[error(transparent)]
    Tessellation(#[from] TessellationError),
    /// The triangles are too many.
    #[error(transparent)]
    Size(#[from] TooManyCorners),
}

/// A mesh for patches: scaled by a power of two if it is larger than 1e12 or smaller than 1e-12. Lengths and covers are
/// converted between its size and the size of the original. So a mesh of any size has the patches of a mesh of size 1,
/// scaled.
#[derive(Clone, Debug)]
pub struct PatchMesh<'a> {
    mesh: Cow<'a, TriMesh>,
    scale: Option<UnitScale>,
}

impl<'a> PatchMesh<'a> {
    /// For patches of a mesh.
    ///
    /// # Errors
    /// The size of the mesh leaves too few digits.
    pub fn new(mesh: &'a TriMesh) -> Result<Self, ScaleError> {
        let scale = UnitScale::with_areas(mesh)?;
        let mesh = match scale {
            None => Cow::Borrowed(mesh),
            Some(scale) => Cow::Owned(scale.mesh(mesh)?),
        };
        Ok(Self { mesh, scale })
    }

    /// The mesh, perhaps scaled.
    #[must_use]
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// A length of the original in this mesh.
    #[must_use]
    pub fn length(&self, length: f64) -> f64 {
        self.scale.map_or(length, |scale| scale.length(length))
    }

    /// A cover of this mesh at the size of the original.
    ///
    /// # Errors
    /// A patch is not a patch at that size.
    pub fn restore(&self, cover: Cover) -> Result<Cover, PatchWorkError> {
        let Some(scale) = self.scale else { return Ok(cover) };
        let patches = cover.patches.into_iter().map(|patch| restored(patch, scale));
        let patches = patches.collect::<Result<_, _>>().map_err(FitError::from)?;
        Ok(Cover { patches, tolerance: scale.original_length(cover.tolerance), ..cover })
    }
}

/// A patch of a scaled mesh at the size of the original.
fn restored(patch: CoverPatch, scale: UnitScale) -> Result<CoverPatch, curvpatch::PatchError> {
    let length = |length: f64| scale.original_length(length);
    let scaled = PatchData::from(patch.fit.patch);
    let data = PatchData {
        origin: scaled.origin.map(length),
        curvatures: scaled.curvatures.map(|curvature| scale.original_power(curvature, -1)),
        arcs: scaled.arcs.map(length),
        translation: length(scaled.translation),
        ..scaled
    };
    let PatchErrors { points, heights, overhang } = patch.errors;
    Ok(CoverPatch {
        fit: PatchFit {
            curvature: restored_disc(&patch.fit.curvature, scale),
            patch: Patch::try_from(data)?,
            ..patch.fit
        },
        errors: PatchErrors {
            points: length(points),
            heights: length(heights),
            overhang: length(overhang),
        },
        ..patch
    })
}

/// The patch of a given radius at a face, as a cover; of several shapes, the one that covers more.
///
/// # Errors
/// The surface has no patch of this radius there.
pub fn patch_of_radius(
    estimator: &CurvatureEstimator<'_>,
    face: FaceId,
    radius: f64,
    shapes: &[Shape],
) -> Result<Cover, PatchWorkError> {
    let mesh = estimator.mesh();
    let mut probe = FitTest::new(mesh);
    let mut best: Option<(f64, CoverPatch)> = None;
    for &shape in shapes {
        let fit = estimator.patch(face, radius, shape)?;
        let faces = probe.faces_under(&fit);
        let area = faces.iter().map(|&face| mesh.face_area(face)).sum();
        if best.as_ref().is_none_or(|(largest, _)| area > *largest) {
            let [l1, l2] = fit.patch.arcs();
            let errors = probe.full_error(&fit, 0.25 * l1.max(l2), true);
            let patch = CoverPatch { fit, stop: StopReason::MaxRadius, errors, faces };
            best = Some((area, patch));
        }
    }
    let patch = best.map(|(_, patch)| patch);
    let tolerance = patch.as_ref().map_or(0.0, |patch| patch.errors.max());
    Ok(single(mesh, patch, tolerance))
}

/// The largest patch at a face that satisfies `options`, as a cover.
///
/// # Errors
/// An option is out of its range, or there is no such patch.
pub fn patch_within(
    estimator: &CurvatureEstimator<'_>,
    face: FaceId,
    options: SizeOptions,
    shapes: &[Shape],
) -> Result<Cover, PatchWorkError> {
    let SizeOptions { tolerance, overhang, .. } = options;
    let mesh = estimator.mesh();
    let mut sizer = PatchSizer::new(estimator, options)?;
    let SizedPatch { fit, stop, faces } = sizer.fit_best(face, shapes)?;
    let errors = FitTest::new(mesh).full_error(&fit, tolerance, overhang);
    Ok(single(mesh, Some(CoverPatch { fit, stop, errors, faces }), tolerance))
}

/// The cover that consists of one patch; all other faces stay triangles.
fn single(mesh: &TriMesh, patch: Option<CoverPatch>, tolerance: f64) -> Cover {
    let mut patch_of_face = mesh.topology().face_map(None);
    for &face in patch.iter().flat_map(|patch| &patch.faces) {
        patch_of_face[face] = Some(0);
    }
    let residual = mesh.topology().faces().filter(|&f| patch_of_face[f].is_none()).collect();
    Cover {
        patches: patch.into_iter().collect(),
        residual,
        patch_of_face,
        tolerance,
        method: CoverMethod::Greedy,
        seeds: 1,
        candidates: 1,
        cancelled: false,
    }
}

/// A cover as triangles: coloured by patch, with normals, and with the number of the patch (-1 for triangles that stay)
/// as a number per face. `cut` is the largest distance of triangles from a patch.
///
/// # Errors
/// `cut` is too fine or not positive, or there are too many triangles.
pub fn cover_model(mesh: &TriMesh, cover: &Cover, cut: f64) -> Result<Model, PatchWorkError> {
    let parts = cover.to_mesh(mesh, cut)?;
    let soup = PolygonSoup::from_triangles(&parts.positions, &parts.triangles)?;
    let number = |patch: &Option<u32>| patch.and_then(|p| i32::try_from(p).ok()).unwrap_or(-1);
    let patches: Vec<i32> = parts.patch_of_triangle.iter().map(number).collect();
    Ok(Model {
        vertex_normals: Some(parts.normals.iter().map(|n| n.as_vec3().to_array()).collect()),
        vertex_colors: Some(parts.colors.iter().map(|&color| opaque(color)).collect()),
        face_scalars: vec![Scalars::new("patch", patches)],
        ..Model::from(soup)
    })
}

/// One point per splat with its normal, its colour, and the half axes `u` and `v` of its ellipse.
#[must_use]
pub fn splat_model(splats: &[Splat]) -> Model {
    let mut soup = PolygonSoup::new();
    for splat in splats {
        soup.push_vertex(splat.center);
    }
    let names = [["u_x", "u_y", "u_z"], ["v_x", "v_y", "v_z"]];
    let component = |axis: usize, i: usize| {
        let values: Vec<f64> = splats.iter().map(|splat| splat.axes[axis][i]).collect();
        Scalars::new(names[axis][i], values)
    };
    let colors = (0_u32..).take(splats.len()).map(patch_color);
    Model {
        vertex_normals: Some(splats.iter().map(|s| s.normal.map(|x| x as f32)).collect()),
        vertex_colors: Some(colors.map(opaque).collect()),
        vertex_scalars: (0..6).map(|i| component(i / 3, i % 3)).collect(),
        ..Model::from(soup)
    }
}

/// A colour as stored in files.
fn opaque([red, green, blue]: [u8; 3]) -> [f32; 4] {
    let [red, green, blue] = [red, green, blue].map(|c| f32::from(c) / 255.0);
    [red, green, blue, 1.0]
}
