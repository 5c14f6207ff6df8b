//! Meshes that exceed the memory limit.

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::ProgressBar;
use mesh_core::build::Weld;
use mesh_io::{Format, Model, Staged};
use out_of_core::{Capacity, Input, Outcome, Repaired, Repairs, ResultMesh, Settings, Step, Work};
use serde::Serialize;
use simplify::{Options, Target};

use crate::args::{RepairOptions, is_standard};
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::interrupt::{self, while_writing, while_writing_all};
use crate::load::{Loading, needed, parse_bytes};
use crate::save::{SaveOptions, explain, make_folder_of, save};
use crate::simplify_options;
use crate::text::printable;

/// The memory limit of a run, and its work folder.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Meshes larger than memory")]
pub(crate) struct Large {
    /// The memory limit, such as 512MiB or 4G. A mesh that needs more is simplified region by region, through
    /// files
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub(crate) memory: Option<u64>,
    /// The folder for these files [default: OUT.work, which is removed at the end]
    #[arg(long, value_name = "DIR", requires = "memory")]
    pub(crate) work_dir: Option<PathBuf>,
}

impl Large {
    /// Whether a file is simplified region by region, judged by its length.
    pub(crate) fn is_needed(&self, input: &Path, loading: &Loading) -> Result<bool, Failure> {
        is_beyond(self.memory, &[input], loading)
    }

    /// The work folder.
    pub(crate) fn folder(&self, output: &Path) -> PathBuf {
        self.work_dir.clone().unwrap_or_else(|| {
            let mut name = output.as_os_str().to_owned();
            name.push(".work");
            name.into()
        })
    }
}

/// Whether files need more memory than the limit, judged by their lengths.
pub(crate) fn is_beyond(
    memory: Option<u64>,
    inputs: &[&Path],
    loading: &Loading,
) -> Result<bool, Failure> {
    let Some(memory) = memory else { return Ok(false) };
    let mut needed = 0_u64;
    for input in inputs {
        if is_standard(input) {
            return Ok(true);
        }
        let format = loading.format(input)?;
        let file = std::fs::metadata(input).ok().filter(std::fs::Metadata::is_file);
        let Some(file) = file else { return Ok(true) };
        needed = needed.saturating_add(whole(file.len(), format));
    }
    Ok(needed > memory)
}

/// An estimate of the bytes that a mesh takes while it is read and simplified in memory.
fn whole(bytes: u64, format: Option<Format>) -> u64 {
    // 400 bytes for a face, which takes some 19 bytes in PLY, 50 in STL and 35 in OBJ.
    let per_byte = match format {
        Some(Format::Stl) => 8,
        Some(Format::Ply) => 21,
        _ => 12,
    };
    bytes.saturating_mul(per_byte).saturating_add(24 << 20)
}

/// The repairs that can be made region by region.
pub(crate) fn repairs(options: &RepairOptions) -> Result<Repairs, Failure> {
    let refuse = |name: &str| {
        Err(Failure::usage(format!(
            "{name} needs the whole mesh in memory, which --memory does not allow; repair the file first"
        )))
    };
    if options.weld.is_some() {
        return refuse("--weld");
    }
    if options.reorient {
        return refuse("--reorient");
    }
    if options.drop_out_of_range {
        return refuse("--drop-out-of-range");
    }
    let (repair, needed) = (options.repair(Weld::None), !options.strict);
    Ok(Repairs {
        join_loose_faces: needed,
        drop_not_finite: needed || repair.drop_not_finite,
        drop_degenerate: needed || repair.drop_degenerate,
        cut_non_manifold: needed || repair.cut_non_manifold,
    })
}

/// The tolerance of proofs in each pass, as a share of the diagonal of the bounding box.
pub(crate) const PROVED: f64 = 1e-4;

/// Splits a file into regions, unless that was done by an earlier run.
pub(crate) fn split_file(
    input: &Path,
    folder: &Path,
    loading: &Loading,
    settings: Settings,
    console: &Console,
) -> Result<Work, Failure> {
    let options = loading.streaming()?;
    let bar = console.progress_of_passes();
    let see = &mut |step: Step| {
        show(&bar, step);
        !interrupt::is_asked_to_end()
    };
    let stream = &mut std::io::stdin();
    let source = if is_standard(input) {
        Input::Stream(stream, Path::new("<stdin>"))
    } else {
        Input::Path(input)
    };
    let work = Work::split(folder, source, &options, settings, see);
    bar.finish_and_clear();
    let work = work.map_err(Failure::regions)?;
    for note in &work.manifest().summary.notes {
        console.message(format_args!("{}: {note}", input.display()));
    }
    let Repaired { degenerate_triangles, non_manifold_vertices } = work.repaired();
    let repaired = [
        ("dropped degenerate triangles", degenerate_triangles),
        ("cut non-manifold vertices", non_manifold_vertices),
    ];
    let repaired: Vec<(&str, usize)> = repaired
        .into_iter()
        .map(|(what, count)| (what, usize::try_from(count).unwrap_or(usize::MAX)))
        .filter(|(_, count)| *count > 0)
        .collect();
    if !repaired.is_empty() {
        let name = printable(input.display());
        console.message(format_args!("{name}: {}", needed(repaired.iter().copied())));
        console.repaired(&name, repaired.into_iter());
    }
    Ok(work)
}

