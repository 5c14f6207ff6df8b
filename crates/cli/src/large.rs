//! Meshes that are larger than the memory they may take.

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::ProgressBar;
use mesh_core::build::Weld;
use mesh_io::{Format, Model};
use out_of_core::{Input, Left, Outcome, Repairs, Settings, Sizes, Step, Work};
use simplify::Options;

use crate::args::{RepairOptions, is_standard};
use crate::console::Console;
use crate::failure::Failure;
use crate::interrupt;
use crate::interrupt::while_writing;
use crate::load::{Loading, parse_bytes};
use crate::save::{SaveOptions, save};

/// How much memory a run may take, and where it keeps what does not fit.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Meshes larger than memory")]
pub(crate) struct Large {
    /// The most memory that the run may take, like 512MiB or 4G. A mesh that needs more is done region
    /// by region, through files
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub(crate) memory: Option<u64>,
    /// The folder for these files [default: OUT.work, which is removed in the end]
    #[arg(long, value_name = "DIR", requires = "memory")]
    pub(crate) work_dir: Option<PathBuf>,
}

impl Large {
    /// Whether a file has to be done region by region, as far as its length tells.
    pub(crate) fn is_needed(&self, input: &Path, loading: &Loading) -> Result<bool, Failure> {
        is_beyond(self.memory, &[input], loading)
    }

    /// Where the files go.
    pub(crate) fn folder(&self, output: &Path) -> PathBuf {
        self.work_dir.clone().unwrap_or_else(|| {
            let mut name = output.as_os_str().to_owned();
            name.push(".work");
            name.into()
        })
    }
}

/// Whether files need more memory than that, as far as their lengths tell.
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

/// About how many bytes a mesh takes while it is read and simplified in one piece.
fn whole(bytes: u64, format: Option<Format>) -> u64 {
    // 400 bytes for a face, which takes some 19 bytes in PLY, 50 in STL and 35 in OBJ.
    (24 << 20)
        + bytes
            * match format {
                Some(Format::Stl) => 8,
                Some(Format::Ply) => 21,
                _ => 12,
            }
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
    let repair = options.repair(Weld::None);
    Ok(Repairs { drop_degenerate: repair.drop_degenerate, cut: repair.cut_non_manifold })
}

/// The share of the diagonal up to which distances are proved, pass by pass.
pub(crate) const PROVED: f64 = 1e-4;

/// Splits a file into regions; what was split before stays.
pub(crate) fn split_file(
    input: &Path,
    folder: &Path,
    loading: &Loading,
    settings: Settings,
    console: &Console,
) -> Result<Work, Failure> {
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
    let work = Work::split(folder, source, &loading.streaming(), settings, see);
    bar.finish_and_clear();
    let work = work.map_err(Failure::regions)?;
    for note in &work.manifest().summary.notes {
        console.message(format_args!("{}: {note}", input.display()));
    }
    Ok(work)
}

/// Simplifies a file region by region.
pub(crate) fn simplify_file(
    input: &Path,
    folder: &Path,
    resume: bool,
    loading: &Loading,
    settings: Settings,
    console: &Console,
) -> Result<(Outcome, Work), Failure> {
    if folder.join("run.json").exists() && !resume {
        return Err(Failure::usage(format!(
            "{}: there is an earlier run in this folder; go on with it with --resume, or remove it",
            folder.display()
        )));
    }
    let work = split_file(input, folder, loading, settings, console)?;
    let bar = console.progress_of_passes();
    let outcome = out_of_core::run(&work, &mut |step| {
        show(&bar, step);
        !interrupt::is_asked_to_end()
    });
    bar.finish_and_clear();
    Ok((outcome.map_err(Failure::regions)?, work))
}

/// Writes what is left: a mesh in any format, or the regions of one that does not fit, as PLY.
pub(crate) fn save_left(
    left: Left,
    work: &Work,
    output: &Path,
    options: &SaveOptions,
    console: &Console,
) -> Result<(), Failure> {
    match left {
        Left::Mesh(mesh) => save(output, &Model::from(mesh.to_soup()), options, console),
        Left::Regions { level } => {
            if options.format_of(output) != Some(Format::Ply) || is_standard(output) {
                return Err(Failure::usage(
                    "a result that does not fit into the memory is written as a PLY file",
                ));
            }
            while_writing(output, || out_of_core::assemble(work, level, output))
                .map_err(Failure::regions)?;
            Ok(())
        }
    }
}

/// What a run in so many bytes is to do.
pub(crate) fn settings(
    options: Options,
    memory: u64,
    repair: &RepairOptions,
    prove: Option<f64>,
) -> Result<Settings, Failure> {
    let sizes = Sizes::within(memory, &options, prove.is_some()).map_err(Failure::regions)?;
    Ok(Settings { options, repairs: repairs(repair)?, sizes, prove })
}

/// Moves the bar to where a step has come.
pub(crate) fn show(bar: &ProgressBar, step: Step) {
    let Step { what, done, of, level } = step;
    bar.set_message(format!("pass {}: {what}", level + 1));
    bar.set_length(of);
    bar.set_position(done);
}

/// Removes a folder of a run that is done with, if it is one that nobody asked for.
pub(crate) fn remove(work: Work, large: &Large) {
    if large.work_dir.is_none() {
        work.remove();
    }
}
