//! The pictures that a PLY file names, in the way of MeshLab: a comment `TextureFile` for each material, and the property
//! `texnumber` of the faces where a face could have another one than the first.

use crate::model::{ImageData, Material, Model};

/// The property of faces with the number of their picture.
pub(super) const NUMBER: &str = "texnumber";

/// The pictures of a model, as a PLY file names them.
pub(crate) struct Textures<'m> {
    /// The picture of each material.
    pub(super) names: Vec<&'m str>,
    /// The material of every face, -1 without one. `None` if all faces have the first.
    pub(super) numbers: Option<Vec<i32>>,
    /// The number of materials that are more than a picture. The file has no place for their names and looks.
    pub(crate) more_than_pictures: u64,
}

impl<'m> Textures<'m> {
    /// The pictures, if there are texture coordinates for them and each material has a picture in a file.
    pub(crate) fn new(model: &'m Model) -> Option<Self> {
        let ids = model.face_materials.as_deref().filter(|_| model.corner_uvs.is_some())?;
        let names: Vec<&str> = model
            .materials
            .iter()
            .map(|material| picture(model, material))
            .collect::<Option<_>>()?;
        let number = |&id: &u32| match i32::try_from(id) {
            Ok(number) if (id as usize) < names.len() => number,
            _ => -1,
        };
        let numbers: Vec<i32> = ids.iter().map(number).collect();
        if numbers.iter().all(|&number| number < 0) {
            return None;
        }
        let is_needed = numbers.iter().any(|&number| number != 0);
        let more = |material: &&Material| {
            let picture = material.base_color_image;
            **material != Material { base_color_image: picture, ..Material::default() }
        };
        let more_than_pictures = model.materials.iter().filter(more).count() as u64;
        Some(Self { names, numbers: is_needed.then_some(numbers), more_than_pictures })
    }
}

/// The name of the file with the picture of a material.
fn picture<'m>(model: &'m Model, material: &Material) -> Option<&'m str> {
    match &model.images.get(material.base_color_image? as usize)?.data {
        ImageData::Uri(name) if !name.is_empty() && !name.contains(char::is_control) => Some(name),
        _ => None,
    }
}
