//! `curvmesh simplify` of a scene: each mesh once, and everything else as it is.

use mesh_work::{
    Choices, DeformedError, MeshOfScene, SceneRules, SimplifiedScene, mesh_title, simplify_scene,
};
use serde::Serialize;
use simplify::{AchievedError, Options, Target};

use crate::commands::simplify::options::Simplify;
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::given::Given;
use crate::load::Seconds;
use crate::scene::{tell_charts, tell_lost, tell_repairs};
use crate::simplify_options::{reasons, settings, show};
use crate::task::{Done, Report, Task};
use crate::text::printable;

/// Further options that need one mesh.
const NEEDING_ONE: [&str; 4] = ["vertices", "bytes", "max_cost", "time_limit"];

#[derive(Serialize)]
struct Results {
    preset: String,
    /// The settings of every mesh, without its target.
    settings: Options,
    /// The numbers of faces that are drawn.
    faces_in: usize,
    faces_out: usize,
    /// The number of drawn faces that the meshes share, if more are left.
    #[serde(skip_serializing_if = "Option::is_none")]
    wanted_faces: Option<usize>,
    meshes: Vec<OfMesh>,
}

/// A mesh of the scene. Errors are in units of the scene, where the mesh is drawn largest.
#[derive(Serialize)]
struct OfMesh {
    mesh: usize,
    name: Option<String>,
    /// The number of times that it is drawn.
    times: usize,
    scale: f64,
    faces_in: usize,
    faces_out: usize,
    vertices_out: usize,
    rms: f64,
    max: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<AchievedError>,
    stop: &'static str,
    /// The number of faces that was wanted and not reached.
    #[serde(skip_serializing_if = "Option::is_none")]
    wanted_faces: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    charts: Option<[usize; 2]>,
    /// The errors in other poses, if the mesh deforms.
    #[serde(skip_serializing_if = "Option::is_none")]
    poses: Option<OfPoses>,
    /// The bound of the rounding by --quantize, which all errors include.
    #[serde(skip_serializing_if = "Option::is_none")]
    rounding: Option<f64>,
}

#[derive(Serialize)]
struct OfPoses {
    count: usize,
    rms: f64,
    max: f64,
}

/// Whether the task is a scene that stays one.
pub(super) fn is_kept(
    options: &Simplify,
    task: &Task,
    given: &Given,
    console: &Console,
) -> Result<bool, Failure> {
    let job = &options.job;
    if options.large.is_needed(&task.input, &job.loading)? {
        return Ok(false);
    }
    let merging = options.scenes.merging;
    let written = task.written(&job.save);
    merging.keeps_scene(&task.input, written, &job.loading, &NEEDING_ONE, (given, console))
}

pub(super) fn one(options: &Simplify, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let loading = &options.job.loading;
    let scene = Seconds::time(&mut seconds.load, || loading.scene(&task.input, console))?;
    let choices = options.policy.choices();
    let rules = SceneRules {
        target: options.targets.of_scene(loading.relative),
        choices,
        attributes: options.carry.rules(),
        keep_seams: options.keep_seams,
        quantization: options.job.save.quantization(),
        ..options.scenes.rules(loading)
    };
    let bar = console.progress(scene.counts()[1], "collapsing");
    let made = Seconds::time(&mut seconds.compute, || {
        simplify_scene(&scene, &rules, &mut |now| show(&bar, now))
    });
    bar.finish_and_clear();
    let failed = |error| Failure::scene(&task.input, task.output.as_deref(), error);
    let made = made.map_err(failed)?;
    if made.meshes.is_empty() && !loading.allows_empty() {
        return Err(Failure::no_mesh_left(&task.input, scene.counts()[1] as usize));
    }
    tell(&made, task, console);
    task.save_scene(&made.scene, &options.job.save, &mut seconds, console)?;
    let results = Results::new(options, &choices, &made);
    let counts = scene.counts().map(|count| count as usize);
    let report = task.report(console, counts, results, seconds);
    let brief =
        format!("{} -> {}", report.results.faces_in, counted(report.results.faces_out, "faces"));
    report.done(console, summary(&report), brief)
}

