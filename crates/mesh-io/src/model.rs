//! The content of a mesh file, in one data structure for all formats.

use crate::color::are_bytes;
use crate::external::is_file_name;
use crate::lost::Lost;
use crate::picture_format::PictureFormat;
use crate::scalars::{ScalarValues, Scalars};
use crate::text::brief;
use glam::DVec3;
use mesh_core::{PolygonSoup, TriMesh};

/// The content of a mesh file: a polygon soup with attributes of its vertices, faces and corners.
///
/// A *corner* is a vertex of a face, numbered as in [`PolygonSoup::corners`]. Attributes that can differ between
/// the faces at a vertex are stored per corner: texture coordinates, and normals across a crease. Every attribute is
/// optional. Its length is the number of vertices, faces or corners; [`Model::check`] verifies that.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct Model {
    /// Positions and faces.
    pub soup: PolygonSoup,
    /// One normal per vertex, as in the file: not necessarily of unit length.
    pub vertex_normals: Option<Vec<[f32; 3]>>,
    /// One colour per vertex: red, green, blue and opacity from 0 to 1, in the colour space of the file. Eight-bit
    /// colours are kept exactly.
    pub vertex_colors: Option<Vec<[f32; 4]>>,
    /// Named numbers, one per vertex.
    pub vertex_scalars: Vec<Scalars>,
    /// One normal per corner; NaN if the file has none.
    pub corner_normals: Option<Vec<[f32; 3]>>,
    /// One texture coordinate per corner, with the origin at the lower left; NaN if the file has none.
    pub corner_uvs: Option<Vec<[f32; 2]>>,
    /// Further sets of texture coordinates, for example for a light map, each as `corner_uvs`.
    pub more_corner_uvs: Vec<Vec<[f32; 2]>>,
    /// One colour per face, as in `vertex_colors`; NaN if the file has none.
    pub face_colors: Option<Vec<[f32; 4]>>,
    /// Named numbers, one per face.
    pub face_scalars: Vec<Scalars>,
    /// The smoothing group of every face (`s` in OBJ): faces of a group are smooth across their common edges. 0 means
    /// no group.
    pub face_smoothing: Option<Vec<u32>>,
    /// The group of every face, an index into `groups` or [`Model::NONE`].
    pub face_groups: Option<Vec<u32>>,
    /// The groups.
    pub groups: Vec<Group>,
    /// The material of every face, an index into `materials` or [`Model::NONE`].
    pub face_materials: Option<Vec<u32>>,
    /// The materials.
    pub materials: Vec<Material>,
    /// The images that the materials refer to.
    pub images: Vec<Image>,
    /// The material libraries that an OBJ file names.
    pub material_libraries: Vec<String>,
    /// The comments in the header of a PLY file, in order. A comment that starts with `obj_info ` is a line of
    /// `obj_info`.
    pub comments: Vec<String>,
    /// Messages of the reader for people: losses, repairs and assumptions. At most a hundred, and
    /// [printable](crate::printable).
    pub notes: Vec<String>,
    /// The content of the file that is not in this model. Each loss is in the notes as well.
    pub lost: Vec<Lost>,
}

/// A named part of a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Group {
    /// The object (`o` in OBJ, a node in glTF), or empty.
    pub object: String,
    /// The group within it (`g` in OBJ, a solid in STL), or empty.
    pub name: String,
}

/// The appearance of a surface.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct Material {
    /// The name, or empty.
    pub name: String,
    /// Red, green, blue, opacity from 0 to 1, multiplied with the texture.
    pub base_color: [f32; 4],
    /// The texture of the base colour, an index into [`Model::images`].
    pub base_color_image: Option<u32>,
    /// From 0 (dielectric) to 1 (metal).
    pub metallic: f32,
    /// From 0 (mirror) to 1 (matt).
    pub roughness: f32,
    /// Emitted light.
    pub emissive: [f32; 3],
    /// Whether the back of the faces is drawn.
    pub double_sided: bool,
    /// The meaning of the opacity.
    pub alpha: Alpha,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_image: None,
            metallic: 0.0,
            roughness: 1.0,
            emissive: [0.0; 3],
            double_sided: false,
            alpha: Alpha::Opaque,
        }
    }
}

