//! Writing a file of any format.

use crate::atomic::{self, Beside};
use crate::error::WriteError;
use crate::format::Format;
use crate::losses::{Target, losses};
use crate::model::{ImageData, Model};
use crate::single::check_range;
use crate::smoothing::with_normals;
use crate::to_model::ToModel;
use crate::write_options::{Compression, Encoding, Precision, WriteOptions, WriteReport};
#[cfg(feature = "gltf")]
use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

/// Writes a model or a mesh to a file, in the format given by the options or the extension.
///
/// The file is written beside the target and renamed when it is complete. So after any failure the target is either the
/// old file or the new one.
///
/// An OBJ file gets a material library, `NAME.mtl`, and its embedded images as files beside it. It gets none if the
/// libraries named in the model exist already, or if nothing is known of its materials. These companions are never
/// written through a link. They replace only companions of an earlier run of the same output, which are recognised by a
/// checksum in the library, unless [`WriteOptions::overwrite_companions`] is set. Images in files keep their names,
/// which are relative to the OBJ or glTF file. A target that is a pipe or a device gets no companions.
///
/// ```no_run
/// use mesh_core::TriMesh;
/// use mesh_io::WriteOptions;
///
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = TriMesh::from_triangles(&corners, &[[0, 1, 2]])?;
/// mesh_io::write("triangle.ply", &mesh, &WriteOptions::default())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A [`WriteError`]. Nothing has been written then. (Only if a *rename* fails, the companions may have been replaced
/// already.)
pub fn write<M: ToModel + ?Sized>(
    path: impl AsRef<Path>,
    model: &M,
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    stage(path, model, options)?.commit()
}

/// A file and its companions, complete and on the disk under temporary names beside their targets.
///
/// [`Staged::commit`] moves them to their targets; dropping removes them. With several such values, all slow steps that
/// can fail are done before the first old file is replaced.
#[derive(Debug)]
#[must_use = "the file takes its place when it is committed"]
pub struct Staged {
    companions: Vec<Beside>,
    file: Beside,
    report: WriteReport,
}

impl Staged {
    /// A file without companions.
    pub(crate) fn new(file: Beside, report: WriteReport) -> Self {
        Self { companions: Vec::new(), file, report }
    }

    /// The report of the files to be written.
    #[must_use]
    pub fn report(&self) -> &WriteReport {
        &self.report
    }

    /// Replaces the files at the targets, companions first.
    ///
    /// # Errors
    /// A file cannot be renamed; its target is unchanged.
    pub fn commit(self) -> Result<WriteReport, WriteError> {
        self.companions.into_iter().try_for_each(Beside::commit)?;
        self.file.commit()?;
        Ok(self.report)
    }
}

/// Does everything that [`write()`] does except the last step, [`Staged::commit`].
///
/// # Errors
/// As [`write()`].
pub fn stage<M: ToModel + ?Sized>(
    path: impl AsRef<Path>,
    model: &M,
    options: &WriteOptions,
) -> Result<Staged, WriteError> {
    let path = path.as_ref();
    let format = format_of(path, options)?;
    let model = model.to_model()?;
    check(&model, format, options)?;
    let model = with_normals(model, format);
    check_names(path, &model, format)?;
    let beside = Companions::prepare(path, &model, format, options)?;
    let written =
        atomic::prepare(path, |writer| put(writer, &model, format, options, &beside.names));
    let (file, mut report) = written?;
    report.lost.extend(losses(&model, target(format, options, beside.any)));
    (report.companions, report.kept) = (beside.paths, beside.kept);
    Ok(Staged { companions: beside.prepared, file, report })
}

/// Checks whether a model can be written in a format, as far as possible without writing it: the model must be
/// consistent, and the format must support the encoding and the coordinates.
///
/// # Errors
/// The errors of [`write()`].
pub fn check_write<M: ToModel + ?Sized>(
    model: &M,
    format: Format,
    options: &WriteOptions,
) -> Result<(), WriteError> {
    check(&*model.to_model()?, format, options)
}

