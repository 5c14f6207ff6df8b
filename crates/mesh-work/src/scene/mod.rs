//! Scenes through the simplification: each mesh once, with all data of its vertices.
//!
//! Layers, lowest first: `transfer`, the data of new vertices; `budget`, which divides the faces among the meshes;
//! `simplify`.

mod budget;
mod simplify;
mod transfer;

pub use simplify::{
    MeshOfScene, SceneBudget, SceneError, SceneRules, SceneTarget, SimplifiedScene, simplify_scene,
};