/// The meaning of the opacity of a material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Alpha {
    /// The opacity is ignored: the surface is opaque.
    #[default]
    Opaque,
    /// The surface is invisible where its opacity is below this.
    Mask(f32),
    /// The surface is blended with its background.
    Blend,
}

/// An image.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Image {
    /// The name, or empty.
    pub name: String,
    /// The media type, such as `image/png`; empty if the file does not state it.
    pub media_type: String,
    /// The image itself.
    pub data: ImageData,
}

/// The location of an image.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ImageData {
    /// Embedded: the bytes of an encoded image file.
    Bytes(Vec<u8>),
    /// In a file, named relative to the file that refers to it: a path with `/` between its parts, not percent-encoded.
    /// A name with a scheme (`https://`) is unchanged.
    Uri(String),
}

/// An inconsistency in a model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The length of an attribute does not match its elements.
    #[error("{} has {found} entries, but the model has {expected} {of}", brief(attribute))]
    Length {
        /// The attribute.
        attribute: String,
        /// The number of entries.
        found: usize,
        /// The elements that it describes.
        of: &'static str,
        /// The number of elements of this kind.
        expected: usize,
    },
    /// An index is out of range.
    #[error("{of} {index} refers to {what} {value}, but there are only {count}")]
    Index {
        /// The kind of element that holds the index.
        of: &'static str,
        /// The index of this element.
        index: usize,
        /// The kind of element that the index refers to.
        what: &'static str,
        /// The index.
        value: u32,
        /// The number of such elements.
        count: usize,
    },
    /// A face has fewer than three corners.
    #[error("face {face} has {corners} corners; a face needs three")]
    TooFewCorners {
        /// The face.
        face: usize,
        /// The number of corners.
        corners: usize,
    },
    /// A rebuilt mesh is larger than 32-bit indices can address.
    #[error(transparent)]
    TooManyCorners(#[from] mesh_core::soup::TooManyCorners),
}

impl Model {
    /// The group or material of a face without one.
    pub const NONE: u32 = u32::MAX;

    /// Checks the length of every attribute and the range of every index.
    ///
    /// # Errors
    /// The first inconsistency.
    pub fn check(&self) -> Result<(), ModelError> {
        self.check_attributes()?;
        in_range("corner", self.soup.corners(), "vertex", self.soup.vertex_count(), None)?;
        match self.soup.faces().enumerate().find(|(_, face)| face.len() < 3) {
            Some((face, vertices)) => {
                Err(ModelError::TooFewCorners { face, corners: vertices.len() })
            }
            None => Ok(()),
        }
    }

    /// Whether every attribute has one entry per element and every index of a group, material or image
    /// is in range. Faces are not checked.
    ///
    /// # Errors
    /// The first inconsistency.
    pub fn check_attributes(&self) -> Result<(), ModelError> {
        let (vertices, faces, corners) =
            (self.soup.vertex_count(), self.soup.face_count(), self.soup.corners().len());
        same_length("vertex_normals", self.vertex_normals.as_deref(), "vertices", vertices)?;
        same_length("vertex_colors", self.vertex_colors.as_deref(), "vertices", vertices)?;
        same_length("corner_normals", self.corner_normals.as_deref(), "corners", corners)?;
        same_length("corner_uvs", self.corner_uvs.as_deref(), "corners", corners)?;
        for uvs in &self.more_corner_uvs {
            same_length("more_corner_uvs", Some(uvs), "corners", corners)?;
        }
        same_length("face_smoothing", self.face_smoothing.as_deref(), "faces", faces)?;
        same_length("face_colors", self.face_colors.as_deref(), "faces", faces)?;
        same_length("face_groups", self.face_groups.as_deref(), "faces", faces)?;
        same_length("face_materials", self.face_materials.as_deref(), "faces", faces)?;
        for (all, of, expected) in
            [(&self.vertex_scalars, "vertices", vertices), (&self.face_scalars, "faces", faces)]
        {
            for Scalars { name, values, .. } in all {
                length_is(name, values.len(), of, expected)?;
            }
        }
        let none = Some(Self::NONE);
        in_range(
            "face",
            self.face_groups.as_deref().unwrap_or_default(),
            "group",
            self.groups.len(),
            none,
        )?;
        let materials = self.face_materials.as_deref().unwrap_or_default();
        in_range("face", materials, "material", self.materials.len(), none)?;
        for (index, material) in self.materials.iter().enumerate() {
            let image = material.base_color_image.as_slice();
            in_range("material", image, "image", self.images.len(), None).map_err(|error| {
                match error {
                    ModelError::Index { of, what, value, count, .. } => {
                        ModelError::Index { of, index, what, value, count }
                    }
                    other => other,
                }
            })?;
        }
        Ok(())
    }

