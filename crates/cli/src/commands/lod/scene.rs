//! `curvmesh lod` of a scene: levels of each mesh, and everything else as it is.

use mesh_io::Format;
use mesh_work::{
    MeshOfLevel, SceneLevel, SceneLevels, SceneRules, SceneSteps, mesh_title, scene_levels,
};
use serde::Serialize;
use simplify::{Options, Target};

use crate::args::is_standard;
use crate::commands::lod::options::Lod;
use crate::commands::lod::place::Place;
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::large::is_folder;
use crate::load::Seconds;
use crate::save::{Outputs, make_folder_of, save_scene};
use crate::scene::{tell_charts, tell_lost, tell_repairs};
use crate::session::{Outcome, Session};
use crate::simplify_options::{settings, show};
use crate::task::{Report, Source, copy_pictures};
use crate::text::printable;

/// Further options that need one mesh.
const NEEDING_ONE: [&str; 2] = ["record", "replay"];

#[derive(Serialize)]
struct Results {
    preset: String,
    /// The settings of every mesh, without its target.
    settings: Options,
    /// The share of the height of the screen down to which the input is shown.
    shown_from: f64,
    /// The wanted numbers of drawn faces that no level reaches.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    missed_faces: Vec<usize>,
    levels: Vec<Level>,
}

/// A level, and its distance from the input: the mean and the root mean square over the drawn surfaces in both
/// directions, and the largest of all samples.
#[derive(Serialize)]
struct Level {
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<String>,
    /// The numbers of drawn faces and vertices.
    faces: usize,
    vertices: usize,
    /// Null if nothing is drawn.
    mean: Option<f64>,
    rms: Option<f64>,
    max: Option<f64>,
    /// The share of the height of the screen down to which it is shown.
    shown_from: f64,
    meshes: Vec<OfMesh>,
}

/// A mesh in a level. Errors are in units of the scene, where the mesh is drawn largest.
#[derive(Serialize)]
struct OfMesh {
    mesh: usize,
    name: Option<String>,
    times: usize,
    faces: usize,
    vertices: usize,
    collapses: usize,
    /// The numbers of charts before and after; null if none were merged.
    charts: Option<[usize; 2]>,
    mean: f64,
    rms: f64,
    max: f64,
}

/// Whether the levels are scenes.
pub(super) fn is_kept(options: &Lod, session: &Session) -> Result<bool, Failure> {
    let Lod { source, output, steps, save, scenes, .. } = options;
    let Source { input, loading } = source;
    let own = if is_standard(input) { None } else { Format::from_extension(input) };
    let count = steps.or_quiet_default(None).count();
    let written = if is_folder(output, save, count) {
        save.format_of(output).or(own)
    } else {
        save.format_of(output)
    };
    let at = (&session.given, &session.console);
    scenes.merging.keeps_scene(input, written, loading, &NEEDING_ONE, at)
}

