//! The meshes of a scene, ready for the simplification.

use std::collections::BTreeSet;

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_io::{Format, NewMesh, Scene, SceneDraw, SceneMesh, ScenePrimitive};
use simplify::{CollapseLog, Metric, Options, SimplifyError};

use super::budget::Collapses;
use super::poses::Deforming;
use super::rules::{SceneBudget, SceneError, SceneRules};
use super::transfer::transfer;
use crate::attributes::Attributes;
use crate::length::{Length, diagonal};
use crate::loaded::{Loaded, splits_vertices};

/// A mesh of the scene, ready for the simplification.
pub(super) struct Part {
    pub(super) mesh: usize,
    pub(super) primitives: Vec<ScenePrimitive>,
    pub(super) loaded: Loaded,
    pub(super) attributes: Attributes,
    pub(super) times: usize,
    pub(super) scale: f64,
    pub(super) name: Option<String>,
    pub(super) draws: Vec<SceneDraw>,
    /// The poses that count, if it deforms.
    pub(super) deforming: Option<Deforming>,
}

/// A mesh keeps at least this many faces, so that it does not vanish.
const LEAST_FACES: usize = 4;
/// The share of its part of an equal division that a mesh keeps whose vertices have data that the measured error does
/// not show: colours, skins, morph targets, numbers.
const LEAST_SHARE: f64 = 0.5;

/// The meshes of a scene with triangles.
pub(super) fn parts(scene: &Scene, rules: &SceneRules) -> Result<Vec<Part>, SceneError> {
    let nodes: Vec<_> = scene.nodes().collect();
    let all: Vec<usize> = (0..scene.mesh_count()).collect();
    let mut draws = vec![Vec::new(); all.len()];
    let mut shapes = vec![Vec::new(); all.len()];
    let drawn = scene.draws()?;
    let poses = if rules.poses > 0 { scene.poses(&drawn)? } else { vec![Vec::new(); drawn.len()] };
    for (draw, poses) in drawn.into_iter().zip(poses) {
        if let (Some(own), Some(shapes)) = (draws.get_mut(draw.mesh), shapes.get_mut(draw.mesh)) {
            own.push(draw);
            shapes.extend(poses);
        }
    }
    let mut parts = Vec::new();
    for (mesh, content) in scene.meshes(&all)?.into_iter().enumerate() {
        let Some(SceneMesh { model, primitives }) = content else { continue };
        let draws = std::mem::take(&mut draws[mesh]);
        let scale = draws.iter().map(SceneDraw::scale).fold(0.0, f64::max);
        let of_node = || draws.iter().find_map(|draw| nodes.get(draw.node)?.name.clone());
        let name = scene.mesh_name(mesh).map(str::to_owned).or_else(of_node);
        let mut repair = rules.repair;
        if rules.join && splits_vertices(&model, Some(Format::Gltf)) {
            repair.weld = mesh_core::build::Weld::Exact;
        }
        let loaded = if rules.needed_repairs {
            Loaded::build_with_needed_repairs(model, &repair)
        } else {
            Loaded::build(model, &repair)
        };
        let loaded =
            loaded.map_err(|source| SceneError::Build { mesh, source: Box::new(source) })?;
        if loaded.mesh.topology().face_count() == 0 {
            continue;
        }
        // A mesh that is drawn flat, or not at all, is measured as it is.
        let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
        let deforming =
            Deforming::new(loaded.source(), &primitives, &shapes[mesh], rules.poses, scale);
        let attributes = Attributes::find(loaded.source(), &rules.attributes)
            .map_err(|source| SceneError::Simplify { mesh, source })?;
        parts.push(Part {
            mesh,
            primitives,
            loaded,
            attributes,
            times: draws.iter().map(|draw| draw.times).sum(),
            scale,
            name,
            draws,
            deforming,
        });
    }
    Ok(parts)
}

/// Scales that differ by less than this part are equal.
const SAME_SCALE: f64 = 1e-6;

/// The scene in which nodes have a mesh of their own if a target for each node makes their results differ: a number of
/// faces, if they draw the mesh a different number of times; a distance, if they draw it at different scales.
pub(super) fn divided(
    scene: &Scene,
    rules: &SceneRules,
    has_faces: bool,
    has_distance: bool,
) -> Result<Option<Scene>, SceneError> {
    if rules.budget != SceneBudget::Node {
        return Ok(None);
    }
    let mut groups: Vec<(SceneDraw, Vec<usize>)> = Vec::new();
    for draw in scene.draws()? {
        let scale = draw.scale();
        let is_same = |other: &SceneDraw| {
            let is_near = (other.scale() - scale).abs() <= SAME_SCALE * scale;
            other.mesh == draw.mesh
                && (!has_faces || other.times == draw.times)
                && (!has_distance || is_near || !scale.is_finite())
        };
        match groups.iter_mut().find(|(other, _)| is_same(other)) {
            Some((_, nodes)) => nodes.push(draw.node),
            None => groups.push((draw.clone(), vec![draw.node])),
        }
    }
    let mut seen = BTreeSet::new();
    // The first group of each mesh keeps it, together with all nodes that are not drawn.
    let others = groups.into_iter().filter(|(draw, _)| !seen.insert(draw.mesh));
    let others: Vec<Vec<usize>> = others.map(|(_, nodes)| nodes).collect();
    if others.is_empty() { Ok(None) } else { Ok(Some(scene.with_own_meshes(&others)?)) }
}

