//! Simplification of the meshes of a scene, with one number of faces for all of them.

use std::ops::ControlFlow;

use glam::DVec3;
use mesh_core::Topology;
use mesh_core::build::{BuildError, BuildReport, Repair};
use mesh_io::{
    Format, Lost, ModelError, NewMesh, ReadError, Scene, SceneDraw, SceneMesh, ScenePrimitive,
    WriteError,
};
use mesh_metric::{CompareOptions, Surface, SurfaceError, compare};
use simplify::{
    AchievedError, Options, Preset, Progress, Shortfall, Simplified, SimplifyError, StopReason,
    Target, simplify_observed,
};

use super::budget::{Curve, split};
use super::transfer::transfer;
use crate::attributes::{AttributeRules, Attributes};
use crate::length::{Length, NoExtent, diagonal};
use crate::loaded::{Loaded, splits_vertices};
use crate::policy::Choices;

/// How a scene is simplified.
#[derive(Clone, Debug)]
pub struct SceneRules {
    /// When to stop.
    pub target: SceneTarget,
    /// What shares a number of faces.
    pub budget: SceneBudget,
    /// How each mesh is simplified.
    pub choices: Choices,
    /// How attributes are weighted and transferred.
    pub attributes: AttributeRules,
    /// Whether all borders of texture charts, materials and primitives stay, even if the shape suffers.
    pub keep_seams: bool,
    /// The repairs of the meshes. Vertices at equal positions are welded unless a weld is given.
    pub repair: Repair,
    /// Whether repairs that a mesh needs are made besides.
    pub needed_repairs: bool,
    /// Whether vertices that the format splits are joined.
    pub join: bool,
}

impl Default for SceneRules {
    fn default() -> Self {
        Self {
            target: SceneTarget::default(),
            budget: SceneBudget::default(),
            choices: Choices::default(),
            attributes: AttributeRules::default(),
            keep_seams: false,
            repair: Repair::strict(),
            needed_repairs: true,
            join: true,
        }
    }
}

/// The targets of the simplification of a scene. It stops at the first target that is reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneTarget {
    /// The number of faces that are drawn. A mesh that is drawn twice counts twice.
    pub faces: Option<usize>,
    /// The share of the faces.
    pub ratio: Option<f64>,
    /// The largest distance from the input, in units of the scene. A percentage is a share of the diagonal of the
    /// bounding box of the scene.
    pub max_error: Option<Length>,
    /// Whether a plain distance is a share of the diagonal as well.
    pub relative: bool,
}

/// What shares a number of faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SceneBudget {
    /// The scene: the squared distance from the input, over all surfaces as they are drawn, is least.
    #[default]
    Scene,
    /// Each mesh by itself: the target is for every mesh.
    Mesh,
}

/// A simplified scene.
#[derive(Clone, Debug)]
pub struct SimplifiedScene {
    /// The scene.
    pub scene: Scene,
    /// The meshes with triangles, in the order of the document.
    pub meshes: Vec<MeshOfScene>,
    /// What is lost.
    pub lost: Vec<Lost>,
}

/// A simplified mesh of a scene.
#[derive(Clone, Debug)]
pub struct MeshOfScene {
    /// The mesh.
    pub mesh: usize,
    /// Its name, or the name of the first node that draws it.
    pub name: Option<String>,
    /// The number of times that the default scene draws it.
    pub times: usize,
    /// The largest factor by which a length grows where it is drawn.
    pub scale: f64,
    /// The numbers of faces before and after.
    pub faces: [usize; 2],
    /// The numbers of vertices before and after, split vertices joined.
    pub vertices: [usize; 2],
    /// The root mean square and the largest distance between samples of the input and the result, at the largest scale
    /// at which the mesh is drawn, in the rest pose.
    pub rms: f64,
    /// The largest distance.
    pub max: f64,
    /// The proved distance at that scale, if it was asked for.
    pub bound: Option<AchievedError>,
    /// Why the run stopped.
    pub stop: StopReason,
    /// The target that was not reached.
    pub shortfall: Option<Shortfall>,
    /// The repairs that were made.
    pub repairs: BuildReport,
    /// The number of charts before and after some were merged.
    pub charts: Option<[usize; 2]>,
    /// Whether each face had a normal of its own. The result has no normals then.
    pub is_flat_shaded: bool,
    /// The primitives that are removed because no face is left.
    pub removed: Vec<usize>,
}

