//! `curvmesh region`: the steps of a run on a mesh larger than memory, one by one, for job arrays.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use mesh_core::as_u32;
use out_of_core::{Next, Plan, Step, Work, refine_cell, run as run_rest, write_tiles};
use serde::Serialize;

use crate::args::{parse_elements, parse_index};
use crate::batch::{Shard, parse_shard};
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::interrupt::{self, while_writing};
use crate::large::{self, Level, RegionSettings};
use crate::load::{Loading, parse_bytes};
use crate::save::{SAVE_OPTIONS, SaveOptions, check_target, paths_of_levels};
use crate::session::{Outcome, Session};
use crate::simplify_options::{NOT_FITTED, OF_FITS, OF_TARGETS, Policy, Targets, parse_ratio};

/// Simplify a mesh larger than memory step by step, on any number of machines
///
/// Each step reads and writes files in a work folder, on a disk that all machines share. Finished steps are skipped, so
/// a failed job can be started again unchanged.
///
/// With --levels or --level-faces, `split` starts a run with several results, levels of detail, which are written to a
/// folder.
#[derive(Debug, Args)]
#[command(after_long_help = EXAMPLES)]
pub(crate) struct Region {
    #[command(subcommand)]
    step: RegionStep,
}

const EXAMPLES: &str = "\
Examples:
    curvmesh region split huge.ply -w work --ratio 0.01 --memory 8G
    curvmesh region plan work                  # prints which level is next, and its steps
    curvmesh region reduce work --level 0 --shard 3/64
    curvmesh region join work --level 1 --shard 3/16
    curvmesh region finish work -o small.ply

A result that does not fit into memory is refined cell by cell:
    curvmesh region finish work --shard 3/16
    curvmesh region finish work --tiles small  # writes a file for each cell

Levels of detail:
    curvmesh region split huge.ply -w work --levels 0.3,0.1,0.01 --memory 8G
    curvmesh region finish work --level 2 --shard 3/16   # if level 2 is a result
    curvmesh region finish work -o levels";

#[derive(Debug, Subcommand)]
enum RegionStep {
    /// Split a file into regions on disk
    Split(Box<Split>),
    /// Print the next steps: reduce and join a level, or finish
    Plan(Folder),
    /// Collapse regions of a level up to the planned cost
    Reduce(Cells),
    /// Join the collapsed regions of the level below
    Join(Cells),
    /// Carry out all remaining steps, and write the result
    Finish(Finish),
}

#[derive(Debug, Args)]
struct Split {
    /// The file to read
    #[arg(value_name = "IN", help_heading = None)]
    input: PathBuf,
    /// The folder for the regions
    #[arg(short, long, value_name = "DIR", help_heading = None)]
    work_dir: PathBuf,
    /// The memory limit of a step, such as 512MiB or 4G
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes, help_heading = None)]
    memory: u64,
    #[command(flatten)]
    targets: Targets,
    /// Make levels of detail with these shares of the faces, not fitted to the input, instead of one result
    #[arg(
        long, value_name = "RATIOS", value_delimiter = ',', value_parser = parse_ratio,
        help_heading = "Levels of detail"
    )]
    levels: Vec<f64>,
    /// Make levels of detail with these numbers of faces
    #[arg(
        long, value_name = "COUNTS", value_delimiter = ',', value_parser = parse_elements,
        help_heading = "Levels of detail"
    )]
    level_faces: Vec<usize>,
    #[command(flatten)]
    policy: Policy,
    #[command(flatten)]
    loading: Loading,
}

#[derive(Debug, Args)]
struct Folder {
    /// The work folder
    #[arg(value_name = "DIR")]
    work_dir: PathBuf,
}

#[derive(Debug, Args)]
struct Cells {
    /// The work folder
    #[arg(value_name = "DIR")]
    work_dir: PathBuf,
    /// The level
    #[arg(long, value_name = "L", value_parser = parse_index::<u32>)]
    level: u32,
    /// Only this cell [default: all cells]
    #[arg(long, value_name = "C", conflicts_with = "shard", value_parser = parse_index::<u32>)]
    cell: Option<u32>,
    /// Only the K-th of N parts of the cells, as in 3/64
    #[arg(long, value_name = "K/N", value_parser = parse_shard)]
    shard: Option<Shard>,
}

