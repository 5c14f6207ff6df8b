//! Writing a file of any format.

use crate::{Format, Model, WriteError, atomic};
use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_core::build::Triangulator;
use std::io::Write;
use std::path::Path;

/// How to write.
#[derive(Clone, Debug, Default)]
pub struct WriteOptions {
    /// The format; told by the extension when absent.
    pub format: Option<Format>,
    /// Text or binary.
    pub encoding: Encoding,
    /// The width of the numbers in PLY.
    pub precision: Precision,
}

/// Text or binary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// What is usual for the format: binary for PLY (little-endian) and STL, text for OFF.
    #[default]
    Usual,
    /// Text.
    Text,
    /// Binary, the least significant byte first (PLY, STL).
    LittleEndian,
    /// Binary, the most significant byte first (PLY, OFF).
    BigEndian,
}

impl Encoding {
    fn name(self) -> &'static str {
        match self {
            Self::Usual => "its usual encoding",
            Self::Text => "text",
            Self::LittleEndian => "little-endian binary",
            Self::BigEndian => "big-endian binary",
        }
    }
}

/// The width of floating-point numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits for numbers that all fit, 64 bits otherwise: nothing is lost.
    #[default]
    Exact,
    /// 32 bits.
    Single,
    /// 64 bits.
    Double,
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WriteReport {
    /// The largest distance, along one axis, between a position and what the file holds, in model
    /// units: the price of 32-bit coordinates. Zero where positions are exact.
    pub rounding: f64,
    /// What the format has no place for, in words.
    pub dropped: Vec<String>,
}

/// Writes a model to a file, in the format that the options or the extension name.
///
/// The file is written beside the target and renamed onto it when it is whole, so that no failure
/// leaves anything else than the old file or the new one.
///
/// An OBJ file comes with a material library, `NAME.mtl`, and with its embedded images as files
/// beside it, unless the libraries that the model names are there already or nothing is known of its
/// materials. Images in files keep their names, which are relative to the OBJ or glTF file.
///
/// # Errors
/// A [`WriteError`]: nothing has been written then, save for the companions of an OBJ file.
pub fn write(
    path: impl AsRef<Path>,
    model: &Model,
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    let path = path.as_ref();
    let format = format_of(path, options)?;
    model.check()?;
    let (libraries, has_images) = companions(path, model, format)?;
    let written =
        atomic::replace(path, |writer| write_stream(writer, model, format, options, &libraries));
    let mut report = written?;
    report.dropped.retain(|what| !(has_images && what == EMBEDDED_IMAGES));
    Ok(report)
}

/// The format that the options or the extension name.
fn format_of(path: &Path, options: &WriteOptions) -> Result<Format, WriteError> {
    let format = options.format.or_else(|| Format::from_extension(path));
    format.ok_or_else(|| WriteError::UnknownExtension(path.to_owned()))
}

/// Writes levels of detail of one object, from fine to coarse, into one glTF or GLB file with the
/// extension `MSFT_lod`. They share the materials and images of the first.
///
/// `coverage` holds for each level the part of the screen that the object must cover for the level
/// to be shown; below the last number nothing is.
///
/// # Errors
/// A [`WriteError`], also for any other format: nothing has been written then.
#[cfg(feature = "gltf")]
pub fn write_levels(
    path: impl AsRef<Path>,
    levels: &[Model],
    coverage: &[f64],
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    let path = path.as_ref();
    let format = format_of(path, options)?;
    levels.iter().try_for_each(Model::check)?;
    let all = crate::gltf::Levels { models: levels.iter().collect(), coverage: coverage.to_vec() };
    let mut report = atomic::replace(path, |writer| match format {
        Format::Gltf => crate::gltf::write_levels_json(writer, &all),
        Format::Glb => crate::gltf::write_levels_binary(writer, &all),
        _ => Err(WriteError::NoLevels(format)),
    })?;
    report.dropped = levels.first().map_or_else(Vec::new, |model| dropped(model, format));
    Ok(report)
}

