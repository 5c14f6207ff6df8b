//! The nodes of a scene and the transforms of their meshes.

use super::accessor::{Document, at, no_such};
use super::schema::{Node, Root};
use crate::error::ReadErrorKind;
use glam::{DMat4, DQuat, DVec3};
use mesh_core::as_u32;

/// Deeper nesting of nodes is rejected.
const DEEPEST: usize = 1000;

/// A mesh with the transform of a node.
pub(crate) struct Placed<'d> {
    pub index: usize,
    pub node: &'d Node,
    pub mesh: u32,
    pub transform: DMat4,
}

/// Calls `visit` for all meshes of the default scene (or of the only scene, or of all root nodes), once for each
/// reference by a node. The nodes must form a forest.
pub(crate) fn each_placed<'d>(
    root: &'d Root,
    mut visit: impl FnMut(&Placed<'d>) -> Result<(), ReadErrorKind>,
) -> Result<(), ReadErrorKind> {
    each_node(root, |index, node, transform| match node.mesh {
        Some(mesh) => visit(&Placed { index, node, mesh, transform }),
        None => Ok(()),
    })
}

/// Calls `visit` for all nodes of the same scene, parents first, with their transforms.
pub(crate) fn each_node<'d>(
    root: &'d Root,
    mut visit: impl FnMut(usize, &'d Node, DMat4) -> Result<(), ReadErrorKind>,
) -> Result<(), ReadErrorKind> {
    let mut seen = vec![false; root.nodes.len()];
    // The nodes from the root down: their transforms, and the children that remain.
    let mut stack: Vec<(DMat4, std::slice::Iter<'_, u32>)> = Vec::new();
    let tops = tops(root)?;
    stack.push((DMat4::IDENTITY, tops.iter()));
    while let Some((parent, children)) = stack.last_mut() {
        let Some(&index) = children.next() else {
            stack.pop();
            continue;
        };
        let parent = *parent;
        let (count, place) = (root.nodes.len(), index as usize);
        let node = root.nodes.get(place).ok_or_else(|| no_such("nodes", "nodes", index, count))?;
        if std::mem::replace(&mut seen[place], true) {
            let expected = "every node to be the child of one node at most";
            let found = "a cycle or a second parent";
            return Err(ReadErrorKind::malformed(at(&format!("nodes[{index}]")), expected, found));
        }
        if stack.len() > DEEPEST {
            let expected = format!("nodes nested no deeper than {DEEPEST}");
            let path = format!("nodes[{index}]");
            return Err(ReadErrorKind::malformed(at(&path), expected, "deeper ones"));
        }
        let transform = parent * local(node);
        visit(place, node, transform)?;
        stack.push((transform, node.children.iter()));
    }
    Ok(())
}

pub(crate) fn tops(root: &Root) -> Result<Vec<u32>, ReadErrorKind> {
    let scene = root.scene.unwrap_or(0);
    if let Some(scene) = root.scenes.get(scene as usize) {
        return Ok(scene.nodes.clone());
    }
    if root.scene.is_some() {
        return Err(no_such("scene", "scenes", scene, root.scenes.len()));
    }
    let mut is_child = vec![false; root.nodes.len()];
    for &child in root.nodes.iter().flat_map(|node| node.children.iter()) {
        if let Some(is_child) = is_child.get_mut(child as usize) {
            *is_child = true;
        }
    }
    Ok((0..as_u32(root.nodes.len())).filter(|&node| !is_child[node as usize]).collect())
}

pub(crate) fn local(node: &Node) -> DMat4 {
    match &node.matrix {
        Some(matrix) => DMat4::from_cols_array(&matrix.map(f64::from)),
        None => placement(node.translation, node.rotation, node.scale),
    }
}

/// The transform of a node with these members.
pub(crate) fn placement(
    translation: Option<[f32; 3]>,
    rotation: Option<[f32; 4]>,
    scale: Option<[f32; 3]>,
) -> DMat4 {
    let vector = |value: Option<[f32; 3]>, default| {
        value.map_or(default, |value| DVec3::from_array(value.map(f64::from)))
    };
    let rotation = rotation.map_or(DQuat::IDENTITY, |rotation| {
        let rotation = DQuat::from_array(rotation.map(f64::from));
        if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY }
    });
    DMat4::from_scale_rotation_translation(
        vector(scale, DVec3::ONE),
        rotation,
        vector(translation, DVec3::ZERO),
    )
}

/// The memory for the transform of an instance while it is read.
pub(crate) const INSTANCE: u64 = 12 + 16 + 12 + 128;

/// The number of times that the extension `EXT_mesh_gpu_instancing` draws the mesh of a node; 1 without it.
pub(crate) fn instance_count(
    document: &Document,
    placed: &Placed<'_>,
) -> Result<u64, ReadErrorKind> {
    let Some(instancing) = &placed.node.extensions.instancing else { return Ok(1) };
    let mut all = None;
    for (name, accessor) in instancing.attributes.iter() {
        let path = path_of(placed, name);
        let count = document.count(accessor, &path)?;
        let expected = *all.get_or_insert(count);
        if count != expected {
            let expected = format!("{expected} values as in the other attributes");
            return Err(ReadErrorKind::malformed(at(&path), expected, count.to_string()));
        }
    }
    Ok(all.unwrap_or(1))
}

fn path_of(placed: &Placed<'_>, name: &str) -> String {
    format!("nodes[{}].extensions.EXT_mesh_gpu_instancing.attributes.{name}", placed.index)
}

/// The transforms of all instances of the mesh of a node.
pub(crate) fn transforms(
    document: &Document,
    placed: &Placed<'_>,
) -> Result<Vec<DMat4>, ReadErrorKind> {
    if placed.node.extensions.instancing.is_none() {
        return Ok(vec![placed.transform]);
    }
    let count = instance_count(document, placed)? as usize;
    let translations = instance_values::<3>(document, placed, "TRANSLATION")?;
    let rotations = instance_values::<4>(document, placed, "ROTATION")?;
    let scales = instance_values::<3>(document, placed, "SCALE")?;
    let one = |index: usize| {
        let own = placement(
            translations.as_ref().map(|all| all[index]),
            rotations.as_ref().map(|all| all[index]),
            scales.as_ref().map(|all| all[index]),
        );
        placed.transform * own
    };
    Ok((0..count).map(one).collect())
}

fn instance_values<const N: usize>(
    document: &Document,
    placed: &Placed<'_>,
    name: &str,
) -> Result<Option<Vec<[f32; N]>>, ReadErrorKind> {
    let instancing = placed.node.extensions.instancing.as_ref();
    let accessor = instancing.and_then(|instancing| instancing.attributes.get(name));
    let path = || path_of(placed, name);
    accessor.map(|index| document.values(index, &path(), N..=N)?.to_vec(0.0)).transpose()
}
