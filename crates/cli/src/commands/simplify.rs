//! `curvmesh simplify`: edge collapse to fewer faces.

use std::collections::BTreeMap;

use mesh_core::TriMesh;
use mesh_io::Model;
use mesh_metric::Surface;
use mesh_view::Page;
use mesh_work::{Attributes, Loaded};
use out_of_core::ResultMesh;
use serde::Serialize;
use simplify::{FitReport, Options, Simplified, simplify_observed};

use crate::batch::{Job, check_output};
use crate::carry::{Carry, OF_ATTRIBUTES, ONLY_SHAPES};
use crate::console::Console;
use crate::failure::Failure;
use crate::given::Given;
use crate::interrupt::Interruption;
use crate::large::{self, Large, Passes};
use crate::load::{Loading, Seconds};
use crate::save::make_folder_of;
use crate::session::{Outcome, Session};
use crate::simplify_options::{Policy, Targets, rejected, settings, show};
use crate::task::{Done, Report, Task};
use crate::view::{self, Look, name_of};

/// Simplify a mesh by collapsing edges
///
/// The first target that is reached ends the run, and the report names it. Without a target, half of
/// the faces stay.
///
///     curvmesh simplify scan.ply -o half.ply
///     curvmesh simplify scan.ply -o small.ply --faces 3000
///     curvmesh simplify part.stl -o part.obj --max-error 0.2% --verify
///     curvmesh simplify truck.glb -o truck-30.glb --ratio 0.3 --preset quality
///     curvmesh simplify a.stl b.stl scans/ -o small/ --ratio 0.1 --resume
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment, mut_arg("output", |output| output.required(true)))]
pub(crate) struct Simplify {
    #[command(flatten)]
    targets: Targets,
    #[command(flatten)]
    policy: Policy,
    #[command(flatten)]
    carry: Carry,
    /// Keep all borders of texture charts, materials, groups and labels, even if the shape suffers. By default, the
    /// smallest charts are merged with their neighbours if the borders need more than a fifth of the wanted faces
    #[arg(long, help_heading = "Attributes", conflicts_with = "no_attributes")]
    keep_seams: bool,
    #[command(flatten)]
    interruption: Interruption,
    #[command(flatten)]
    look: Look,
    #[command(flatten)]
    large: Large,
    #[command(flatten)]
    job: Job,
}

#[derive(Default, Serialize)]
struct Results {
    preset: String,
    /// All settings, with those of the preset.
    settings: Options,
    faces_in: usize,
    faces_out: usize,
    /// Absent if the result is larger than memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    vertices_out: Option<usize>,
    stop: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    max_cost: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    collapses: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rejected: Option<BTreeMap<&'static str, usize>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<Achieved>,
    #[serde(skip_serializing_if = "Option::is_none")]
    boundary_shift: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fit: Option<Fit>,
    /// Absent if no charts were merged.
    #[serde(skip_serializing_if = "Option::is_none")]
    charts: Option<Charts>,
    #[serde(skip_serializing_if = "Option::is_none")]
    passes: Option<Passes>,
}

/// The distance from the original: at least `lower`, and at most `upper` if it was proved.
#[derive(Serialize)]
struct Achieved {
    lower: f64,
    upper: Option<f64>,
}

/// The number of charts between seams, before and after some were merged.
#[derive(Clone, Copy, Serialize)]
struct Charts {
    before: usize,
    after: usize,
}

#[derive(Serialize)]
struct Fit {
    norm: &'static str,
    rounds: usize,
    flips: usize,
    rms_before: f64,
    rms_last: f64,
}

impl From<&FitReport> for Fit {
    fn from(fit: &FitReport) -> Self {
        let FitReport { norm, rounds, flips, rms_before, rms_last, .. } = *fit;
        Self { norm: norm.name(), rounds, flips, rms_before, rms_last }
    }
}

