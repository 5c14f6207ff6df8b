//! Saving a mesh to a file.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use mesh_io::{
    Compression, Encoding, Format, Model, Precision, Quantization, Scene, Staged, StlColors,
    WriteError, WriteOptions, WriteReport,
};

use crate::args::{FormatName, is_standard};
use crate::console::Console;
use crate::failure::Failure;
use crate::given::Given;
use crate::interrupt::{while_writing, while_writing_all};
use crate::text::printable;

/// How output files are written.
#[derive(Clone, Copy, Debug, Default, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct SaveOptions {
    /// The format of the output [default: by its extension]
    #[arg(long, value_name = "FORMAT", alias = "format")]
    pub(crate) to: Option<FormatName>,
    /// Text or binary
    #[arg(long, value_enum, default_value_t)]
    pub(crate) encoding: EncodingName,
    /// Width of the numbers in PLY: `exact` takes 32 bits where they suffice, 64 otherwise
    #[arg(long, value_enum, default_value_t)]
    pub(crate) precision: PrecisionName,
    /// Let the companion files of an OBJ file, its material library and pictures, replace any file
    ///
    /// Without this option, they replace only files of an earlier run with the same output.
    #[arg(long)]
    pub(crate) overwrite_companions: bool,
    /// How a binary STL file stores the colours of faces
    #[arg(long, value_enum, default_value_t)]
    pub(crate) stl_colors: StlColorsName,
    /// Compress the data of a glTF or GLB file
    ///
    /// All values stay the same. Programs that read the file must know the extension `EXT_meshopt_compression`.
    #[arg(long, value_enum, value_name = "HOW", default_value_t)]
    pub(crate) compress: CompressName,
    /// Round the data of a glTF or GLB file to integers: positions and texture coordinates of BITS bits, from 8 to 16
    /// [default: 16], and normals, tangents, colours and weights of 8 bits
    ///
    /// Programs that read the file must know the extension `KHR_mesh_quantization`. Errors and error limits of scenes
    /// include the rounding.
    #[arg(
        long,
        value_name = "BITS",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "16",
        value_parser = clap::value_parser!(u8).range(8..=16)
    )]
    pub(crate) quantize: Option<u8>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum CompressName {
    #[default]
    None,
    /// Order triangles for the vertex cache, and store differences in few bits
    Meshopt,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum StlColorsName {
    /// As VisCAM and SolidView write them
    #[default]
    Viscam,
    /// As Materialise Magics writes them
    Magics,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum EncodingName {
    /// The usual encoding of the format
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

impl SaveOptions {
    /// The format of an output: as given, or by its extension.
    pub(crate) fn format_of(&self, path: &Path) -> Option<Format> {
        self.to.map(Format::from).or_else(|| Format::from_extension(path))
    }

    pub(crate) fn write_options(&self) -> WriteOptions {
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
        let format = self.to.map(Format::from);
        let overwrite_companions = self.overwrite_companions;
        let stl_colors = match self.stl_colors {
            StlColorsName::Viscam => StlColors::Viscam,
            StlColorsName::Magics => StlColors::Magics,
        };
        let compression = match self.compress {
            CompressName::None => Compression::None,
            CompressName::Meshopt => Compression::Meshopt,
        };
        let quantization = self.quantization();
        WriteOptions {
            format,
            encoding,
            precision,
            overwrite_companions,
            stl_colors,
            compression,
            quantization,
        }
    }

    pub(crate) fn quantization(&self) -> Option<Quantization> {
        self.quantize.map(Quantization::with_bits)
    }
}

/// The options of [`SaveOptions`].
pub(crate) const SAVE_OPTIONS: [&str; 7] =
    ["to", "encoding", "precision", "overwrite_companions", "stl_colors", "compress", "quantize"];

/// Refuses an output that cannot be written as asked, before any work is done.
pub(crate) fn check_target(
    path: &Path,
    options: &SaveOptions,
    given: &Given,
) -> Result<(), Failure> {
    let Some(format) = options.format_of(path) else {
        let message = if is_standard(path) {
            "the standard output has no extension that names its format; add --to, as in --to ply"
                .to_owned()
        } else {
            format!(
                "{}: the extension names no format; use .obj, .ply, .stl, .off, .gltf or .glb, or --to",
                path.display()
            )
        };
        return Err(Failure::usage(message));
    };
    if format != Format::Ply {
        given
            .refuse(&["precision"], "it is for PLY, the other formats have one width of numbers")?;
    }
    if format != Format::Stl {
        given.refuse(&["stl_colors"], "it is for STL")?;
    }
    if !matches!(format, Format::Gltf | Format::Glb) {
        given.refuse(&["compress", "quantize"], "it is for glTF and GLB")?;
    }
    if format != Format::Obj || is_standard(path) {
        given.refuse(&["overwrite_companions"], "it is for the files that go with an OBJ file")?;
    }
    // The library knows the encodings of each format.
    match mesh_io::check_write(&Model::default(), format, &options.write_options()) {
        Err(error @ WriteError::NoSuchEncoding { .. }) => Err(Failure::usage(error)),
        _ => Ok(()),
    }
}

/// Refuses a file in a folder that does not exist, before any work is done.
pub(crate) fn check_folder_of(path: &Path) -> Result<(), Failure> {
    match path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        Some(folder) if !folder.is_dir() => {
            let folder = printable(folder.display());
            let message = format!("there is no folder {folder}; make it first");
            Err(Failure::write(path, std::io::Error::new(ErrorKind::NotFound, message)))
        }
        _ => Ok(()),
    }
}

/// Writes a file, whole or not at all, and reports losses.
pub(crate) fn save(
    path: &Path,
    model: &Model,
    options: &SaveOptions,
    console: &Console,
) -> Result<(), Failure> {
    console.compare_with_input(model);
    let settings = options.write_options();
    let written = match options.format_of(path) {
        Some(format) if is_standard(path) => {
            let mut bytes = Vec::new();
            let written = mesh_io::write_to(&mut bytes, model, format, &settings);
            if written.is_ok() {
                to_stdout(&bytes)?;
            }
            written
        }
        _ => while_writing(path, || mesh_io::write(path, model, &settings)),
    };
    let report = written.map_err(|source| Failure::write(path, source))?;
    explain(path, &report, console);
    Ok(())
}

/// Writes a scene, whole or not at all, and reports losses.
pub(crate) fn save_scene(
    path: &Path,
    scene: &Scene,
    options: &SaveOptions,
    console: &Console,
) -> Result<(), Failure> {
    let written = match options.format_of(path) {
        Some(format) if is_standard(path) => {
            let mut bytes = Vec::new();
            let written = scene.write_with(&mut bytes, format, &options.write_options());
            if written.is_ok() {
                to_stdout(&bytes)?;
            }
            written
        }
        _ => while_writing(path, || scene.write(path, &options.write_options())),
    };
    let report = written.map_err(|source| Failure::write(path, source))?;
    explain(path, &report, console);
    Ok(())
}

/// Writes a complete file that is not yet in its place.
type Stage<'b> = Box<dyn FnOnce() -> Result<Staged, WriteError> + 'b>;

/// Files that belong together: all of them are complete on the disk before the first is moved to its place.
#[derive(Default)]
pub(crate) struct Outputs<'b> {
    files: Vec<(&'b Path, Stage<'b>)>,
}

impl<'b> Outputs<'b> {
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

    /// Adds a scene.
    pub(crate) fn add_scene(&mut self, path: &'b Path, scene: &'b Scene, options: &SaveOptions) {
        let options = options.write_options();
        self.add(path, move || scene.stage(path, &options));
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

    /// Writes the files, and reports what their formats could not hold.
    pub(crate) fn write(self, console: &Console) -> Result<(), Failure> {
        let paths: Vec<&Path> = self.files.iter().map(|(path, _)| *path).collect();
        let reports = while_writing_all(&paths, || {
            let stage = |(path, stage): (&Path, Stage<'b>)| {
                stage().map_err(|error| Failure::write(path, error))
            };
            let staged: Vec<Staged> =
                self.files.into_iter().map(stage).collect::<Result<_, Failure>>()?;
            let commit = |(staged, path): (Staged, &&Path)| {
                staged.commit().map_err(|error| Failure::write(path, error))
            };
            staged.into_iter().zip(&paths).map(commit).collect::<Result<Vec<_>, Failure>>()
        })?;
        paths.iter().zip(&reports).for_each(|(path, report)| explain(path, report, console));
        Ok(())
    }
}

/// Writes data other than meshes: to a file, whole or not at all, or to the standard output.
pub(crate) fn save_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if is_standard(path) {
        return to_stdout(bytes);
    }
    while_writing(path, || mesh_io::replace_file(path, |writer| writer.write_all(bytes)))
        .map_err(|source| Failure::write(path, source))
}

fn to_stdout(bytes: &[u8]) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(bytes).and_then(|()| stdout.flush()).map_err(Failure::Stdout)
}