    /// The model of a mesh that was rebuilt from this one, with its attributes.
    ///
    /// `vertex_source` holds the source vertex of each new position. `face_source` and `corner_source` hold the
    /// source face and the source corners of each new triangle, with corners numbered by [`PolygonSoup::corners`].
    ///
    /// # Errors
    /// A source is out of range, the number of sources is wrong, or the result is too large for 32-bit indices.
    pub fn reindexed(
        &self,
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        vertex_source: &[u32],
        face_source: &[u32],
        corner_source: &[[u32; 3]],
    ) -> Result<Self, ModelError> {
        same_length("vertex_source", Some(vertex_source), "vertices", positions.len())?;
        same_length("face_source", Some(face_source), "triangles", triangles.len())?;
        same_length("corner_source", Some(corner_source), "triangles", triangles.len())?;
        // Faces that a repair has dropped may have been invalid.
        self.check_attributes()?;
        let corner_source = corner_source.as_flattened();
        let (vertices, faces) = (self.soup.vertex_count(), self.soup.face_count());
        in_range("new vertex", vertex_source, "vertex", vertices, None)?;
        in_range("new triangle", face_source, "face", faces, None)?;
        in_range("new corner", corner_source, "corner", self.soup.corners().len(), None)?;
        let model = Self {
            soup: PolygonSoup::from_triangles(positions, triangles)?,
            vertex_normals: gather(self.vertex_normals.as_deref(), vertex_source),
            vertex_colors: gather(self.vertex_colors.as_deref(), vertex_source),
            vertex_scalars: gather_scalars(&self.vertex_scalars, vertex_source),
            corner_normals: gather(self.corner_normals.as_deref(), corner_source),
            corner_uvs: gather(self.corner_uvs.as_deref(), corner_source),
            more_corner_uvs: self
                .more_corner_uvs
                .iter()
                .filter_map(|uvs| gather(Some(uvs), corner_source))
                .collect(),
            face_smoothing: gather(self.face_smoothing.as_deref(), face_source),
            face_colors: gather(self.face_colors.as_deref(), face_source),
            face_scalars: gather_scalars(&self.face_scalars, face_source),
            face_groups: gather(self.face_groups.as_deref(), face_source),
            groups: self.groups.clone(),
            face_materials: gather(self.face_materials.as_deref(), face_source),
            materials: self.materials.clone(),
            images: self.images.clone(),
            material_libraries: self.material_libraries.clone(),
            comments: self.comments.clone(),
            notes: self.notes.clone(),
            lost: self.lost.clone(),
        };
        in_range("new corner", model.soup.corners(), "vertex", positions.len(), None)?;
        Ok(model)
    }
}

/// A weighted mean of the data of three corners or vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Blend {
    /// The sources.
    pub sources: [u32; 3],
    /// Their weights, with sum 1; sources with weight 0 are ignored.
    pub weights: [f64; 3],
}

impl Blend {
    /// The data of one corner or vertex.
    #[must_use]
    pub fn one(source: u32) -> Self {
        Self { sources: [source; 3], weights: [1.0, 0.0, 0.0] }
    }

    /// The source with the largest weight, the first of those with equal weights.
    #[must_use]
    pub fn nearest(&self) -> u32 {
        let [a, b, c] = self.weights;
        let place = if a >= b && a >= c { 0 } else { 1 + usize::from(c > b) };
        self.sources[place]
    }

