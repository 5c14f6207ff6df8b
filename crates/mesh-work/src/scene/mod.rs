//! Scenes through the simplification: each mesh once, with all data of its vertices.
//!
//! Layers, lowest first: `rules`, options and errors; `transfer`, the data of new vertices; `budget`, which divides the
//! faces among the meshes; `poses` of meshes that deform; `parts`, the
//! meshes ready for the simplification; `simplify`, and `levels` of detail; `repair`;
//! `losses`, the reports of both.

mod budget;
mod levels;
mod losses;
mod parts;
mod poses;
mod repair;
mod rules;
mod simplify;
mod transfer;

pub use levels::{MeshOfLevel, SceneLevel, SceneLevels, SceneSteps, scene_levels};
pub use losses::mesh_title;
pub use poses::DeformedError;
pub use repair::{RepairedScene, repaired_scene};
pub use rules::{SceneBudget, SceneError, SceneRules, SceneTarget};
pub use simplify::{MeshOfScene, SimplifiedScene, simplify_scene};