/// Reports repairs, unreached targets and losses.
fn tell(made: &SimplifiedScene, task: &Task, console: &Console) {
    let name = printable(task.input.display());
    tell_repairs(&name, made.meshes.iter().map(|mesh| &mesh.repairs), console);
    for mesh in &made.meshes {
        let title = mesh_title(mesh.name.as_deref(), mesh.mesh);
        if let Some(charts) = mesh.charts {
            tell_charts(&title, charts, console);
        }
        if let Some(shortfall) = &mesh.shortfall {
            let reasons = match reasons(shortfall).as_slice() {
                [] => String::new(),
                reasons => format!(" ({})", reasons.join("; ")),
            };
            console.message(format_args!(
                "{title}: the target of {} was not reached, {} left{reasons}",
                counted(shortfall.wanted_faces.unwrap_or_default(), "faces"),
                counted(mesh.faces[1], "faces")
            ));
        }
    }
    if let Some(wanted) = made.missed_faces {
        let left: usize = made.meshes.iter().map(|mesh| mesh.times * mesh.faces[1]).sum();
        console.message(format_args!(
            "{name}: the target of {} was not reached, {left} left (every further collapse would fold a mesh or change its topology)",
            counted(wanted, "faces")
        ));
    }
    tell_lost(&name, &made.losses(), console);
}

impl Results {
    fn new(options: &Simplify, choices: &Choices, made: &SimplifiedScene) -> Self {
        let meshes = &made.meshes;
        let drawn = |after: usize| meshes.iter().map(|mesh| mesh.times * mesh.faces[after]).sum();
        Self {
            preset: options.policy.preset.to_string(),
            settings: settings(&choices.options_without_features(Target::default())),
            faces_in: drawn(0),
            faces_out: drawn(1),
            wanted_faces: made.missed_faces,
            meshes: meshes.iter().map(OfMesh::from).collect(),
        }
    }
}

impl From<&MeshOfScene> for OfMesh {
    fn from(mesh: &MeshOfScene) -> Self {
        Self {
            mesh: mesh.mesh,
            name: mesh.name.clone(),
            times: mesh.times,
            scale: mesh.scale,
            faces_in: mesh.faces[0],
            faces_out: mesh.faces[1],
            vertices_out: mesh.vertices[1],
            rms: mesh.rms,
            max: mesh.max,
            error: mesh.bound,
            stop: mesh.stop.name(),
            wanted_faces: mesh.shortfall.as_ref().and_then(|shortfall| shortfall.wanted_faces),
            charts: mesh.charts,
            poses: mesh.deformed.map(|DeformedError { poses, rms, max }| OfPoses {
                count: poses,
                rms,
                max,
            }),
            rounding: (mesh.rounding > 0.0).then_some(mesh.rounding),
        }
    }
}

/// More meshes than this are only counted.
const MOST_LINES: usize = 20;

fn summary(report: &Report<Results>) -> String {
    let found = &report.results;
    let mut text = format!(
        "{}: {} -> {} in {}, {:.3} s",
        report.subject(),
        found.faces_in,
        counted(found.faces_out, "faces"),
        counted(found.meshes.len(), "meshes"),
        report.seconds.compute
    );
    for mesh in found.meshes.iter().take(MOST_LINES) {
        let title = mesh_title(mesh.name.as_deref(), mesh.mesh);
        let OfMesh { times, faces_in, faces_out, rms, max, .. } = mesh;
        let drawn = if *times == 1 { String::new() } else { format!("drawn {times} times, ") };
        text += &format!(
            "\n  {title}: {drawn}{faces_in} -> {}, distance {rms:.3e} (rms), {max:.3e} (largest)",
            counted(*faces_out, "faces")
        );
        if let Some(OfPoses { count, rms, max }) = &mesh.poses {
            text += &format!(
                ", in {} {rms:.3e} (rms), {max:.3e} (largest)",
                counted(*count, "other poses")
            );
        }
        if let Some(AchievedError { lower, upper: Some(upper) }) = mesh.error {
            text += &format!(", proved between {lower:.6e} and {upper:.6e}");
        }
    }
    let rounding = found.meshes.iter().filter_map(|mesh| mesh.rounding).fold(0.0, f64::max);
    if rounding > 0.0 {
        text += &format!("\n  distances include up to {rounding:.3e} for rounding");
    }
    if found.meshes.len() > MOST_LINES {
        text += &format!("\n  and {} more", found.meshes.len() - MOST_LINES);
    }
    text
}