/// The diagonal of the bounding box of the drawn meshes; `None` if nothing is drawn.
pub(super) fn scene_diagonal(parts: &[Part]) -> Option<f64> {
    let mut bounds: Option<[DVec3; 2]> = None;
    for part in parts {
        // The joints of a skin place a mesh where the first one does, up to the pose.
        let transforms = part.draws.iter().flat_map(|draw| draw.transforms.iter().take(draw.times));
        for transform in transforms {
            for &position in part.loaded.mesh.positions() {
                let at = transform.transform_point3(position);
                let [low, high] = bounds.get_or_insert([at; 2]);
                (*low, *high) = (low.min(at), high.max(at));
            }
        }
    }
    bounds.map(|[low, high]| (high - low).length())
}

/// A length in units of the scene. Relative lengths and percentages are shares of the diagonal of its bounding box.
pub(super) fn in_units(length: Length, relative: bool, parts: &[Part]) -> Result<f64, SceneError> {
    let of_box = || diagonal(scene_diagonal(parts)).map_err(SceneError::from);
    Ok(match length {
        Length::Plain(length) if !relative => length,
        Length::Plain(share) => share * of_box()?,
        Length::Percent(share) => share / 100.0 * of_box()?,
    })
}

impl Part {
    /// Whether it has tangents, but no normals.
    pub(super) fn has_ignored_tangents(&self) -> bool {
        let data = |primitive: &ScenePrimitive| {
            let mut all = primitive.attributes.iter().chain(primitive.targets.iter().flatten());
            all.any(|data| data.name == "TANGENT")
        };
        self.loaded.model.corner_normals.is_none() && self.primitives.iter().any(data)
    }

    pub(super) fn faces(&self) -> usize {
        self.loaded.mesh.topology().face_count()
    }

    /// The number of times that the mesh is drawn by what a number of faces is for.
    pub(super) fn times_for(&self, budget: SceneBudget) -> usize {
        match budget {
            SceneBudget::Scene => self.times.max(1),
            SceneBudget::Mesh => 1,
            // All nodes draw it the same number of times.
            SceneBudget::Node => self.draws.first().map_or(1, |draw| draw.times).max(1),
        }
    }

    /// Adds what the vertices carry to the cost.
    pub(super) fn constrain(&self, attributes: &Attributes, options: &mut Options) {
        attributes.constrain(&self.loaded.mesh, options);
        // The curvature norms have no term for poses.
        let deforming = self.deforming.as_ref().filter(|_| !options.cost.metric.is_norm());
        options.attributes.poses = deforming.map(|deforming| deforming.of_vertices.clone());
    }

    pub(super) fn error(&self, source: SimplifyError) -> SceneError {
        SceneError::Simplify { mesh: self.mesh, source }
    }

    /// The least number of faces of the mesh if the scene keeps this share of its faces.
    pub(super) fn least(&self, ratio: f64) -> usize {
        let faces = self.faces();
        let least = if self.has_more_data() { LEAST_SHARE * ratio * faces as f64 } else { 0.0 };
        (least as usize).max(LEAST_FACES).min(faces)
    }

    /// The collapses of a run that leaves `left` faces, with costs at the scale of the scene.
    pub(super) fn collapses(&self, log: &CollapseLog, metric: Metric, left: usize) -> Collapses {
        let growth = self.scale.powi(metric.length_exponent());
        let entries = log.entries();
        let after = entries.iter().skip(1).map(|entry| entry.faces_before as usize).chain([left]);
        let steps = entries.iter().map(|entry| growth * entry.cost).zip(after).collect();
        Collapses { times: self.times, faces: self.faces(), least: 0, steps }
    }

    /// A simplified mesh with the data of the vertices. `became` maps old to new vertices.
    pub(super) fn replacement(
        &self,
        attributes: &Attributes,
        result: &TriMesh,
        became: &VertexMap<Option<VertexId>>,
    ) -> Result<NewMesh, SceneError> {
        let source = self.loaded.source();
        let sources = attributes.sources(source, result, became);
        let carried = attributes.carry_from(source, result, &sources)?;
        let primitives = transfer(source.model, &self.primitives, result, &sources, &carried);
        Ok(NewMesh { mesh: self.mesh, primitives })
    }

    /// Whether the vertices have data besides positions, normals and texture coordinates.
    fn has_more_data(&self) -> bool {
        const SHOWN: [&str; 3] = ["POSITION", "NORMAL", "TANGENT"];
        self.primitives.iter().any(|primitive| {
            let names = primitive.attributes.iter().map(|data| data.name.as_str());
            let hidden = |name: &str| !SHOWN.contains(&name) && !name.starts_with("TEXCOORD_");
            !primitive.targets.is_empty() || names.into_iter().any(hidden)
        })
    }
}
