//! Face-based curvature, and surface patches made from it.
mod arc;
mod closest;
mod curvature;
mod fit;
mod params;
mod patch;
mod probe;
mod region;
mod section;
mod section_curvature;
mod shape;
mod size;
mod surface_point;
mod tessellate;

pub use curvature::{CurvatureError, CurvatureEstimator, DiscCurvature, PointClass};
pub use fit::{FitError, PatchFit};
pub use params::{NormalRule, Params, PrincipalRule, SectionRule, TranslationRule};
pub use patch::{Patch, PatchData, PatchError, Splat};
pub use probe::{PatchErrors, PatchProbe};
pub use shape::Shape;
pub use size::{ErrorTest, OptionError, PatchSizer, SizeOptions, SizedPatch, StopReason, Unfit};
pub use surface_point::SurfacePoint;
pub use tessellate::{Tessellation, TessellationError};
