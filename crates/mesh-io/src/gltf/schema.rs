//! The parts of a glTF document that are read, as they are in the JSON.
//!
//! Objects are small, because a document may hold one for every three bytes, and unused data is not kept. Indices are
//! unchecked; the user of an index must check it.

use crate::meshopt::stream::Broken;
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::sync::OnceLock;

/// The size of the largest object of which there may be one for every brace in the text, without the parts that are
/// counted by their own characters.
pub(crate) const LARGEST: u64 = size_of::<Node>() as u64 + 16;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Root {
    #[serde(rename = "asset")]
    _asset: IgnoredAny,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub animations: Vec<IgnoredAny>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub buffer_views: Vec<View>,
    #[serde(default)]
    pub cameras: Vec<IgnoredAny>,
    #[serde(default)]
    pub extensions: RootExtensions,
    #[serde(default)]
    pub extensions_required: Vec<Box<str>>,
    #[serde(default)]
    pub extensions_used: Vec<Box<str>>,
    #[serde(default, deserialize_with = "present")]
    pub extras: bool,
    #[serde(default)]
    pub images: Vec<Image>,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub samplers: Vec<IgnoredAny>,
    pub scene: Option<u32>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub skins: Vec<Skin>,
    #[serde(default)]
    pub textures: Vec<Texture>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(crate) struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub lights: Option<Lights>,
}

