//! Repairs of the meshes of a scene.

use mesh_core::build::{BuildReport, Repair};
use mesh_io::{Blend, Lost, NewMesh, Scene};

use super::parts::{Part, parts};
use super::rules::{SceneError, SceneRules};
use super::transfer::transfer;
use crate::attributes::Sources;

/// A scene with repaired meshes.
#[derive(Clone, Debug)]
pub struct RepairedScene {
    /// The scene.
    pub scene: Scene,
    /// The repairs of the meshes with triangles, in the order of the document.
    pub repairs: Vec<BuildReport>,
    /// What is lost.
    pub lost: Vec<Lost>,
}

/// Repairs every mesh of a scene. All data of vertices stay, and so does every mesh that needs no repair but the merging
/// of vertices that the format splits. A mesh of which no face would be left stays as well.
///
/// # Errors
/// A mesh cannot be read or built, or the result cannot be written into the scene.
pub fn repaired_scene(scene: &Scene, repair: &Repair) -> Result<RepairedScene, SceneError> {
    let rules =
        SceneRules { repair: *repair, needed_repairs: false, poses: 0, ..SceneRules::default() };
    let parts = parts(scene, &rules)?;
    let changed = parts
        .iter()
        .filter(|part| part.loaded.report.repairs().any(|(what, _)| what != BuildReport::MERGED));
    let new = changed.map(Part::repaired).collect::<Result<Vec<_>, _>>()?;
    let (scene, lost) = scene.replaced(&new)?;
    let repairs = parts.into_iter().map(|part| part.loaded.report).collect();
    Ok(RepairedScene { scene, repairs, lost })
}

impl Part {
    /// The repaired mesh, with the data of the corners that it was built from.
    fn repaired(&self) -> Result<NewMesh, SceneError> {
        let source = self.loaded.source();
        let corners = &source.provenance.corner_source;
        let carried = self.loaded.to_model(corners)?;
        let corners: Vec<_> = corners.iter().map(|corners| corners.map(Blend::one)).collect();
        let sources = Sources {
            vertices: Vec::new(),
            faces: source.provenance.face_source.clone(),
            points: corners.clone(),
            corners,
        };
        let primitives = transfer(source.model, &self.primitives, source.mesh, &sources, &carried);
        Ok(NewMesh { mesh: self.mesh, primitives })
    }
}