fn check(model: &Model, format: Format, options: &WriteOptions) -> Result<(), WriteError> {
    model.check()?;
    check_encoding(format, options.encoding)?;
    check_compression(format, options)?;
    let positions = model.soup.positions();
    if is_single(format, options) || matches!(format, Format::Gltf | Format::Glb) {
        check_range(positions, format)?;
    }
    match format {
        #[cfg(feature = "gltf")]
        Format::Gltf | Format::Glb => crate::single::check_finite(positions, format),
        _ => Ok(()),
    }
}

/// Refuses a target that the file itself would refer to, as its picture or material library.
fn check_names(path: &Path, model: &Model, format: Format) -> Result<(), WriteError> {
    let pictures = model.images.iter().filter_map(|image| match &image.data {
        ImageData::Uri(name) => Some(name.as_str()),
        ImageData::Bytes(_) => None,
    });
    if !matches!(format, Format::Stl | Format::Off) {
        check_is_none_of(path, pictures, "picture")?;
    }
    if format == Format::Obj {
        let libraries = model.material_libraries.iter().map(String::as_str);
        check_is_none_of(path, libraries, "material library")?;
    }
    Ok(())
}

/// Refuses a target whose name, in its own folder, is one of `names`.
pub(crate) fn check_is_none_of<'n>(
    path: &Path,
    names: impl IntoIterator<Item = &'n str>,
    what: &'static str,
) -> Result<(), WriteError> {
    let mut names = names.into_iter().peekable();
    if names.peek().is_none() || atomic::is_device(path) {
        return Ok(());
    }
    let (target, folder) = (atomic::place_of(path), atomic::folder_of(path));
    if target.is_some() && names.any(|name| atomic::place_of(&folder.join(name)) == target) {
        return Err(WriteError::OwnCompanion { path: path.to_owned(), what });
    }
    Ok(())
}

/// Whether positions are rounded to 32 bits as they are. (glTF files move them to the origin before.)
fn is_single(format: Format, options: &WriteOptions) -> bool {
    match format {
        Format::Ply => options.precision == Precision::Single,
        Format::Off => options.encoding == Encoding::BigEndian,
        Format::Stl => true,
        Format::Obj | Format::Gltf | Format::Glb => false,
    }
}

fn target(format: Format, options: &WriteOptions, has_companions: bool) -> Target {
    let is_text = options.encoding == Encoding::Text;
    Target {
        format,
        is_text,
        is_single: is_single(format, options),
        stl_colors: options.stl_colors,
        has_companions,
    }
}

/// Checks that this build supports the format and the encoding.
pub(crate) fn check_encoding(format: Format, encoding: Encoding) -> Result<(), WriteError> {
    use Encoding::{BigEndian, LittleEndian, Text, Usual};
    let disabled = match format {
        Format::Obj => !cfg!(feature = "obj"),
        Format::Gltf | Format::Glb => !cfg!(feature = "gltf"),
        Format::Ply | Format::Stl | Format::Off => false,
    };
    if disabled {
        return Err(WriteError::FormatDisabled(format));
    }
    let known = match format {
        Format::Ply => true,
        Format::Stl => matches!(encoding, Usual | Text | LittleEndian),
        Format::Off => matches!(encoding, Usual | Text | BigEndian),
        Format::Obj | Format::Gltf => matches!(encoding, Usual | Text),
        Format::Glb => matches!(encoding, Usual | LittleEndian),
    };
    if known {
        return Ok(());
    }
    Err(WriteError::NoSuchEncoding { format, encoding: encoding.name() })
}

