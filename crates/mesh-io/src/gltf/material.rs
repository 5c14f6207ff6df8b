//! Materials and images.

use super::accessor::{Document, at};
use super::container::data_uri;
use super::schema::{self, AlphaMode, TextureInfo};
use crate::error::ReadErrorKind;
use crate::input::Input;
use crate::lost::Lost;
use crate::notes::Notes;
use crate::{Alpha, Image, ImageData, Material, Model};
use mesh_core::as_u32;
use percent_encoding::percent_decode_str;
use std::collections::HashMap;
use std::sync::Arc;

/// Reads the materials and images of a document; unreadable parts are noted. Returns, for every material, the texture
/// that its texture coordinates belong to.
pub(crate) fn read(
    document: &Document,
    model: &mut Model,
    notes: &mut Notes,
    input: &mut Input<'_>,
) -> Result<Vec<Option<TextureInfo>>, ReadErrorKind> {
    let images = read_images(document, model, notes, input)?;
    let materials = &document.root.materials;
    let each = (size_of::<Material>() + size_of::<Option<TextureInfo>>() + 16) as u64;
    input.spend(each * materials.len() as u64, || at("materials"))?;
    model.materials.reserve_exact(materials.len());
    let mut textures = Vec::with_capacity(materials.len());
    for (index, material) in materials.iter().enumerate() {
        let (material, texture) = read_material(document, material, &images, index, notes);
        model.materials.push(material);
        textures.push(texture);
    }
    Ok(textures)
}

/// The texture of the base colour, or the diffuse texture of a material without the usual model.
pub(crate) fn base_texture(material: &schema::Material) -> Option<TextureInfo> {
    match (&material.pbr_metallic_roughness, &material.extensions.specular_glossiness) {
        (Some(pbr), _) => pbr.base_color_texture.clone(),
        (None, Some(other)) => other.diffuse_texture.clone(),
        (None, None) => None,
    }
}

/// Reads the images, and returns the index in the model for each image of the document. Images with the same bytes of a
/// buffer become one image.
fn read_images(
    document: &Document,
    model: &mut Model,
    notes: &mut Notes,
    input: &mut Input<'_>,
) -> Result<Vec<u32>, ReadErrorKind> {
    let images = &document.root.images;
    input.spend(2 * (size_of::<Image>() + 64) as u64 * images.len() as u64, || at("images"))?;
    // Views can overlap, and buffers can be the same file. The pixels that pictures may have are justified by their bytes,
    // so all images together have at most the bytes that are there.
    let contents: HashMap<_, usize> = document
        .buffers
        .iter()
        .map(|buffer| (Arc::as_ptr(&buffer.all), buffer.all.len()))
        .collect();
    let mut room: usize = contents.values().sum();
    let mut places = Vec::with_capacity(images.len());
    let mut known = HashMap::new();
    model.images.reserve_exact(images.len());
    for (index, image) in images.iter().enumerate() {
        let path = format!("images[{index}]");
        let here = as_u32(model.images.len());
        let text = |text: &Option<Box<str>>| text.as_deref().unwrap_or_default().to_owned();
        let (media_type, data) = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match data_uri(uri) {
                Some((kind, Ok(bytes))) => (kind, ImageData::Bytes(bytes)),
                Some((kind, Err(why))) => {
                    notes.add(format!("{path}: {why}"));
                    (kind, ImageData::Bytes(Vec::new()))
                }
                None => (text(&image.mime_type), ImageData::Uri(plain_name(uri))),
            },
            (None, view) => {
                let path = format!("{path}.bufferView");
                let bytes = view.and_then(|view| Some((view, document.view(view, &path).ok()?.0)));
                let bytes = match bytes {
                    Some((view, bytes)) => {
                        let place = document
                            .root
                            .buffer_views
                            .get(view as usize)
                            .map(|view| (view.buffer, view.byte_offset, view.byte_length));
                        let place = *known.entry(place).or_insert(here);
                        if place != here {
                            places.push(place);
                            continue;
                        }
                        if let Some(left) = room.checked_sub(bytes.len()) {
                            room = left;
                            input.spend(bytes.len() as u64, || at(&path))?;
                            bytes.to_vec()
                        } else {
                            let why = "the images have more bytes together than the buffers";
                            notes.lose(Lost::new(path, why));
                            Vec::new()
                        }
                    }
                    None => {
                        notes.add(format!("{path}: the image is not there"));
                        Vec::new()
                    }
                };
                (text(&image.mime_type), ImageData::Bytes(bytes))
            }
        };
        places.push(here);
        model.images.push(Image { name: text(&image.name), media_type, data });
    }
    Ok(places)
}

