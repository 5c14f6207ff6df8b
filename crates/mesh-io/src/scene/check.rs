//! Checks of a document that is kept whole: every index that is used here is in range.

use mesh_core::as_u32;

use crate::error::ReadErrorKind;
use crate::gltf::accessor::{Document, at, item, no_such};
use crate::gltf::plan::path_of;
use crate::gltf::scene::each_node;
use crate::gltf::schema::{Attributes, Primitive};
use crate::input::Input;

/// Checks the accessors, the primitives and the nodes. Values that exist only in compressed data are not checked.
pub(super) fn check(document: &Document, input: &Input<'_>) -> Result<(), ReadErrorKind> {
    let root = &document.root;
    for index in 0..as_u32(root.accessors.len()) {
        let path = format!("accessors[{index}]");
        let values = document.values(index, &path, 1..=16).map(|_| ());
        if let Err(error) = values
            && !is_compressed(&error)
        {
            return Err(error);
        }
    }
    each_node(root, |_, _, _| Ok(()))?;
    for (index, node) in root.nodes.iter().enumerate() {
        if let Some(mesh) = node.mesh {
            item(&root.meshes, mesh, "meshes", &format!("nodes[{index}].mesh"))?;
        }
    }
    let mut largest = Largest { known: vec![None; root.accessors.len()], read: 0 };
    for (mesh, primitives) in root.meshes.iter().enumerate() {
        for (index, primitive) in primitives.primitives.iter().enumerate() {
            let path = path_of(as_u32(mesh), index);
            check_primitive(document, primitive, &path, &mut largest, input)?;
        }
    }
    Ok(())
}

/// Whether the error is that the data are compressed: such data are written as they were read.
fn is_compressed(error: &ReadErrorKind) -> bool {
    matches!(error, ReadErrorKind::Unsupported { .. })
}

/// Whether the scene draws nothing.
pub(super) fn is_empty(document: &Document) -> bool {
    let root = &document.root;
    let has_vertices = |primitive: &Primitive| {
        let positions = primitive.attributes.get("POSITION");
        let accessor = positions.and_then(|index| root.accessors.get(index as usize));
        accessor.is_some_and(|accessor| accessor.count > 0)
    };
    let mut is_empty = true;
    // The nodes were checked before.
    let _ = each_node(root, |_, node, _| {
        let mesh = node.mesh.and_then(|mesh| root.meshes.get(mesh as usize));
        is_empty &= !mesh.is_some_and(|mesh| mesh.primitives.iter().any(has_vertices));
        Ok(())
    });
    is_empty
}

/// The largest index of each accessor of indices, as far as it is known.
struct Largest {
    known: Vec<Option<Option<u32>>>,
    /// The memory that the indices would take, which limits the time.
    read: u64,
}

impl Largest {
    fn of(
        &mut self,
        document: &Document,
        accessor: u32,
        path: &str,
        input: &Input<'_>,
    ) -> Result<Option<u32>, ReadErrorKind> {
        if let Some(Some(known)) = self.known.get(accessor as usize) {
            return Ok(*known);
        }
        let values = match document.values(accessor, path, 1..=1) {
            Err(error) if is_compressed(&error) => return Ok(None),
            values => values?,
        };
        self.read = self.read.saturating_add(4 * values.count() as u64);
        input.require(self.read, || at(path))?;
        let largest = values.largest_index()?;
        if let Some(slot) = self.known.get_mut(accessor as usize) {
            *slot = Some(largest);
        }
        Ok(largest)
    }
}

fn check_primitive(
    document: &Document,
    primitive: &Primitive,
    path: &str,
    largest: &mut Largest,
    input: &Input<'_>,
) -> Result<(), ReadErrorKind> {
    let mut count = None;
    let targets = primitive.targets.iter().flat_map(Attributes::iter);
    for (name, accessor) in primitive.attributes.iter().chain(targets) {
        let path = format!("{path}.{name}");
        let found = document.count(accessor, &path)?;
        let expected = *count.get_or_insert(found);
        if found != expected {
            let expected = format!("{expected} values as in the other attributes");
            return Err(ReadErrorKind::malformed(at(&path), expected, found.to_string()));
        }
    }
    let Some(indices) = primitive.indices else { return Ok(()) };
    let path = format!("{path}.indices");
    match (largest.of(document, indices, &path, input)?, count) {
        (Some(index), Some(count)) if u64::from(index) >= count => {
            Err(no_such(&path, "vertices", index, count as usize))
        }
        _ => Ok(()),
    }
}
