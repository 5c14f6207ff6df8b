//! What most commands share: a mesh comes in, a file goes out, and a report is printed.

use std::path::{Path, PathBuf};

use mesh_io::Model;
use serde::Serialize;

use crate::args::RepairOptions;
use crate::console::Console;
use crate::failure::Failure;
use crate::load::{Loaded, Seconds, load, load_whole};
use crate::save::{SaveOptions, check_target, save};

/// A mesh to read.
#[derive(Debug, clap::Args)]
pub(crate) struct Source {
    /// The file to read
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) repair: RepairOptions,
}

impl Source {
    /// Reads the mesh, the parts of split vertices joined; see [`load_whole`].
    pub(crate) fn load_whole(
        &self,
        seconds: &mut Seconds,
        console: &Console,
    ) -> Result<Loaded, Failure> {
        Seconds::time(&mut seconds.load, || load_whole(&self.input, &self.repair, console))
    }
}

/// Options of the commands that turn a mesh into a file.
#[derive(Debug, clap::Args)]
pub(crate) struct Job {
    #[command(flatten)]
    pub(crate) source: Source,
    /// The file to write
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) save: SaveOptions,
}

impl Job {
    /// Reads the mesh, once it is clear that the output can be written as asked.
    pub(crate) fn load(&self, seconds: &mut Seconds, console: &Console) -> Result<Loaded, Failure> {
        check_target(&self.output, &self.save)?;
        let Source { input, repair } = &self.source;
        Seconds::time(&mut seconds.load, || load(input, repair, console))
    }

    /// As [`Job::load`], with the parts of split vertices joined.
    pub(crate) fn load_whole(
        &self,
        seconds: &mut Seconds,
        console: &Console,
    ) -> Result<Loaded, Failure> {
        check_target(&self.output, &self.save)?;
        self.source.load_whole(seconds, console)
    }

    /// Writes the output.
    pub(crate) fn save(
        &self,
        model: &Model,
        seconds: &mut Seconds,
        console: &Console,
    ) -> Result<(), Failure> {
        Seconds::time(&mut seconds.save, || save(&self.output, model, &self.save, console))
    }
}

/// The keys that the reports of all commands begin and end with.
#[derive(Serialize)]
pub(crate) struct Report<T> {
    command: &'static str,
    input: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<String>,
    pub(crate) vertices: usize,
    pub(crate) faces: usize,
    #[serde(flatten)]
    pub(crate) results: T,
    pub(crate) seconds: Seconds,
}

impl<T> Report<T> {
    /// The report of a command on a file with so many vertices and faces.
    pub(crate) fn new(
        command: &'static str,
        input: &Path,
        [vertices, faces]: [usize; 2],
        results: T,
        seconds: Seconds,
    ) -> Self {
        let input = input.display().to_string();
        Self { command, input, output: None, vertices, faces, results, seconds: seconds.summed() }
    }

    /// With the file that was written.
    pub(crate) fn with_output(self, output: &Path) -> Self {
        Self { output: Some(output.display().to_string()), ..self }
    }

    /// What the report is about, for a line of text: the output if there is one.
    pub(crate) fn subject(&self) -> &str {
        self.output.as_deref().unwrap_or(&self.input)
    }
}
