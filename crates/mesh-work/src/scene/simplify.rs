//! Simplification of the meshes of a scene, with one number of faces for all of them.

use std::ops::ControlFlow;

use mesh_core::Topology;
use mesh_core::build::BuildReport;
use mesh_io::{Lost, NewMesh, NewPrimitive, Scene};
use mesh_metric::{CompareOptions, Surface, compare};
use simplify::{
    AchievedError, ErrorCheck, Options, Progress, RefineOptions, Shortfall, Simplified, StopReason,
    Target, simplify_observed,
};

use super::budget::{Collapses, split};
use super::parts::{Part, divided, in_units, parts};
use super::poses::DeformedError;
use super::rules::{SceneBudget, SceneError, SceneRules, SceneTarget};
use crate::attributes::Attributes;
use crate::charts::MergedCharts;
use crate::policy::Choices;

/// A simplified scene.
#[derive(Clone, Debug)]
pub struct SimplifiedScene {
    /// The scene.
    pub scene: Scene,
    /// The meshes with triangles, in the order of the document.
    pub meshes: Vec<MeshOfScene>,
    /// What is lost.
    pub lost: Vec<Lost>,
    /// The number of drawn faces that was asked for, if several meshes share it and more faces are left: no collapse of
    /// any mesh is possible.
    pub missed_faces: Option<usize>,
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
    /// Whether there were tangents without normals, which the format tells readers to ignore. The result has none.
    pub has_ignored_tangents: bool,
    /// The primitives that are removed because no face is left.
    pub removed: Vec<usize>,
    /// The errors in the other poses that count, if the mesh deforms.
    pub deformed: Option<DeformedError>,
    /// The bound of the rounding of positions, which all errors include.
    pub rounding: f64,
}

impl MeshOfScene {
    fn add_rounding(&mut self, rounding: f64) {
        self.rounding = rounding;
        let deformed = self.deformed.iter_mut().flat_map(|found| [&mut found.rms, &mut found.max]);
        [&mut self.rms, &mut self.max]
            .into_iter()
            .chain(deformed)
            .for_each(|error| *error += rounding);
        if let Some(bound) = &mut self.bound {
            bound.lower = (bound.lower - rounding).max(0.0);
            bound.upper = bound.upper.map(|upper| upper + rounding);
        }
    }
}

/// Samples of a face, and the fewest and the most samples of a mesh.
const SAMPLES_OF_FACE: usize = 5;
const SAMPLES: [usize; 2] = [500, 20_000];