/// Checks that the format can be compressed and quantized, if it is to be.
pub(crate) fn check_compression(format: Format, options: &WriteOptions) -> Result<(), WriteError> {
    let is_gltf = matches!(format, Format::Gltf | Format::Glb);
    if options.compression == Compression::Meshopt && !is_gltf {
        return Err(WriteError::NoCompression(format));
    }
    match &options.quantization {
        Some(_) if !is_gltf => Err(WriteError::NoQuantization(format)),
        Some(quantization) => quantization.check(),
        None => Ok(()),
    }
}

/// The format given by the options or the extension.
pub(crate) fn format_of(path: &Path, options: &WriteOptions) -> Result<Format, WriteError> {
    let format = options.format.or_else(|| Format::from_extension(path));
    format.ok_or_else(|| WriteError::UnknownExtension(path.to_owned()))
}

/// Writes levels of detail of one object, from fine to coarse, into one glTF or GLB file with the
/// extension `MSFT_lod`. They share the materials and images of the first.
///
/// `coverage` holds, for each level, the part of the screen that the object must cover for the level to be shown; below
/// the last number nothing is shown. Levels without faces are left out.
///
/// # Errors
/// A [`WriteError`], also for other formats. Nothing has been written then.
#[cfg(feature = "gltf")]
pub fn write_levels<M: ToModel>(
    path: impl AsRef<Path>,
    levels: &[M],
    coverage: &[f64],
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    stage_levels(path, levels, coverage, options)?.commit()
}

/// Does everything that [`write_levels`] does except the last step, [`Staged::commit`].
///
/// # Errors
/// As [`write_levels`].
#[cfg(feature = "gltf")]
pub fn stage_levels<M: ToModel>(
    path: impl AsRef<Path>,
    levels: &[M],
    coverage: &[f64],
    options: &WriteOptions,
) -> Result<Staged, WriteError> {
    let path = path.as_ref();
    let format = format_of(path, options)?;
    if !matches!(format, Format::Gltf | Format::Glb) {
        return Err(WriteError::NoLevels(format));
    }
    let models: Vec<Cow<'_, Model>> = levels.iter().map(M::to_model).collect::<Result<_, _>>()?;
    models.iter().try_for_each(|model| check(model, format, options))?;
    check_coverage(coverage, models.len())?;
    models.iter().try_for_each(|model| check_names(path, model, format))?;
    let models: Vec<Cow<'_, Model>> =
        models.into_iter().map(|model| with_normals(model, format)).collect();
    let all = crate::gltf::Levels { models: models.iter().map(|m| &**m).collect(), coverage };
    let (file, mut report) =
        atomic::prepare(path, |writer| put_gltf(writer, &all, format, options))?;
    let target = target(format, options, false);
    for lost in models.iter().flat_map(|model| losses(model, target)) {
        if !report.lost.iter().any(|other| other.what == lost.what) {
            report.lost.push(lost);
        }
    }
    Ok(Staged::new(file, report))
}

/// Checks that there is a coverage for each level.
#[cfg(feature = "gltf")]
fn check_coverage(coverage: &[f64], levels: usize) -> Result<(), WriteError> {
    if coverage.len() != levels {
        return Err(crate::model::ModelError::Length {
            attribute: "coverage".to_owned(),
            found: coverage.len(),
            of: "levels",
            expected: levels,
        }
        .into());
    }
    let is_wrong = |&value: &f64| !value.is_finite() || value < 0.0;
    match coverage.iter().position(is_wrong) {
        Some(level) => Err(WriteError::Coverage { level, value: coverage[level] }),
        None => Ok(()),
    }
}

/// Replaces a file of any kind in the same way as [`write()`]: the old file stays until the new one is complete.
///
/// # Errors
/// The file cannot be written; it is unchanged.
pub fn replace_file(
    path: impl AsRef<Path>,
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), WriteError> {
    stage_file(path, content)?.commit().map(|_| ())
}

