//! What a scene loses, in words, and the names of its meshes for people.

use std::collections::HashSet;

use mesh_io::{Lost, printable};

use super::levels::SceneLevels;
use super::simplify::SimplifiedScene;

/// The name of a mesh for people, or its number if it has none.
#[must_use]
pub fn mesh_title(name: Option<&str>, mesh: usize) -> String {
    name.map_or_else(|| format!("mesh {mesh}"), |name| printable(name).into_owned())
}

impl SimplifiedScene {
    /// Everything that is lost: data of the scene, normals and tangents of flat-shaded meshes, primitives without faces.
    #[must_use]
    pub fn losses(&self) -> Vec<Lost> {
        let flat = self.meshes.iter().filter(|mesh| mesh.is_flat_shaded).count();
        let removed = self
            .meshes
            .iter()
            .flat_map(|mesh| removed_primitives(mesh.name.as_deref(), mesh.mesh, &mesh.removed));
        self.lost.iter().cloned().chain(normals(flat)).chain(removed).collect()
    }
}

impl SceneLevels {
    /// Everything that the levels lose, each loss once; see [`SimplifiedScene::losses`].
    #[must_use]
    pub fn losses(&self) -> Vec<Lost> {
        let mut all: Vec<Lost> = normals(self.flat_shaded).into_iter().collect();
        let mut known: HashSet<Lost> = all.iter().cloned().collect();
        for level in &self.levels {
            let removed = level.meshes.iter().flat_map(|mesh| {
                removed_primitives(mesh.name.as_deref(), mesh.mesh, &mesh.removed)
            });
            for lost in level.lost.iter().cloned().chain(removed) {
                if known.insert(lost.clone()) {
                    all.push(lost);
                }
            }
        }
        all
    }
}

/// The normals and tangents of flat-shaded meshes, if there are such meshes.
fn normals(meshes: usize) -> Option<Lost> {
    let why = "every face has a normal of its own, and a mesh without normals looks the same";
    (meshes > 0)
        .then(|| Lost::some("normals and tangents of flat-shaded meshes", meshes as u64, why))
}

fn removed_primitives(name: Option<&str>, mesh: usize, removed: &[usize]) -> Vec<Lost> {
    let lost = |primitive: &usize| {
        let what = format!("{}: primitive {primitive}", mesh_title(name, mesh));
        Lost::new(what, "it has no face at this target; ask for more faces")
    };
    removed.iter().map(lost).collect()
}