#[derive(Debug, Args)]
struct Finish {
    /// The work folder
    #[arg(value_name = "DIR")]
    work_dir: PathBuf,
    /// The file to write, or the folder for several levels of detail
    #[arg(short, long, value_name = "OUT", required_unless_present_any = ["tiles", "shard", "cell", "level"])]
    output: Option<PathBuf>,
    /// The folder for one PLY file for each cell, and tiles.json, which lists them. Vertices that two files share have the
    /// same coordinates. Each level of detail gets its own folder in it
    #[arg(long, value_name = "DIR")]
    tiles: Option<PathBuf>,
    /// Only refine this cell of a result that does not fit into memory
    #[arg(
        long, value_name = "C", conflicts_with_all = ["shard", "output", "tiles"],
        value_parser = parse_index::<u32>
    )]
    cell: Option<u32>,
    /// Only refine the K-th of N parts of its cells, as in 3/16
    #[arg(long, value_name = "K/N", value_parser = parse_shard, conflicts_with_all = ["output", "tiles"])]
    shard: Option<Shard>,
    /// Print the progress as lines on stderr, for programs: `progress: fit 3 of 12`
    #[arg(long, hide = true)]
    tell_progress: bool,
    /// Level of the cells [default: the last one]
    #[arg(
        long, value_name = "L", conflicts_with_all = ["output", "tiles"],
        value_parser = parse_index::<u32>
    )]
    level: Option<u32>,
    #[command(flatten)]
    save: SaveOptions,
}

/// The report of a step.
#[derive(Serialize)]
struct Report {
    command: String,
    work_dir: String,
    step: &'static str,
    level: u32,
    /// The number of cells of the level.
    cells: u32,
    /// The number of faces of the regions of the step, or of the level.
    faces: u64,
    /// The settings of the run, from a plan.
    #[serde(flatten)]
    in_force: Option<RegionSettings>,
    /// The next step, from a plan: `pass`, `strips`, `finish`.
    #[serde(skip_serializing_if = "Option::is_none")]
    next: Option<&'static str>,
    /// The number of cells of the next level.
    #[serde(skip_serializing_if = "Option::is_none")]
    joined: Option<u32>,
    /// The number of cells that can be refined side by side, if the level is a result that does not fit into memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    apart: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<String>,
    /// The folder of the tiles, and their number.
    #[serde(skip_serializing_if = "Option::is_none")]
    tiles: Option<(String, usize)>,
    /// The levels of detail that were written, from the finest.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    levels: Vec<Level>,
    /// The proved upper bound of the Hausdorff distance from the input.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<f64>,
}

pub(crate) fn run(options: &Region, session: &Session) -> Result<Outcome, Failure> {
    let console = &session.console;
    match &options.step {
        RegionStep::Split(split) => split_file(split, session),
        RegionStep::Plan(folder) => {
            let work = open(&folder.work_dir)?;
            print_plan(&work, &work.current().map_err(Failure::regions)?, console)
        }
        RegionStep::Reduce(cells) => each_cell(cells, "reduce", console, &|work, cell| {
            work.reduce(cells.level, cell).map(|record| record.faces)
        }),
        RegionStep::Join(cells) => each_cell(cells, "join", console, &|work, cell| {
            work.join(cells.level, cell).map(|record| record.faces)
        }),
        RegionStep::Finish(finish) => finish_run(finish, session),
    }
}

fn open(folder: &Path) -> Result<Work, Failure> {
    Work::open(folder).map_err(Failure::regions)
}

fn split_file(options: &Split, session: &Session) -> Result<Outcome, Failure> {
    let mut finer = large::levels(&options.levels, &options.level_faces);
    let chosen = match finer.pop() {
        None => {
            options.targets.explain(&session.console);
            options.policy.check_given(&session.given)?;
            options.policy.regional_options(options.targets.regional_limits()?)?
        }
        Some(limits) => {
            session.given.refuse(&OF_FITS, NOT_FITTED)?;
            session.given.refuse(&OF_TARGETS, "the levels say how many faces there are to be")?;
            options.policy.regional_options(limits)?.for_levels()
        }
    };
    let prove = options.policy.proves().then_some(large::PROVED);
    let settings = large::settings(chosen, finer, options.memory, &options.loading.repair, prove)?;
    let (folder, console) = (&options.work_dir, &session.console);
    let work = large::split_file(&options.input, folder, &options.loading, settings, console)?;
    print_plan(&work, &work.plan(0).map_err(Failure::regions)?, console)
}

