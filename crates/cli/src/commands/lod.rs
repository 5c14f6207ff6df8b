//! `curvmesh lod`: levels of detail from one run of collapses.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use mesh_core::TriMesh;
use mesh_io::Model;
use mesh_metric::{CompareOptions, Surface, compare};
use serde::Serialize;
use simplify::{CollapseLog, ErrorCheck, collapses_within, simplify_observed};

use crate::args::parse_positive;
use crate::attributes::{Attributes, Carry};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::{Report, Source};
use crate::load::{Loaded, Seconds};
use crate::save::{Batch, SaveOptions, check_target};
use crate::simplify_options::{Policy, Targets, parse_ratio, rejected, show};

/// Make levels of detail, each of them a stage of one run of collapses
///
/// The vertices of a level have become of those of the finer ones, and therefore levels are not fitted
/// to the input, as `simplify` does by default. OUT is a folder for a file per
/// level, or a GLB or glTF file for all of them with the input as the finest (`MSFT_lod`).
///
/// The run can be recorded, and levels made from the record later; they are exactly the same.
///
///     curvmesh lod truck.glb -o truck-lod.glb --levels 0.5,0.25,0.1 --lenient
///     curvmesh lod scan.ply -o levels --errors 0.01,0.1 --record scan.lod
///     curvmesh lod scan.ply -o small.ply --replay scan.lod --faces 3000
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Lod {
    #[command(flatten)]
    source: Source,
    /// A folder for the levels, a GLB or glTF file for all of them, or a file for the only one
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    steps: Steps,
    /// Write the collapses to a file
    #[arg(long, value_name = "FILE", conflicts_with = "replay")]
    record: Option<PathBuf>,
    /// Take the collapses from a file instead of finding them
    #[arg(long, value_name = "FILE")]
    replay: Option<PathBuf>,
    #[command(flatten)]
    policy: Policy,
    #[command(flatten)]
    carry: Carry,
    #[command(flatten)]
    save: SaveOptions,
}

/// What the levels are.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
struct Steps {
    /// Levels with these parts of the faces of the input
    #[arg(long, value_name = "RATIOS", value_delimiter = ',', value_parser = parse_ratio)]
    levels: Vec<f64>,
    /// Levels with so many faces, or one fewer
    #[arg(long, value_name = "COUNTS", value_delimiter = ',')]
    faces: Vec<usize>,
    /// The coarsest levels within these distances of the input, in model units
    #[arg(long, value_name = "DISTANCES", value_delimiter = ',', value_parser = parse_positive)]
    errors: Vec<f64>,
}

#[derive(Serialize)]
struct Results {
    collapses: usize,
    rejected: BTreeMap<&'static str, usize>,
    levels: Vec<Level>,
}

/// A level, and its distance from the input: the mean and the root mean square over both
/// directions, and the largest of all samples.
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

pub(crate) fn run(options: &Lod, console: &Console) -> Result<(), Failure> {
    let mut seconds = Seconds::default();
    let place = Place::new(options)?;
    let mut loaded = options.source.load_whole(&mut seconds, console)?;
    let attributes = options.carry.find(&mut loaded, console);
    let (log, rejected) = Seconds::time(&mut seconds.compute, || {
        collapses(options, &loaded.mesh, &attributes, console)
    })?;
    let spinner = console.spinner("measuring");
    let (mut levels, models) = Seconds::time(&mut seconds.compute, || {
        options.steps.levels(&log, &loaded, &attributes, options.policy.check())
    })?;
    spinner.finish_and_clear();
    Seconds::time(&mut seconds.save, || {
        place.write(&loaded, &mut levels, &models, &log, options, console)
    })?;
    let results = Results { collapses: log.len(), rejected, levels };
    let report = Report::new("lod", &options.source.input, loaded.counts(), results, seconds)
        .with_output(&options.output);
    console.result(&report, summary(&report))
}

/// The collapses, recorded or found.
fn collapses(
    options: &Lod,
    mesh: &TriMesh,
    attributes: &Attributes,
    console: &Console,
) -> Result<(CollapseLog, BTreeMap<&'static str, usize>), Failure> {
    if let Some(path) = &options.replay {
        let failed = |source| Failure::Record { path: path.clone(), source: Box::new(source) };
        let file = File::open(path).map_err(|error| failed(error.into()))?;
        let log = CollapseLog::read(mesh, &mut BufReader::new(file)).map_err(failed)?;
        return Ok((log, BTreeMap::new()));
    }
    let targets = options.steps.targets();
    let mut settings = options.policy.options(mesh, &targets);
    // Levels are stages of the run, which fitting would move away from.
    (settings.fit, settings.anneal, settings.peaks) = (None, None, None);
    attributes.constrain(mesh, &mut settings);
    let bar = console.progress(mesh.topology().face_count() as u64, "collapsing");
    let result = simplify_observed(mesh, &settings, &mut |now| show(&bar, now));
    bar.finish_and_clear();
    let result = result.map_err(Failure::simplify)?;
    Ok((result.log, rejected(&result.refusals)))
}

impl Steps {
    /// How far the run has to go.
    fn targets(&self) -> Targets {
        Targets {
            ratio: self.levels.iter().copied().reduce(f64::min),
            faces: self.faces.iter().copied().min(),
            max_error: self.errors.iter().copied().reduce(f64::max),
            ..Targets::default()
        }
    }