/// Why a scene cannot be simplified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The data of a mesh cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A mesh cannot be built.
    #[error("mesh {mesh}: {source}")]
    Build {
        /// The mesh.
        mesh: usize,
        /// The defect.
        source: Box<BuildError>,
    },
    /// A mesh cannot be simplified as asked.
    #[error("mesh {mesh}: {source}")]
    Simplify {
        /// The mesh.
        mesh: usize,
        /// The reason.
        source: SimplifyError,
    },
    /// The error of a mesh cannot be measured.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The data of a mesh are inconsistent.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The result does not fit into the scene.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A length is relative to a scene without extent.
    #[error(transparent)]
    NoExtent(#[from] NoExtent),
}

/// A mesh of the scene, ready for the simplification.
struct Part {
    mesh: usize,
    primitives: Vec<ScenePrimitive>,
    loaded: Loaded,
    attributes: Attributes,
    times: usize,
    scale: f64,
    name: Option<String>,
}

/// A mesh keeps at least this many faces, so that it does not vanish.
const LEAST_FACES: usize = 4;
/// The share of its part of an equal division that a mesh keeps whose vertices have data that the measured error does
/// not show: colours, skins, morph targets, numbers.
const LEAST_SHARE: f64 = 0.5;
/// Numbers of faces at which the error is measured are this factor apart.
const STEP: f64 = 0.6;
/// Samples of a face and the most samples, for the division of the faces and for the report.
const FEW_SAMPLES: [usize; 2] = [1, 2_000];
const SAMPLES: [usize; 2] = [5, 20_000];
/// The fewest samples.
const LEAST_SAMPLES: usize = 500;