    fn of<const N: usize>(&self, values: &[[f32; N]]) -> [f32; N] {
        core::array::from_fn(|i| self.sum(|source| f64::from(values[source][i])) as f32)
    }

    fn sum(&self, value: impl Fn(usize) -> f64) -> f64 {
        let weighted = self.weights.iter().zip(self.sources).filter(|(weight, _)| **weight != 0.0);
        weighted.map(|(weight, source)| weight * value(source as usize)).sum()
    }
}

impl Model {
    /// The model of a mesh whose vertices lie between the vertices of this one: as [`Model::reindexed`], with
    /// interpolated data of vertices and corners. Normals get unit length, eight-bit colours stay eight-bit colours,
    /// and labels are copied from the nearest vertex.
    ///
    /// # Errors
    /// As [`Model::reindexed`].
    pub fn blended(
        &self,
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        vertices: &[Blend],
        face_source: &[u32],
        corners: &[[Blend; 3]],
    ) -> Result<Self, ModelError> {
        let flat = corners.as_flattened();
        let nearest =
            |blends: &[Blend]| -> Vec<u32> { blends.iter().map(Blend::nearest).collect() };
        let nearest_corners: Vec<_> = corners.iter().map(|c| c.map(|b| b.nearest())).collect();
        let mut model = self.reindexed(
            positions,
            triangles,
            &nearest(vertices),
            face_source,
            &nearest_corners,
        )?;
        let others =
            |blends: &[Blend]| -> Vec<u32> { blends.iter().flat_map(|b| b.sources).collect() };
        in_range("new vertex", &others(vertices), "vertex", self.soup.vertex_count(), None)?;
        in_range("new corner", &others(flat), "corner", self.soup.corners().len(), None)?;
        let unit = |blends: &[Blend], normals: &Vec<[f32; 3]>| -> Vec<[f32; 3]> {
            let normal = |b: &Blend| glam::Vec3::from(b.of(normals)).normalize_or(glam::Vec3::NAN);
            blends.iter().map(|b| normal(b).to_array()).collect()
        };
        let all =
            |blends: &[Blend], uvs: &Vec<[f32; 2]>| blends.iter().map(|b| b.of(uvs)).collect();
        model.vertex_normals = self.vertex_normals.as_ref().map(|n| unit(vertices, n));
        model.corner_normals = self.corner_normals.as_ref().map(|n| unit(flat, n));
        model.corner_uvs = self.corner_uvs.as_ref().map(|uvs| all(flat, uvs));
        model.more_corner_uvs = self.more_corner_uvs.iter().map(|uvs| all(flat, uvs)).collect();
        model.vertex_colors = self.vertex_colors.as_ref().map(|c| blend_colors(c, vertices));
        let old = &self.vertex_scalars;
        for (new, old) in model.vertex_scalars.iter_mut().zip(old).filter(|(new, _)| !new.is_label)
        {
            new.values = blend_scalars(&old.values, vertices);
        }
        Ok(model)
    }
}

fn blend_colors(colors: &[[f32; 4]], blends: &[Blend]) -> Vec<[f32; 4]> {
    let eight_bits = are_bytes(colors);
    let round = |c: f32| if eight_bits { (255.0 * c).round() / 255.0 } else { c };
    blends.iter().map(|b| b.of(colors).map(round)).collect()
}

impl From<PolygonSoup> for Model {
    fn from(soup: PolygonSoup) -> Self {
        Self { soup, ..Self::default() }
    }
}

/// Vertices and faces keep their order; gaps are closed.
impl From<&TriMesh> for Model {
    fn from(mesh: &TriMesh) -> Self {
        mesh.to_soup().into()
    }
}

impl Model {
    /// Whether the model has only vertices and faces.
    #[must_use]
    pub fn is_bare(&self) -> bool {
        let Self {
            soup: _,
            vertex_normals,
            vertex_colors,
            vertex_scalars,
            corner_normals,
            corner_uvs,
            more_corner_uvs,
            face_colors,
            face_scalars,
            face_smoothing,
            face_groups,
            groups,
            face_materials,
            materials,
            images,
            material_libraries,
            comments: _,
            notes: _,
            lost: _,
        } = self;
        vertex_normals.is_none()
            && vertex_colors.is_none()
            && vertex_scalars.is_empty()
            && corner_normals.is_none()
            && corner_uvs.is_none()
            && more_corner_uvs.is_empty()
            && face_smoothing.is_none()
            && face_colors.is_none()
            && face_scalars.is_empty()
            && face_groups.is_none()
            && groups.is_empty()
            && face_materials.is_none()
            && materials.is_empty()
            && images.is_empty()
            && material_libraries.is_empty()
    }

