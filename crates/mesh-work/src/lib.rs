#![doc = include_str!("../README.md")]

mod attributes;
mod charts;
mod constraint_choices;
mod curvature_failure;
mod face_curvature;
mod file_size;
mod frame_curvature;
mod holes;
mod labels;
mod length;
mod levels;
mod loaded;
mod normals;
mod not_finite;
mod patches;
mod policy;
mod printing;
mod quantity;
mod scene;
mod seams;
mod subdivide;
mod surface;
mod vertex_curvature;

pub use attributes::{AttributeRules, Attributes};
pub use constraint_choices::{ConstraintChoices, ConstraintError};
pub use curvature_failure::CurvatureFailure;
pub use face_curvature::{FaceValues, disc_quantity};
pub use file_size::{Largest, Sized, file_size, largest_within};
pub use frame_curvature::{FrameEstimator, FrameValue, FrameValues, PointKind};
pub use labels::{UnknownNumbers, mark_labels};
pub use length::{Length, NoExtent, diagonal, parse_length};
pub use levels::{LevelError, LevelOfDetail, LevelPlan, LevelRecord, LevelSteps, shown_from};
pub use loaded::{Loaded, Source, build_with_needed_repairs, splits_vertices, usual_weld};
pub use not_finite::drop_not_finite;
pub use patches::{
    PatchMesh, PatchWorkError, cover_model, patch_of_radius, patch_within, splat_model,
};
pub use policy::Choices;
pub use printing::TooFarToSeparate;
pub use quantity::{Integrals, Quantity, UnknownQuantity, legend_title};
pub use scene::{
    DeformedError, MeshOfLevel, MeshOfScene, RepairedScene, SceneBudget, SceneError, SceneLevel,
    SceneLevels, SceneRules, SceneSteps, SceneTarget, SimplifiedScene, mesh_title, repaired_scene,
    scene_levels, simplify_scene,
};
pub use seams::Seams;
pub use subdivide::{Subdivided, SubdivisionError, subdivide_step};
pub use surface::{is_point_cloud, surface, surface_or_points};
pub use vertex_curvature::VertexValues;
