//! Material libraries, read by `tobj`.

use crate::{Image, ImageData, Material, Model};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// A material of which nothing but the name is known.
pub(super) fn named(name: String) -> Material {
    Material { name, ..Material::default() }
}

/// Fills in the materials of a model from the libraries that it names. A library that is missing
/// or malformed is noted, no more: the mesh is whole without it.
pub(super) fn read_libraries(model: &mut Model, folder: Option<&Path>) {
    let Some(folder) = folder else { return };
    for library in model.material_libraries.clone() {
        match read_library(&folder.join(&library)) {
            Ok(materials) => materials.iter().for_each(|found| fill_in(model, found)),
            Err(reason) => {
                model.notes.push(format!("cannot read the material library {library:?}: {reason}"));
            }
        }
    }
}

fn read_library(path: &Path) -> Result<Vec<tobj::Material>, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    if !file.metadata().is_ok_and(|metadata| metadata.is_file()) {
        return Err("not a file".to_owned());
    }
    let mut kept = Vec::new();
    for line in BufReader::new(file).split(b'\n') {
        let line = line.map_err(|error| error.to_string())?;
        let line = String::from_utf8_lossy(&line);
        if is_sound(&line) {
            kept.extend_from_slice(line.trim().as_bytes());
            kept.push(b'\n');
        }
    }
    let (materials, _) =
        tobj::load_mtl_buf(&mut kept.as_slice()).map_err(|error| error.to_string())?;
    Ok(materials)
}

/// Whether a line is one that is used here and that `tobj` reads: it panics at a colour of fewer
/// than three numbers, and gives up the whole library at one malformed line.
fn is_sound(line: &str) -> bool {
    let mut words = line.split_whitespace();
    let keyword = words.next().unwrap_or_default();
    let numbers = words.clone().map_while(|word| word.parse::<f64>().ok()).count();
    match keyword {
        "newmtl" | "map_Kd" => words.next().is_some(),
        "Kd" | "Ke" => numbers >= 3,
        "d" => numbers >= 1,
        _ => false,
    }
}

fn fill_in(model: &mut Model, found: &tobj::Material) {
    let Some(place) = model.materials.iter().position(|material| material.name == found.name)
    else {
        return;
    };
    let image = found.diffuse_texture.as_ref().map(|uri| image_of(&mut model.images, uri));
    let material = &mut model.materials[place];
    let diffuse = found.diffuse.unwrap_or([1.0; 3]).map(|value| value as f32);
    let opacity = found.dissolve.unwrap_or(1.0) as f32;
    material.base_color = [diffuse[0], diffuse[1], diffuse[2], opacity];
    material.emissive = found.emissive.unwrap_or_default().map(|value| value as f32);
    material.base_color_image = image;
    if opacity < 1.0 {
        material.alpha = crate::Alpha::Blend;
    }
}

fn image_of(images: &mut Vec<Image>, uri: &str) -> u32 {
    let data = ImageData::Uri(uri.to_owned());
    let place = images.iter().position(|image| image.data == data).unwrap_or_else(|| {
        images.push(Image { name: String::new(), media_type: String::new(), data });
        images.len() - 1
    });
    place as u32
}
