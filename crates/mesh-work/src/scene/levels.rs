//! Levels of detail of a scene: stages of one sequence of edge collapses for each mesh.

use std::borrow::Cow;
use std::ops::ControlFlow;

use mesh_core::build::BuildReport;
use mesh_io::{Lost, NewMesh, Scene, WriteError};
use mesh_metric::{CompareOptions, Comparison, Surface, compare};
use simplify::{CollapseLog, Options, Progress, Stages, Target, simplify_observed};

use super::budget::split;
use super::parts::{Part, divided, in_units, parts, scene_diagonal};
use super::rules::{SceneBudget, SceneError, SceneRules};
use super::simplify::merged;
use crate::attributes::Attributes;
use crate::length::Length;
use crate::levels::{SAMPLES, shown_from, stages_of};

/// The levels of a scene to make.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneSteps {
    /// One level for each share of the faces.
    pub ratios: Vec<f64>,
    /// One level for each number of drawn faces.
    pub faces: Vec<usize>,
    /// One level for each distance from the input: the coarsest within it. A percentage is a share of the diagonal of
    /// the bounding box of the scene.
    pub errors: Vec<Length>,
    /// Whether a plain distance is a share of the diagonal as well.
    pub relative: bool,
}

/// The levels of a scene.
#[derive(Clone, Debug)]
pub struct SceneLevels {
    /// The levels, from fine to coarse.
    pub levels: Vec<SceneLevel>,
    /// For the input and each level, the share of the height of the screen that the scene must cover for it to be
    /// shown; see [`shown_from`].
    pub coverage: Vec<f64>,
    /// The repairs of each mesh with triangles.
    pub repairs: Vec<BuildReport>,
    /// The number of meshes of which each face had a normal of its own. The levels have no normals there.
    pub flat_shaded: usize,
    /// The number of meshes with tangents but without normals. The levels have no tangents there.
    pub ignored_tangents: usize,
    /// The wanted numbers of drawn faces that no level reaches.
    pub missed_faces: Vec<usize>,
    /// The input, in which nodes that need different levels have meshes of their own.
    input: Scene,
    meshes: Vec<usize>,
    /// The new meshes of each level, and the shares of the screen for each mesh.
    new: Vec<Vec<NewMesh>>,
    of_meshes: Vec<Vec<f64>>,
}

/// A level of detail of a scene.
#[derive(Clone, Debug)]
pub struct SceneLevel {
    /// The scene.
    pub scene: Scene,
    /// The meshes with triangles, in the order of the document.
    pub meshes: Vec<MeshOfLevel>,
    /// The mean distance between the drawn surfaces of the input and the level, over both; NaN if nothing is drawn.
    pub mean: f64,
    /// The root mean square distance; NaN if nothing is drawn.
    pub rms: f64,
    /// The largest distance of a sample; NaN if nothing is drawn.
    pub max: f64,
    /// What is lost.
    pub lost: Vec<Lost>,
}

impl SceneLevel {
    /// Adds the rounding of the meshes of the input and of this level: in one file, they have the same grids.
    fn add_rounding(&mut self, input: &[f64], own: &[f64]) {
        let mut most = 0.0_f64;
        for mesh in &mut self.meshes {
            let of = |all: &[f64]| all.get(mesh.mesh).copied().unwrap_or(0.0);
            let rounding = of(input).max(of(own));
            for error in [&mut mesh.mean, &mut mesh.rms, &mut mesh.max] {
                *error += rounding;
            }
            most = most.max(if mesh.times > 0 { rounding } else { 0.0 });
        }
        for error in [&mut self.mean, &mut self.rms, &mut self.max] {
            *error += most;
        }
    }
}

/// A mesh in a level of detail of a scene. Distances are at the largest scale at which it is drawn, in the rest pose.
#[derive(Clone, Debug)]
pub struct MeshOfLevel {
    /// The mesh.
    pub mesh: usize,
    /// Its name, or the name of the first node that draws it.
    pub name: Option<String>,
    /// The number of times that the default scene draws it.
    pub times: usize,
    /// The numbers of faces before and after.
    pub faces: [usize; 2],
    /// The number of vertices, split vertices joined.
    pub vertices: usize,
    /// Number of collapses that lead to it.
    pub collapses: usize,
    /// The numbers of charts before and after, if charts were merged.
    pub charts: Option<[usize; 2]>,
    /// The mean distance.
    pub mean: f64,
    /// The root mean square distance.
    pub rms: f64,
    /// The largest distance.
    pub max: f64,
    /// The primitives that are removed because no face is left.
    pub removed: Vec<usize>,
}

