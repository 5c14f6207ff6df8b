//! Content of a model that a format cannot hold.

use crate::format::Format;
use crate::lost::Lost;
use crate::model::{Alpha, Group, ImageData, Material, Model};
use crate::ply::Textures;
use crate::single::{are_finite, flattened, flattened_faces, rounding};
use crate::stl::{self, StlColors};
use Format::{Glb, Gltf, Obj, Off, Ply, Stl};
use glam::DVec3;

/// The properties of the output that determine what is kept.
#[derive(Clone, Copy)]
pub(crate) struct Target {
    pub(crate) format: Format,
    /// Whether the file is text.
    pub(crate) is_text: bool,
    /// Whether coordinates are rounded to 32 bits where they are.
    pub(crate) is_single: bool,
    /// The convention for colours of binary STL.
    pub(crate) stl_colors: StlColors,
    /// Whether material libraries and images are written to their own files.
    pub(crate) has_companions: bool,
}

/// A kind of content.
struct Kind {
    what: String,
    /// The number of such elements in the model.
    count: u64,
    /// The formats that hold it.
    keepers: &'static [Format],
}

/// The content of the model that a file will not hold.
pub(crate) fn losses(model: &Model, target: Target) -> Vec<Lost> {
    let format = target.format;
    let kinds = kinds(model, format).into_iter();
    let kinds = kinds.filter(|kind| kind.count > 0 && !kind.keepers.contains(&format));
    let by_format = kinds
        .map(|Kind { what, count, keepers }| Lost::by_format(what, Some(count), format, keepers));
    let is_rounded = target.is_single && rounding(model.soup.positions()) > 0.0;
    let flattened =
        is_rounded.then(|| flattened(flattened_faces(&model.soup, DVec3::ZERO), format)).flatten();
    by_format.chain(special(model, target)).chain(flattened).collect()
}

fn length<T>(values: Option<&Vec<T>>) -> u64 {
    values.map_or(0, |values| values.len() as u64)
}

/// Content that depends on the format only, not on values; but PLY holds materials that are pictures.
fn kinds(model: &Model, format: Format) -> Vec<Kind> {
    let kind = |what: &str, count: u64, keepers| Kind { what: what.to_owned(), count, keepers };
    let named = |what: &str, all: &[crate::scalars::Scalars], keepers| {
        let names: Vec<&str> = all.iter().map(|scalars| scalars.name.as_str()).collect();
        let what = format!("numbers per {what}: {}", names.join(", "));
        Kind { what, count: all.len() as u64, keepers }
    };
    let faces_with = |ids: &Option<Vec<u32>>, count: usize| {
        let ids = ids.as_deref().unwrap_or_default();
        if ids.iter().any(|&id| (id as usize) < count) { count as u64 } else { 0 }
    };
    let polygons = model.soup.faces().filter(|face| face.len() > 3).count() as u64;
    let set = model.more_corner_uvs.len() as u64;
    let groups = if model.groups.iter().any(|group| *group != Group::default()) {
        faces_with(&model.face_groups, model.groups.len())
    } else {
        0
    };
    let materials = match Textures::new(model) {
        Some(_) if format == Ply => 0,
        _ => faces_with(&model.face_materials, model.materials.len()),
    };
    vec![
        kind("polygons (cut into triangles)", polygons, &[Obj, Ply, Off]),
        kind("vertex normals", length(model.vertex_normals.as_ref()), &[Obj, Ply, Off, Gltf, Glb]),
        kind("vertex colours", length(model.vertex_colors.as_ref()), &[Obj, Ply, Off, Gltf, Glb]),
        kind("corner normals", length(model.corner_normals.as_ref()), &[Obj, Gltf, Glb]),
        kind("texture coordinates", length(model.corner_uvs.as_ref()), &[Obj, Ply, Off, Gltf, Glb]),
        kind("further sets of texture coordinates", set, &[Gltf, Glb]),
        kind("face colours", length(model.face_colors.as_ref()), &[Ply, Off, Stl]),
        kind("materials", materials, &[Obj, Gltf, Glb]),
        kind("groups", groups, &[Obj, Stl]),
        named("vertex", &model.vertex_scalars, &[Ply, Gltf, Glb]),
        named("face", &model.face_scalars, &[Ply]),
    ]
}