/// The file name in a percent-encoded URI. An internet address is unchanged.
pub(crate) fn plain_name(uri: &str) -> String {
    if uri.contains("://") {
        return uri.to_owned();
    }
    percent_decode_str(uri).decode_utf8_lossy().replace('\\', "/")
}

fn read_material(
    document: &Document,
    material: &schema::Material,
    images: &[u32],
    index: usize,
    notes: &mut Notes,
) -> (Material, Option<TextureInfo>) {
    let path = format!("materials[{index}]");
    let default = schema::Pbr::default();
    let pbr = material.pbr_metallic_roughness.as_deref().unwrap_or(&default);
    let (mut color, texture) = (pbr.base_color_factor, base_texture(material));
    if let Some(other) = &material.extensions.specular_glossiness {
        let why = "only the diffuse colour and texture are kept";
        notes.lose(Lost::new(format!("{path}: its specular-glossiness"), why));
        // If the other model is also present, as a fallback for readers without the extension, it takes precedence.
        if material.pbr_metallic_roughness.is_none() {
            color = other.diffuse_factor;
        }
    }
    let textures = [
        (material.normal_texture, "normal"),
        (material.occlusion_texture, "occlusion"),
        (material.emissive_texture, "emissive"),
        (pbr.metallic_roughness_texture, "metallic-roughness"),
    ];
    let names: Vec<&str> =
        textures.iter().filter(|(there, _)| *there).map(|(_, name)| *name).collect();
    if !names.is_empty() {
        let what = format!("{path}: textures: {}", names.join(", "));
        notes.lose(Lost::some(what, names.len() as u64, "only the base colour texture is kept"));
    }
    let image = texture.as_ref().and_then(|info| image_of(document, info, images, notes));
    let read = Material {
        name: material.name.as_deref().unwrap_or_default().to_owned(),
        base_color: color,
        base_color_image: image,
        metallic: pbr.metallic_factor,
        roughness: pbr.roughness_factor,
        emissive: material.emissive_factor,
        double_sided: material.double_sided,
        alpha: match material.alpha_mode {
            AlphaMode::Mask => Alpha::Mask(material.alpha_cutoff.unwrap_or(0.5)),
            AlphaMode::Blend => Alpha::Blend,
            AlphaMode::Opaque => Alpha::Opaque,
        },
    };
    (read, texture)
}

/// The image of a texture in a widely supported format, or a note that there is none.
fn image_of(
    document: &Document,
    info: &TextureInfo,
    images: &[u32],
    notes: &mut Notes,
) -> Option<u32> {
    let path = format!("textures[{}]", info.index);
    let Some(texture) = document.root.textures.get(info.index as usize) else {
        notes.lose(Lost::new(path, "there is no such texture"));
        return None;
    };
    let image = texture.source.and_then(|source| images.get(source as usize).copied());
    if image.is_none() {
        let why = match (&texture.extensions.webp, &texture.extensions.basis) {
            (true, _) => "it is there as WebP only",
            (_, true) => "it is there as Basis (KTX2) only",
            _ => "it has no image",
        };
        notes.lose(Lost::new(path, why));
    }
    image
}
