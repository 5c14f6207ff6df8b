//! Writing of the material library and the pictures beside an OBJ file.

use super::companion::{Companions, Earlier, first_line, picture_line};
use super::material::named;
use super::names::{file_name, material_names, one_line};
use crate::atomic::Beside;
use crate::decimal::Decimal;
use crate::error::WriteError;
use crate::model::{Image, ImageData, Model};
use mesh_core::Checksum;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The companions of an OBJ file.
#[derive(Default)]
pub(crate) struct Library {
    /// The names of the libraries that the OBJ file refers to.
    pub(crate) names: Vec<String>,
    /// The prepared files.
    pub(crate) prepared: Vec<Beside>,
    /// Their paths.
    pub(crate) paths: Vec<PathBuf>,
    /// The existing libraries that stay unchanged.
    pub(crate) kept: Vec<PathBuf>,
}

/// Prepares the files that an OBJ file at `path` refers to.
///
/// If all libraries of the model exist beside the target, they stay unchanged, because they may contain more than a
/// model holds. (A library from an earlier run of the same output contains no more, and is replaced.) Libraries also
/// stay unchanged if only the names of the materials are known. Otherwise `NAME.mtl` is written for `NAME.obj`.
/// Pictures in files keep their names, which are relative to the OBJ file; embedded pictures are written as
/// `NAME-0.png`, `NAME-1.jpg` and so on. Files of other origin are replaced only if `overwrite` is set; see
/// [`super::companion`].
pub(crate) fn prepare_library(
    path: &Path,
    model: &Model,
    overwrite: bool,
) -> Result<Library, WriteError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let output = one_line(&path.file_name().unwrap_or_default().to_string_lossy());
    // The names must fit on a line, and must not look like paths.
    let stem = one_line(&path.file_stem().unwrap_or_default().to_string_lossy());
    let stem = stem.replace(['\\', ':'], "_");
    let mut name = format!("{stem}.mtl");
    if name.eq_ignore_ascii_case(&output) {
        name = format!("{output}.mtl");
    }
    let earlier = Earlier::find(&folder.join(&name), &output);
    let libraries = &model.material_libraries;
    let stays = |library: &String| {
        folder.join(library).is_file() && !(earlier.is_some() && *library == name)
    };
    let all_there = !libraries.is_empty() && libraries.iter().all(stays);
    let nothing_known = model.materials.iter().all(|m| *m == named(m.name.clone()));
    if nothing_known || all_there {
        let kept = libraries.iter().map(|library| folder.join(library));
        let kept = kept.filter(|path| path.is_file()).collect();
        return Ok(Library { names: libraries.clone(), kept, ..Library::default() });
    }
    let mut companions = Companions::new(folder, earlier, overwrite);
    let (mut references, mut pictures) = (Vec::with_capacity(model.images.len()), Vec::new());
    for (index, image) in model.images.iter().enumerate() {
        references.push(match &image.data {
            ImageData::Uri(name) => {
                // The output is its own input. Pictures written with it remain registered.
                let line = companions.earlier.as_ref().and_then(|earlier| earlier.line_of(name));
                pictures.extend(line.map(str::to_owned));
                file_name(name)
            }
            ImageData::Bytes(bytes) if bytes.is_empty() => None,
            ImageData::Bytes(bytes) => {
                let name = format!("{stem}-{index}.{}", extension(image));
                companions.picture(&name, bytes)?;
                pictures.push(picture_line(&name, Checksum::of(bytes)));
                file_name(&name)
            }
        });
    }
    let content = |writer: &mut dyn Write| -> std::io::Result<()> {
        pictures.iter().try_for_each(|line| writeln!(writer, "{line}"))?;
        write_materials(writer, model, &references)
    };
    let mut sum = Checksum::default();
    content(&mut sum)?;
    companions.library(&name, |writer| {
        writeln!(writer, "{}", first_line(&output, sum))?;
        Ok(content(writer)?)
    })?;
    let Companions { prepared, paths, .. } = companions;
    Ok(Library { names: vec![name], prepared, paths, kept: Vec::new() })
}

/// The file extension of an image.
fn extension(image: &Image) -> &'static str {
    match image.media_type() {
        "image/png" => "png",
        "image/jpeg" => "jpg",
        "image/webp" => "webp",
        "image/ktx2" => "ktx2",
        _ => "img",
    }
}

fn write_materials(
    writer: &mut dyn Write,
    model: &Model,
    references: &[Option<String>],
) -> std::io::Result<()> {
    for (material, name) in model.materials.iter().zip(material_names(model)) {
        let number = |value: f32| Decimal(if value.is_finite() { value } else { 1.0 });
        let [r, g, b, opacity] = material.base_color.map(number);
        writeln!(writer, "newmtl {name}")?;
        writeln!(writer, "Kd {r} {g} {b}")?;
        writeln!(writer, "d {opacity}")?;
        if material.emissive != [0.0; 3] && material.emissive.iter().all(|e| e.is_finite()) {
            let [r, g, b] = material.emissive.map(Decimal);
            writeln!(writer, "Ke {r} {g} {b}")?;
        }
        let image = material.base_color_image.and_then(|image| references.get(image as usize));
        if let Some(Some(name)) = image {
            writeln!(writer, "map_Kd {name}")?;
        }
        writeln!(writer)?;
    }
    Ok(())
}