fn print_plan(work: &Work, plan: &Plan, console: &Console) -> Result<Outcome, Failure> {
    let (next, joined) = match plan.next {
        Next::Pass { bits, .. } => ("pass", Some(plan.cells.div_ceil(1 << bits))),
        Next::SeamStrips { .. } => ("strips", Some(plan.cells)),
        Next::InMemory | Next::Done => ("finish", None),
    };
    let apart = (plan.results > 0).then_some(plan.cells);
    let report = Report {
        level: plan.level,
        cells: plan.cells,
        faces: plan.faces,
        in_force: Some(RegionSettings::of(&work.manifest().settings)),
        next: Some(next),
        joined,
        apart,
        ..report(work, "plan", console)
    };
    let text = match joined {
        Some(_) if next == "strips" => format!(
            "level {}: {} in {}; collapse their seams: join one cell of level {}, which makes all cells",
            plan.level,
            counted(plan.faces, "faces"),
            counted(plan.cells, "cells"),
            plan.level + 1
        ),
        Some(joined) => format!(
            "level {}: {} in {}; reduce them, then join them to {} of level {}",
            plan.level,
            counted(plan.faces, "faces"),
            counted(plan.cells, "cells"),
            counted(joined, "cells"),
            plan.level + 1
        ),
        None => format!("level {}: {}; finish", plan.level, counted(plan.faces, "faces")),
    };
    print(&report, &text, console)
}

fn each_cell(
    options: &Cells,
    step: &'static str,
    console: &Console,
    act: &dyn Fn(&Work, u32) -> Result<u64, out_of_core::Error>,
) -> Result<Outcome, Failure> {
    let work = open(&options.work_dir)?;
    let below = if step == "join" { options.level.checked_sub(1) } else { Some(options.level) };
    let Some(below) = below else {
        return Err(Failure::usage(
            "level 0 is the input and is not joined; the first level that is joined is 1",
        ));
    };
    // Each process makes the same plan.
    work.plan(below).map_err(Failure::regions)?;
    let cells = work.cells(options.level).map_err(Failure::regions)?;
    let mut faces = 0;
    for cell in mine(options.cell, options.shard, options.level, cells)? {
        faces += act(&work, cell).map_err(Failure::regions)?;
    }
    let report = Report { level: options.level, cells, faces, ..report(&work, step, console) };
    print(
        &report,
        &format!("{step} of level {}: {}", options.level, counted(faces, "faces")),
        console,
    )
}

/// The cells of a level that the options select.
fn mine(
    cell: Option<u32>,
    shard: Option<Shard>,
    level: u32,
    cells: u32,
) -> Result<Vec<u32>, Failure> {
    Ok(match (cell, shard) {
        (Some(cell), _) if cell >= cells => {
            let message = format!("there are only {cells} cells on level {level}");
            return Err(Failure::usage(message));
        }
        (Some(cell), _) => vec![cell],
        (None, Some(shard)) => shard.of_items(0..cells),
        (None, None) => (0..cells).collect(),
    })
}

/// Refines some cells of a result that does not fit into memory.
fn finish_apart(options: &Finish, work: &Work, console: &Console) -> Result<Outcome, Failure> {
    let plan = options.level.map_or_else(|| work.current(), |level| work.plan(level));
    let plan = plan.map_err(Failure::regions)?;
    let cells = match plan.next {
        _ if plan.results > 0 => plan.cells,
        Next::InMemory | Next::Done => 0,
        Next::Pass { .. } | Next::SeamStrips { .. } if options.level.is_some() => {
            return Err(Failure::usage(format!("level {} is no result", plan.level)));
        }
        Next::Pass { .. } | Next::SeamStrips { .. } => {
            let message = format!("reduce and join level {} first", plan.level);
            return Err(Failure::usage(message));
        }
    };
    let bar = console.progress_of_passes();
    let mut faces = 0;
    if cells > 0 {
        for cell in mine(options.cell, options.shard, plan.level, cells)? {
            let record = refine_cell(work, plan.level, cell, &mut |step| {
                large::show(&bar, step);
                !interrupt::is_asked_to_end()
            });
            faces += record.map_err(Failure::regions)?.faces;
        }
    }
    bar.finish_and_clear();
    let report = Report { level: plan.level, cells, faces, ..report(work, "finish", console) };
    let text = match cells {
        0 => "the result fits into memory: finish it as one mesh, with -o".to_owned(),
        _ => format!("refined cells of level {}: {}", plan.level, counted(faces, "faces")),
    };
    print(&report, &text, console)
}