/// The work folder of a run.
pub(crate) struct Folder {
    pub(crate) path: PathBuf,
    /// Whether an interrupted run in the folder is resumed.
    pub(crate) resume: bool,
}

/// Simplifies a file region by region.
pub(crate) fn simplify_file(
    input: &Path,
    large: &Large,
    folder: &Folder,
    loading: &Loading,
    settings: Settings,
    takes_regions: bool,
    console: &Console,
) -> Result<(Outcome, Work), Failure> {
    let Folder { path, resume } = folder;
    if path.join("run.json").exists() && !resume {
        // A damaged folder, or a folder that another process uses, has its own error.
        Work::open(path).map_err(Failure::regions)?;
        return Err(Failure::usage(format!(
            "{}: there is an earlier run in this folder; resume it with --resume, or remove the folder",
            path.display()
        )));
    }
    let work = split_file(input, path, loading, settings, console)?;
    if !takes_regions && !work.fits() {
        remove(work, large);
        return Err(Failure::usage(ONLY_PLY));
    }
    let bar = console.progress_of_passes();
    let outcome = out_of_core::run(&work, &mut |step| {
        show(&bar, step);
        !interrupt::is_asked_to_end()
    });
    bar.finish_and_clear();
    Ok((outcome.map_err(Failure::regions)?, work))
}

pub(crate) const ONLY_PLY: &str =
    "a result larger than --memory is written as a PLY file; name an output that ends in .ply";

/// Whether a result that does not fit into memory can be written to a path.
pub(crate) fn takes_regions(output: &Path, options: &SaveOptions) -> bool {
    options.format_of(output) == Some(Format::Ply) && !is_standard(output)
}

/// Whether this number of levels of detail goes to a folder: the folder exists, or the name does not end like a mesh
/// file.
pub(crate) fn is_folder(output: &Path, options: &SaveOptions, levels: usize) -> bool {
    let names_format = || Format::from_extension(output).is_some();
    let is_plain_file = || levels == 1 && options.to.is_some() && output.extension().is_some();
    output.is_dir() || !(is_standard(output) || names_format() || is_plain_file())
}

/// Writes a result: a mesh in memory in any format, or regions on disk as PLY.
pub(crate) fn save_left(
    result: ResultMesh,
    work: &Work,
    output: &Path,
    options: &SaveOptions,
    console: &Console,
) -> Result<(), Failure> {
    match result {
        ResultMesh::InMemory(mesh) => save(output, &Model::from(mesh.to_soup()), options, console),
        ResultMesh::OnDisk { level } => {
            if !takes_regions(output, options) {
                return Err(Failure::usage(ONLY_PLY));
            }
            while_writing(output, || out_of_core::assemble(work, level, output))
                .map_err(Failure::regions)?;
            Ok(())
        }
    }
}

/// A level of detail that was written.
#[derive(Serialize)]
pub(crate) struct Level {
    output: String,
    faces: u64,
    /// The number of tiles, if it was written as tiles.
    #[serde(skip_serializing_if = "Option::is_none")]
    tiles: Option<usize>,
    /// The proved upper bound of the Hausdorff distance from the input.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<f64>,
}

impl core::fmt::Display for Level {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { output, faces, tiles, error } = self;
        f.write_str(&counted(*faces, "faces"))?;
        if let Some(tiles) = tiles {
            write!(f, " in {}", counted(*tiles, "tiles"))?;
        }
        if let Some(error) = error {
            write!(f, ", within {error:.6e} of the input")?;
        }
        write!(f, "  {}", printable(output))
    }
}

/// The number of faces and cells of each pass over a mesh larger than memory.
#[derive(Serialize)]
pub(crate) struct Passes {
    faces: Vec<u64>,
    cells: Vec<u32>,
}

impl Passes {
    pub(crate) fn of(outcome: &Outcome) -> Self {
        Self { faces: outcome.levels.clone(), cells: outcome.cells.clone() }
    }
}

/// Levels of detail with these shares of the faces, and with these numbers of faces.
pub(crate) fn levels(ratios: &[f64], faces: &[usize]) -> Vec<Target> {
    let of_ratios = ratios.iter().map(|&ratio| Target { ratio: Some(ratio), ..Target::default() });
    let of_faces = faces.iter().map(|&faces| Target { faces: Some(faces), ..Target::default() });
    of_ratios.chain(of_faces).collect()
}

