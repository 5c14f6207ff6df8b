//! `curvmesh simplify` of one mesh: edge collapse to fewer faces.

use std::collections::BTreeMap;

use mesh_core::TriMesh;
use mesh_io::Model;
use mesh_metric::Surface;
use mesh_view::Page;
use mesh_work::{Attributes, Largest, Loaded, Sized, file_size, largest_within};
use out_of_core::ResultMesh;
use serde::Serialize;
use simplify::{FitReport, Preset, Simplified, UnfoldReport, simplify_observed};

use crate::batch::Job;
use crate::carry::{OF_ATTRIBUTES, ONLY_SHAPES};
use crate::commands::simplify::options::Simplify;
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::given::Given;
use crate::large::{self, Passes, RegionSettings};
use crate::load::{Loading, Seconds, tell_crowded_mesh, tell_unused};
use crate::save::make_folder_of;
use crate::simplify_options::{
    Charts, Settings, Unreached, rejected, show, tell_kept, tell_shortfall, tell_turned_over,
};
use crate::task::{Done, Report, Task};
use crate::text::printable;
use crate::view::{self, name_of};

/// The size of the written file.
#[derive(Serialize)]
struct FileSize {
    limit: u64,
    bytes: u64,
    fits: bool,
    /// The number of runs.
    trials: usize,
}

/// The settings of a run in memory, or region by region.
#[derive(Serialize)]
#[serde(untagged)]
enum InForce {
    InMemory { settings: Settings },
    InRegions(RegionSettings),
}

#[derive(Serialize)]
struct Results {
    preset: String,
    /// All settings, with the preset expanded.
    #[serde(flatten)]
    in_force: InForce,
    faces_in: usize,
    faces_out: usize,
    /// Absent if the result is larger than memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    vertices_out: Option<usize>,
    stop: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    unreached: Option<Unreached>,
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<FileSize>,
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
    /// The cheaper preset whose result was closer; absent if none was.
    #[serde(skip_serializing_if = "Option::is_none")]
    preset_kept: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fit: Option<Fit>,
    #[serde(skip_serializing_if = "Option::is_none")]
    turned_over: Option<TurnedOver>,
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

/// Faces that refinement turned over, before and after they were turned back.
#[derive(Serialize)]
struct TurnedOver {
    found: usize,
    left: usize,
}

impl From<UnfoldReport> for TurnedOver {
    fn from(report: UnfoldReport) -> Self {
        Self { found: report.turned_before, left: report.turned_after }
    }
}

pub(crate) fn one(
    options: &Simplify,
    task: &Task,
    given: &Given,
    console: &Console,
) -> Result<Done, Failure> {
    if options.large.is_needed(&task.input, &options.job.loading)? {
        given.refuse(&OF_ATTRIBUTES, ONLY_SHAPES)?;
        given.refuse(&["keep_seams"], ONLY_SHAPES)?;
        return in_regions(options, task, console);
    }
    let mut seconds = Seconds::default();
    let loaded = task.load(&options.job.loading, &mut seconds, console)?;
    tell_unused(&task.input, &loaded, console);
    if options.policy.forbids_intersections() || options.targets.limits_error() {
        tell_crowded_mesh(&task.input, &loaded.mesh, console);
    }
    let attributes = options.carry.find(&loaded, console)?;
    let name = printable(task.input.display());
    let made = Seconds::time(&mut seconds.compute, || {
        let make = |faces| reduce(&name, &loaded, options, &attributes, faces, console);
        match options.targets.bytes {
            Some(limit) => make_within(limit, task, options, &loaded, make, console),
            None => make(None).map(|made| (made, None)),
        }
    });
    let (Made { simplified, settings, model, charts }, size) = made?;
    if let Some(charts) = charts {
        charts.tell(console);
    }
    if let Some(shortfall) = &simplified.shortfall {
        tell_shortfall(shortfall, simplified.mesh.topology(), console);
    }
    tell_turned_over(&simplified, console);
    task.save(&model, &options.job.save, &mut seconds, console)?;
    let faces_in = loaded.mesh.topology().face_count();
    let results =
        Results { size, charts, ..Results::new(options, settings, faces_in, &simplified) };
    let report = task.report(console, loaded.counts(), results, seconds);
    if options.look.is_wanted() {
        let page = page(task, &options.job.loading, &loaded, &simplified.mesh, &model)?;
        options.look.write(page, &report, console)?;
    }
    let brief =
        format!("{} -> {}", report.results.faces_in, counted(report.results.faces_out, "faces"));
    report.done(console, summary_of(&report), brief)
}

/// Simplifies a mesh that exceeds the memory limit.
fn in_regions(options: &Simplify, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    if options.look.is_wanted() {
        return Err(Failure::usage("--view shows the whole mesh, which --memory does not allow"));
    }
    options.constraining.check_regional()?;
    let limits = options.targets.regional_limits()?;
    let chosen = options.policy.regional_options(limits)?;
    let Job { loading, many, .. } = &options.job;
    let (large, memory) = (&options.large, options.large.memory.unwrap_or(u64::MAX));
    let prove = options.policy.proves().then_some(large::PROVED);
    let settings = large::settings(chosen, Vec::new(), memory, &loading.repair, prove)?;
    let in_force = InForce::InRegions(RegionSettings::of(&settings));
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
        in_force,
        faces_in: summary.triangles as usize,
        faces_out: outcome.faces as usize,
        vertices_out,
        stop: outcome.stop.name(),
        error: outcome.error.map(|upper| Achieved { lower: 0.0, upper: Some(upper) }),
        passes: Some(passes),
        unreached: None,
        charts: None,
        size: None,
        max_cost: None,
        collapses: None,
        rejected: None,
        boundary_shift: None,
        preset_kept: None,
        fit: None,
        turned_over: None,
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
    let brief =
        format!("{} -> {}", report.results.faces_in, counted(report.results.faces_out, "faces"));
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
        view::add_distances(&mut exhibit, &surface(other)?).map_err(Failure::refused)?;
        exhibits.push(exhibit);
    }
    let mut page = Page::new(format!("{}: simplified", name_of(&task.input)), exhibits);
    page.start.color = Some("vertex:distance".into());
    Ok(page)
}

