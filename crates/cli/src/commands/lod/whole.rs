//! `curvmesh lod` of a mesh in memory: one run of collapses, its record, and its stages.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;

use mesh_io::Model;
use mesh_metric::Surface;
use mesh_view::{Exhibit, Page, Section};
use mesh_work::{
    Attributes, LevelError, LevelOfDetail, LevelRecord, LevelSteps, Loaded, shown_from,
};
use serde::Serialize;
use simplify::{SimplifyError, simplify_observed};

use crate::args::is_standard;
use crate::commands::lod::options::Lod;
use crate::commands::lod::place::Place;
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::load::{Loading, Seconds, tell_crowded_mesh, tell_unused};
use crate::save::{Outputs, make_folder_of, save};
use crate::session::{Outcome, Session};
use crate::simplify_options::{
    Charts, Settings, Unreached, rejected, show, tell_kept, tell_shortfall,
};
use crate::task::{Report, Source, copy_pictures};
use crate::text::printable;
use crate::view::{self, name_of};

#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    run: Option<CollapseRun>,
    collapses: usize,
    rejected: BTreeMap<&'static str, usize>,
    /// Absent if no charts were merged.
    #[serde(skip_serializing_if = "Option::is_none")]
    charts: Option<Charts>,
    /// The wanted numbers of faces that no level reaches.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    missed_faces: Vec<usize>,
    levels: Vec<Level>,
}

/// How the collapses were found; absent if they were replayed.
#[derive(Serialize)]
struct CollapseRun {
    preset: String,
    settings: Settings,
    #[serde(skip_serializing_if = "Option::is_none")]
    unreached: Option<Unreached>,
}

/// A level, and its distance from the input: the mean and the root mean square over both directions, and the largest of
/// all samples.
#[derive(Serialize)]
struct Level {
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<String>,
    faces: usize,
    vertices: usize,
    collapses: usize,
    mean: f64,
    rms: f64,
    max: f64,
}

pub(super) fn run(options: &Lod, session: &Session) -> Result<Outcome, Failure> {
    // Checks the outputs before anything is read.
    Place::new(options, options.steps.or_quiet_default(None).count(), &session.given)?;
    let console = &*session.console.beside(Some(&options.output))?;
    let mut seconds = Seconds::default();
    let Source { input, loading } = &options.source;
    let loaded = Seconds::time(&mut seconds.load, || loading.load(input, console))?;
    tell_unused(input, &loaded, console);
    if options.policy.forbids_intersections() || !options.steps.errors.is_empty() {
        tell_crowded_mesh(input, &loaded.mesh, console);
    }
    let steps = options.steps.or_default(Some(loaded.mesh.topology().face_count()), console);
    let place = Place::new(options, steps.count(), &session.given)?;
    let steps = steps.of(&loaded.mesh, loading.relative)?;
    let attributes = options.carry.find(&loaded, console)?;
    let Collapses { record, run, rejected, attributes } =
        Seconds::time(&mut seconds.compute, || {
            collapses(options, &steps, &loaded, attributes, console)
        })?;
    let charts = Charts::of(&attributes);
    if let Some(charts) = charts {
        charts.tell(console);
    }
    let spinner = console.spinner("measuring");
    let levels = Seconds::time(&mut seconds.compute, || {
        steps.levels(&record, loaded.source(), &attributes, options.policy.check())
    })
    .map_err(failed)?;
    spinner.finish_and_clear();
    let missed_faces = steps.missed_faces(&loaded.mesh, &levels);
    let (mut levels, models) = told(levels);
    if let (Some(path), Some(coarsest), false) =
        (&options.replay, levels.last(), missed_faces.is_empty())
    {
        console.message(format_args!(
            "{}: the record ends at {}, more than were asked for; make a record of more levels",
            printable(path.display()),
            counted(coarsest.faces, "faces")
        ));
    }
    Seconds::time(&mut seconds.save, || {
        write(&place, &loaded, &mut levels, &models, &record, options, console)
    })?;
    let results =
        Results { run, collapses: record.log.len(), rejected, charts, missed_faces, levels };
    let report =
        Report::new(console, input, loaded.counts(), results, seconds).with_output(&options.output);
    if options.look.is_wanted() {
        let page = page(input, loading, &loaded, &report.results.levels, &models)?;
        options.look.write(page, &report, console)?;
    }
    report.done(console, summary(&report), String::new())?.print(console)?;
    Ok(Outcome::of_run())
}