pub(crate) fn run(options: &Simplify, session: &Session) -> Result<Outcome, Failure> {
    options.targets.explain(&session.console);
    options.policy.check_given(&session.given)?;
    check_output(&options.job, &session.given)?;
    options.look.check(&options.job.inputs)?;
    options.job.run(session, &|task, console| one(options, task, &session.given, console))
}

fn one(options: &Simplify, task: &Task, given: &Given, console: &Console) -> Result<Done, Failure> {
    if options.large.is_needed(&task.input, &options.job.loading)? {
        given.refuse(&OF_ATTRIBUTES, ONLY_SHAPES)?;
        given.refuse(&["keep_seams"], ONLY_SHAPES)?;
        return in_regions(options, task, console);
    }
    let mut seconds = Seconds::default();
    let loaded = task.load(&options.job.loading, &mut seconds, console)?;
    let mut attributes = options.carry.find(&loaded, console)?;
    let (simplified, settings, charts) = Seconds::time(&mut seconds.compute, || {
        reduce(&loaded.mesh, options, &mut attributes, console)
    })?;
    let model = attributes
        .carry(loaded.source(), &simplified.mesh, &simplified.vertex_map)
        .map_err(Failure::model)?;
    task.save(&model, &options.job.save, &mut seconds, console)?;
    let faces_in = loaded.mesh.topology().face_count();
    let results = Results { charts, ..Results::new(options, settings, faces_in, &simplified) };
    let report = task.report(console, loaded.counts(), results, seconds);
    if options.look.is_wanted() {
        let page = page(task, &options.job.loading, &loaded, &simplified.mesh, &model)?;
        options.look.write(page, &report, console)?;
    }
    let brief = format!("{} -> {} faces", report.results.faces_in, report.results.faces_out);
    report.done(console, summary_of(&report), brief)
}

/// Simplifies a mesh that exceeds the memory limit.
fn in_regions(options: &Simplify, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    if options.look.is_wanted() {
        return Err(Failure::usage("--view shows the whole mesh, which --memory does not allow"));
    }
    let limits = options.targets.regional_limits()?;
    let chosen = options.policy.regional_options(limits)?;
    let Job { loading, many, .. } = &options.job;
    let (large, memory) = (&options.large, options.large.memory.unwrap_or(u64::MAX));
    let prove = options.policy.proves().then_some(large::PROVED);
    let in_force = settings(&chosen);
    let settings = large::settings(chosen, Vec::new(), memory, &loading.repair, prove)?;
    let Some(output) = &task.output else {
        return Err(Failure::usage("say where the result goes: -o OUT"));
    };
    let takes_regions = large::takes_regions(output, &options.job.save);
    let (outcome, work) = Seconds::time(&mut seconds.compute, || {
        let folder = large::Folder { path: large.folder(output), resume: many.resume };
        large::simplify_file(&task.input, large, &folder, loading, settings, takes_regions, console)
    })?;
    let passes = Passes::of(&outcome);
    let summary = &work.manifest().summary;
    let vertices_out = match &outcome.result {
        ResultMesh::InMemory(mesh) => {
            let topology = mesh.topology();
            Some(topology.vertices().filter(|&v| !topology.is_isolated_vertex(v)).count())
        }
        ResultMesh::OnDisk { .. } => None,
    };
    let results = Results {
        preset: options.policy.preset.to_string(),
        settings: in_force,
        faces_in: summary.triangles as usize,
        faces_out: outcome.faces as usize,
        vertices_out,
        stop: outcome.stop.name(),
        error: outcome.error.map(|upper| Achieved { lower: 0.0, upper: Some(upper) }),
        passes: Some(passes),
        ..Results::default()
    };
    let counts = [summary.vertices as usize, summary.triangles as usize];
    Seconds::time(&mut seconds.save, || {
        if task.makes_folder {
            make_folder_of(output)?;
        }
        large::save_left(outcome.result, &work, output, &options.job.save, console)
    })?;
    large::remove(work, large);
    let report = task.report(console, counts, results, seconds);
    let brief = format!("{} -> {} faces", report.results.faces_in, report.results.faces_out);
    report.done(console, summary_of(&report), brief)
}