/// A simplified mesh.
struct Made {
    simplified: Simplified,
    settings: Settings,
    /// With the attributes of the input.
    model: Model,
    /// The charts, if some were merged.
    charts: Option<Charts>,
}

/// The result with the most faces whose file has at most `limit` bytes.
fn make_within(
    limit: u64,
    task: &Task,
    options: &Simplify,
    loaded: &Loaded,
    make: impl Fn(Option<usize>) -> Result<Made, Failure>,
    console: &Console,
) -> Result<(Made, Option<FileSize>), Failure> {
    let save = &options.job.save;
    let format = task.output.as_ref().and_then(|output| Some((output, save.format_of(output)?)));
    let Some((output, format)) = format else {
        return Err(Failure::usage("--bytes needs the format of the result: -o OUT, or --to"));
    };
    let written = save.write_options();
    let sized = |faces: usize| {
        let result = make(Some(faces))?;
        let bytes = file_size(&result.model, format, &written)
            .map_err(|source| Failure::write(output, source))?;
        let faces = result.simplified.mesh.topology().face_count();
        Ok(Sized { result, faces, bytes })
    };
    let largest = largest_within(limit, loaded.mesh.topology().face_count(), sized)?;
    let Largest { found: Sized { result, faces, bytes }, fits, trials } = largest;
    if fits {
        let faces = counted(faces, "faces");
        console.message(format_args!("size: {bytes} of {limit} bytes for {faces}"));
    } else {
        console.message(format_args!(
            "the result does not fit into {limit} bytes: {bytes} bytes for {}, and there are no fewer; leave out attributes (--no-attributes), or relax other limits",
            counted(faces, "faces")
        ));
    }
    Ok((result, Some(FileSize { limit, bytes, fits, trials })))
}

