//! From a mesh to a file.

use std::path::Path;

use clap::{Args, ValueEnum};
use mesh_io::{Encoding, Format, Model, Precision, WriteError, WriteOptions, WriteReport};

use crate::console::Console;
use crate::failure::Failure;
use crate::interrupt::while_writing;

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

/// Writes a file, whole or not at all, and says what the format could not hold.
pub(crate) fn save(
    path: &Path,
    model: &Model,
    options: &SaveOptions,
    console: &Console,
) -> Result<(), Failure> {
    let written = while_writing(path, || mesh_io::write(path, model, &options.write_options()));
    explain(path, written, console)
}

/// Writes levels of detail into one file, whole or not at all.
pub(crate) fn save_levels(
    path: &Path,
    levels: &[Model],
    coverage: &[f64],
    options: &SaveOptions,
    console: &Console,
) -> Result<(), Failure> {
    let written = while_writing(path, || {
        mesh_io::write_levels(path, levels, coverage, &options.write_options())
    });
    explain(path, written, console)
}

/// Says what the format could not hold.
fn explain(
    path: &Path,
    written: Result<WriteReport, WriteError>,
    console: &Console,
) -> Result<(), Failure> {
    let report = written
        .map_err(|source| Failure::Write { path: path.to_owned(), source: Box::new(source) })?;
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
    Ok(())
}
