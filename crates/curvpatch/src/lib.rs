//! Face-based curvature of triangle meshes, smooth patches made from it, and covers of meshes by
//! such patches, after M. Szilvási-Nagy, *Surface Patches Constructed from Curvature Data* (2010),
//! called SN10 throughout.
//!
//! A plane through the normal of a face cuts the mesh in a polygon. Followed for a length `r` to
//! either side, its bend tells the normal curvature in that direction; planes all round tell the
//! principal curvatures and directions. No vertex needs to be near, and none inside the mesh: a
//! half cylinder with vertices on its two rims only has the same curvature as a dense one. From
//! the curvatures comes a patch, a smooth graph over the tangent plane that stands for the part of
//! the mesh under it.
//!
//! ```
//! use curvpatch::{CurvatureEstimator, Params, PatchProbe, Shape};
//! use mesh_core::{FaceId, TriMesh, shapes::Sphere};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let soup = Sphere { radius: 2.0 }.icosphere(4)?;
//! let mesh = TriMesh::from_soup(&soup)?;
//!
//! let estimator = CurvatureEstimator::new(&mesh, Params::robust())?;
//! let fit = estimator.patch(FaceId::new(7), 0.8, Shape::Circle)?;
//! assert!((fit.curvature.mean() - 0.5).abs() < 0.005);
//!
//! let errors = PatchProbe::new(&mesh).full_error(&fit, 0.01, false);
//! assert!(errors.max() < 0.005 * 0.8);
//! # Ok(())
//! # }
//! ```
//!
//! | to get | use |
//! |---|---|
//! | curvature at a point, a face, all faces | [`CurvatureEstimator`] |
//! | a normal section to draw | [`CurvatureEstimator::trace`] |
//! | a patch of given radius | [`CurvatureEstimator::patch`] |
//! | its error against the mesh | [`PatchProbe`] |
//! | the largest patch within a tolerance | [`PatchSizer`] |
//! | patches for a whole mesh | [`cover()`] |
//! | patches in a row | [`CurvatureEstimator::strip`] |
//! | triangles, records, splats | [`Patch::tessellate`], [`Cover::to_mesh`], [`Cover::record`], [`Cover::splats`] |
//!
//! **Signs and units.** Curvatures are pointwise, in one over length, positive where the surface is
//! convex seen from the side of its normals: a sphere of radius `R` with outward normals has
//! `κ₁ = κ₂ = 1/R`. (SN10 has the opposite sign.) `κ₁` is the one of larger absolute value. Angles
//! are in radians, lengths and tolerances in model units.
//!
//! **Boundaries.** A section that comes to the boundary ends there. Its shorter arc enters with less
//! weight, and the disc is flagged as truncated.
//!
//! **Presets.** [`Params::paper`] does what SN10 prints; [`Params::robust`], the default, has the
//! same idea with less error. [`PrincipalRule::SignedExtremes`] says why the "maximal and minimal
//! diameter" of SN10 must not be taken literally.
//!
//! Results are bitwise the same for any number of threads and without the `rayon` feature.

mod arc;
mod closest;
mod cover;
mod curvature;
mod curvature_error;
mod export;
mod fit;
mod params;
mod patch;
mod probe;
mod region;
mod section;
mod section_curvature;
mod shape;
mod size;
mod strip;
mod surface_point;
mod tessellate;
mod trace;

pub use cover::{
    Cover, CoverCandidates, CoverMethod, CoverOptions, CoverPatch, CoverProgress, Seeds, cover,
};
pub use curvature::{CurvatureEstimator, DiscCurvature, PointClass};
pub use curvature_error::CurvatureError;
pub use export::{CoverMesh, CoverRecord, PatchRecord, patch_color};
pub use fit::{FitError, PatchFit};
pub use params::{NormalRule, Params, PrincipalRule, SectionRule, TranslationRule};
pub use patch::{Patch, PatchData, PatchError, Splat};
pub use probe::{PatchErrors, PatchProbe};
pub use shape::Shape;
pub use size::{ErrorTest, OptionError, PatchSizer, SizeOptions, SizedPatch, StopReason, Unfit};
pub use strip::{Strip, StripEnd, StripError, StripOptions};
pub use surface_point::SurfacePoint;
pub use tessellate::{Tessellation, TessellationError};
pub use trace::SectionTrace;