fn reduce(
    name: &str,
    loaded: &Loaded,
    options: &Simplify,
    attributes: &Attributes,
    faces: Option<usize>,
    console: &Console,
) -> Result<Made, Failure> {
    let mesh = &loaded.mesh;
    let mut goals = options.targets.goals(mesh, options.job.loading.relative)?;
    goals.limits.faces = goals.limits.faces.or(faces);
    let mut chosen = options.policy.options(mesh, goals.limits);
    let merged = (!options.keep_seams).then(|| attributes.merge_charts(mesh, &chosen.target));
    let merged = merged.flatten();
    let attributes = merged.as_ref().unwrap_or(attributes);
    attributes.constrain(mesh, &mut chosen);
    let constraints = options.constraining.choices(options.job.loading.relative);
    let wanted = chosen.target;
    let kept = constraints.constrain(loaded.source(), &mut chosen).map_err(Failure::refused)?;
    tell_kept(&constraints, kept, console);
    if let (Some(faces), true) = (chosen.target.faces, chosen.target != wanted) {
        let stays = format!(
            "the kept faces leave the others no room: they are simplified to the wanted share, {} with the kept ones",
            counted(faces, "faces")
        );
        console.message(format_args!("{name}: {stays}"));
        console.stays(name, &stays);
    }
    chosen.record = false;
    if let Some(error) = goals.max_error {
        chosen = chosen.within(error, options.policy.check());
    }
    let bar = console.progress(mesh.topology().face_count() as u64, "collapsing");
    let result = simplify_observed(mesh, &chosen, &mut |now| show(&bar, now));
    bar.finish_and_clear();
    let settings = Settings::new(&chosen, constraints);
    let simplified = result.map_err(Failure::simplify)?;
    let model = attributes
        .carry(loaded.source(), &simplified.mesh, &simplified.vertex_map)
        .map_err(Failure::model)?;
    let charts = Charts::of(attributes);
    Ok(Made { simplified, settings, model, charts })
}

impl Results {
    fn new(options: &Simplify, settings: Settings, faces_in: usize, result: &Simplified) -> Self {
        let topology = result.mesh.topology();
        let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
        let (faces, vertices) = (topology.face_count(), used.count());
        let unreached =
            result.shortfall.as_ref().map(|shortfall| Unreached::new(shortfall, topology));
        Self {
            preset: options.policy.preset.to_string(),
            in_force: InForce::InMemory { settings },
            faces_in,
            faces_out: faces,
            vertices_out: Some(vertices),
            stop: result.stop.name(),
            unreached,
            max_cost: Some(result.max_cost),
            collapses: Some(result.collapses),
            rejected: Some(rejected(&result.rejections)),
            error: result.error.map(|e| Achieved { lower: e.lower, upper: e.upper }),
            boundary_shift: result.boundary_shift,
            preset_kept: result.preset_kept.map(Preset::name),
            fit: result.fit.as_ref().map(Fit::from),
            turned_over: result.unfold.map(TurnedOver::from),
            charts: None,
            size: None,
            passes: None,
        }
    }
}

fn summary_of(report: &Report<Results>) -> String {
    let found = &report.results;
    let mut text = format!(
        "{}: {} -> {},{} in {:.3} s (stopped: {})",
        report.subject(),
        found.faces_in,
        counted(found.faces_out, "faces"),
        found.vertices_out.map(|n| format!(" {},", counted(n, "vertices"))).unwrap_or_default(),
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
    if let Some(preset) = found.preset_kept {
        text += &format!("\n  kept: the result of {preset}, which is closer to the original");
    }
    if let Some(shift) = found.boundary_shift {
        text += &format!("\n  boundary vertices are up to {shift:.6e} from the new boundary");
    }
    text
}
