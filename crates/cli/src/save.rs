//! From a mesh to a file.

use std::path::Path;

use clap::{Args, ValueEnum};
use mesh_io::{Encoding, Format, Model, Precision, Staged, WriteError, WriteOptions, WriteReport};

use crate::console::Console;
use crate::failure::Failure;
use crate::interrupt::while_writing_all;

/// How output files are written.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct SaveOptions {
    /// The format of the output [default: by its extension]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) format: Option<FormatName>,
    /// Text or binary
    #[arg(long, value_enum, default_value_t)]
    pub(crate) encoding: EncodingName,
    /// Width of the numbers in PLY: `exact` takes 32 bits where they suffice, 64 otherwise
    #[arg(long, value_enum, default_value_t)]
    pub(crate) precision: PrecisionName,
    /// Let the material library and the pictures beside an OBJ file replace files of others
    ///
    /// Without it they replace only those of an earlier run with the same output.
    #[arg(long)]
    pub(crate) overwrite_companions: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FormatName {
    Obj,
    Ply,
    Stl,
    Off,
    Gltf,
    Glb,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum EncodingName {
    /// What is usual for the format
    #[default]
    Usual,
    Text,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum PrecisionName {
    #[default]
    Exact,
    Single,
    Double,
}

impl From<FormatName> for Format {
    fn from(name: FormatName) -> Self {
        match name {
            FormatName::Obj => Self::Obj,
            FormatName::Ply => Self::Ply,
            FormatName::Stl => Self::Stl,
            FormatName::Off => Self::Off,
            FormatName::Gltf => Self::Gltf,
            FormatName::Glb => Self::Glb,
        }
    }
}

impl SaveOptions {
    /// The extension of the format, if one is named.
    pub(crate) fn extension(&self) -> Option<&'static str> {
        self.format.map(|name| Format::from(name).extension())
    }

    fn write_options(&self) -> WriteOptions {
        let encoding = match self.encoding {
            EncodingName::Usual => Encoding::Usual,
            EncodingName::Text => Encoding::Text,
            EncodingName::LittleEndian => Encoding::LittleEndian,
            EncodingName::BigEndian => Encoding::BigEndian,
        };
        let precision = match self.precision {
            PrecisionName::Exact => Precision::Exact,
            PrecisionName::Single => Precision::Single,
            PrecisionName::Double => Precision::Double,
        };
        let format = self.format.map(Format::from);
        let overwrite_companions = self.overwrite_companions;
        WriteOptions { format, encoding, precision, overwrite_companions }
    }
}

/// Refuses an output path whose extension names no format before any work is done.
pub(crate) fn check_target(path: &Path, options: &SaveOptions) -> Result<(), Failure> {
    if options.format.is_some() || Format::from_extension(path).is_some() {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{}: the extension names no format; use .obj, .ply, .stl, .off, .gltf or .glb, or --format",
        path.display()
    )))
}

/// Makes a file that is whole but has not taken its place.
type Stage<'b> = Box<dyn FnOnce() -> Result<Staged, WriteError> + 'b>;

/// Files that belong together: all of them are whole on the disk before the first takes its place.
#[derive(Default)]
pub(crate) struct Batch<'b> {
    files: Vec<(&'b Path, Stage<'b>)>,
}

impl<'b> Batch<'b> {
    /// Adds a file of any kind.
    pub(crate) fn add(
        &mut self,
        path: &'b Path,
        stage: impl FnOnce() -> Result<Staged, WriteError> + 'b,
    ) {
        self.files.push((path, Box::new(stage)));
    }

    /// Adds a mesh.
    pub(crate) fn add_model(&mut self, path: &'b Path, model: &'b Model, options: &SaveOptions) {
        let options = options.write_options();
        self.add(path, move || mesh_io::stage(path, model, &options));
    }

    /// Adds levels of detail in one file.
    pub(crate) fn add_levels(
        &mut self,
        path: &'b Path,
        levels: &'b [Model],
        coverage: &'b [f64],
        options: &SaveOptions,
    ) {
        let options = options.write_options();
        self.add(path, move || mesh_io::stage_levels(path, levels, coverage, &options));
    }

    /// Writes the files, and says what their formats could not hold.
    pub(crate) fn write(self, console: &Console) -> Result<(), Failure> {
        let paths: Vec<&Path> = self.files.iter().map(|(path, _)| *path).collect();
        let failed = |path: &Path, source| Failure::Write {
            path: path.to_owned(),
            source: Box::new(source),
        };
        let reports = while_writing_all(&paths, || {
            let stage = |(path, stage): (_, Stage<'b>)| stage().map_err(|e| failed(path, e));
            let staged: Vec<Staged> =
                self.files.into_iter().map(stage).collect::<Result<_, Failure>>()?;
            let commit = |(staged, path): (Staged, &&Path)| {
                staged.commit().map_err(|error| failed(path, error))
            };
            staged.into_iter().zip(&paths).map(commit).collect::<Result<Vec<_>, Failure>>()
        })?;
        paths.iter().zip(&reports).for_each(|(path, report)| explain(path, report, console));
        Ok(())
    }
}

/// Writes a file, whole or not at all, and says what the format could not hold.
pub(crate) fn save(
    path: &Path,
    model: &Model,
    options: &SaveOptions,
    console: &Console,
) -> Result<(), Failure> {
    let mut batch = Batch::default();
    batch.add_model(path, model, options);
    batch.write(console)
}

/// Says what the format could not hold.
fn explain(path: &Path, report: &WriteReport, console: &Console) {
    if report.rounding > 0.0 {
        console.message(format_args!(
            "{}: coordinates were rounded by up to {:.2e}",
            path.display(),
            report.rounding
        ));
    }
    for kept in &report.kept {
        console.message(format_args!("{}: was there already and stays as it is", kept.display()));
    }
    for dropped in &report.dropped {
        console.message(format_args!("{}: the format has no place for {dropped}", path.display()));
    }
}
