//! Meshes of their own for nodes that shared one.

use super::document::{Scene, list_mut, push, root_of};
use super::extensions::occurs;
use crate::error::WriteError;
use crate::gltf::accessor::Document;
use serde_json::Value;

impl Scene {
    /// The scene in which each group of nodes draws a mesh of its own: a copy, at the end of the list, of the mesh that
    /// the nodes draw in this scene. Other nodes draw what they drew before. The copies have the accessors of the
    /// originals, so no data are stored twice.
    ///
    /// # Errors
    /// A node does not exist, or the nodes of a group do not all draw the same mesh. Animations point into the scene,
    /// and could not point into a copy.
    pub fn with_own_meshes(&self, groups: &[Vec<usize>]) -> Result<Self, WriteError> {
        let pointer = "KHR_animation_pointer";
        if !groups.is_empty() && occurs(&self.json, pointer) {
            let why = "animations point into meshes that nodes share";
            let cure = "give all nodes of a mesh the same result";
            return Err(WriteError::Scene(format!("extension {pointer}: {why}; {cure}")));
        }
        let mut json = self.json.clone();
        for group in groups {
            let drawn = |node: &usize| Some(self.root().nodes.get(*node)?.mesh? as usize);
            let mesh = group.first().and_then(drawn);
            let original = mesh.and_then(|mesh| list_mut(&mut json, "meshes").get(mesh).cloned());
            let (Some(original), true) = (original, group.iter().all(|node| drawn(node) == mesh))
            else {
                return Err(WriteError::Scene(format!("nodes {group:?} do not draw one mesh")));
            };
            let copy = push(&mut json, "meshes", original);
            for &node in group {
                if let Some(node) = list_mut(&mut json, "nodes").get_mut(node) {
                    node["mesh"] = Value::from(copy);
                }
            }
        }
        let root = root_of(&json).map_err(|error| WriteError::Scene(error.to_string()))?;
        Ok(self.with(json, Document { root, buffers: self.document.buffers.clone() }))
    }
}