/// The input and the levels with their errors, and the sizes on the screen at which they change.
fn page(
    input: &Path,
    loading: &Loading,
    loaded: &Loaded,
    levels: &[Level],
    models: &[Model],
) -> Result<Page, Failure> {
    let identity = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
    let original = Surface::new(&loaded.mesh).map_err(Failure::refused)?;
    let names = levels.iter().map(|level| counted(level.faces, "faces"));
    let names: Vec<String> = std::iter::once("input".to_owned()).chain(names).collect();
    let mut exhibits = Vec::new();
    let all = names.iter().zip([&identity].into_iter().chain(models));
    for ((name, model), coverage) in all.zip(shown(loaded, levels)) {
        let mut exhibit = view::content(name, input, model, loading)?;
        view::add_distances(&mut exhibit, &original).map_err(Failure::refused)?;
        exhibit.coverage = Some(coverage);
        exhibits.push(exhibit);
    }
    let line = |(level, exhibit): (&Level, &Exhibit)| {
        let share = 100.0 * exhibit.coverage.unwrap_or(0.0);
        let counts = [level.faces, level.vertices].map(|n| n.to_string());
        let errors = [level.mean, level.rms, level.max].map(|x| format!("{x:.3e}"));
        counts.into_iter().chain(errors).chain([format!("{share:.1} %")]).collect()
    };
    let heads = ["faces", "vertices", "mean", "rms", "largest", "down to"];
    let table = Section {
        title: "Levels".into(),
        text: "Distances from the input, and the share of the height of the screen down to which \
               a level is shown: there its error is a pixel of 1080."
            .into(),
        header: heads.map(String::from).into(),
        lines: levels.iter().zip(&exhibits[1..]).map(line).collect(),
        ..Section::default()
    };
    let mut page = Page::new(format!("{}: levels of detail", name_of(input)), exhibits);
    let has_materials = page.exhibits.iter().any(|exhibit| exhibit.materials.is_some());
    page.start.color = Some(if has_materials { "material" } else { "plain" }.into());
    page.report.push(table);
    Ok(page)
}

/// The collapses, from a record or from a run, and the attributes of the levels.
struct Collapses {
    record: LevelRecord,
    run: Option<CollapseRun>,
    rejected: BTreeMap<&'static str, usize>,
    attributes: Attributes,
}

fn collapses(
    options: &Lod,
    steps: &LevelSteps,
    loaded: &Loaded,
    attributes: Attributes,
    console: &Console,
) -> Result<Collapses, Failure> {
    let mesh = &loaded.mesh;
    if let Some(path) = &options.replay {
        let failed = |source| Failure::Record { path: path.clone(), source: Box::new(source) };
        let file = File::open(path).map_err(|error| failed(error.into()))?;
        let record = LevelRecord::read(mesh, &mut BufReader::new(file)).map_err(failed)?;
        let attributes = record.attributes(mesh, attributes);
        return Ok(Collapses { record, run: None, rejected: BTreeMap::new(), attributes });
    }
    let chosen = options.policy.options(mesh, steps.limits());
    let constraints = options.constraining.choices(options.source.loading.relative);
    let limits = (&constraints, options.keep_seams);
    let plan = steps.plan(loaded.source(), chosen, attributes, limits, options.policy.check());
    let plan = plan.map_err(Failure::refused)?;
    tell_kept(&constraints, plan.kept, console);
    let bar = console.progress(mesh.topology().face_count() as u64, "collapsing");
    let result = simplify_observed(mesh, &plan.options, &mut |now| show(&bar, now));
    bar.finish_and_clear();
    let result = result.map_err(Failure::simplify)?;
    let topology = result.mesh.topology();
    if let Some(shortfall) = &result.shortfall {
        tell_shortfall(shortfall, topology, console);
    }
    let run = CollapseRun {
        preset: options.policy.preset.to_string(),
        settings: Settings::new(&plan.options, constraints),
        unreached: result.shortfall.as_ref().map(|shortfall| Unreached::new(shortfall, topology)),
    };
    let rejected = rejected(&result.rejections);
    let record = plan.record(mesh, result.log);
    Ok(Collapses { record, run: Some(run), rejected, attributes: plan.attributes })
}

