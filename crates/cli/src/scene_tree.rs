//! The nodes of a scene, for reports.

use std::collections::BTreeMap;
use std::fmt;

use mesh_io::Scene;
use serde::Serialize;
use serde_json::Value;

use crate::counted::counted;
use crate::text::printable;

/// The nodes and the other parts of a scene.
#[derive(Debug, Serialize)]
pub(crate) struct SceneTree {
    /// The parts of the document besides nodes, with their numbers.
    parts: BTreeMap<&'static str, usize>,
    /// The nodes of the default scene, parents first.
    nodes: Vec<Node>,
}

#[derive(Debug, Serialize)]
struct Node {
    node: usize,
    name: Option<String>,
    /// The number of nodes above it.
    depth: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<Mesh>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    has: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
struct Mesh {
    mesh: usize,
    name: Option<String>,
    faces: u64,
}

/// The lists of a document that are counted.
const PARTS: [&str; 8] =
    ["meshes", "materials", "textures", "images", "cameras", "skins", "animations", "scenes"];

impl SceneTree {
    pub(crate) fn of(scene: &Scene) -> Self {
        let json = scene.json();
        let count = |name: &&str| json.get(*name).and_then(Value::as_array).map_or(0, Vec::len);
        let mut parts: BTreeMap<&str, usize> =
            PARTS.iter().map(|name| (*name, count(name))).collect();
        let lights = json.pointer("/extensions/KHR_lights_punctual/lights");
        parts.insert("lights", lights.and_then(Value::as_array).map_or(0, Vec::len));
        parts.retain(|_, count| *count > 0);
        let all: Vec<_> = scene.nodes().collect();
        let mut nodes = Vec::with_capacity(all.len());
        let mut open: Vec<(usize, usize)> =
            scene.top_nodes().into_iter().rev().map(|node| (node, 0)).collect();
        while let Some((index, depth)) = open.pop() {
            let Some(node) = all.get(index) else { continue };
            open.extend(node.children.iter().rev().map(|&child| (child, depth + 1)));
            let object = json.pointer(&format!("/nodes/{index}"));
            let has = ["camera", "skin", "extras", "extensions"];
            let is_there = |name: &&str| object.is_some_and(|object| object.get(*name).is_some());
            let mesh = node.mesh.map(|mesh| Mesh {
                mesh,
                name: scene.mesh_name(mesh).map(str::to_owned),
                faces: scene.mesh_counts(mesh)[1],
            });
            nodes.push(Node {
                node: index,
                name: node.name.clone(),
                depth,
                mesh,
                has: has.into_iter().filter(is_there).collect(),
            });
        }
        Self { parts, nodes }
    }
}

/// More nodes than this are only counted.
const MOST_LINES: usize = 100;
/// Deeper nodes are not indented further.
const DEEPEST: usize = 20;

impl fmt::Display for SceneTree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts: Vec<String> =
            self.parts.iter().map(|(name, &count)| counted(count, name)).collect();
        let nodes = counted(self.nodes.len(), "nodes");
        write!(f, "  scene        {nodes}, {}", parts.join(", "))?;
        for Node { node, name, depth, mesh, has } in self.nodes.iter().take(MOST_LINES) {
            let name = name.as_ref().map_or_else(|| format!("node {node}"), printable);
            write!(f, "\n    {:indent$}{name}", "", indent = 2 * depth.min(&DEEPEST))?;
            if let Some(Mesh { mesh, name, faces }) = mesh {
                let name = name.as_ref().map_or_else(|| mesh.to_string(), printable);
                write!(f, ": mesh {name}, {}", counted(*faces, "faces"))?;
            }
            if !has.is_empty() {
                write!(f, " ({})", has.join(", "))?;
            }
        }
        if self.nodes.len() > MOST_LINES {
            write!(f, "\n    and {} more nodes", self.nodes.len() - MOST_LINES)?;
        }
        Ok(())
    }
}
