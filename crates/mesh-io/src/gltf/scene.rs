//! The nodes of a scene and where they put their meshes.

use super::accessor::{at, no_such};
use crate::error::ReadErrorKind;
use glam::{DMat4, DQuat, DVec3};
use gltf::json::{Root, scene::Node};

/// Nodes nested deeper than this are refused.
const DEEPEST: usize = 1000;

/// A mesh, put somewhere by a node.
pub(super) struct Instance {
    pub node: usize,
    pub mesh: usize,
    pub transform: DMat4,
}

/// All meshes of the default scene (or of the only one, or of all nodes that are no children),
/// each as often as it is used. The nodes must form a forest.
pub(super) fn instances(root: &Root) -> Result<Vec<Instance>, ReadErrorKind> {
    let nodes = &root.nodes;
    let mut stack: Vec<(usize, usize, DMat4)> =
        roots(root)?.into_iter().rev().map(|node| (node, 1, DMat4::IDENTITY)).collect();
    let mut seen = vec![false; nodes.len()];
    let mut instances = Vec::new();
    while let Some((index, depth, parent)) = stack.pop() {
        let path = format!("nodes[{index}]");
        let node = nodes.get(index).ok_or_else(|| no_such("nodes", "nodes", index, nodes.len()))?;
        if std::mem::replace(&mut seen[index], true) {
            let expected = "every node to be the child of one node at most";
            return Err(ReadErrorKind::malformed(
                at(&path),
                expected,
                "a cycle or a second parent",
            ));
        }
        if depth > DEEPEST {
            let expected = format!("nodes nested no deeper than {DEEPEST}");
            return Err(ReadErrorKind::malformed(at(&path), expected, "deeper ones"));
        }
        let transform = parent * local(node);
        if let Some(mesh) = node.mesh {
            instances.push(Instance { node: index, mesh: mesh.value(), transform });
        }
        let children = node.children.as_deref().unwrap_or_default();
        stack.extend(children.iter().rev().map(|child| (child.value(), depth + 1, transform)));
    }
    Ok(instances)
}

fn roots(root: &Root) -> Result<Vec<usize>, ReadErrorKind> {
    let scene = root.scene.map_or(0, |scene| scene.value());
    if let Some(scene) = root.scenes.get(scene) {
        return Ok(scene.nodes.iter().map(gltf::json::Index::value).collect());
    }
    if root.scene.is_some() {
        return Err(no_such("scene", "scenes", scene, root.scenes.len()));
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    Ok((0..root.nodes.len()).filter(|&node| !is_child[node]).collect())
}

fn local(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |value: Option<[f32; 3]>, default| {
        value.map_or(default, |value| DVec3::from_array(value.map(f64::from)))
    };
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |rotation| {
        let rotation = DQuat::from_array(rotation.0.map(f64::from));
        if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY }
    });
    DMat4::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}