impl SceneLevels {
    /// The input with all levels as alternatives of its nodes (`MSFT_lod`).
    ///
    /// # Errors
    /// As [`Scene::with_levels`].
    pub fn together(&self) -> Result<(Scene, Vec<Lost>), WriteError> {
        let coverage = self.meshes.iter().copied().zip(self.of_meshes.iter().cloned()).collect();
        self.input.with_levels(&self.new, &coverage)
    }
}

/// A mesh, the collapses of its run, and the stages of its levels.
struct Run<'p> {
    part: &'p Part,
    /// With merged charts, if there was no room for all.
    attributes: Cow<'p, Attributes>,
    log: CollapseLog,
    options: Options,
    stages: Vec<usize>,
}

impl Run<'_> {
    /// All stages of the run.
    fn all(&self) -> Stages<'_> {
        let limits = self.options.protect.limits;
        stages_of(&self.part.loaded.mesh, &self.log, &self.attributes, limits)
    }
}

/// Makes levels of detail of a scene. As with [`simplify_scene`](super::simplify_scene), each mesh is simplified once,
/// and all data of vertices are carried over. The levels of a mesh are stages of one run, as those of
/// [`LevelSteps`](crate::LevelSteps). With [`SceneBudget::Scene`], the collapses of all meshes are merged by their costs.
/// A single mesh gives the levels of the mesh. The target of the rules has no meaning here. Charts are merged for the
/// level with the fewest faces.
///
/// # Errors
/// A mesh cannot be read, built or simplified, or a level cannot be written into the scene.
pub fn scene_levels(
    scene: &Scene,
    steps: &SceneSteps,
    rules: &SceneRules,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<SceneLevels, SceneError> {
    let own = divided(scene, rules, !steps.faces.is_empty(), !steps.errors.is_empty())?;
    let scene = own.as_ref().unwrap_or(scene);
    let parts = parts(scene, rules)?;
    let in_units =
        |&length: &Length| rules.without_rounding(in_units(length, steps.relative, &parts)?, scene);
    let errors = steps.errors.iter().map(in_units).collect::<Result<Vec<_>, _>>()?;
    let budgets = Budgets::new(&parts, steps, rules);
    let mut runs = Vec::with_capacity(parts.len());
    let merged = if rules.keep_seams { vec![None; parts.len()] } else { budgets.merged(&parts) };
    for (part, merged) in parts.iter().zip(merged) {
        let attributes = merged.map_or(Cow::Borrowed(&part.attributes), Cow::Owned);
        runs.push(part.run(attributes, budgets.limits(part), &errors, rules, observe)?);
    }
    let missed_faces = budgets.add_stages(&mut runs)?;
    for run in &mut runs {
        let part = run.part;
        for error in &errors {
            let found = run.all().within(error / part.scale, rules.choices.check());
            run.stages.push(found.map_err(|source| part.error(source))?);
        }
        run.stages.sort_unstable();
    }
    let count = steps.ratios.len() + steps.faces.len() + errors.len();
    let (mut levels, mut all_new) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for level in 0..count {
        let (mut level, new) = level_of(scene, &runs, level)?;
        level.add_rounding(&rules.rounding(scene)?, &rules.rounding(&level.scene)?);
        levels.push(level);
        all_new.push(new);
    }
    let errors = levels.iter().map(|level: &SceneLevel| level.max);
    let coverage = shown_from(scene_diagonal(&parts).unwrap_or(f64::NAN), errors);
    let of_mesh = |(place, part): (usize, &Part)| {
        let size = part.loaded.mesh.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
        shown_from(part.scale * size, levels.iter().map(|level| level.meshes[place].max))
    };
    Ok(SceneLevels {
        coverage,
        repairs: parts.iter().map(|part| part.loaded.report.clone()).collect(),
        flat_shaded: parts.iter().filter(|part| part.attributes.is_flat_shaded()).count(),
        ignored_tangents: parts.iter().filter(|part| part.has_ignored_tangents()).count(),
        input: scene.clone(),
        meshes: parts.iter().map(|part| part.mesh).collect(),
        of_meshes: parts.iter().enumerate().map(of_mesh).collect(),
        missed_faces,
        new: all_new,
        levels,
    })
}

/// The numbers of faces of the levels.
struct Budgets {
    /// The ratio of each level, or its number of faces.
    wanted: Vec<(Option<f64>, Option<usize>)>,
    /// The number of drawn faces.
    total: usize,
    budget: SceneBudget,
    /// Whether several drawn meshes share the faces.
    are_shared: bool,
}

impl Budgets {
    fn new(parts: &[Part], steps: &SceneSteps, rules: &SceneRules) -> Self {
        let ratios = steps.ratios.iter().map(|&ratio| (Some(ratio), None));
        let faces = steps.faces.iter().map(|&faces| (None, Some(faces)));
        let drawn = || parts.iter().filter(|part| part.times > 0);
        Self {
            wanted: ratios.chain(faces).collect(),
            total: drawn().map(|part| part.times * part.faces()).sum(),
            budget: rules.budget,
            are_shared: rules.budget == SceneBudget::Scene && drawn().count() > 1,
        }
    }

    /// The drawn faces of a level.
    fn drawn(&self, (ratio, faces): (Option<f64>, Option<usize>)) -> usize {
        ratio.map_or(0, |ratio| (ratio * self.total as f64).ceil() as usize).max(faces.unwrap_or(0))
    }

    /// The share of the drawn faces that a level keeps.
    fn ratio(&self, wanted: (Option<f64>, Option<usize>)) -> f64 {
        wanted.0.unwrap_or(self.drawn(wanted) as f64 / self.total.max(1) as f64).min(1.0)
    }

    /// The number of faces of a mesh that does not share them.
    fn alone(&self, part: &Part, (ratio, faces): (Option<f64>, Option<usize>)) -> usize {
        let of_ratio = |ratio: f64| (ratio * part.faces() as f64).ceil() as usize;
        match (part.times, faces) {
            (0, Some(_)) if self.budget == SceneBudget::Scene => {
                of_ratio(self.ratio((ratio, faces)))
            }
            (_, Some(faces)) => faces / part.times_for(self.budget),
            _ => of_ratio(ratio.unwrap_or(1.0)),
        }
    }

    /// Where the run of a mesh ends.
    fn limits(&self, part: &Part) -> Target {
        let least = |wanted: &(Option<f64>, Option<usize>)| {
            if self.are_shared && part.times > 0 {
                part.least(self.ratio(*wanted))
            } else {
                self.alone(part, *wanted)
            }
        };
        Target { faces: self.wanted.iter().map(least).min(), ..Target::default() }
    }

    /// The attributes of each mesh with merged charts, if the level with the fewest faces has no room for them.
    fn merged(&self, parts: &[Part]) -> Vec<Option<Attributes>> {
        let Some(&fewest) = self.wanted.iter().min_by_key(|wanted| self.drawn(**wanted)) else {
            return vec![None; parts.len()];
        };
        let drawn: Vec<&Part> = parts.iter().filter(|part| part.times > 0).collect();
        let shared = if self.are_shared { merged(&drawn, self.drawn(fewest)) } else { Vec::new() };
        let mut shared = shared.into_iter();
        let of_part = |part: &Part| {
            if self.are_shared && part.times > 0 {
                return shared.next().flatten();
            }
            let target = Target { faces: Some(self.alone(part, fewest)), ..Target::default() };
            part.attributes.merge_charts(&part.loaded.mesh, &target)
        };
        parts.iter().map(of_part).collect()
    }

    /// Adds the stages of the levels with a number of faces. Returns the numbers that are not reached.
    fn add_stages(&self, runs: &mut [Run<'_>]) -> Result<Vec<usize>, SceneError> {
        let mut ends = Vec::with_capacity(runs.len());
        for run in runs.iter() {
            let (end, _) = run.log.level(&run.part.loaded.mesh, run.log.len())?;
            ends.push(end.topology().face_count());
        }
        let mut shared = Vec::new();
        if self.are_shared && !self.wanted.is_empty() {
            for (run, &end) in runs.iter().zip(&ends).filter(|(run, _)| run.part.times > 0) {
                let Run { part, log, options, .. } = run;
                shared.push(part.collapses(log, options.cost.metric, end));
            }
        }
        let is_missed = |&wanted: &(Option<f64>, Option<usize>), runs: &[Run<'_>]| {
            let mut drawn = runs.iter().zip(&ends).filter(|(run, _)| run.part.times > 0);
            if self.are_shared {
                drawn.map(|(run, &end)| run.part.times * end).sum::<usize>() > self.drawn(wanted)
            } else {
                drawn.any(|(run, &end)| end > self.alone(run.part, wanted))
            }
        };
        let missed = self.wanted.iter().filter(|wanted| is_missed(wanted, runs));
        let missed = missed.map(|&wanted| wanted.1.unwrap_or_else(|| self.drawn(wanted))).collect();
        for &wanted in &self.wanted {
            let drawn = runs.iter().filter(|run| run.part.times > 0);
            for (collapses, run) in shared.iter_mut().zip(drawn) {
                collapses.least = run.part.least(self.ratio(wanted));
            }
            let mut counts = split(&shared, self.drawn(wanted)).into_iter();
            for run in runs.iter_mut() {
                let own = if run.part.times > 0 { counts.next() } else { None };
                let faces = own.unwrap_or_else(|| self.alone(run.part, wanted));
                run.stages.push(run.log.count_for_faces(faces));
            }
        }
        Ok(missed)
    }
}

impl Part {
    /// The run whose stages are the levels.
    fn run<'p>(
        &'p self,
        attributes: Cow<'p, Attributes>,
        limits: Target,
        errors: &[f64],
        rules: &SceneRules,
        observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Run<'p>, SceneError> {
        let mesh = &self.loaded.mesh;
        let mut options = rules.choices.options(mesh, limits).for_levels();
        self.constrain(&attributes, &mut options);
        if let Some(error) = errors.iter().copied().reduce(f64::max) {
            options = options.within(error / self.scale, rules.choices.check());
            // With decimation to the tolerance, the result would not be a stage of the run.
            options.tolerance.decimate = false;
        }
        let run =
            simplify_observed(mesh, &options, observe).map_err(|source| self.error(source))?;
        Ok(Run { part: self, attributes, log: run.log, options, stages: Vec::new() })
    }
}

/// A level, and its new meshes.
fn level_of(
    scene: &Scene,
    runs: &[Run<'_>],
    level: usize,
) -> Result<(SceneLevel, Vec<NewMesh>), SceneError> {
    let area = |part: &Part| part.times as f64 * part.scale.powi(2) * part.loaded.mesh.area();
    let whole: f64 = runs.iter().map(|run| area(run.part)).sum();
    let (mut new, mut meshes, mut all) = (Vec::new(), Vec::new(), Sums::default());
    for run in runs {
        let Run { part, attributes, stages, .. } = run;
        let collapses = stages.get(level).copied().unwrap_or(0);
        let level = run.all().level(collapses);
        let (mesh, became) = level.map_err(|source| part.error(source))?;
        let replaced = part.replacement(attributes, &mesh, &became)?;
        let share = if whole > 0.0 { area(part) / whole } else { 0.0 };
        let samples = ((share * SAMPLES as f64) as usize).max(FEWEST_SAMPLES);
        let sampling = CompareOptions { samples, ..CompareOptions::default() };
        let distance = compare(&Surface::new(&part.loaded.mesh)?, &Surface::new(&mesh)?, &sampling);
        all.add(part, mesh.area(), &distance);
        let removed = replaced.primitives.iter().filter(|p| p.triangles.is_empty());
        meshes.push(MeshOfLevel {
            mesh: part.mesh,
            name: part.name.clone(),
            times: part.times,
            faces: [part.faces(), mesh.topology().face_count()],
            vertices: mesh.topology().vertex_count(),
            collapses,
            charts: attributes.merged(),
            mean: part.scale * distance.mean(),
            rms: part.scale * distance.rms(),
            max: part.scale * distance.hausdorff(),
            removed: removed.map(|primitive| primitive.index).collect(),
        });
        new.push(replaced);
    }
    let (scene, lost) = scene.replaced(&new)?;
    let [mean, rms, max] = all.distances();
    Ok((SceneLevel { scene, meshes, mean, rms, max, lost }, new))
}

/// The fewest samples of a mesh.
const FEWEST_SAMPLES: usize = 500;

/// Distances summed over the drawn surfaces, in both directions.
#[derive(Default)]
struct Sums {
    areas: [f64; 2],
    means: [f64; 2],
    squares: [f64; 2],
    max: Option<f64>,
}

impl Sums {
    fn add(&mut self, part: &Part, area: f64, distance: &Comparison) {
        if part.times == 0 {
            return;
        }
        let drawn = part.times as f64 * part.scale.powi(2);
        let sides = [distance.forward, distance.backward];
        for (i, (area, side)) in [part.loaded.mesh.area(), area].into_iter().zip(sides).enumerate()
        {
            self.areas[i] += drawn * area;
            self.means[i] += drawn * area * part.scale * side.mean;
            self.squares[i] += drawn * area * (part.scale * side.rms).powi(2);
        }
        let max = part.scale * distance.hausdorff();
        self.max = Some(self.max.map_or(max, |other| other.max(max)));
    }

    /// The mean, the root mean square and the largest distance.
    fn distances(&self) -> [f64; 3] {
        let over = |sums: [f64; 2]| 0.5 * (sums[0] / self.areas[0] + sums[1] / self.areas[1]);
        [over(self.means), over(self.squares).sqrt(), self.max.unwrap_or(f64::NAN)]
    }
}