    /// The number of collapses of each level, ascending.
    fn stages(
        &self,
        log: &CollapseLog,
        mesh: &TriMesh,
        check: ErrorCheck,
    ) -> Result<Vec<usize>, Failure> {
        let faces = mesh.topology().face_count() as f64;
        let of_ratios = self.levels.iter().map(|ratio| (ratio * faces).ceil() as usize);
        let counts = of_ratios.chain(self.faces.iter().copied());
        let mut stages: Vec<usize> = counts.map(|count| log.count_for_faces(count)).collect();
        for &error in &self.errors {
            stages.push(collapses_within(mesh, log, error, check).map_err(Failure::simplify)?);
        }
        stages.sort_unstable();
        Ok(stages)
    }

    /// The levels and their content, from fine to coarse.
    fn levels(
        &self,
        log: &CollapseLog,
        loaded: &Loaded,
        attributes: &Attributes,
        check: ErrorCheck,
    ) -> Result<(Vec<Level>, Vec<Model>), Failure> {
        let original = Surface::new(&loaded.mesh).map_err(|e| Failure::simplify(e.into()))?;
        let sampling = CompareOptions { samples: 200_000, ..CompareOptions::default() };
        let (mut levels, mut models) = (Vec::new(), Vec::new());
        for collapses in self.stages(log, &loaded.mesh, check)? {
            let level = log.level(&loaded.mesh, collapses);
            let (mesh, became) = level.map_err(|error| Failure::Replay(Box::new(error)))?;
            models.push(attributes.carry(loaded, &mesh, &became)?);
            let surface = Surface::new(&mesh).map_err(|e| Failure::simplify(e.into()))?;
            let found = compare(&original, &surface, &sampling);
            levels.push(Level {
                output: None,
                faces: mesh.topology().face_count(),
                vertices: mesh.topology().vertex_count(),
                collapses,
                mean: found.mean(),
                rms: found.rms(),
                max: found.hausdorff(),
            });
        }
        Ok((levels, models))
    }
}

/// Where the levels go.
enum Place {
    /// All into one file.
    Together(PathBuf),
    /// Each into a file of its own.
    Apart(Vec<PathBuf>),
}

impl Place {
    fn new(options: &Lod) -> Result<Self, Failure> {
        let Steps { levels, faces, errors } = &options.steps;
        let count = levels.len() + faces.len() + errors.len();
        let output = &options.output;
        let extension = output.extension().map(|e| e.to_string_lossy().to_lowercase());
        let holds_all = matches!(extension.as_deref(), Some("glb" | "gltf"));
        if holds_all && !(count == 1 && options.replay.is_some()) {
            return Ok(Self::Together(output.clone()));
        }
        if extension.is_some() && !output.is_dir() {
            check_target(output, &options.save)?;
            if count > 1 {
                return Err(Failure::Usage(format!(
                    "{}: one file for several levels must be GLB or glTF; name one, or a folder",
                    output.display()
                )));
            }
            return Ok(Self::Apart(vec![output.clone()]));
        }
        let input = &options.source.input;
        let stem = input.file_stem().unwrap_or_default().to_string_lossy();
        let own = input.extension().map(|e| e.to_string_lossy().into_owned());
        let extension = options.save.extension().map(str::to_owned).or(own).unwrap_or_default();
        let paths: Vec<PathBuf> =
            (1..=count).map(|level| output.join(format!("{stem}-{level}.{extension}"))).collect();
        paths.iter().try_for_each(|path| check_target(path, &options.save))?;
        Ok(Self::Apart(paths))
    }

    /// Writes the levels and the record. All of them are whole before the first takes its place.
    fn write(
        &self,
        loaded: &Loaded,
        levels: &mut [Level],
        models: &[Model],
        log: &CollapseLog,
        options: &Lod,
        console: &Console,
    ) -> Result<(), Failure> {
        let (all, coverage);
        let mut batch = Batch::default();
        match self {
            Self::Together(path) => {
                let identity = loaded.to_model(&loaded.provenance.corner_source)?;
                all = [&identity].into_iter().chain(models).cloned().collect::<Vec<Model>>();
                coverage = shown_from(loaded, levels);
                batch.add_levels(path, &all, &coverage, &options.save);
            }
            Self::Apart(paths) => {
                for ((path, model), level) in paths.iter().zip(models).zip(levels) {
                    let folder = path.parent().unwrap_or(Path::new(""));
                    std::fs::create_dir_all(folder).map_err(|source| Failure::Write {
                        path: folder.to_owned(),
                        source: Box::new(source.into()),
                    })?;
                    batch.add_model(path, model, &options.save);
                    level.output = Some(path.display().to_string());
                }
            }
        }
        if let Some(path) = &options.record {
            let content = |writer: &mut dyn Write| log.write(&loaded.mesh, writer);
            batch.add(path, move || mesh_io::stage_file(path, content));
        }
        batch.write(console)
    }
}

/// The height of a usual screen in pixels.
const SCREEN: f64 = 1080.0;

/// For the input and each level, the part of the screen that the object must cover for it to be
/// shown: where the largest error of the next one would be more than a pixel. The last is shown
/// however small.
fn shown_from(loaded: &Loaded, levels: &[Level]) -> Vec<f64> {
    let size = loaded.mesh.bounding_box().map_or(0.0, |b| b.diagonal());
    let mut last = 1.0_f64;
    let mut all: Vec<f64> = levels
        .iter()
        .map(|level| {
            last = last.min(size / (SCREEN * level.max.max(f64::MIN_POSITIVE)));
            last
        })
        .collect();
    all.push(0.0);
    all
}

fn summary(report: &Report<Results>) -> String {
    let mut text = format!("{}: {} faces", report.subject(), report.faces);
    for level in &report.results.levels {
        let Level { faces, vertices, mean, max, .. } = level;
        text += &format!(
            "\n  {faces} faces, {vertices} vertices: mean distance {mean:.6e}, maximum {max:.6e}"
        );
        if let Some(output) = &level.output {
            text += &format!("  {output}");
        }
    }
    text
}
