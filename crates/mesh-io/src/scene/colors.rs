//! Colours with a range other than 0 to 1, which the format does not allow: whole numbers that are not marked as
//! normalised, and numbers above 1.

use super::document::{Scene, list_mut, push, push_all, root_of};
use super::extensions::unknown;
use super::prune::{Referenced, prune};
use crate::color_range::{Range, range};
use crate::error::ReadErrorKind;
use crate::gltf::accessor::{Bytes, Document, at};
use crate::input::Input;
use crate::notes::Notes;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::sync::Arc;

const ARRAY_BUFFER: u32 = 34962;
const FLOAT: u32 = 5126;

/// An accessor and its colours.
struct Colors {
    accessor: u32,
    width: usize,
    values: Vec<[f32; 4]>,
    full: [f32; 2],
}

impl Scene {
    /// The scene with colours from 0 to 1, and notes about the changes. Accessors that are also something else, and
    /// those of compressed meshes, stay.
    pub(super) fn with_unit_colors(
        self,
        input: &mut Input<'_>,
        notes: &mut Notes,
    ) -> Result<Self, ReadErrorKind> {
        let (mut marked, mut divided, mut floats) = (Vec::new(), Vec::new(), Vec::new());
        for accessor in self.color_accessors() {
            let path = format!("accessors[{accessor}]");
            let values = self.document.values(accessor, &path, 1..=4)?;
            if values.is_nothing() || values.is_normalized() {
                continue;
            }
            input.spend(16 * values.count() as u64, || at(&path))?;
            let full = values.full_color()?;
            let most = values.component().range().map(|[_, most]| most as f64);
            if most == Some(f64::from(full)) {
                marked.push(accessor);
                continue;
            }
            let list = if values.is_whole() { &mut divided } else { &mut floats };
            let (width, values) = (self.document.width(accessor, &path)?, values.to_vec(full)?);
            list.push(Colors { accessor, width, values, full: [full; 2] });
        }
        let found = range(floats.iter().flat_map(|colors: &Colors| &colors.values));
        if let Range::UpTo(full) = found {
            divided.extend(floats.into_iter().map(|colors| Colors { full, ..colors }));
        }
        if marked.is_empty() && divided.is_empty() {
            return Ok(self);
        }
        let mut json = self.json.clone();
        for accessor in marked {
            let accessors = list_mut(&mut json, "accessors");
            if let Some(Value::Object(members)) = accessors.get_mut(accessor as usize) {
                members.insert("normalized".to_owned(), true.into());
            }
            notes.add(format!(
                "accessors[{accessor}]: colours in whole numbers are not marked as normalized: marked"
            ));
        }
        let before = Referenced::of(&mut json);
        let mut buffers = self.document.buffers.clone();
        for colors in divided {
            let full = colors.full[0].max(colors.full[1]);
            let index = colors.accessor;
            colors.store(&mut json, &mut buffers);
            notes.add(format!("accessors[{index}]: colours are above 1: divided by {full}"));
        }
        if unknown(&json).is_empty() {
            prune(&mut json, &mut buffers, &before);
        }
        let root = root_of(&json).map_err(|error| {
            ReadErrorKind::malformed(at("the document"), "a glTF document", error.to_string())
        })?;
        Ok(self.with(json, Document { root, buffers }))
    }

    /// The accessors that are colours of vertices, and nothing else.
    fn color_accessors(&self) -> BTreeSet<u32> {
        let (mut colors, mut others) = (BTreeSet::new(), BTreeSet::new());
        for primitive in self.root().meshes.iter().flat_map(|mesh| &mesh.primitives) {
            let is_compressed = primitive.extensions.draco.is_some();
            for (name, accessor) in primitive.attributes.iter() {
                let is_color = name.starts_with("COLOR_") && !is_compressed;
                let set = if is_color { &mut colors } else { &mut others };
                set.insert(accessor);
            }
        }
        colors.difference(&others).copied().collect()
    }
}

impl Colors {
    /// Gives the accessor the divided colours, in a buffer of their own.
    fn store(self, json: &mut Value, buffers: &mut Vec<Bytes>) {
        let [full, full_opacity] = self.full;
        let divided = |color: &[f32; 4]| {
            let [red, green, blue, opacity] = *color;
            [red / full, green / full, blue / full, opacity / full_opacity]
        };
        let channels = self.values.iter().map(divided);
        let bytes: Vec<u8> = channels
            .flat_map(|color| color.into_iter().take(self.width).flat_map(f32::to_le_bytes))
            .collect();
        let view = json!({
            "buffer": buffers.len(), "byteLength": bytes.len(), "target": ARRAY_BUFFER,
        });
        let view = push(json, "bufferViews", view);
        push_all(json, "buffers", [json!({ "byteLength": bytes.len() })]);
        buffers.push(Bytes { length: bytes.len(), all: Arc::new(bytes) });
        let accessor = list_mut(json, "accessors").get_mut(self.accessor as usize);
        if let Some(members) = accessor.and_then(Value::as_object_mut) {
            for name in ["byteOffset", "sparse", "min", "max", "normalized"] {
                members.remove(name);
            }
            members.insert("bufferView".to_owned(), view.into());
            members.insert("componentType".to_owned(), FLOAT.into());
        }
    }
}
