//! Reading a scene, and access to its parts.

use super::check;
use crate::budget::{Budget, GROWING};
use crate::error::{ReadError, ReadErrorKind, WriteError};
use crate::external::{Files, is_file_name};
use crate::format::Format;
use crate::gltf::accessor::{Document, at};
use crate::gltf::compressed;
use crate::gltf::container::{self, Container};
use crate::gltf::material::plain_name;
use crate::gltf::read::{document_bytes, parse};
use crate::gltf::scene::local;
use crate::gltf::schema::Root;
use crate::input::Input;
use crate::lost::Lost;
use crate::notes::Notes;
use crate::read::{ReadOptions, detect, open};
use glam::DMat4;
use serde::Deserialize;
use serde_json::Value;
use std::fmt;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// A glTF or GLB document, kept whole as it was read: nodes, names, cameras, lights, skins, animations, materials,
/// images, extensions and extras.
///
/// [`Scene::write`] writes everything as it was; only [`Scene::replaced`] changes vertices and triangles. The order of
/// the members of JSON objects is not kept, and buffers are embedded in the written file. Images in files of their own
/// keep their names, which are relative to the file.
///
/// ```
/// use mesh_io::{Format, ReadOptions, Scene};
/// # let triangle = mesh_core::PolygonSoup::from_triangles(
/// #     &[glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y], &[[0, 1, 2]])?;
/// # let mut file = Vec::new();
/// # mesh_io::write_to(&mut file, &triangle, Format::Glb, &Default::default())?;
/// let scene = Scene::read_from(&mut &file[..], &ReadOptions::default())?;
/// assert_eq!(scene.mesh_count(), 1);
/// let mut written = Vec::new();
/// scene.write_to(&mut written, Format::Glb)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Scene {
    pub(super) json: Value,
    pub(super) document: Arc<Document>,
    /// The memory that the geometry may use.
    pub(super) memory: u64,
    notes: Vec<String>,
    pub(super) lost: Vec<Lost>,
}

impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scene").field("json", &self.json).finish_non_exhaustive()
    }
}

/// A node of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneNode {
    /// The name, if there is one.
    pub name: Option<String>,
    /// The mesh that it draws.
    pub mesh: Option<usize>,
    /// The nodes below it.
    pub children: Vec<usize>,
    /// The transform to its parent.
    pub transform: DMat4,
}

impl Scene {
    /// Reads a scene from a file.
    ///
    /// # Errors
    /// A [`ReadError`]: the file is no glTF or GLB file, an index or a size is out of range, or the content needs more
    /// memory than a file of its size may use.
    pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Self, ReadError> {
        let path = path.as_ref();
        let read = || -> Result<Self, ReadError> {
            let (mut file, options) = open(path, options)?;
            Self::read_stream(&mut file, &options, Some(path))
        };
        read().map_err(|error| error.at_path(path))
    }

    /// Reads a scene from a stream. Files named in the content are read only if the options name their folder.
    ///
    /// # Errors
    /// As [`Scene::read`]; the error has no path.
    pub fn read_from(reader: &mut dyn Read, options: &ReadOptions) -> Result<Self, ReadError> {
        Self::read_stream(reader, options, None)
    }

    /// Reads a file that this crate has just written.
    pub(crate) fn read_written(file: &[u8]) -> Result<Self, WriteError> {
        let options =
            ReadOptions { max_memory: Some(u64::MAX), allow_empty: true, ..ReadOptions::default() };
        Self::read_from(&mut &*file, &options).map_err(|error| WriteError::Scene(error.to_string()))
    }

