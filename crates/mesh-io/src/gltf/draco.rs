//! Primitives whose data are compressed by Draco (`KHR_draco_mesh_compression`).

use super::accessor::{Document, at, item};
use super::plan::path_of;
use super::schema::{Draco, Primitive};
use crate::error::ReadErrorKind;
use crate::input::Input;
use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointIndex};
use mesh_core::as_u32;

const UNSIGNED_INT: u32 = 5125;
const TRIANGLES: u32 = 4;
/// The memory of the decoder for each byte of its result.
const WORKING: u64 = 3;

/// Decompresses the primitives that have no other data. The values go to their accessors.
///
/// Without an input, no memory is counted: the same data were counted before.
pub(crate) fn fill(
    document: &mut Document,
    mut input: Option<&mut Input<'_>>,
) -> Result<(), ReadErrorKind> {
    for mesh in 0..document.root.meshes.len() {
        let count = document.root.meshes.get(mesh).map_or(0, |mesh| mesh.primitives.len());
        for index in 0..count {
            let primitive = document.root.meshes.get(mesh).and_then(|m| m.primitives.get(index));
            let Some(primitive) = primitive else { continue };
            let Some(draco) = primitive.extensions.draco.as_deref() else { continue };
            if !is_needed(document, primitive, draco) {
                continue;
            }
            let path = path_of(as_u32(mesh), index);
            let filled = decode(document, primitive, draco, &path, input.as_deref_mut())?;
            for (accessor, values, count) in filled.values {
                if let Some(accessor) = document.root.accessors.get_mut(accessor as usize) {
                    accessor.decoded = Some(values);
                    accessor.count = count;
                }
            }
            if let Some(accessor) = document.root.accessors.get_mut(filled.indices as usize) {
                accessor.component_type = UNSIGNED_INT;
            }
            let meshes = document.root.meshes.get_mut(mesh);
            if let Some(primitive) = meshes.and_then(|mesh| mesh.primitives.get_mut(index)) {
                primitive.mode = TRIANGLES;
            }
        }
    }
    Ok(())
}

/// Whether values of a primitive are nowhere else.
fn is_needed(document: &Document, primitive: &Primitive, draco: &Draco) -> bool {
    let attributes = draco.attributes.iter();
    let attributes = attributes.filter_map(|(name, _)| primitive.attributes.get(name));
    attributes.chain(primitive.indices).any(|accessor| {
        let accessor = document.root.accessors.get(accessor as usize);
        accessor
            .is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none() && a.decoded.is_none())
    })
}

/// The data of a primitive.
struct Filled {
    /// Accessors with their values, and how many there are.
    values: Vec<(u32, Box<[u8]>, u64)>,
    indices: u32,
}

fn decode(
    document: &Document,
    primitive: &Primitive,
    draco: &Draco,
    path: &str,
    input: Option<&mut Input<'_>>,
) -> Result<Filled, ReadErrorKind> {
    let path = format!("{path}.extensions.KHR_draco_mesh_compression");
    let wrong = |expected: String, found: String| {
        let found = format!("{found}; the file is damaged: export it again");
        ReadErrorKind::malformed(at(&path), expected, found)
    };
    let bytes = document.view(draco.buffer_view, &path)?.0;
    let Some(indices) = primitive.indices else {
        return Err(wrong("indices beside the compressed data".to_owned(), "nothing".to_owned()));
    };
    let mut needed = document.count(indices, &path)?.saturating_mul(4);
    let mut vertices = 0;
    for (_, accessor) in primitive.attributes.iter() {
        let accessor = document.accessor(accessor, &path)?;
        let size = document.value_size(accessor, &path)? as u64;
        needed = needed.saturating_add(accessor.count.saturating_mul(size));
        vertices = accessor.count.max(vertices);
    }
    let mut limits = DecodeLimits::default();
    if let Some(input) = input {
        input.spend(needed.saturating_mul(WORKING), || at(&path))?;
        // Draco splits vertices along seams, so that there can be more than the document says.
        limits = limits
            .with_max_points(vertices.saturating_mul(6).max(1 << 10))
            .with_max_faces(document.count(indices, &path)? / 3)
            .with_max_decoded_bytes(input.memory_left().saturating_add(needed));
    }
    let mut mesh = Mesh::new();
    MeshDecoder::new()
        .decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh)
        .map_err(|error| wrong("data compressed by Draco".to_owned(), error.to_string()))?;
    let count = mesh.num_points();
    let mut filled =
        Filled { values: Vec::with_capacity(primitive.attributes.iter().count()), indices };
    let corners: Vec<u32> = mesh.faces().iter().flatten().map(|point| point.0).collect();
    if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= count) {
        return Err(wrong(format!("corners below {count}"), corner.to_string()));
    }
    let corners: Vec<u8> = corners.iter().flat_map(|corner| corner.to_le_bytes()).collect();
    let faces = corners.len() as u64 / 4;
    filled.values.push((indices, corners.into(), faces));
    for (name, id) in draco.attributes.iter() {
        let Some(index) = primitive.attributes.get(name) else { continue };
        let accessor = item(&document.root.accessors, index, "accessors", &path)?;
        if accessor.buffer_view.is_some() {
            continue;
        }
        let (width, size) = (document.width(index, &path)?, document.value_size(accessor, &path)?);
        let found = mesh.attribute_by_unique_id(id);
        let attribute = found.filter(|attribute| {
            usize::from(attribute.num_components()) == width
                && code(attribute.data_type()) == Some(accessor.component_type)
        });
        let Some(attribute) = attribute else {
            let expected =
                format!("{name} with {width} numbers of the type {}", accessor.component_type);
            let found = match found {
                Some(a) => {
                    format!("{} numbers of the type {:?}", a.num_components(), a.data_type())
                }
                None => format!("no attribute {id}"),
            };
            return Err(wrong(expected, found));
        };
        let mut values = vec![0; count * size];
        for (point, value) in (0..as_u32(count)).zip(values.chunks_exact_mut(size.max(1))) {
            let place = attribute.mapped_index(PointIndex(point)).0 as usize;
            if !attribute.buffer().try_read(place.saturating_mul(size), value) {
                return Err(wrong(format!("{name} for vertex {point}"), "nothing".to_owned()));
            }
        }
        filled.values.push((index, values.into(), count as u64));
    }
    Ok(filled)
}

/// The code of a type in glTF.
fn code(kind: DataType) -> Option<u32> {
    Some(match kind {
        DataType::Int8 => 5120,
        DataType::Uint8 => 5121,
        DataType::Int16 => 5122,
        DataType::Uint16 => 5123,
        DataType::Uint32 => UNSIGNED_INT,
        DataType::Float32 => 5126,
        _ => return None,
    })
}