fn finish_run(options: &Finish, session: &Session) -> Result<Outcome, Failure> {
    let console = &session.console;
    let work = open(&options.work_dir)?;
    let (count, source) = (work.targets().len(), &work.manifest().input);
    let name = Path::new(source.bytes.map_or("-", |_| &source.name));
    let paths_in = |folder| paths_of_levels(name, folder, count, &options.save, "ply");
    let is_folder = |output: &Path| large::is_folder(output, &options.save, count);
    let has_levels = count > 1 || options.output.as_deref().is_some_and(is_folder);
    let paths = match &options.output {
        Some(folder) if has_levels => paths_in(folder),
        output => output.iter().cloned().collect(),
    };
    paths.iter().try_for_each(|path| check_target(path, &options.save, &session.given))?;
    if paths.is_empty() {
        session.given.refuse(&SAVE_OPTIONS, "without -o no such file is written")?;
    }
    if options.cell.is_some() || options.shard.is_some() || options.level.is_some() {
        return finish_apart(options, &work, console);
    }
    if !work.fits() && !paths.iter().all(|path| large::takes_regions(path, &options.save)) {
        return Err(Failure::usage(large::ONLY_PLY));
    }
    let bar = console.progress_of_passes();
    let mut last = None;
    let outcome = run_rest(&work, &mut |step| {
        large::show(&bar, step);
        if options.tell_progress {
            tell(step, &mut last);
        }
        !interrupt::is_asked_to_end()
    });
    bar.finish_and_clear();
    let outcome = outcome.map_err(Failure::regions)?;
    let mut report = Report {
        // A run has at least one level, and at most 2^32 plans.
        level: as_u32(outcome.levels.len()) - 1,
        cells: outcome.cells.last().copied().unwrap_or(0),
        faces: outcome.faces,
        output: options.output.as_ref().map(|output| output.display().to_string()),
        error: outcome.error,
        ..report(&work, "finish", console)
    };
    if has_levels {
        if let Some(folder) = &options.tiles {
            let folders: Vec<PathBuf> =
                paths_in(folder).iter().map(|folder| folder.with_extension("")).collect();
            report.levels = large::save_tiles(&outcome, &work, &folders)?;
        }
        if options.output.is_some() {
            let levels = large::save_levels(&outcome, &work, &paths, &options.save, console)?;
            report.levels.extend(levels);
        }
        let lines: Vec<String> = report.levels.iter().map(ToString::to_string).collect();
        return print(&report, &lines.join("\n"), console);
    }
    if let Some(folder) = &options.tiles {
        let written = while_writing(folder, || write_tiles(&work, &outcome.result, folder))
            .map_err(Failure::regions)?;
        report.tiles = Some((folder.display().to_string(), written.tiles.len()));
    }
    if let Some(output) = &options.output {
        large::save_left(outcome.result, &work, output, &options.save, console)?;
    }
    let places = options.output.iter().chain(&options.tiles).map(|path| path.display().to_string());
    let places = places.collect::<Vec<_>>().join(", ");
    let text = format!("{places}: {}", counted(report.faces, "faces"));
    print(&report, &text, console)
}

/// Prints the progress if it differs from the last line by a percent.
fn tell(step: Step, last: &mut Option<(&'static str, u64)>) {
    let Step { what, done, of, .. } = step;
    let now = (what, 100 * done / of.max(1));
    if last.replace(now) != Some(now) {
        let _ = writeln!(std::io::stderr(), "progress: {what} {done} of {of}");
    }
}

fn report(work: &Work, step: &'static str, console: &Console) -> Report {
    Report {
        command: console.command().to_owned(),
        work_dir: work.folder().display().to_string(),
        step,
        level: 0,
        cells: 0,
        faces: 0,
        in_force: None,
        next: None,
        joined: None,
        apart: None,
        output: None,
        tiles: None,
        levels: Vec::new(),
        error: None,
    }
}

fn print(report: &Report, text: &str, console: &Console) -> Result<Outcome, Failure> {
    if console.is_json() {
        console.print(console.signed(report)?)?;
    } else {
        console.print(text)?;
    }
    Ok(Outcome::of_run())
}