/// Simplifies every mesh of a scene once, for the largest scale at which it is drawn. All data of vertices are carried
/// over: sets of texture coordinates, colours, normals, tangents, joints and weights, morph targets, custom attributes.
/// Primitives of a mesh are simplified together, so that borders between them stay closed. Primitives of points or
/// lines stay as they are.
///
/// With [`SceneBudget::Scene`], the drawn faces are divided so that the next collapse of each mesh costs about the same in
/// units of the scene, as if one queue had the collapses of all meshes. The costs are those of a first run for each mesh,
/// without refinement. The smallest charts of all meshes are merged first. A mesh that the default scene does not draw
/// has its own budget, with the same ratio. With [`SceneBudget::Node`], nodes that need different results get copies of
/// their mesh.
/// A single mesh gives the same geometry as [`simplify_observed`] with the same options.
///
/// # Errors
/// A mesh cannot be read, built or simplified, or the result cannot be written into the scene.
pub fn simplify_scene(
    scene: &Scene,
    rules: &SceneRules,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<SimplifiedScene, SceneError> {
    let SceneTarget { faces, max_error, relative, .. } = rules.target;
    let own = divided(scene, rules, faces.is_some(), max_error.is_some())?;
    let scene = own.as_ref().unwrap_or(scene);
    let parts = parts(scene, rules)?;
    let max_error = max_error.map(|length| in_units(length, relative, &parts)).transpose()?;
    let max_error = max_error.map(|limit| rules.without_rounding(limit, scene)).transpose()?;
    let shares = shares(&parts, rules)?;
    let (mut new, mut meshes) = (Vec::new(), Vec::new());
    for (part, share) in parts.iter().zip(&shares) {
        let (mesh, report) = part.simplified(rules, share, max_error, observe)?;
        new.push(mesh);
        meshes.push(report);
    }
    let (scene, lost) = scene.replaced(&new)?;
    let rounding = rules.rounding(&scene)?;
    for mesh in &mut meshes {
        mesh.add_rounding(rounding.get(mesh.mesh).copied().unwrap_or(0.0));
    }
    let left: usize = meshes.iter().map(|mesh| mesh.times * mesh.faces[1]).sum();
    let is_one = parts.iter().filter(|part| part.times > 0).nth(1).is_none();
    let missed_faces = shared_faces(&parts, rules).filter(|&wanted| !is_one && left > wanted);
    Ok(SimplifiedScene { scene, meshes, lost, missed_faces })
}

/// The share of a mesh in the targets.
struct Share {
    target: Target,
    /// The attributes, if charts were merged.
    merged: Option<Attributes>,
}

/// The number of faces that the drawn meshes share, if they share any.
fn shared_faces(parts: &[Part], rules: &SceneRules) -> Option<usize> {
    let SceneTarget { faces, ratio, .. } = rules.target;
    let is_shared = (faces.is_some() || ratio.is_some()) && rules.budget == SceneBudget::Scene;
    let target = Target { faces, ratio, ..Target::default() };
    is_shared.then(|| target.face_target(drawn_faces(parts)))
}

/// The number of faces that are drawn.
fn drawn_faces(parts: &[Part]) -> usize {
    parts.iter().map(|part| part.times * part.faces()).sum()
}

/// The share of each mesh.
fn shares(parts: &[Part], rules: &SceneRules) -> Result<Vec<Share>, SceneError> {
    let SceneTarget { faces, ratio, .. } = rules.target;
    let whole = Target { faces, ratio, ..Target::default() };
    let alone = |part: &Part, target: Target| {
        let faces = target.faces.map(|faces| faces / part.times_for(rules.budget));
        let target = Target { faces, ..target };
        let merge = || part.attributes.merge_charts(&part.loaded.mesh, &target);
        Share { target, merged: (!rules.keep_seams).then(merge).flatten() }
    };
    let drawn: Vec<&Part> = parts.iter().filter(|part| part.times > 0).collect();
    let Some(budget) = shared_faces(parts, rules) else {
        return Ok(parts.iter().map(|part| alone(part, whole)).collect());
    };
    let ratio_of_all = budget as f64 / drawn_faces(parts).max(1) as f64;
    let mut of_drawn = match drawn.as_slice() {
        [] => Vec::new(),
        // The share is rounded as for a single mesh.
        [one] => vec![alone(one, whole)],
        several => together(several, rules, budget, ratio_of_all)?,
    }
    .into_iter();
    let undrawn = Target { ratio: Some(ratio_of_all.min(1.0)), ..Target::default() };
    let share = |part: &Part| {
        let of_drawn = if part.times > 0 { of_drawn.next() } else { None };
        of_drawn.unwrap_or_else(|| alone(part, undrawn))
    };
    Ok(parts.iter().map(share).collect())
}

/// The shares of several drawn meshes in a number of faces.
fn together(
    parts: &[&Part],
    rules: &SceneRules,
    budget: usize,
    ratio: f64,
) -> Result<Vec<Share>, SceneError> {
    let merged = if rules.keep_seams { vec![None; parts.len()] } else { merged(parts, budget) };
    let all = parts.iter().zip(&merged).map(|(part, merged)| {
        part.first_collapses(rules, merged.as_ref().unwrap_or(&part.attributes), ratio)
    });
    let all = all.collect::<Result<Vec<_>, _>>()?;
    let shares =
        split(&all, budget).into_iter().zip(merged).zip(parts).map(|((faces, merged), part)| {
            let target = Target { faces: Some(faces), ..Target::default() };
            // A mesh with few faces may have no room for charts that have room in the scene.
            let own =
                merged.is_some().then(|| part.attributes.merge_charts(&part.loaded.mesh, &target));
            let charts = |one: &Attributes| one.merged().map(|[_, after]| after);
            Share { target, merged: merged.into_iter().chain(own.flatten()).min_by_key(charts) }
        });
    Ok(shares.collect())
}

/// For each mesh, the attributes with merged charts if the charts of all meshes have no room in a number of faces.
pub(super) fn merged(parts: &[&Part], faces: usize) -> Vec<Option<Attributes>> {
    let (mut places, mut charted) = (Vec::new(), Vec::new());
    for (place, part) in parts.iter().enumerate() {
        let (mesh, growth) = (&part.loaded.mesh, part.scale * part.scale);
        if let Some(charts) = part.attributes.charted(mesh, part.times, growth) {
            places.push(place);
            charted.push(charts);
        }
    }
    let mut all = vec![None; parts.len()];
    for (place, merged) in places.into_iter().zip(MergedCharts::make_room(&charted, faces)) {
        let part = parts[place];
        all[place] = merged.map(|merged| part.attributes.with_merged(&part.loaded.mesh, merged));
    }
    all
}

/// How often an error limit is lowered, what is left of it for rounding, and the least factor.
const TRIES: usize = 5;
const MARGIN: f64 = 0.9;
const LEAST_STEP: f64 = 0.2;

/// A result for a mesh.
struct Candidate {
    result: Simplified,
    new: NewMesh,
    /// The errors in the poses that count, if the mesh deforms.
    deformed: Option<DeformedError>,
}

impl Part {
    /// The collapses of a run without refinement, with costs at the scale of the scene.
    fn first_collapses(
        &self,
        rules: &SceneRules,
        attributes: &Attributes,
        ratio: f64,
    ) -> Result<Collapses, SceneError> {
        let mesh = &self.loaded.mesh;
        let least = self.least(ratio);
        let target = Target { faces: Some(least), ..Target::default() };
        let choices = Choices { verify: false, ..rules.choices };
        let mut options = choices.options(mesh, target).for_levels();
        self.constrain(attributes, &mut options);
        let run = simplify_observed(mesh, &options, &mut |_| ControlFlow::Continue(()))
            .map_err(|source| self.error(source))?;
        let left = run.mesh.topology().face_count();
        let all = self.collapses(&run.log, options.cost.metric, left);
        Ok(Collapses { least, ..all })
    }

    fn simplified(
        &self,
        rules: &SceneRules,
        share: &Share,
        max_error: Option<f64>,
        observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<(NewMesh, MeshOfScene), SceneError> {
        let mesh = &self.loaded.mesh;
        let attributes = share.merged.as_ref().unwrap_or(&self.attributes);
        let mut options = rules.choices.options(mesh, share.target);
        self.constrain(attributes, &mut options);
        if let Some(error) = max_error {
            options = options.within(error / self.scale, rules.choices.check());
        }
        let limit = max_error.map(|error| (error, rules.choices.check()));
        let rounds = rules.quantization.is_some();
        let best = self.best(attributes, options, (limit, rounds), observe)?;
        let Candidate { result, new, deformed } = best;
        let removed = new.primitives.iter().filter(|p| p.triangles.is_empty()).map(|p| p.index);
        let removed = removed.collect();
        let report = self.report(&result, attributes.merged())?;
        Ok((new, MeshOfScene { removed, deformed, ..report }))
    }

    /// The result of these options. If the mesh deforms, two more results are made: one without refinement, and one
    /// without poses. The result with the least error over all poses is taken. An error limit, in units of the scene,
    /// holds in all poses, or is missed by less than if it held in the pose of the file only. Weights of skins are
    /// rounded if `rounds` is set.
    fn best(
        &self,
        attributes: &Attributes,
        mut options: Options,
        (limit, rounds): (Option<(f64, ErrorCheck)>, bool),
        observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Candidate, SceneError> {
        let mut best = self.candidate(attributes, &options, rounds, observe)?;
        let is_stopped = |candidate: &Candidate| candidate.result.stop == StopReason::Cancelled;
        if let Some((limit, check)) = limit {
            let mut own = limit / self.scale;
            for _ in 0..TRIES {
                let found = best.deformed.map_or(0.0, |found| found.max);
                if found <= limit || is_stopped(&best) {
                    break;
                }
                own *= (MARGIN * limit / found).max(LEAST_STEP);
                options = options.within(own, check);
                let next = self.candidate(attributes, &options, rounds, observe)?;
                if is_stopped(&next) || next.deformed.is_some_and(|next| next.max < found) {
                    best = next;
                }
            }
            return Ok(best);
        }
        let unrefined = Options { refine: RefineOptions::none(), ..options.clone() };
        options.attributes.poses = None;
        let is_other = options.refine.is_any();
        for other in is_other.then_some(unrefined).into_iter().chain([options]) {
            let Some(own) = best.deformed.filter(|_| !is_stopped(&best)) else { break };
            let next = self.candidate(attributes, &other, rounds, observe)?;
            let faces = |of: &Candidate| of.result.mesh.topology().face_count();
            let has_no_more = faces(&next) <= faces(&best);
            if is_stopped(&next) {
                best.result.stop = StopReason::Cancelled;
            } else if has_no_more && next.deformed.is_some_and(|next| next.rms < own.rms) {
                best = next;
            }
        }
        Ok(best)
    }

    /// The result of these options as a mesh of the scene, with its measured errors.
    fn candidate(
        &self,
        attributes: &Attributes,
        options: &Options,
        rounds: bool,
        observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Candidate, SceneError> {
        let mesh = &self.loaded.mesh;
        let result =
            simplify_observed(mesh, options, observe).map_err(|source| self.error(source))?;
        let mut new = self.replacement(attributes, &result.mesh, &result.vertex_map)?;
        if rounds {
            // The errors in other poses depend on it.
            new.primitives.iter_mut().for_each(NewPrimitive::round_weights);
        }
        let deformed = self.deformed(&new)?;
        Ok(Candidate { result, new, deformed })
    }

    /// The errors of a result in the poses that count.
    fn deformed(&self, new: &NewMesh) -> Result<Option<DeformedError>, SceneError> {
        let Some(deforming) = &self.deforming else { return Ok(None) };
        let samples = self.samples();
        Ok(Some(deforming.error(self.loaded.source(), &self.primitives, new, samples)?))
    }

    /// The number of points at which distances are measured.
    fn samples(&self) -> usize {
        let [fewest, most] = SAMPLES;
        (SAMPLES_OF_FACE * self.faces()).clamp(fewest, most)
    }

    fn report(
        &self,
        result: &Simplified,
        charts: Option<[usize; 2]>,
    ) -> Result<MeshOfScene, SceneError> {
        let (before, after) = (self.loaded.mesh.topology(), result.mesh.topology());
        let sampling = CompareOptions { samples: self.samples(), ..CompareOptions::default() };
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
            has_ignored_tangents: self.has_ignored_tangents(),
            removed: Vec::new(),
            deformed: None,
            rounding: 0.0,
        })
    }
}
