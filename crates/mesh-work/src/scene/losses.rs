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
    /// Everything that is lost: data of the scene, normals and tangents, primitives without faces.
    #[must_use]
    pub fn losses(&self) -> Vec<Lost> {
        let flat = self.meshes.iter().filter(|mesh| mesh.is_flat_shaded).count();
        let ignored = self.meshes.iter().filter(|mesh| mesh.has_ignored_tangents).count();
        let removed = self
            .meshes
            .iter()
            .flat_map(|mesh| removed_primitives(mesh.name.as_deref(), mesh.mesh, &mesh.removed));
        self.lost.iter().cloned().chain(normals(flat, ignored)).chain(removed).collect()
    }
}

impl SceneLevels {
    /// Everything that the levels lose, each loss once; see [`SimplifiedScene::losses`].
    #[must_use]
    pub fn losses(&self) -> Vec<Lost> {
        let mut all: Vec<Lost> = normals(self.flat_shaded, self.ignored_tangents).collect();
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

/// The normals and tangents of flat-shaded meshes, and tangents of meshes without normals, by the numbers of such meshes.
fn normals(flat: usize, ignored: usize) -> impl Iterator<Item = Lost> {
    let flat_why = "every face has a normal of its own, and a mesh without normals looks the same";
    let why =
        "programs must ignore them, by the specification of glTF; save the model with normals";
    let lost = [
        ("normals and tangents of flat-shaded meshes", flat, flat_why),
        ("tangents of meshes without normals", ignored, why),
    ];
    lost.into_iter()
        .filter(|(_, meshes, _)| *meshes > 0)
        .map(|(what, meshes, why)| Lost::some(what, meshes as u64, why))
}

fn removed_primitives(name: Option<&str>, mesh: usize, removed: &[usize]) -> Vec<Lost> {
    let lost = |primitive: &usize| {
        let what = format!("{}: primitive {primitive}", mesh_title(name, mesh));
        Lost::new(what, "it has no face at this target; ask for more faces")
    };
    removed.iter().map(lost).collect()
}