/// Writes a file of any kind as [`write()`] does: the file at `path` is the old one until the new one
/// is whole.
///
/// # Errors
/// The file cannot be written: it is as it was.
pub fn replace_file(
    path: impl AsRef<Path>,
    content: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), WriteError> {
    atomic::replace(path.as_ref(), |writer| Ok(content(writer)?))
}

/// Writes the files that go with the one at `path`; the material libraries that it is to name, and
/// whether embedded images have got files of their own.
#[cfg(feature = "obj")]
fn companions(
    path: &Path,
    model: &Model,
    format: Format,
) -> Result<(Vec<String>, bool), WriteError> {
    match format {
        Format::Obj => Ok((crate::obj::write_library(path, model)?, true)),
        _ => Ok((Vec::new(), false)),
    }
}

#[cfg(not(feature = "obj"))]
fn companions(_: &Path, _: &Model, _: Format) -> Result<(Vec<String>, bool), WriteError> {
    Ok((Vec::new(), false))
}

/// Writes a model to a stream, many small pieces at a time: buffer it.
///
/// # Errors
/// A [`WriteError`]; part of the file may have been written when the stream itself fails, or when
/// a coordinate turns out not to fit into the 32-bit numbers of the format.
pub fn write_to(
    writer: &mut dyn Write,
    model: &Model,
    format: Format,
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    model.check()?;
    write_stream(writer, model, format, options, &model.material_libraries)
}

fn write_stream(
    mut writer: &mut dyn Write,
    model: &Model,
    format: Format,
    options: &WriteOptions,
    libraries: &[String],
) -> Result<WriteReport, WriteError> {
    let encoding = options.encoding;
    let no_such_encoding = WriteError::NoSuchEncoding { format, encoding: encoding.name() };
    let mut report = match (format, encoding) {
        (Format::Ply, _) => crate::ply::write(&mut writer, model, options),
        (Format::Stl, Encoding::Text) => crate::stl::write_text(&mut writer, model),
        (Format::Stl, Encoding::Usual | Encoding::LittleEndian) => {
            crate::stl::write_binary(&mut writer, model)
        }
        (Format::Off, Encoding::Usual | Encoding::Text) => {
            crate::off::write_text(&mut writer, model)
        }
        (Format::Off, Encoding::BigEndian) => crate::off::write_binary(&mut writer, model),
        #[cfg(feature = "obj")]
        (Format::Obj, Encoding::Usual | Encoding::Text) => {
            crate::obj::write(&mut writer, model, libraries)
        }
        #[cfg(feature = "gltf")]
        (Format::Gltf, Encoding::Usual | Encoding::Text) => {
            crate::gltf::write_json(&mut writer, model)
        }
        #[cfg(feature = "gltf")]
        (Format::Glb, Encoding::Usual | Encoding::LittleEndian) => {
            crate::gltf::write_binary(&mut writer, model)
        }
        #[cfg(not(feature = "obj"))]
        (Format::Obj, _) => {
            let _ = libraries;
            Err(WriteError::FormatDisabled(format))
        }
        #[cfg(not(feature = "gltf"))]
        (Format::Gltf | Format::Glb, _) => Err(WriteError::FormatDisabled(format)),
        _ => Err(no_such_encoding),
    }?;
    if report.rounding.is_infinite() {
        return Err(out_of_single_range(model, format));
    }
    writer.flush()?;
    report.dropped = dropped(model, format);
    Ok(report)
}

/// The error for a coordinate that became infinite on its way to 32 bits.
fn out_of_single_range(model: &Model, format: Format) -> WriteError {
    let coordinates = model.soup.positions().iter().flat_map(DVec3::to_array);
    let largest = coordinates.enumerate().filter(|(_, value)| value.is_finite());
    let (index, value) =
        largest.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs())).unwrap_or_default();
    WriteError::OutOfSingleRange { format, vertex: index / 3, value }
}

const EMBEDDED_IMAGES: &str = "embedded images";

