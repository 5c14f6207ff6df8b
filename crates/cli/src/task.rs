//! The common steps of most commands: read a mesh, write a file, print a report.

use std::path::{Path, PathBuf};

use mesh_io::{CopiedPictures, Format, Model, Scene};
use mesh_work::Loaded;
use serde::Serialize;

use crate::args::is_standard;
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::load::{Loading, Seconds};
use crate::save::{SaveOptions, make_folder_of, save, save_scene};
use crate::text::printable;

/// A mesh to read.
#[derive(Debug, clap::Args)]
pub(crate) struct Source {
    /// The file to read; `-` is the standard input
    #[arg(value_name = "IN", help_heading = None)]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) loading: Loading,
}

/// One of the files of a run: the input, and the place of the result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Task {
    pub(crate) input: PathBuf,
    pub(crate) output: Option<PathBuf>,
    /// Whether the folder of the output is made if it does not exist.
    pub(crate) makes_folder: bool,
}

impl Task {
    /// Reads the mesh and joins the parts of split vertices; see [`Loading::load`].
    pub(crate) fn load(
        &self,
        loading: &Loading,
        seconds: &mut Seconds,
        console: &Console,
    ) -> Result<Loaded, Failure> {
        Seconds::time(&mut seconds.load, || loading.load(&self.input, console))
    }

    /// The format of the output, if it is asked for and known.
    pub(crate) fn written(&self, options: &SaveOptions) -> Option<Format> {
        self.output.as_ref().and_then(|output| options.format_of(output))
    }

    /// Writes the output, if one is asked for.
    pub(crate) fn save(
        &self,
        model: &Model,
        options: &SaveOptions,
        seconds: &mut Seconds,
        console: &Console,
    ) -> Result<(), Failure> {
        let Some(output) = &self.output else { return Ok(()) };
        Seconds::time(&mut seconds.save, || {
            if self.makes_folder {
                make_folder_of(output)?;
            }
            save(output, model, options, console)?;
            copy_pictures(&self.input, output, options, &model.file_pictures(), console);
            Ok(())
        })
    }

    /// Writes a scene.
    pub(crate) fn save_scene(
        &self,
        scene: &Scene,
        options: &SaveOptions,
        seconds: &mut Seconds,
        console: &Console,
    ) -> Result<(), Failure> {
        let Some(output) = &self.output else { return Ok(()) };
        Seconds::time(&mut seconds.save, || {
            if self.makes_folder {
                make_folder_of(output)?;
            }
            save_scene(output, scene, options, console)?;
            copy_pictures(&self.input, output, options, &scene.file_pictures(), console);
            Ok(())
        })
    }

    /// The report of a command on this file.
    pub(crate) fn report<T>(
        &self,
        console: &Console,
        counts: [usize; 2],
        results: T,
        seconds: Seconds,
    ) -> Report<T> {
        let report = Report::new(console, &self.input, counts, results, seconds);
        match &self.output {
            Some(output) => report.with_output(output),
            None => report,
        }
    }
}

/// Copies the pictures that an output names from the folder of the input to its folder, and reports it.
pub(crate) fn copy_pictures(
    input: &Path,
    output: &Path,
    options: &SaveOptions,
    names: &[impl AsRef<str>],
    console: &Console,
) {
    let format = options.format_of(output);
    let (Some(Format::Obj | Format::Gltf | Format::Glb), Some(first)) = (format, names.first())
    else {
        return;
    };
    let name = printable(output.display());
    let tell = |message: String| {
        console.message(format_args!("{name}: {message}"));
        console.stays(&name, &message);
    };
    let folder = |path: &Path| path.parent().map(Path::to_owned).unwrap_or_default();
    if is_standard(input) || is_standard(output) {
        tell(format!(
            "it names {} in files beside the input, such as {}; copy them to its folder",
            counted(names.len(), "pictures"),
            printable(first.as_ref())
        ));
        return;
    }
    let CopiedPictures { copied, left_out } =
        mesh_io::copy_pictures(names, &folder(input), &folder(output));
    if let Some(first) = copied.first() {
        let (count, first) = (counted(copied.len(), "pictures"), printable(first.display()));
        console.message(format_args!("{name}: copied {count} that it names, such as {first}"));
    }
    if let Some((first, error)) = left_out.first() {
        let (count, first) = (counted(left_out.len(), "pictures"), printable(first));
        tell(format!("it names {count} that could not be copied, such as {first}: {error}"));
    }
}

/// The first and last keys of the reports of all commands.
#[derive(Serialize)]
pub(crate) struct Report<T> {
    command: String,
    input: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<String>,
    pub(crate) vertices: usize,
    pub(crate) faces: usize,
    #[serde(flatten)]
    pub(crate) results: T,
    pub(crate) seconds: Seconds,
}

/// The report of a command about one file.
#[derive(Debug)]
pub(crate) struct Done {
    /// As JSON; empty unless asked for.
    pub(crate) json: String,
    /// As text.
    pub(crate) text: String,
    /// In a few words, for a table.
    pub(crate) brief: String,
    pub(crate) seconds: f64,
}

impl<T> Report<T> {
    /// The report of a command on a file with these numbers of vertices and faces.
    pub(crate) fn new(
        console: &Console,
        input: &Path,
        [vertices, faces]: [usize; 2],
        results: T,
        seconds: Seconds,
    ) -> Self {
        let command = console.command().to_owned();
        let input = input.display().to_string();
        Self { command, input, output: None, vertices, faces, results, seconds: seconds.summed() }
    }

    /// With the name of the written file.
    pub(crate) fn with_output(self, output: &Path) -> Self {
        Self { output: Some(output.display().to_string()), ..self }
    }

    /// The subject of a line of text: the output if there is one, else the input.
    pub(crate) fn input(&self) -> &Path {
        Path::new(&self.input)
    }

    pub(crate) fn subject(&self) -> String {
        printable(self.output.as_deref().unwrap_or(&self.input))
    }
}

impl<T: Serialize> Report<T> {
    /// The report in its printed forms: a text, and a few words.
    pub(crate) fn done(
        &self,
        console: &Console,
        text: String,
        brief: String,
    ) -> Result<Done, Failure> {
        let json = if console.is_json() { console.signed(self)? } else { String::new() };
        Ok(Done { json, text, brief, seconds: self.seconds.total })
    }
}

impl Done {
    /// Prints the report of a run on a single file.
    pub(crate) fn print(&self, console: &Console) -> Result<(), Failure> {
        console.print(if console.is_json() { &self.json } else { &self.text })
    }
}