/// The reports of all results of a run, from the finest.
fn levels_at(outcome: &Outcome, paths: &[PathBuf]) -> Vec<Level> {
    let finer = outcome.finer_levels.iter().map(|level| (level.faces, level.error));
    let results = finer.chain([(outcome.faces, outcome.error)]).zip(paths);
    let level = |((faces, error), path): ((u64, Option<f64>), &PathBuf)| Level {
        output: path.display().to_string(),
        faces,
        tiles: None,
        error,
    };
    results.map(level).collect()
}

/// Calls `visit` with each result of a run, from the finest. Only one of them is in memory, besides the coarsest.
fn each_level<T>(
    outcome: &Outcome,
    work: &Work,
    mut visit: impl FnMut(usize, &ResultMesh) -> Result<T, Failure>,
) -> Result<Vec<T>, Failure> {
    let mut visited = Vec::new();
    for (number, level) in outcome.finer_levels.iter().enumerate() {
        visited.push(visit(number, &level.load(work).map_err(Failure::regions)?)?);
    }
    visited.push(visit(outcome.finer_levels.len(), &outcome.result)?);
    Ok(visited)
}

/// Writes all results of a run, from the finest, each as a folder of tiles.
pub(crate) fn save_tiles(
    outcome: &Outcome,
    work: &Work,
    folders: &[PathBuf],
) -> Result<Vec<Level>, Failure> {
    let mut levels = levels_at(outcome, folders);
    let counts = each_level(outcome, work, |number, left| {
        let folder = &folders[number];
        let tiles = while_writing(folder, || out_of_core::write_tiles(work, left, folder));
        Ok(tiles.map_err(Failure::regions)?.tiles.len())
    })?;
    for (level, count) in levels.iter_mut().zip(counts) {
        level.tiles = Some(count);
    }
    Ok(levels)
}

/// Writes all results of a run, from the finest, each as a file. All files are complete before the first is moved to
/// its place.
pub(crate) fn save_levels(
    outcome: &Outcome,
    work: &Work,
    paths: &[PathBuf],
    options: &SaveOptions,
    console: &Console,
) -> Result<Vec<Level>, Failure> {
    paths.iter().try_for_each(|path| make_folder_of(path))?;
    let names: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
    let reports = while_writing_all(&names, || {
        let staged = each_level(outcome, work, |number, left| {
            let path = names[number];
            match left {
                ResultMesh::InMemory(mesh) => {
                    let model = Model::from(mesh.to_soup());
                    mesh_io::stage(path, &model, &options.write_options())
                        .map_err(|error| Failure::write(path, error))
                }
                ResultMesh::OnDisk { level } if takes_regions(path, options) => {
                    let staged = out_of_core::stage_assembled(work, *level, path);
                    Ok(staged.map_err(Failure::regions)?.0)
                }
                ResultMesh::OnDisk { .. } => Err(Failure::usage(ONLY_PLY)),
            }
        })?;
        let commit = |(staged, path): (Staged, &&Path)| {
            staged.commit().map_err(|error| Failure::write(path, error))
        };
        staged.into_iter().zip(&names).map(commit).collect::<Result<Vec<_>, Failure>>()
    })?;
    names.iter().zip(&reports).for_each(|(path, report)| explain(path, report, console));
    Ok(levels_at(outcome, paths))
}

/// The settings of a run with a memory limit.
pub(crate) fn settings(
    options: Options,
    finer_levels: Vec<Target>,
    memory: u64,
    repair: &RepairOptions,
    prove: Option<f64>,
) -> Result<Settings, Failure> {
    let capacity = Capacity::within(memory, &options, 1 + finer_levels.len(), prove.is_some())
        .map_err(Failure::regions)?;
    Ok(Settings { options, finer_levels, repairs: repairs(repair)?, capacity, prove })
}

/// All settings of a run with a memory limit, with the preset expanded, for reports.
#[derive(Serialize)]
pub(crate) struct RegionSettings {
    settings: Options,
    regions: Regions,
}

/// The settings beside the options of the collapses.
#[derive(Serialize)]
struct Regions {
    finer_levels: Vec<Target>,
    repairs: Repairs,
    capacity: Capacity,
    prove: Option<f64>,
}

impl RegionSettings {
    pub(crate) fn of(settings: &Settings) -> Self {
        // Destructured, so that the compiler finds a forgotten field.
        let Settings { options, finer_levels, repairs, capacity, prove } = settings.clone();
        let regions = Regions { finer_levels, repairs, capacity, prove };
        Self { settings: simplify_options::settings(&options), regions }
    }
}

/// Shows a step on the progress bar.
pub(crate) fn show(bar: &ProgressBar, step: Step) {
    let Step { what, done, of, level } = step;
    bar.set_message(format!("pass {}: {what}", level + 1));
    bar.set_length(of);
    bar.set_position(done);
}

/// Removes the work folder of a finished run, unless the user has named it.
pub(crate) fn remove(work: Work, large: &Large) {
    if large.work_dir.is_none() {
        work.remove();
    }
}