/// What a model has and a format has no place for.
fn dropped(model: &Model, format: Format) -> Vec<String> {
    use Format::{Glb, Gltf, Obj, Off, Ply};
    let holds = |formats: &[Format]| formats.contains(&format);
    let polygons = model.soup.faces().any(|face| face.len() > 3);
    let images = model.images.iter().any(|i| matches!(i.data, crate::ImageData::Bytes(_)));
    let seams = model.corner_uvs.is_some() && format == Off && vertex_uvs(model).is_none();
    [
        (polygons && !holds(&[Obj, Ply, Off]), "polygons (cut into triangles)"),
        (model.vertex_normals.is_some() && holds(&[Format::Stl]), "vertex normals"),
        (model.vertex_colors.is_some() && holds(&[Format::Stl]), "vertex colours"),
        (!model.vertex_scalars.is_empty() && !holds(&[Ply, Gltf, Glb]), "numbers per vertex"),
        (model.corner_normals.is_some() && holds(&[Ply, Off, Format::Stl]), "corner normals"),
        (model.corner_uvs.is_some() && holds(&[Format::Stl]), "texture coordinates"),
        (seams && holds(&[Off]), "texture coordinates (they differ between faces)"),
        (model.face_colors.is_some() && !holds(&[Ply, Off]), "face colours"),
        (!model.face_scalars.is_empty() && !holds(&[Ply]), "numbers per face"),
        (model.face_groups.is_some() && !holds(&[Obj, Format::Stl]), "groups"),
        (model.face_materials.is_some() && !holds(&[Obj, Gltf, Glb]), "materials"),
        (images && !holds(&[Gltf, Glb]), EMBEDDED_IMAGES),
    ]
    .into_iter()
    .filter(|(lost, _)| *lost)
    .map(|(_, what)| what.to_owned())
    .collect()
}

/// The largest error of a coordinate when stored in 32 bits.
pub(crate) fn rounding(positions: &[DVec3]) -> f64 {
    positions
        .iter()
        .flat_map(DVec3::to_array)
        .map(|value| (value - f64::from(value as f32)).abs())
        .fold(0.0, f64::max)
}

/// Cuts faces into triangles for formats that hold nothing else, along diagonals that stay inside.
#[derive(Default)]
pub(crate) struct Cutter {
    triangulator: Triangulator,
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter {
    /// The triangles of a face, as places in the face.
    pub(crate) fn cut(&mut self, soup: &PolygonSoup, face: usize) -> &[[u32; 3]] {
        let vertices = soup.face(face);
        self.triangles.clear();
        self.positions.clear();
        self.positions.extend(vertices.iter().map(|&v| soup.positions()[v as usize]));
        if self.positions.iter().all(|p| p.is_finite()) {
            self.triangulator.triangulate(&self.positions, vertices, &mut self.triangles);
        } else {
            // Nowhere is inside; any triangles will do.
            self.triangles.extend((2..vertices.len() as u32).map(|last| [0, last - 1, last]));
        }
        &self.triangles
    }
}

/// A colour in eight bits, when that is exact for all of them.
pub(crate) fn as_bytes(colors: &[[f32; 4]]) -> Option<Vec<[u8; 4]>> {
    colors
        .iter()
        .map(|color| {
            let bytes = color.map(|value| (value * 255.0).round() as u8);
            let exact = bytes.iter().zip(color).all(|(&byte, &value)| from_byte(byte) == value);
            exact.then_some(bytes)
        })
        .collect()
}

/// An eight-bit colour from 0 to 1.
pub(crate) fn from_byte(byte: u8) -> f32 {
    f32::from(byte) / 255.0
}

/// Texture coordinates by vertex, when there are any and the corners of every vertex agree.
pub(crate) fn vertex_uvs(model: &Model) -> Option<Vec<[f32; 2]>> {
    let corner_uvs = model.corner_uvs.as_deref()?;
    let mut uvs = vec![None; model.soup.vertex_count()];
    for (&vertex, &uv) in model.soup.corners().iter().zip(corner_uvs) {
        let bits = uv.map(f32::to_bits);
        if uvs[vertex as usize].replace(bits).is_some_and(|other| other != bits) {
            return None;
        }
    }
    // A vertex that no face uses has no coordinate; the value is never looked at.
    Some(uvs.into_iter().map(|uv| uv.unwrap_or_default().map(f32::from_bits)).collect())
}

/// The unit normal of a triangle, or zero for one without an area.
pub(crate) fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}