/// Content that depends on values, or on more than the format.
fn special(model: &Model, target: Target) -> Vec<Lost> {
    let Target { format, is_text, has_companions, .. } = target;
    let mut all = Vec::new();
    let mut lose = |count: u64, what: &str, why: &str| {
        if count > 0 {
            all.push(Lost::some(what, count, why));
        }
    };
    let points = match format {
        Stl => unused_vertices(model),
        _ => 0,
    };
    let holds_points = format!("{format} files hold faces only; PLY, OBJ, glTF and GLB keep them");
    lose(points, "vertices that no face uses", &holds_points);
    if model.corner_normals.is_some() && matches!(format, Obj | Gltf | Glb) {
        let why = "the corners have normals of their own";
        lose(length(model.vertex_normals.as_ref()), "vertex normals", why);
    }
    if format == Off && model.corner_uvs.is_some() && model.vertex_uvs().is_none() {
        let why = "they differ between the faces at a vertex, for which OFF has no place";
        lose(length(model.corner_uvs.as_ref()), "texture coordinates", why);
    } else {
        lose(gaps(model, format), "gaps in the texture coordinates", "0 is written there");
    }
    if format == Stl && is_text {
        let why = "only binary STL has a place for them";
        lose(length(model.face_colors.as_ref()), "face colours", why);
    }
    if format == Stl && !is_text {
        let named = model.groups.iter().filter(|group| **group != Group::default()).count();
        let why = "binary STL has no place for them; --encoding text writes them as solids";
        lose(named as u64, "names of groups", why);
        let why = "STL has five bits per channel and no opacity";
        lose(rounded_colors(model), "bits of face colours", why);
    }
    if format == Ply {
        let more = Textures::new(model).map_or(0, |textures| textures.more_than_pictures);
        let why = "PLY names the pictures of textures only; OBJ, glTF or GLB keeps them";
        lose(more, "names, colours and looks of materials", why);
    }
    let comments = model.comments.len() as u64;
    match format {
        Ply => {
            let uncolored = model.face_colors.iter().flatten().filter(|color| color[0].is_nan());
            lose(uncolored.count() as u64, "gaps in the face colours", "white is written there");
        }
        Stl if !is_text => {
            let kept = u64::from(stl::comment(model, target.stl_colors).is_some());
            lose(comments - kept, "comments", "binary STL has 80 bytes for one; PLY keeps them");
        }
        _ => lose(comments, "comments", &format!("{format} has no place for them; PLY keeps them")),
    }
    smoothing(model, format, &mut lose);
    if format == Obj {
        lose(looks(model), "metalness, roughness, opacity limits and sides of materials", NO_LOOKS);
        let control = |name: &String| name.contains(char::is_control);
        let names = model.images.iter().filter(|image| match &image.data {
            ImageData::Uri(name) => control(name),
            ImageData::Bytes(_) => false,
        });
        let why = "a name in a material library ends with its line";
        lose(names.count() as u64, "textures whose names have line breaks", why);
    }
    if !has_companions && !matches!(format, Gltf | Glb) {
        let embedded = model.images.iter().filter(|i| matches!(i.data, ImageData::Bytes(_)));
        let why = "only glTF and GLB hold images; OBJ has them in files beside it";
        lose(embedded.count() as u64, "embedded images", why);
    }
    if matches!(format, Gltf | Glb) {
        rounded_numbers(model, &mut lose);
    }
    all
}

const NO_LOOKS: &str = "material libraries have no place for them; glTF and GLB keep them";

/// Smoothing groups become normals in formats with corner normals.
fn smoothing(model: &Model, format: Format, lose: &mut impl FnMut(u64, &str, &str)) {
    let Some(groups) = &model.face_smoothing else { return };
    let mut distinct: Vec<u32> = groups.iter().copied().filter(|&group| group != 0).collect();
    distinct.sort_unstable();
    distinct.dedup();
    let why = match format {
        Obj => return,
        Gltf | Glb if model.corner_normals.is_some() || model.vertex_normals.is_some() => {
            "the normals of the file are written instead"
        }
        Gltf | Glb => return,
        _ => "only OBJ has them; glTF and GLB get normals made from them",
    };
    lose(distinct.len() as u64, "smoothing groups", why);
}

/// The number of materials with properties that material libraries cannot hold.
fn looks(model: &Model) -> u64 {
    let has_looks = |material: &&Material| {
        let Material { metallic, roughness, double_sided, alpha, .. } = **material;
        let mask = matches!(alpha, Alpha::Mask(_));
        metallic != 0.0 || roughness != 1.0 || double_sided || mask
    };
    model.materials.iter().filter(has_looks).count() as u64
}

/// Columns with numbers that 32-bit floating point rounds.
fn rounded_numbers(model: &Model, lose: &mut impl FnMut(u64, &str, &str)) {
    for scalars in &model.vertex_scalars {
        let values = &scalars.values;
        let is_rounded = |place: &usize| match values.whole(*place) {
            Some(whole) => whole.unsigned_abs() > 1 << 24 && whole as f32 as i128 != whole,
            None => values.get(*place).is_some_and(|v| f64::from(v as f32) != v && !v.is_nan()),
        };
        let count = (0..values.len()).filter(is_rounded).count() as u64;
        let what = format!("digits of the numbers {}", scalars.name);
        lose(count, &what, "glTF has 32-bit floating point only; PLY keeps them");
    }
}

/// The number of faces whose colour changes with five bits per channel.
fn rounded_colors(model: &Model) -> u64 {
    let changes = |color: &&[f32; 4]| {
        let five = |value: f32| (value.clamp(0.0, 1.0) * 31.0).round() / 31.0;
        let differs = |value: f32| (five(value) - value).abs() > 0.5 / 255.0;
        !color[0].is_nan() && (color[..3].iter().any(|&v| differs(v)) || color[3] != 1.0)
    };
    model.face_colors.iter().flatten().filter(changes).count() as u64
}

/// The number of corners without texture coordinates that get some, because the format has no other way.
fn gaps(model: &Model, format: Format) -> u64 {
    let Some(uvs) = &model.corner_uvs else { return 0 };
    let lacks = |uv: &&[f32; 2]| !are_finite(uv);
    match format {
        Off | Gltf | Glb => uvs.iter().filter(lacks).count() as u64,
        // PLY can leave out texture coordinates of whole faces.
        Ply => (0..model.soup.face_count())
            .map(|face| {
                let uvs = &uvs[model.soup.corner_range(face)];
                let count = uvs.iter().filter(lacks).count();
                if count < uvs.len() { count as u64 } else { 0 }
            })
            .sum(),
        Obj | Stl => 0,
    }
}

fn unused_vertices(model: &Model) -> u64 {
    let mut used = vec![false; model.soup.vertex_count()];
    model.soup.corners().iter().for_each(|&vertex| used[vertex as usize] = true);
    used.iter().filter(|&&is_used| !is_used).count() as u64
}