/// Does everything that [`replace_file`] does except the last step, [`Staged::commit`].
///
/// # Errors
/// As [`replace_file`].
pub fn stage_file(
    path: impl AsRef<Path>,
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<Staged, WriteError> {
    let (file, ()) = atomic::prepare(path.as_ref(), |writer| Ok(content(writer)?))?;
    Ok(Staged::new(file, WriteReport::default()))
}

/// The companions of a file, prepared.
#[derive(Default)]
struct Companions {
    /// The material libraries that the file refers to.
    names: Vec<String>,
    prepared: Vec<Beside>,
    paths: Vec<std::path::PathBuf>,
    kept: Vec<std::path::PathBuf>,
    /// Whether embedded images, if any, have their own files.
    any: bool,
}

impl Companions {
    fn prepare(
        path: &Path,
        model: &Model,
        format: Format,
        options: &WriteOptions,
    ) -> Result<Self, WriteError> {
        if format != Format::Obj || atomic::is_device(path) {
            return Ok(Self { names: model.material_libraries.clone(), ..Self::default() });
        }
        #[cfg(feature = "obj")]
        {
            let library = crate::obj::prepare_library(path, model, options.overwrite_companions)?;
            let crate::obj::Library { names, prepared, paths, kept } = library;
            Ok(Self { names, prepared, paths, kept, any: true })
        }
        #[cfg(not(feature = "obj"))]
        {
            let _ = options.overwrite_companions;
            Err(WriteError::FormatDisabled(format))
        }
    }
}

/// Writes a model to a stream, in many small pieces, so the stream should be buffered.
///
/// # Errors
/// A [`WriteError`]; part of the output may have been written only if the stream itself fails.
pub fn write_to<M: ToModel + ?Sized>(
    mut writer: &mut dyn Write,
    model: &M,
    format: Format,
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    let model = model.to_model()?;
    check(&model, format, options)?;
    let model = with_normals(model, format);
    let mut report = put(&mut writer, &model, format, options, &model.material_libraries)?;
    report.lost.extend(losses(&model, target(format, options, false)));
    Ok(report)
}

/// Writes a model that has already been checked.
fn put(
    writer: &mut dyn Write,
    model: &Model,
    format: Format,
    options: &WriteOptions,
    libraries: &[String],
) -> Result<WriteReport, WriteError> {
    let report = match (format, options.encoding) {
        (Format::Ply, _) => crate::ply::write(writer, model, options),
        (Format::Stl, Encoding::Text) => crate::stl::write_text(writer, model),
        (Format::Stl, _) => crate::stl::write_binary(writer, model, options.stl_colors),
        (Format::Off, Encoding::BigEndian) => crate::off::write_binary(writer, model),
        (Format::Off, _) => crate::off::write_text(writer, model),
        #[cfg(feature = "obj")]
        (Format::Obj, _) => crate::obj::write(writer, model, libraries),
        #[cfg(feature = "gltf")]
        (Format::Gltf | Format::Glb, _) => {
            let levels = crate::gltf::Levels { models: vec![model], coverage: &[] };
            put_gltf(writer, &levels, format, options)
        }
        #[cfg(not(all(feature = "obj", feature = "gltf")))]
        _ => {
            let _ = libraries;
            Err(WriteError::FormatDisabled(format))
        }
    }?;
    writer.flush()?;
    Ok(report)
}

#[cfg(feature = "gltf")]
fn put_gltf(
    writer: &mut dyn Write,
    levels: &crate::gltf::Levels<'_>,
    format: Format,
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    if options.compression == Compression::None && options.quantization.is_none() {
        return match format {
            Format::Gltf => crate::gltf::write_json(writer, levels),
            _ => crate::gltf::write_binary(writer, levels),
        };
    }
    let mut plain = Vec::new();
    let report = crate::gltf::write_binary(&mut plain, levels)?;
    let scene = crate::scene::Scene::read_written(&plain)?;
    drop(plain);
    let written = scene.write_with(writer, format, options)?;
    let rounding = report.rounding + written.rounding;
    Ok(WriteReport { rounding, stayed: written.stayed, ..report })
}
