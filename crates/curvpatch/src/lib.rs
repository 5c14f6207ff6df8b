#![doc = include_str!("../README.md")]

mod arc;
mod closest;
mod cover;
mod curvature;
mod curvature_error;
mod export;
mod fit;
mod height_bracket;
mod march;
mod params;
mod patch;
mod probe;
mod region;
mod section;
mod section_curvature;
mod sections;
mod shape;
mod size;
mod strip;
mod surface_point;
mod terrain;
mod tessellate;
mod trace;
mod wide;

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