    fn read_stream(
        reader: &mut dyn Read,
        options: &ReadOptions,
        path: Option<&Path>,
    ) -> Result<Self, ReadError> {
        let mut input = Input::new(reader, options.size, Budget::new(options.max_memory));
        let (format, _) = detect(&mut input, options, path)?;
        if !matches!(format, Format::Gltf | Format::Glb) {
            let found = format!("a file in the format {format}");
            return Err(ReadErrorKind::malformed(input.here(), "glTF or GLB", found).into());
        }
        let mut notes = Notes::default();
        let container = container::read(&mut input)?;
        container.note(&mut notes);
        let Container { json: text, binary, .. } = container;
        input.spend(document_bytes(&text).saturating_add(tree_bytes(&text)), || {
            at("the document")
        })?;
        let root = parse(&text)?;
        let mut json: Value = serde_json::from_slice(&text).map_err(|error| {
            let line = crate::error::Location::Line(error.line() as u64);
            ReadErrorKind::malformed(line, "a glTF document", error.to_string())
        })?;
        drop(text);
        let files = Files { folder: options.folder.as_deref(), external: options.external };
        let buffers = container::buffers(&root, binary, &files, &mut input)?;
        #[cfg_attr(
            not(feature = "draco"),
            expect(unused_mut, reason = "only that feature changes it")
        )]
        let mut document = Document { root, buffers };
        compressed::spend(&document.root, &document.buffers, &mut input)?;
        #[cfg(feature = "draco")]
        crate::gltf::draco::fill(&mut document, Some(&mut input))?;
        check::check(&document, &input)?;
        if check::is_empty(&document) && !options.allow_empty {
            return Err(ReadErrorKind::Empty { notes: Vec::new() }.into());
        }
        // The bytes are there, so their places are not needed.
        let loaded = document.buffers.iter().map(|buffer| !buffer.get().is_empty());
        for (buffer, is_loaded) in list_mut(&mut json, "buffers").iter_mut().zip(loaded) {
            if let (Some(buffer), true) = (buffer.as_object_mut(), is_loaded) {
                buffer.remove("uri");
            }
        }
        let document = Arc::new(document);
        let scene = Self { json, document, memory: 0, notes: Vec::new(), lost: Vec::new() };
        let mut scene = scene.with_unit_colors(&mut input, &mut notes)?;
        (scene.notes, scene.lost) = notes.finish();
        scene.memory = input.memory_left();
        Ok(scene)
    }

    /// The scene with another document and buffers.
    #[cfg_attr(not(feature = "draco"), expect(unused_mut, reason = "only that feature changes it"))]
    pub(super) fn with(&self, json: Value, mut document: Document) -> Self {
        // The same data could be decompressed before.
        #[cfg(feature = "draco")]
        let _ = crate::gltf::draco::fill(&mut document, None);
        Self { json, document: Arc::new(document), ..self.clone() }
    }

    /// The document as JSON. Buffers that were read have no `uri`.
    #[must_use]
    pub fn json(&self) -> &Value {
        &self.json
    }

    /// Messages of the reader for people: losses and assumptions. They are [printable](crate::printable).
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The content of the file that is not in the scene.
    #[must_use]
    pub fn lost(&self) -> &[Lost] {
        &self.lost
    }

    /// The names of images in files of their own, relative to the file, without the escapes of addresses.
    #[must_use]
    pub fn file_pictures(&self) -> Vec<String> {
        let uris = self.root().images.iter().filter_map(|image| image.uri.as_deref());
        uris.filter(|uri| is_file_name(uri)).map(plain_name).collect()
    }

    /// The number of meshes.
    #[must_use]
    pub fn mesh_count(&self) -> usize {
        self.root().meshes.len()
    }

    /// The name of a mesh, if it has one.
    #[must_use]
    pub fn mesh_name(&self, mesh: usize) -> Option<&str> {
        self.root().meshes.get(mesh)?.name.as_deref()
    }

    /// The nodes, in the order of the document.
    pub fn nodes(&self) -> impl Iterator<Item = SceneNode> + '_ {
        self.root().nodes.iter().map(|node| SceneNode {
            name: node.name.as_ref().map(ToString::to_string),
            mesh: node.mesh.map(|mesh| mesh as usize),
            children: node.children.iter().map(|&child| child as usize).collect(),
            transform: local(node),
        })
    }

    pub(super) fn root(&self) -> &Root {
        &self.document.root
    }
}

/// The members of a list of the document; empty if there is no such list.
pub(super) fn list_mut<'j>(json: &'j mut Value, name: &str) -> &'j mut [Value] {
    json.get_mut(name).and_then(Value::as_array_mut).map(Vec::as_mut_slice).unwrap_or_default()
}

/// Appends items to a list of the document, which is made if it is not there.
pub(super) fn push_all(json: &mut Value, name: &str, items: impl IntoIterator<Item = Value>) {
    let Some(document) = json.as_object_mut() else { return };
    let list = document.entry(name).or_insert_with(|| Value::Array(Vec::new()));
    if let Some(list) = list.as_array_mut() {
        list.extend(items);
    }
}

/// Appends an item to a list of the document, and returns its index.
pub(super) fn push(json: &mut Value, list: &str, item: Value) -> usize {
    let items = list_mut(json, list).len();
    if let Some(list) = json.get_mut(list).and_then(Value::as_array_mut) {
        list.push(item);
    }
    items
}

/// The typed parts of a document.
pub(super) fn root_of(json: &Value) -> Result<Root, serde_json::Error> {
    Root::deserialize(json)
}

/// The memory of a tree of JSON values. An object takes a node of a search tree, a member at most a share of one,
/// and an item of a list its value; lists grow.
fn tree_bytes(text: &[u8]) -> u64 {
    const NODE: u64 = 640;
    const MEMBER: u64 = NODE / 5;
    const ITEM: u64 = GROWING * size_of::<Value>() as u64;
    let bytes = text.iter().map(|byte| match byte {
        b'{' => NODE,
        b':' => MEMBER,
        b'[' | b',' => ITEM,
        _ => 1,
    });
    bytes.sum()
}
