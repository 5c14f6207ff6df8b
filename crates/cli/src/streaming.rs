//! Meshes that are larger than memory and pass by: what is found out about them, or written of them.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::ProgressBar;
use mesh_io::Format;
use out_of_core::{Columns, Input, ScratchFolder, Spool, Step};

use crate::args::is_standard;
use crate::batch::Job;
use crate::console::Console;
use crate::failure::Failure;
use crate::interrupt::{is_asked_to_end, removes, while_writing};
use crate::large::is_beyond;
use crate::load::{Loading, Seconds, parse_bytes};
use crate::save::{SaveOptions, explain, make_folder_of};
use crate::task::Task;

/// How much memory a run may take, and where it keeps what does not fit.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Meshes larger than memory")]
pub(crate) struct Streaming {
    /// The most memory that the run may take, like 512MiB or 4G. A mesh that needs more is read as a
    /// stream, positions and faces alone, and done through files: PLY, STL and OBJ
    #[arg(id = "within", long = "memory", value_name = "BYTES", value_parser = parse_bytes)]
    memory: Option<u64>,
    /// The folder for these files, which are removed in the end [default: OUT.work, or without an output
    /// one in the system's folder for temporary files]
    #[arg(long, value_name = "DIR", requires = "within")]
    work_dir: Option<PathBuf>,
}

impl Streaming {
    /// Whether files have to pass by, as far as their lengths tell.
    pub(crate) fn is_needed(&self, inputs: &[&Path], loading: &Loading) -> Result<bool, Failure> {
        is_beyond(self.memory, inputs, loading)
    }

    /// Refuses repairs, which need the whole mesh.
    pub(crate) fn check(loading: &Loading) -> Result<(), Failure> {
        if loading.repair.any() {
            return Err(Failure::usage(
                "repairs need the whole mesh in memory, which --memory does not allow; repair the file first, \
                 or give more",
            ));
        }
        Ok(())
    }

    /// A folder for what lies on disk in the meantime.
    pub(crate) fn scratch(&self, output: Option<&Path>) -> Result<ScratchFolder, Failure> {
        let beside = |path: &Path| {
            let mut name = path.as_os_str().to_owned();
            name.push(".work");
            PathBuf::from(name)
        };
        let usual = || match output.filter(|output| !is_standard(output)) {
            Some(output) => beside(output),
            None => std::env::temp_dir().join(format!("curvmesh-{}.work", std::process::id())),
        };
        let folder = self.work_dir.clone().unwrap_or_else(usual);
        let scratch = ScratchFolder::new(&folder).map_err(Failure::regions)?;
        removes(&folder);
        Ok(scratch)
    }

    /// Reads the input of a task whose output, if there is one, is written as a stream. The folder is for
    /// as long as what was read is needed.
    pub(crate) fn spool_of(
        &self,
        task: &Task,
        job: &Job,
        seconds: &mut Seconds,
        console: &Console,
    ) -> Result<(Spool, ScratchFolder), Failure> {
        Self::check(&job.loading)?;
        if let Some(output) = &task.output {
            check_format(output, &job.save)?;
        }
        let scratch = self.scratch(task.output.as_deref())?;
        let spool = Seconds::time(&mut seconds.load, || {
            self.spool(&scratch, "mesh", &task.input, &job.loading, console)
        })?;
        Ok((spool, scratch))
    }

    /// Reads a file as a stream, and says what was passed over.
    pub(crate) fn spool(
        &self,
        scratch: &ScratchFolder,
        name: &str,
        input: &Path,
        loading: &Loading,
        console: &Console,
    ) -> Result<Spool, Failure> {
        let stream = &mut std::io::stdin();
        let source = if is_standard(input) {
            Input::Stream(stream, Path::new("<stdin>"))
        } else {
            Input::Path(input)
        };
        let memory = self.memory.unwrap_or(u64::MAX);
        let spool = with_bar(console, |see| {
            Spool::read(scratch, name, source, &loading.streaming(), memory, see)
        })?;
        for note in &spool.summary().notes {
            console.message(format_args!("{}: {note}", input.display()));
        }
        Ok(spool)
    }
}

/// Does something with a bar that tells how far it is.
pub(crate) fn with_bar<T>(
    console: &Console,
    act: impl FnOnce(&mut dyn FnMut(Step) -> bool) -> Result<T, out_of_core::Error>,
) -> Result<T, Failure> {
    let bar: ProgressBar = console.progress_of_passes();
    let result = act(&mut |step: Step| {
        bar.set_message(step.what);
        bar.set_length(step.of);
        bar.set_position(step.done);
        !is_asked_to_end()
    });
    bar.finish_and_clear();
    result.map_err(Failure::regions)
}

/// Refuses an output that cannot be written as a stream.
fn check_format(output: &Path, options: &SaveOptions) -> Result<Format, Failure> {
    match options.format_of(output) {
        Some(format @ (Format::Ply | Format::Stl | Format::Obj)) => Ok(format),
        _ => Err(Failure::usage(
            "what does not fit into the memory is written as PLY, STL or OBJ; give more memory for other formats",
        )),
    }
}

/// Writes the output, if one is asked for, and says what the format could not hold.
pub(crate) fn save(
    spool: &Spool,
    task: &Task,
    options: &SaveOptions,
    columns: Option<Columns<'_>>,
    console: &Console,
) -> Result<(), Failure> {
    let Some(output) = &task.output else { return Ok(()) };
    if task.makes_folder {
        make_folder_of(output)?;
    }
    let format = check_format(output, options)?;
    let settings = options.write_options();
    let report = if is_standard(output) {
        let mut stdout = BufWriter::new(std::io::stdout().lock());
        let report =
            spool.write_to(&mut stdout, format, &settings, columns).map_err(Failure::regions)?;
        stdout.flush().map_err(Failure::Stdout)?;
        report
    } else {
        while_writing(output, || {
            let staged = spool.stage(output, &settings, columns).map_err(Failure::regions)?;
            staged.commit().map_err(|error| Failure::write(output, error))
        })?
    };
    explain(output, &report, console);
    Ok(())
}