/// The files of levels of detail in a folder, from the finest: named after the input, and in the usual format unless
/// another one is given.
pub(crate) fn paths_of_levels(
    input: &Path,
    folder: &Path,
    count: usize,
    options: &SaveOptions,
    usual: &str,
) -> Vec<PathBuf> {
    let stem = match input.file_stem() {
        Some(stem) if !is_standard(input) => stem.to_string_lossy(),
        _ => "level".into(),
    };
    let extension = options.to.map_or(usual, |name| Format::from(name).extension());
    (1..=count).map(|level| folder.join(format!("{stem}-{level}.{extension}"))).collect()
}

/// Makes the folder of a file.
pub(crate) fn make_folder_of(path: &Path) -> Result<(), Failure> {
    match path.parent() {
        Some(folder) => {
            std::fs::create_dir_all(folder).map_err(|source| Failure::write(folder, source))
        }
        None => Ok(()),
    }
}

/// Reports what the format could not hold.
pub(crate) fn explain(path: &Path, report: &WriteReport, console: &Console) {
    let name = printable(path.display());
    if report.rounding > 0.0 {
        let rounding = report.rounding;
        console.message(format_args!("{name}: coordinates were rounded by up to {rounding:.2e}"));
        console.rounded(rounding);
    }
    for stayed in &report.stayed {
        console.message(format_args!("{name}: {stayed}"));
        console.stays(&name, stayed);
    }
    for kept in &report.kept {
        let kept = printable(kept.display());
        console.message(format_args!("{kept}: was there already and stays as it is"));
    }
    for lost in &report.lost {
        console.message(format_args!("{name}: lost {lost}"));
        console.lose(&name, "writing", lost);
    }
    console.wrote();
}
