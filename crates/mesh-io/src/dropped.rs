//! What a model has and a format has no place for.

use crate::format::Format;
use crate::model::{Alpha, ImageData, Material, Model};
use crate::single::are_finite;

/// In words; `beside` when material libraries and pictures go into files of their own.
pub(crate) fn dropped(model: &Model, format: Format, beside: bool) -> Vec<String> {
    use Format::{Glb, Gltf, Obj, Off, Ply, Stl};
    let holds = |formats: &[Format]| formats.contains(&format);
    let polygons = model.soup.faces().any(|face| face.len() > 3);
    let images = model.images.iter().any(|image| matches!(image.data, ImageData::Bytes(_)));
    let corner_uvs = model.corner_uvs.is_some();
    let seams = corner_uvs && format == Off && model.vertex_uvs().is_none();
    let gaps = !seams && has_gaps(model, format);
    let both_normals = model.vertex_normals.is_some() && model.corner_normals.is_some();
    let points = match format {
        Stl => has_unused_vertices(model),
        Gltf | Glb => model.soup.vertex_count() > 0 && model.soup.face_count() == 0,
        _ => false,
    };
    let looks = model.materials.iter().any(|material| {
        let Material { metallic, roughness, double_sided, alpha, .. } = *material;
        let mask = matches!(alpha, Alpha::Mask(_));
        metallic != 0.0 || roughness != 1.0 || double_sided || mask
    });
    let line_breaks = model.images.iter().any(|image| match &image.data {
        ImageData::Uri(name) => name.contains(char::is_control),
        ImageData::Bytes(_) => false,
    });
    [
        (points, "vertices that no face uses"),
        (polygons && !holds(&[Obj, Ply, Off]), "polygons (cut into triangles)"),
        (model.vertex_normals.is_some() && holds(&[Stl]), "vertex normals"),
        (both_normals && holds(&[Obj, Gltf, Glb]), "vertex normals (corners have their own)"),
        (model.vertex_colors.is_some() && holds(&[Stl]), "vertex colours"),
        (!model.vertex_scalars.is_empty() && !holds(&[Ply, Gltf, Glb]), "numbers per vertex"),
        (model.corner_normals.is_some() && holds(&[Ply, Off, Stl]), "corner normals"),
        (corner_uvs && holds(&[Stl]), "texture coordinates"),
        (seams && holds(&[Off]), "texture coordinates (they differ between faces)"),
        (gaps, "gaps in the texture coordinates (0 there)"),
        (model.face_colors.is_some() && !holds(&[Ply, Off]), "face colours"),
        (!model.face_scalars.is_empty() && !holds(&[Ply]), "numbers per face"),
        (model.face_groups.is_some() && !holds(&[Obj, Stl]), "groups"),
        (model.face_materials.is_some() && !holds(&[Obj, Gltf, Glb]), "materials"),
        (looks && holds(&[Obj]), "metalness, roughness, opacity limits and sides of materials"),
        (line_breaks && holds(&[Obj]), "textures whose names have line breaks"),
        (images && !beside && !holds(&[Gltf, Glb]), "embedded images"),
    ]
    .into_iter()
    .filter(|(lost, _)| *lost)
    .map(|(_, what)| what.to_owned())
    .collect()
}

/// Whether corners without texture coordinates get some for want of another way to say it.
fn has_gaps(model: &Model, format: Format) -> bool {
    let Some(uvs) = &model.corner_uvs else { return false };
    let lacks = |uv: &[f32; 2]| !are_finite(uv);
    match format {
        Format::Off | Format::Gltf | Format::Glb => uvs.iter().any(lacks),
        // A whole face can be without them.
        Format::Ply => (0..model.soup.face_count()).any(|face| {
            let uvs = &uvs[model.soup.corner_range(face)];
            uvs.iter().any(lacks) && uvs.iter().any(are_finite)
        }),
        Format::Obj | Format::Stl => false,
    }
}

fn has_unused_vertices(model: &Model) -> bool {
    let mut used = vec![false; model.soup.vertex_count()];
    model.soup.corners().iter().for_each(|&vertex| used[vertex as usize] = true);
    used.contains(&false)
}