fn failed(error: LevelError) -> Failure {
    match error {
        LevelError::Simplify(SimplifyError::OtherMesh(error)) => Failure::Replay(Box::new(error)),
        LevelError::Simplify(error) => Failure::simplify(error),
        LevelError::Surface(error) => Failure::simplify(error.into()),
        LevelError::Model(error) => Failure::model(error),
        other => Failure::refused(other),
    }
}

/// The reports of the levels, and their content.
fn told(levels: Vec<LevelOfDetail>) -> (Vec<Level>, Vec<Model>) {
    let tell = |level: LevelOfDetail| {
        let LevelOfDetail { model, mesh, collapses, distance } = level;
        let level = Level {
            output: None,
            faces: mesh.topology().face_count(),
            vertices: mesh.topology().vertex_count(),
            collapses,
            mean: distance.mean(),
            rms: distance.rms(),
            max: distance.hausdorff(),
        };
        (level, model)
    };
    levels.into_iter().map(tell).unzip()
}

/// Writes the levels and the record. All of them are complete before the first is moved to its place.
fn write(
    place: &Place,
    loaded: &Loaded,
    levels: &mut [Level],
    models: &[Model],
    record: &LevelRecord,
    options: &Lod,
    console: &Console,
) -> Result<(), Failure> {
    let (all, coverage);
    let mut outputs = Outputs::default();
    match place {
        Place::Together(path) => {
            let identity =
                loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
            all = [&identity].into_iter().chain(models).cloned().collect::<Vec<Model>>();
            coverage = shown(loaded, levels);
            outputs.add_levels(path, &all, &coverage, &options.save);
        }
        Place::Apart(paths) => {
            for ((path, model), level) in paths.iter().zip(models).zip(levels) {
                if is_standard(path) {
                    save(path, model, &options.save, console)?;
                } else {
                    make_folder_of(path)?;
                    outputs.add_model(path, model, &options.save);
                }
                level.output = Some(path.display().to_string());
            }
        }
    }
    if let Some(path) = &options.record {
        let content = |writer: &mut dyn Write| record.write(&loaded.mesh, writer);
        outputs.add(path, move || mesh_io::stage_file(path, content));
    }
    outputs.write(console)?;
    if let (Some(path), Some(model)) = (place.first(), models.first()) {
        let pictures = model.file_pictures();
        copy_pictures(&options.source.input, path, &options.save, &pictures, console);
    }
    Ok(())
}

/// For the input and each level, the share of the screen down to which it is shown.
fn shown(loaded: &Loaded, levels: &[Level]) -> Vec<f64> {
    let size = loaded.mesh.bounding_box().map_or(0.0, |b| b.diagonal());
    shown_from(size, levels.iter().map(|level| level.max))
}

fn summary(report: &Report<Results>) -> String {
    let mut text = format!("{}: {}", report.subject(), counted(report.faces, "faces"));
    for level in &report.results.levels {
        let Level { faces, vertices, mean, max, .. } = level;
        text += &format!(
            "\n  {}, {}: mean distance {mean:.6e}, maximum {max:.6e}",
            counted(*faces, "faces"),
            counted(*vertices, "vertices")
        );
        if let Some(output) = &level.output {
            text += &format!("  {}", printable(output));
        }
    }
    text
}
