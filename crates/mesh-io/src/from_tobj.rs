//! Models from data loaded by the crate `tobj`.

use crate::lost::Lost;
use crate::model::{Alpha, Group, Image, ImageData, Material, Model, ModelError};
use glam::DVec3;
use mesh_core::as_u32;
use mesh_core::soup::TooManyCorners;

impl Model {
    /// The model of an OBJ file loaded by `tobj`: one group for each `tobj::Model`, with its material.
    ///
    /// Any load options are possible. `single_index` and `triangulate` should be off, because they split vertices and
    /// cut polygons.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no square\nf 1 2 3 4\n";
    /// let no_libraries = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    /// let options = tobj::LoadOptions::default();
    /// let (models, _) = tobj::load_obj_buf(&mut obj.as_bytes(), &options, no_libraries)?;
    ///
    /// let model = mesh_io::Model::from_tobj(&models, &[])?;
    /// assert_eq!(model.soup.face(0), [0, 1, 2, 3]);
    /// assert_eq!(model.groups[0].object, "square");
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// An index is out of range, or there are more corners than 32-bit indices can address.
    pub fn from_tobj(
        models: &[tobj::Model],
        materials: &[tobj::Material],
    ) -> Result<Self, ModelError> {
        let mut loaded = Loaded::default();
        for (group, model) in (0..).zip(models) {
            loaded.mesh(&model.mesh, group, materials.len())?;
        }
        let mut model = loaded.model;
        pad(&mut model.corner_uvs, model.soup.corners().len(), [f32::NAN; 2]);
        pad(&mut model.corner_normals, model.soup.corners().len(), [f32::NAN; 3]);
        pad(&mut model.vertex_colors, model.soup.vertex_count(), [1.0; 4]);
        let group = |model: &tobj::Model| Group { object: model.name.clone(), name: String::new() };
        model.groups = models.iter().map(group).collect();
        (model.materials, model.images) = read_materials(materials);
        if model.materials.is_empty() {
            model.face_materials = None;
        }
        if loaded.small > 0 {
            let what = "lines, points and other faces of fewer than three corners";
            model.lost.push(Lost::some(what, loaded.small, "a model holds faces only"));
        }
        crate::color_range::to_unit_range(&mut model);
        model.check()?;
        Ok(model)
    }
}

#[derive(Default)]
struct Loaded {
    model: Model,
    /// Faces of fewer than three corners.
    small: u64,
}

impl Loaded {
    #[allow(clippy::useless_conversion, reason = "the precision of tobj depends on its features")]
    fn mesh(&mut self, mesh: &tobj::Mesh, group: u32, materials: usize) -> Result<(), ModelError> {
        let model = &mut self.model;
        let base = model.soup.vertex_count();
        for &[x, y, z] in mesh.positions.as_chunks::<3>().0 {
            model.soup.push_vertex(DVec3::new(x.into(), y.into(), z.into()));
        }
        if !mesh.vertex_color.is_empty() {
            let colors = model.vertex_colors.get_or_insert_default();
            colors.resize(base, [1.0; 4]);
            let colors_of_mesh = mesh.vertex_color.as_chunks::<3>().0;
            colors.extend(
                colors_of_mesh.iter().map(|&[r, g, b]| [r as f32, g as f32, b as f32, 1.0]),
            );
        }
        let material = mesh.material_id.filter(|&id| id < materials);
        let material = material.map_or(Model::NONE, as_u32);
        let first_vertex = u32::try_from(base).map_err(|_| TooManyCorners)?;
        let mut first = 0;
        let triangles =
            [3].repeat(if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 });
        for &arity in mesh.face_arities.iter().chain(&triangles) {
            let corners = first..first + arity as usize;
            first = corners.end;
            if arity < 3 {
                self.small += 1;
                continue;
            }
            face(model, mesh, corners, first_vertex)?;
            model.face_groups.get_or_insert_default().push(group);
            model.face_materials.get_or_insert_default().push(material);
        }
        Ok(())
    }
}

/// Appends a face with corners at these indices.
fn face(
    model: &mut Model,
    mesh: &tobj::Mesh,
    places: std::ops::Range<usize>,
    base: u32,
) -> Result<(), ModelError> {
    let before = model.soup.corners().len();
    let vertices = mesh.indices.get(places.clone()).unwrap_or_default();
    let vertices: Vec<u32> = vertices.iter().map(|&v| base.saturating_add(v)).collect();
    model.soup.push_face(&vertices)?;
    // With a single index, all attributes use the index of the position.
    let index = |own: &[u32], place: usize| {
        let own = own.get(place).copied();
        own.or_else(|| mesh.indices.get(place).copied()).unwrap_or(u32::MAX) as usize
    };
    if !mesh.texcoords.is_empty() {
        let all = mesh.texcoords.as_chunks::<2>().0;
        let uv = |place| all.get(index(&mesh.texcoord_indices, place));
        let uvs = places
            .clone()
            .map(|place| uv(place).map_or([f32::NAN; 2], |uv| uv.map(|value| value as f32)));
        let corner_uvs = model.corner_uvs.get_or_insert_default();
        corner_uvs.resize(before, [f32::NAN; 2]);
        corner_uvs.extend(uvs);
    }
    if !mesh.normals.is_empty() {
        let all = mesh.normals.as_chunks::<3>().0;
        let normal = |place| all.get(index(&mesh.normal_indices, place));
        let normals = places.map(|place| {
            normal(place).map_or([f32::NAN; 3], |normal| normal.map(|value| value as f32))
        });
        let corner_normals = model.corner_normals.get_or_insert_default();
        corner_normals.resize(before, [f32::NAN; 3]);
        corner_normals.extend(normals);
    }
    Ok(())
}

fn pad<T: Clone>(values: &mut Option<Vec<T>>, count: usize, value: T) {
    if let Some(values) = values {
        values.resize(count, value);
    }
}

fn read_materials(materials: &[tobj::Material]) -> (Vec<Material>, Vec<Image>) {
    let mut images: Vec<Image> = Vec::new();
    let mut image_of = |name: &String| {
        let uri = name.replace('\\', "/");
        let is_same = |image: &Image| matches!(&image.data, ImageData::Uri(other) if *other == uri);
        let place = images.iter().position(is_same).unwrap_or(images.len());
        if place == images.len() {
            let (name, media_type) = (String::new(), String::new());
            images.push(Image { name, media_type, data: ImageData::Uri(uri) });
        }
        as_u32(place)
    };
    let read = |material: &tobj::Material| {
        let [r, g, b] = material.diffuse.map_or([1.0; 3], |color| color.map(|value| value as f32));
        let opacity = material.dissolve.map_or(1.0, |opacity| opacity as f32);
        Material {
            name: material.name.clone(),
            base_color: [r, g, b, opacity],
            base_color_image: material.diffuse_texture.as_ref().map(&mut image_of),
            alpha: if opacity < 1.0 { Alpha::Blend } else { Alpha::Opaque },
            ..Material::default()
        }
    };
    let materials = materials.iter().map(read).collect();
    (materials, images)
}
