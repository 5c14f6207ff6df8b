//! Writing the material library and the pictures beside an OBJ file.

use std::io::Write;
use std::path::Path;

use super::write::{material_name, one_line};
use crate::decimal::Decimal;
use crate::{Image, ImageData, Model, WriteError, atomic};

/// Writes what an OBJ file at `path` refers to, and returns the names of the libraries that it is to
/// name.
///
/// Where the libraries that the model came with are all beside the target, they stay as they are:
/// they may say more than a model holds. So they do where nothing is known of the materials but
/// their names. Otherwise `NAME.mtl` is written, for `NAME.obj`. Pictures
/// in files keep their names, which are relative to the OBJ file; embedded ones are written as
/// `NAME-0.png`, `NAME-1.jpg` and so on.
pub(crate) fn write_library(path: &Path, model: &Model) -> Result<Vec<String>, WriteError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let libraries = &model.material_libraries;
    let all_there = libraries.iter().all(|name| folder.join(name).is_file());
    let nothing_known =
        model.materials.iter().all(|m| *m == super::material::named(m.name.clone()));
    if nothing_known || (all_there && !libraries.is_empty()) {
        return Ok(libraries.clone());
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut images = Vec::with_capacity(model.images.len());
    for (index, image) in model.images.iter().enumerate() {
        images.push(write_image(folder, &format!("{stem}-{index}"), image)?);
    }
    let name = format!("{stem}.mtl");
    atomic::replace(&folder.join(&name), |writer| write_materials(writer, model, &images))?;
    Ok(vec![name])
}

/// The name of the file of an image, which is written if it was embedded.
fn write_image(folder: &Path, stem: &str, image: &Image) -> Result<Option<String>, WriteError> {
    match &image.data {
        ImageData::Uri(uri) => Ok(Some(uri.clone())),
        ImageData::Bytes(bytes) if bytes.is_empty() => Ok(None),
        ImageData::Bytes(bytes) => {
            let extension = match image.media_type.as_str() {
                "image/png" => "png",
                "image/jpeg" => "jpg",
                "image/webp" => "webp",
                "image/ktx2" => "ktx2",
                _ => "img",
            };
            let name = format!("{stem}.{extension}");
            atomic::replace(&folder.join(&name), |writer| Ok(writer.write_all(bytes)?))?;
            Ok(Some(name))
        }
    }
}

fn write_materials(
    writer: &mut dyn Write,
    model: &Model,
    images: &[Option<String>],
) -> Result<(), WriteError> {
    for (index, material) in model.materials.iter().enumerate() {
        let [r, g, b, opacity] = material.base_color.map(Decimal);
        writeln!(writer, "newmtl {}", material_name(model, index as u32))?;
        writeln!(writer, "Kd {r} {g} {b}")?;
        writeln!(writer, "d {opacity}")?;
        if material.emissive != [0.0; 3] {
            let [r, g, b] = material.emissive.map(Decimal);
            writeln!(writer, "Ke {r} {g} {b}")?;
        }
        let image = material.base_color_image.and_then(|index| images.get(index as usize));
        if let Some(Some(name)) = image {
            writeln!(writer, "map_Kd {}", one_line(name))?;
        }
        writeln!(writer)?;
    }
    Ok(())
}