pub(super) fn run(options: &Lod, session: &Session) -> Result<Outcome, Failure> {
    // Checks the outputs before anything is read.
    Place::new(options, options.steps.or_quiet_default(None).count(), &session.given)?;
    let console = &*session.console.beside(Some(&options.output))?;
    let mut seconds = Seconds::default();
    let Source { input, loading } = &options.source;
    let scene = Seconds::time(&mut seconds.load, || loading.scene(input, console))?;
    let counts = scene.counts().map(|count| count as usize);
    let steps = options.steps.or_default(Some(counts[1]), console);
    let place = Place::new(options, steps.count(), &session.given)?;
    let choices = options.policy.choices();
    let rules = SceneRules {
        choices,
        attributes: options.carry.rules(),
        keep_seams: options.keep_seams,
        quantization: options.save.quantization(),
        ..options.scenes.rules(loading)
    };
    let steps: SceneSteps = steps.of_scene(loading.relative);
    let bar = console.progress(counts[1] as u64, "collapsing");
    let made = Seconds::time(&mut seconds.compute, || {
        scene_levels(&scene, &steps, &rules, &mut |now| show(&bar, now))
    });
    bar.finish_and_clear();
    let failed = |error| Failure::scene(input, Some(&options.output), error);
    let made = made.map_err(failed)?;
    if made.levels.first().is_none_or(|level| level.meshes.is_empty()) && !loading.allows_empty() {
        return Err(Failure::no_mesh_left(input, counts[1]));
    }
    let name = printable(input.display());
    tell(&name, &made, console);
    let mut levels: Vec<Level> =
        made.levels.iter().zip(&made.coverage[1..]).map(Level::new).collect();
    Seconds::time(&mut seconds.save, || -> Result<(), Failure> {
        let all;
        let mut outputs = Outputs::default();
        match &place {
            Place::Together(path) => {
                let (together, _) = made.together().map_err(|error| Failure::write(path, error))?;
                all = together;
                outputs.add_scene(path, &all, &options.save);
            }
            Place::Apart(paths) => {
                for ((path, made), level) in paths.iter().zip(&made.levels).zip(&mut levels) {
                    if is_standard(path) {
                        save_scene(path, &made.scene, &options.save, console)?;
                    } else {
                        make_folder_of(path)?;
                        outputs.add_scene(path, &made.scene, &options.save);
                    }
                    level.output = Some(path.display().to_string());
                }
            }
        }
        outputs.write(console)?;
        if let Some(path) = place.first() {
            copy_pictures(input, path, &options.save, &scene.file_pictures(), console);
        }
        Ok(())
    })?;
    let results = Results {
        preset: options.policy.preset.to_string(),
        settings: settings(&choices.options_without_features(Target::default()).for_levels()),
        shown_from: made.coverage.first().copied().unwrap_or(0.0),
        missed_faces: made.missed_faces.clone(),
        levels,
    };
    let report = Report::new(console, input, counts, results, seconds).with_output(&options.output);
    report.done(console, summary(&report), String::new())?.print(console)?;
    Ok(Outcome::of_run())
}

/// Reports repairs and losses.
fn tell(name: &str, made: &SceneLevels, console: &Console) {
    tell_repairs(name, made.repairs.iter(), console);
    let coarsest = made.levels.last().map_or(&[][..], |level| &level.meshes);
    for mesh in coarsest {
        if let Some(charts) = mesh.charts {
            tell_charts(&mesh_title(mesh.name.as_deref(), mesh.mesh), charts, console);
        }
    }
    if !made.missed_faces.is_empty() {
        let wanted: Vec<String> = made.missed_faces.iter().map(usize::to_string).collect();
        let left: usize = coarsest.iter().map(|mesh| mesh.times * mesh.faces[1]).sum();
        console.message(format_args!(
            "{name}: levels of {} faces were not reached, {left} left (every further collapse would fold a mesh, change its topology or cross what is protected)",
            wanted.join(", ")
        ));
    }
    tell_lost(name, &made.losses(), console);
}

impl Level {
    fn new((level, &shown_from): (&SceneLevel, &f64)) -> Self {
        let [vertices, faces] = level.scene.counts().map(|count| count as usize);
        let known = |value: f64| (!value.is_nan()).then_some(value);
        Self {
            output: None,
            faces,
            vertices,
            mean: known(level.mean),
            rms: known(level.rms),
            max: known(level.max),
            shown_from,
            meshes: level.meshes.iter().map(OfMesh::new).collect(),
        }
    }
}

impl OfMesh {
    fn new(mesh: &MeshOfLevel) -> Self {
        Self {
            mesh: mesh.mesh,
            name: mesh.name.clone(),
            times: mesh.times,
            faces: mesh.faces[1],
            vertices: mesh.vertices,
            collapses: mesh.collapses,
            charts: mesh.charts,
            mean: mesh.mean,
            rms: mesh.rms,
            max: mesh.max,
        }
    }
}

fn summary(report: &Report<Results>) -> String {
    let mut text = format!("{}: {}", report.subject(), counted(report.faces, "faces"));
    for level in &report.results.levels {
        let Level { faces, meshes, mean, max, shown_from, .. } = level;
        text += &format!("\n  {} in {}", counted(*faces, "faces"), counted(meshes.len(), "meshes"));
        if let (Some(mean), Some(max)) = (mean, max) {
            text += &format!(": mean distance {mean:.6e}, maximum {max:.6e}");
        }
        text += &format!(", shown down to {:.1} % of the screen", 100.0 * shown_from);
        if let Some(output) = &level.output {
            text += &format!("  {}", printable(output));
        }
    }
    text
}
