//! Streaming of meshes larger than memory: reading to disk, measuring, writing.

use std::ffi::OsStr;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::ProgressBar;
use mesh_io::Format;
use out_of_core::{Columns, DiskMesh, Input, ScratchFolder, Step};

use crate::args::is_standard;
use crate::batch::Job;
use crate::console::Console;
use crate::failure::Failure;
use crate::interrupt::{is_asked_to_end, removes, while_writing};
use crate::large::is_beyond;
use crate::load::{Loading, Seconds, parse_bytes};
use crate::save::{SaveOptions, explain, make_folder_of};
use crate::task::Task;

/// The memory limit of a run, and the folder for temporary files.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Meshes larger than memory")]
pub(crate) struct Streaming {
    /// The memory limit, such as 512MiB or 4G. A mesh that needs more is streamed through temporary files,
    /// with positions and faces only
    #[arg(id = "within", long = "memory", value_name = "BYTES", value_parser = parse_bytes)]
    memory: Option<u64>,
    /// Where to create the folder for temporary files, which is removed at the end [default: the folder of
    /// the output, or the system's folder for temporary files]
    #[arg(long, value_name = "DIR", requires = "within")]
    work_dir: Option<PathBuf>,
}

impl Streaming {
    /// Whether files are streamed, judged by their lengths.
    pub(crate) fn is_needed(&self, inputs: &[&Path], loading: &Loading) -> Result<bool, Failure> {
        is_beyond(self.memory, inputs, loading)
    }

    /// Refuses repairs, which need the whole mesh in memory.
    pub(crate) fn check(loading: &Loading) -> Result<(), Failure> {
        if loading.repair.any() {
            return Err(Failure::usage(
                "repairs need the whole mesh in memory, which --memory does not allow; repair the file first, \
                 or give more",
            ));
        }
        Ok(())
    }

    /// A folder for temporary files.
    pub(crate) fn scratch(&self, output: Option<&Path>) -> Result<ScratchFolder, Failure> {
        let output = output.filter(|output| !is_standard(output));
        let name = output.and_then(Path::file_name).unwrap_or(OsStr::new("curvmesh"));
        let beside =
            || output.and_then(Path::parent).map_or_else(std::env::temp_dir, Path::to_owned);
        let parent = self.work_dir.clone().unwrap_or_else(beside);
        let scratch = ScratchFolder::new(&parent, name).map_err(Failure::regions)?;
        removes(scratch.path());
        Ok(scratch)
    }

    /// Reads the input of a task as a stream. Refuses an output that cannot be written as a stream. The scratch folder
    /// must outlive the mesh.
    pub(crate) fn disk_mesh_of(
        &self,
        task: &Task,
        job: &Job,
        seconds: &mut Seconds,
        console: &Console,
    ) -> Result<(DiskMesh, ScratchFolder), Failure> {
        Self::check(&job.loading)?;
        if let Some(output) = &task.output {
            check_format(output, &job.save)?;
        }
        let scratch = self.scratch(task.output.as_deref())?;
        let disk_mesh = Seconds::time(&mut seconds.load, || {
            self.disk_mesh(&scratch, "mesh", &task.input, &job.loading, console)
        })?;
        Ok((disk_mesh, scratch))
    }

    /// Reads a file as a stream, and reports what was omitted.
    pub(crate) fn disk_mesh(
        &self,
        scratch: &ScratchFolder,
        name: &str,
        input: &Path,
        loading: &Loading,
        console: &Console,
    ) -> Result<DiskMesh, Failure> {
        let stream = &mut std::io::stdin();
        let source = if is_standard(input) {
            Input::Stream(stream, Path::new("<stdin>"))
        } else {
            Input::Path(input)
        };
        let memory = self.memory.unwrap_or(u64::MAX);
        let options = loading.streaming()?;
        let disk_mesh =
            with_bar(console, |see| DiskMesh::read(scratch, name, source, &options, memory, see))?;
        for note in &disk_mesh.summary().notes {
            console.message(format_args!("{}: {note}", input.display()));
        }
        Ok(disk_mesh)
    }
}

/// Shows a progress bar during an operation.
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

/// Refuses an output format that cannot be written as a stream.
fn check_format(output: &Path, options: &SaveOptions) -> Result<Format, Failure> {
    match options.format_of(output) {
        Some(format @ (Format::Ply | Format::Stl | Format::Obj)) => Ok(format),
        _ => Err(Failure::usage(
            "a mesh larger than --memory is written as PLY, STL or OBJ; allow more memory for other formats",
        )),
    }
}

/// Writes the output, if there is one, and reports what the format cannot hold.
pub(crate) fn save(
    disk_mesh: &DiskMesh,
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
        let report = disk_mesh
            .write_to(&mut stdout, format, &settings, columns)
            .map_err(Failure::regions)?;
        stdout.flush().map_err(Failure::Stdout)?;
        report
    } else {
        while_writing(output, || {
            let staged = disk_mesh.stage(output, &settings, columns).map_err(Failure::regions)?;
            staged.commit().map_err(|error| Failure::write(output, error))
        })?
    };
    explain(output, &report, console);
    Ok(())
}