    /// The names of images in files of their own, relative to the file, as they are written in it.
    #[must_use]
    pub fn file_pictures(&self) -> Vec<&str> {
        let names = self.images.iter().filter_map(|image| match &image.data {
            ImageData::Uri(name) => Some(name.as_str()),
            ImageData::Bytes(_) => None,
        });
        names.filter(|name| is_file_name(name)).collect()
    }

    /// Texture coordinates by vertex, if there are any and all corners of every vertex agree. Zero at vertices that no
    /// face uses.
    #[must_use]
    pub fn vertex_uvs(&self) -> Option<Vec<[f32; 2]>> {
        let corner_uvs = self.corner_uvs.as_deref()?;
        let mut uvs = vec![None; self.soup.vertex_count()];
        for (&vertex, &uv) in self.soup.corners().iter().zip(corner_uvs) {
            let bits = uv.map(f32::to_bits);
            if uvs.get_mut(vertex as usize)?.replace(bits).is_some_and(|other| other != bits) {
                return None;
            }
        }
        Some(uvs.into_iter().map(|uv| uv.unwrap_or_default().map(f32::from_bits)).collect())
    }
}

impl Image {
    /// The media type. If the file does not state it, it is derived from the first bytes; empty if unknown.
    #[must_use]
    pub fn media_type(&self) -> &str {
        match &self.data {
            ImageData::Bytes(bytes) if self.media_type.is_empty() => {
                PictureFormat::of(bytes).map_or("", PictureFormat::media_type)
            }
            _ => &self.media_type,
        }
    }
}

fn same_length<T>(
    attribute: &str,
    values: Option<&[T]>,
    of: &'static str,
    expected: usize,
) -> Result<(), ModelError> {
    values.map_or(Ok(()), |values| length_is(attribute, values.len(), of, expected))
}

fn length_is(
    attribute: &str,
    found: usize,
    of: &'static str,
    expected: usize,
) -> Result<(), ModelError> {
    if found == expected {
        return Ok(());
    }
    Err(ModelError::Length { attribute: attribute.to_owned(), found, of, expected })
}

fn in_range(
    of: &'static str,
    values: &[u32],
    what: &'static str,
    count: usize,
    none: Option<u32>,
) -> Result<(), ModelError> {
    match values.iter().position(|&value| value as usize >= count && Some(value) != none) {
        Some(index) => Err(ModelError::Index { of, index, what, value: values[index], count }),
        None => Ok(()),
    }
}

/// The values at `source`, whose range has been checked.
fn gather<T: Copy>(values: Option<&[T]>, source: &[u32]) -> Option<Vec<T>> {
    values.map(|values| source.iter().map(|&index| values[index as usize]).collect())
}

fn gather_scalars(scalars: &[Scalars], source: &[u32]) -> Vec<Scalars> {
    scalars.iter().map(|scalars| scalars.with(scalars.values.gather(source))).collect()
}

/// Interpolated numbers, in the original type. Rounding does not take them out of the range of their sources.
fn blend_scalars(values: &ScalarValues, blends: &[Blend]) -> ScalarValues {
    let old = values.to_f64();
    let between = |blend: &Blend| {
        let sum = blend.sum(|source| old[source]);
        let used = blend.sources.iter().zip(blend.weights).filter(|(_, weight)| *weight != 0.0);
        let used = used.map(|(&source, _)| old[source as usize]);
        let (low, high) = used.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        // An unknown number makes the sum unknown.
        if sum.is_nan() { sum } else { sum.max(low).min(high) }
    };
    let blended: ScalarValues = blends.iter().map(between).collect();
    blended.cast(values.scalar_type())
}