#[derive(Deserialize)]
pub(crate) struct Lights {
    #[serde(default)]
    pub lights: Vec<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub buffer_view: Option<u32>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
    pub count: u64,
    #[serde(rename = "type")]
    pub shape: Shape,
    #[serde(default)]
    pub normalized: bool,
    pub sparse: Option<Box<Sparse>>,
    /// The values, if only compressed data have them.
    #[serde(skip)]
    pub decoded: Option<Box<[u8]>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum Shape {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

impl Shape {
    pub(crate) fn is_scalar(self) -> bool {
        matches!(self, Self::Scalar)
    }

    pub(crate) fn is_matrix(self) -> bool {
        matches!(self, Self::Mat2 | Self::Mat3 | Self::Mat4)
    }
}

#[derive(Deserialize)]
pub(crate) struct Sparse {
    pub count: u64,
    pub indices: SparsePart,
    pub values: SparsePart,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SparsePart {
    pub buffer_view: u32,
    #[serde(default)]
    pub byte_offset: u64,
    /// The component type of the indices; the values have the type of the accessor.
    #[serde(default)]
    pub component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Buffer {
    pub uri: Option<Box<str>>,
    pub byte_length: u64,
    #[serde(default)]
    pub extensions: BufferExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(crate) struct BufferExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Option<Fallback>,
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Option<Fallback>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Fallback {
    fallback: bool,
}

impl BufferExtensions {
    /// Whether the buffer holds only what compressed views hold too.
    pub(crate) fn is_fallback(&self) -> bool {
        [&self.ext, &self.khr].into_iter().flatten().any(|extension| extension.fallback)
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct View {
    pub buffer: u32,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u32>,
    #[serde(default)]
    pub extensions: ViewExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(crate) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Option<Box<Compressed>>,
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Option<Box<Compressed>>,
}

impl ViewExtensions {
    /// The compressed form of the view.
    pub(crate) fn compressed(&self) -> Option<&Compressed> {
        self.khr.as_deref().or(self.ext.as_deref())
    }
}

/// The compressed form of a view.
#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Compressed {
    pub buffer: u32,
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: u32,
    pub count: u64,
    pub mode: CompressionMode,
    pub filter: CompressionFilter,
    /// The bytes of the view, or the reason why there are none; empty until they are needed.
    #[serde(skip)]
    pub decoded: OnceLock<Result<Vec<u8>, Broken>>,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum CompressionMode {
    Attributes,
    Triangles,
    Indices,
    #[default]
    #[serde(other)]
    Unknown,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum CompressionFilter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
    #[serde(other)]
    Unknown,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Image {
    pub uri: Option<Box<str>>,
    pub mime_type: Option<Box<str>>,
    pub buffer_view: Option<u32>,
    pub name: Option<Box<str>>,
}

#[derive(Deserialize)]
pub(crate) struct Texture {
    pub source: Option<u32>,
    #[serde(default)]
    pub extensions: TextureExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(crate) struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp", deserialize_with = "present")]
    pub webp: bool,
    #[serde(rename = "KHR_texture_basisu", deserialize_with = "present")]
    pub basis: bool,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Material {
    pub name: Option<Box<str>>,
    pub pbr_metallic_roughness: Option<Box<Pbr>>,
    #[serde(default, deserialize_with = "present")]
    pub normal_texture: bool,
    #[serde(default, deserialize_with = "present")]
    pub occlusion_texture: bool,
    #[serde(default, deserialize_with = "present")]
    pub emissive_texture: bool,
    #[serde(default)]
    pub emissive_factor: [f32; 3],
    #[serde(default)]
    pub alpha_mode: AlphaMode,
    pub alpha_cutoff: Option<f32>,
    #[serde(default)]
    pub double_sided: bool,
    #[serde(default)]
    pub extensions: MaterialExtensions,
    #[serde(default, deserialize_with = "present")]
    pub extras: bool,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum AlphaMode {
    #[default]
    Opaque,
    Mask,
    Blend,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(crate) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub specular_glossiness: Option<Box<SpecularGlossiness>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct SpecularGlossiness {
    pub diffuse_factor: [f32; 4],
    pub diffuse_texture: Option<TextureInfo>,
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self { diffuse_factor: [1.0; 4], diffuse_texture: None }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Pbr {
    pub base_color_factor: [f32; 4],
    pub base_color_texture: Option<TextureInfo>,
    pub metallic_factor: f32,
    pub roughness_factor: f32,
    #[serde(deserialize_with = "present")]
    pub metallic_roughness_texture: bool,
}

impl Default for Pbr {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: false,
        }
    }
}

#[derive(Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub index: u32,
    #[serde(default)]
    pub tex_coord: u32,
    #[serde(default)]
    pub extensions: TextureInfoExtensions,
}

#[derive(Clone, Default, Deserialize)]
#[serde(default)]
pub(crate) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub transform: Option<TextureTransform>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct TextureTransform {
    pub offset: [f32; 2],
    pub rotation: f32,
    pub scale: [f32; 2],
    pub tex_coord: Option<u32>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

#[derive(Deserialize)]
pub(crate) struct Mesh {
    pub name: Option<Box<str>>,
    pub primitives: Vec<Primitive>,
    #[serde(default, deserialize_with = "present")]
    pub extras: bool,
}

#[derive(Deserialize)]
pub(crate) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<u32>,
    pub material: Option<u32>,
    #[serde(default = "triangles")]
    pub mode: u32,
    #[serde(default)]
    pub targets: Box<[Attributes]>,
    #[serde(default)]
    pub extensions: PrimitiveExtensions,
    #[serde(default, deserialize_with = "present")]
    pub extras: bool,
}

fn triangles() -> u32 {
    4
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(crate) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Box<Draco>>,
}

/// The compressed form of a primitive.
#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct Draco {
    pub buffer_view: u32,
    /// The numbers of the attributes in the compressed data.
    pub attributes: Attributes,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Skin {
    pub inverse_bind_matrices: Option<u32>,
    #[serde(default)]
    pub joints: Box<[u32]>,
}

#[derive(Deserialize)]
pub(crate) struct Scene {
    #[serde(default)]
    pub nodes: Vec<u32>,
    #[serde(default, deserialize_with = "present")]
    pub extras: bool,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Node {
    pub mesh: Option<u32>,
    pub skin: Option<u32>,
    #[serde(default)]
    pub children: Box<[u32]>,
    pub name: Option<Box<str>>,
    pub matrix: Option<Box<[f32; 16]>>,
    pub rotation: Option<[f32; 4]>,
    pub scale: Option<[f32; 3]>,
    pub translation: Option<[f32; 3]>,
    #[serde(default)]
    pub extensions: NodeExtensions,
    #[serde(default, deserialize_with = "present")]
    pub extras: bool,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(crate) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Box<Instancing>>,
}

#[derive(Deserialize)]
pub(crate) struct Instancing {
    pub attributes: Attributes,
}

/// Names and the accessors of their values, in the order of the names.
#[derive(Default, PartialEq, Eq, Hash)]
pub(crate) struct Attributes(Vec<(Box<str>, u32)>);

impl Attributes {
    pub(crate) fn get(&self, name: &str) -> Option<u32> {
        let place = self.0.binary_search_by(|(other, _)| other.as_ref().cmp(name)).ok()?;
        Some(self.0[place].1)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, u32)> {
        self.0.iter().map(|(name, accessor)| (name.as_ref(), *accessor))
    }
}

impl<'de> Deserialize<'de> for Attributes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries;

        impl<'de> Visitor<'de> for Entries {
            type Value = Attributes;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("names with an accessor each")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Attributes, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                entries.sort();
                // If a name is given twice, one of the values is used.
                entries.dedup_by(|a: &mut (Box<str>, u32), b| a.0 == b.0);
                Ok(Attributes(entries))
            }
        }

        deserializer.deserialize_map(Entries)
    }
}

/// Whether there is any value under a name.
fn present<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
    IgnoredAny::deserialize(deserializer).map(|_| true)
}
