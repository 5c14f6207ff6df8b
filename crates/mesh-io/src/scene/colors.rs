//! Colours in whole numbers that are not marked as normalised, which the format does not allow.

use crate::gltf::schema::Root;
use crate::notes::Notes;
use serde_json::Value;
use std::collections::BTreeSet;

const FLOAT: u32 = 5126;

/// Marks colours in whole numbers as normalised, and notes it. Accessors that are also something else stay.
pub(super) fn mark_normalized(root: &mut Root, json: &mut Value, notes: &mut Notes) {
    let (mut colors, mut others) = (BTreeSet::new(), BTreeSet::new());
    for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        for (name, accessor) in primitive.attributes.iter() {
            let set = if name.starts_with("COLOR_") { &mut colors } else { &mut others };
            set.insert(accessor);
        }
    }
    for &index in colors.difference(&others) {
        let Some(accessor) = root.accessors.get_mut(index as usize) else { continue };
        if accessor.normalized || accessor.component_type == FLOAT {
            continue;
        }
        accessor.normalized = true;
        if let Some(object) =
            json.pointer_mut(&format!("/accessors/{index}")).and_then(Value::as_object_mut)
        {
            object.insert("normalized".to_owned(), true.into());
        }
        notes.add(format!(
            "accessors[{index}]: colours in whole numbers are not marked as normalized: marked"
        ));
    }
}