/// The original and the result, each with its distance from the other.
fn page(
    task: &Task,
    loading: &Loading,
    loaded: &Loaded,
    result: &TriMesh,
    model: &Model,
) -> Result<Page, Failure> {
    let original = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
    let surface = |mesh: &TriMesh| Surface::new(mesh).map_err(Failure::refused);
    let mut exhibits = Vec::new();
    for (name, model, other) in [("original", &original, result), ("result", model, &loaded.mesh)] {
        let mut exhibit = view::content(name, &task.input, model, loading)?;
        let distance = view::distance_field(&exhibit, &surface(other)?);
        exhibit.fields.retain(|field| field.name != distance.name);
        exhibit.fields.insert(0, distance);
        exhibits.push(exhibit);
    }
    let mut page = Page::new(format!("{}: simplified", name_of(&task.input)), exhibits);
    page.start.color = Some("vertex:distance".into());
    Ok(page)
}

fn reduce(
    mesh: &TriMesh,
    options: &Simplify,
    attributes: &mut Attributes,
    console: &Console,
) -> Result<(Simplified, Options, Option<Charts>), Failure> {
    let goals = options.targets.goals(mesh, options.job.loading.relative)?;
    let mut chosen = options.policy.options(mesh, goals.limits);
    let merged = (!options.keep_seams).then(|| attributes.merge_charts(mesh, &chosen.target));
    let charts = merged.flatten().map(|[before, after]| Charts { before, after });
    if let Some(Charts { before, after }) = charts {
        console.message(format_args!(
            "charts of textures, materials and labels: {before} -> {after}; the borders of all would need more than a \
             fifth of the wanted faces (--keep-seams keeps them, --no-attributes leaves them out)"
        ));
    }
    attributes.constrain(mesh, &mut chosen);
    chosen.record = false;
    if let Some(error) = goals.max_error {
        chosen = chosen.within(error, options.policy.check());
    }
    let bar = console.progress(mesh.topology().face_count() as u64, "collapsing");
    let result = simplify_observed(mesh, &chosen, &mut |now| show(&bar, now));
    bar.finish_and_clear();
    result.map(|result| (result, settings(&chosen), charts)).map_err(Failure::simplify)
}

impl Results {
    fn new(options: &Simplify, settings: Options, faces_in: usize, result: &Simplified) -> Self {
        let topology = result.mesh.topology();
        let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
        Self {
            preset: options.policy.preset.to_string(),
            settings,
            faces_in,
            faces_out: topology.face_count(),
            vertices_out: Some(used.count()),
            stop: result.stop.name(),
            max_cost: Some(result.max_cost),
            collapses: Some(result.collapses),
            rejected: Some(rejected(&result.rejections)),
            error: result.error.map(|e| Achieved { lower: e.lower, upper: e.upper }),
            boundary_shift: result.boundary_shift,
            fit: result.fit.as_ref().map(Fit::from),
            charts: None,
            passes: None,
        }
    }
}

fn summary_of(report: &Report<Results>) -> String {
    let found = &report.results;
    let mut text = format!(
        "{}: {} -> {} faces,{} in {:.3} s (stopped: {})",
        report.subject(),
        found.faces_in,
        found.faces_out,
        found.vertices_out.map(|count| format!(" {count} vertices,")).unwrap_or_default(),
        report.seconds.compute,
        found.stop.replace('_', " ")
    );
    match found.error {
        Some(Achieved { lower, upper: Some(upper) }) => {
            text += &format!("\n  distance from the original: between {lower:.6e} and {upper:.6e}");
        }
        Some(Achieved { lower, upper: None }) => {
            text += &format!("\n  largest distance met between samples: {lower:.6e}");
        }
        None => {}
    }
    if let Some(shift) = found.boundary_shift {
        text += &format!("\n  boundary vertices are up to {shift:.6e} from the new boundary");
    }
    text
}
