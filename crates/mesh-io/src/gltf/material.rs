//! Materials and images.

use super::accessor::Document;
use super::container::data_uri;
use crate::{Alpha, Image, ImageData, Material, Model};
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;

/// Takes the materials and images of a document; what cannot be read of them is noted.
pub(super) fn read(document: &Document, model: &mut Model) {
    let root = &document.root;
    for (index, image) in root.images.iter().enumerate() {
        let media_type = image.mime_type.as_ref().map(|kind| kind.0.clone()).unwrap_or_default();
        let (media_type, data) = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match data_uri(uri) {
                Some((kind, Ok(bytes))) => (kind, ImageData::Bytes(bytes)),
                Some((kind, Err(why))) => {
                    model.notes.push(format!("images[{index}]: {why}"));
                    (kind, ImageData::Bytes(Vec::new()))
                }
                None => (media_type, ImageData::Uri(file_name(uri))),
            },
            (None, view) => {
                let path = format!("images[{index}].bufferView");
                let bytes = view.and_then(|view| document.view(view, &path).ok());
                if bytes.is_none() {
                    model.notes.push(format!("{path}: the image is not there"));
                }
                let bytes = bytes.map(|(bytes, _)| bytes.to_vec()).unwrap_or_default();
                (media_type, ImageData::Bytes(bytes))
            }
        };
        let name = image.name.clone().unwrap_or_default();
        model.images.push(Image { name, media_type, data });
    }
    for (index, material) in root.materials.iter().enumerate() {
        let pbr = &material.pbr_metallic_roughness;
        let image = pbr
            .base_color_texture
            .as_ref()
            .and_then(|info| root.textures.get(info.index.value()))
            .map(|texture| texture.source.value())
            .filter(|&image| image < root.images.len());
        if material.normal_texture.is_some()
            || material.occlusion_texture.is_some()
            || material.emissive_texture.is_some()
            || pbr.metallic_roughness_texture.is_some()
        {
            model.notes.push(format!("materials[{index}]: only the base colour texture is kept"));
        }
        model.materials.push(Material {
            name: material.name.clone().unwrap_or_default(),
            base_color: pbr.base_color_factor.0,
            base_color_image: image.map(|image| image as u32),
            metallic: pbr.metallic_factor.0,
            roughness: pbr.roughness_factor.0,
            emissive: material.emissive_factor.0,
            double_sided: material.double_sided,
            alpha: match material.alpha_mode {
                Checked::Valid(AlphaMode::Mask) => {
                    Alpha::Mask(material.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0))
                }
                Checked::Valid(AlphaMode::Blend) => Alpha::Blend,
                _ => Alpha::Opaque,
            },
        });
    }
}

/// The name of the file that a relative URI names; an absolute one is as it is.
fn file_name(uri: &str) -> String {
    if uri.contains("://") {
        return uri.to_owned();
    }
    let name = percent_encoding::percent_decode_str(uri).decode_utf8();
    name.map_or_else(|_| uri.to_owned(), std::borrow::Cow::into_owned)
}