/// Simplifies every mesh of a scene once, for the largest scale at which it is drawn. All data of vertices are carried
/// over: sets of texture coordinates, colours, normals, tangents, joints and weights, morph targets, custom attributes.
/// Primitives of a mesh are simplified together, so that borders between them stay closed. Primitives of points or
/// lines stay as they are.
///
/// With [`SceneBudget::Scene`], the drawn faces are divided so that the squared distance from the input, measured on a
/// quick simplification and summed over all drawn surfaces, is least. A mesh that the default scene does not draw has its own budget, with the same ratio.
/// A single mesh gives the same geometry as [`simplify_observed`] with the same options.
///
/// # Errors
/// A mesh cannot be read, built or simplified, or the result cannot be written into the scene.
pub fn simplify_scene(
    scene: &Scene,
    rules: &SceneRules,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<SimplifiedScene, SceneError> {
    let parts = parts(scene, rules)?;
    let max_error = match rules.target.max_error {
        Some(length) => {
            let of_box =
                || diagonal(scene_diagonal(&scene.draws()?, &parts)).map_err(SceneError::from);
            Some(match length {
                Length::Plain(length) if !rules.target.relative => length,
                Length::Plain(share) => share * of_box()?,
                Length::Percent(share) => share / 100.0 * of_box()?,
            })
        }
        None => None,
    };
    let targets = targets(&parts, rules)?;
    let (mut new, mut meshes) = (Vec::new(), Vec::new());
    for (part, target) in parts.iter().zip(targets) {
        let (mesh, report) = part.simplified(rules, target, max_error, observe)?;
        new.push(mesh);
        meshes.push(report);
    }
    let (scene, lost) = scene.replaced(&new)?;
    Ok(SimplifiedScene { scene, meshes, lost })
}

fn parts(scene: &Scene, rules: &SceneRules) -> Result<Vec<Part>, SceneError> {
    let draws = scene.draws()?;
    let nodes: Vec<_> = scene.nodes().collect();
    let all: Vec<usize> = (0..scene.mesh_count()).collect();
    let mut parts = Vec::new();
    for (mesh, content) in scene.meshes(&all)?.into_iter().enumerate() {
        let Some(SceneMesh { model, primitives }) = content else { continue };
        let own = || draws.iter().filter(|draw| draw.mesh == mesh);
        let scale = own().map(SceneDraw::scale).fold(0.0, f64::max);
        let of_node = || own().find_map(|draw| nodes.get(draw.node)?.name.clone());
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
        let attributes = Attributes::find(loaded.source(), &rules.attributes)
            .map_err(|source| SceneError::Simplify { mesh, source })?;
        parts.push(Part {
            mesh,
            primitives,
            loaded,
            attributes,
            times: own().map(|draw| draw.times).sum(),
            // A mesh that is drawn flat, or not at all, is measured as it is.
            scale: if scale > 0.0 && scale.is_finite() { scale } else { 1.0 },
            name,
        });
    }
    Ok(parts)
}

/// The diagonal of the bounding box of the drawn meshes; `None` if nothing is drawn.
fn scene_diagonal(draws: &[SceneDraw], parts: &[Part]) -> Option<f64> {
    let mut bounds: Option<[DVec3; 2]> = None;
    for draw in draws {
        let Some(part) = parts.iter().find(|part| part.mesh == draw.mesh) else { continue };
        // The joints of a skin place a mesh where the first one does, up to the pose.
        for transform in draw.transforms.iter().take(draw.times) {
            for &position in part.loaded.mesh.positions() {
                let at = transform.transform_point3(position);
                let [low, high] = bounds.get_or_insert([at; 2]);
                (*low, *high) = (low.min(at), high.max(at));
            }
        }
    }
    bounds.map(|[low, high]| (high - low).length())
}

/// The target of each mesh.
fn targets(parts: &[Part], rules: &SceneRules) -> Result<Vec<Target>, SceneError> {
    let SceneTarget { faces, ratio, .. } = rules.target;
    let whole = Target { faces, ratio, ..Target::default() };
    let drawn: Vec<&Part> = parts.iter().filter(|part| part.times > 0).collect();
    let total: usize = drawn.iter().map(|part| part.times * part.faces()).sum();
    if (faces.is_none() && ratio.is_none()) || rules.budget == SceneBudget::Mesh {
        return Ok(vec![whole; parts.len()]);
    }
    let budget = whole.face_target(total);
    let share = budget as f64 / total.max(1) as f64;
    let undrawn = Target { ratio: Some(share.min(1.0)), ..Target::default() };
    let counts = match drawn.as_slice() {
        [] => Vec::new(),
        // The share is rounded as for a single mesh.
        [one] => {
            let faces = faces.map(|faces| faces / one.times);
            let target = Target { faces, ratio, ..Target::default() };
            return Ok(parts
                .iter()
                .map(|part| if part.times > 0 { target } else { undrawn })
                .collect());
        }
        several => {
            let curves = several.iter().map(|part| part.curve(rules, share));
            split(&curves.collect::<Result<Vec<_>, _>>()?, budget)
        }
    };
    let mut counts = counts.into_iter();
    let target = |part: &Part| {
        if part.times == 0 {
            return undrawn;
        }
        Target { faces: counts.next(), ..Target::default() }
    };
    Ok(parts.iter().map(target).collect())
}

impl Part {
    fn faces(&self) -> usize {
        self.loaded.mesh.topology().face_count()
    }

    fn error(&self, source: SimplifyError) -> SceneError {
        SceneError::Simplify { mesh: self.mesh, source }
    }

    fn sampling(&self, [of_face, most]: [usize; 2]) -> CompareOptions {
        let samples = (of_face * self.faces()).clamp(LEAST_SAMPLES, most);
        CompareOptions { samples, ..CompareOptions::default() }
    }

    /// The squared distance, summed over the surface, at falling numbers of faces, from a quick simplification, at the
    /// scale of the scene.
    fn curve(&self, rules: &SceneRules, share: f64) -> Result<Curve, SceneError> {
        let (mesh, faces) = (&self.loaded.mesh, self.faces());
        let equal = share * faces as f64;
        let least = if self.has_more_data() { LEAST_SHARE * equal } else { 0.0 };
        let least = (least as usize).max(LEAST_FACES).min(faces);
        let quick = Choices { preset: Preset::Fast, ..rules.choices };
        let quick = Choices { verify: false, anneal_time: None, placement: None, ..quick };
        let target = Target { faces: Some(least), ..Target::default() };
        let (mut options, _) = self.options(&quick, target, rules.keep_seams, equal as usize);
        options = options.for_levels();
        let run = simplify_observed(mesh, &options, &mut |_| ControlFlow::Continue(()))
            .map_err(|source| self.error(source))?;
        let original = Surface::new(mesh)?;
        let sampling = self.sampling(FEW_SAMPLES);
        let area = mesh.area();
        let mut points = vec![(faces, 0.0)];
        let last = run.mesh.topology().face_count();
        let mut wanted = faces as f64;
        while points.last().is_some_and(|&(count, _)| count > last) {
            wanted *= STEP;
            let stage = run.log.count_for_faces((wanted as usize).max(last));
            let (level, _) = run.log.level(mesh, stage).map_err(|e| self.error(e.into()))?;
            let count = level.topology().face_count();
            if points.last().is_some_and(|&(before, _)| count >= before) {
                continue;
            }
            let distance = compare(&original, &Surface::new(&level)?, &sampling);
            // Areas grow with the square of the scale, and squared distances as well.
            let squared = (self.scale * self.scale * distance.rms()).powi(2);
            points.push((count, area * squared));
        }
        Ok(Curve { times: self.times, points, least })
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

    /// The options of a run, and the attributes with charts merged as the wanted faces require it.
    fn options(
        &self,
        choices: &Choices,
        target: Target,
        keep_seams: bool,
        for_charts: usize,
    ) -> (Options, Option<Attributes>) {
        let mesh = &self.loaded.mesh;
        let mut options = choices.options(mesh, target);
        let charts =
            if for_charts == 0 { target } else { Target { faces: Some(for_charts), ..target } };
        let merged = (!keep_seams).then(|| self.attributes.merge_charts(mesh, &charts)).flatten();
        merged.as_ref().unwrap_or(&self.attributes).constrain(mesh, &mut options);
        (options, merged)
    }

    fn simplified(
        &self,
        rules: &SceneRules,
        target: Target,
        max_error: Option<f64>,
        observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<(NewMesh, MeshOfScene), SceneError> {
        let mesh = &self.loaded.mesh;
        let (mut options, merged) = self.options(&rules.choices, target, rules.keep_seams, 0);
        if let Some(error) = max_error {
            options = options.within(error / self.scale, rules.choices.check());
        }
        let result =
            simplify_observed(mesh, &options, observe).map_err(|source| self.error(source))?;
        let attributes = merged.as_ref().unwrap_or(&self.attributes);
        let source = self.loaded.source();
        let sources = attributes.sources(source, &result.mesh, &result.vertex_map);
        let carried = attributes.carry_from(source, &result.mesh, &sources)?;
        let primitives = transfer(source.model, &self.primitives, &result.mesh, &sources, &carried);
        let removed = primitives.iter().filter(|p| p.triangles.is_empty()).map(|p| p.index);
        let mut report = self.report(&result, attributes.merged())?;
        report.removed = removed.collect();
        Ok((NewMesh { mesh: self.mesh, primitives }, report))
    }

    fn report(
        &self,
        result: &Simplified,
        charts: Option<[usize; 2]>,
    ) -> Result<MeshOfScene, SceneError> {
        let (before, after) = (self.loaded.mesh.topology(), result.mesh.topology());
        let sampling = self.sampling(SAMPLES);
        let [from, to] = [&self.loaded.mesh, &result.mesh].map(Surface::new);
        let distance = compare(&from?, &to?, &sampling);
        let bound = result.error.map(|error| AchievedError {
            lower: error.lower * self.scale,
            upper: error.upper.map(|upper| upper * self.scale),
        });
        Ok(MeshOfScene {
            mesh: self.mesh,
            name: self.name.clone(),
            times: self.times,
            scale: self.scale,
            faces: [before, after].map(Topology::face_count),
            vertices: [before, after].map(Topology::vertex_count),
            rms: self.scale * distance.rms(),
            max: self.scale * distance.hausdorff(),
            bound,
            stop: result.stop,
            shortfall: result.shortfall.clone(),
            repairs: self.loaded.report.clone(),
            charts,
            is_flat_shaded: self.attributes.is_flat_shaded(),
            removed: Vec::new(),
        })
    }
}
