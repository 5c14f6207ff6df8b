//! Writing OBJ.

use mesh_core::as_u32;

use super::names::{material_names, one_line};
use crate::decimal::Decimal;
use crate::error::WriteError;
use crate::model::{Group, Model};
use crate::write_options::WriteReport;
use std::collections::HashMap;
use std::io::Write;

pub(crate) fn write(
    writer: &mut dyn Write,
    model: &Model,
    libraries: &[String],
) -> Result<WriteReport, WriteError> {
    for library in libraries {
        writeln!(writer, "mtllib {}", one_line(library))?;
    }
    write_vertices(writer, model)?;
    let uvs = Distinct::new(model.corner_uvs.as_deref());
    for uv in &uvs.values {
        let [u, v] = uv.map(Decimal);
        writeln!(writer, "vt {u} {v}")?;
    }
    let vertex_normals = model.vertex_normals.as_ref().filter(|_| model.corner_normals.is_none());
    let normals = Distinct::new(model.corner_normals.as_deref());
    for normal in vertex_normals.unwrap_or(&normals.values) {
        let [x, y, z] = normal.map(Decimal);
        writeln!(writer, "vn {x} {y} {z}")?;
    }
    let names = material_names(model);
    let mut group = Model::NONE;
    let mut material = Model::NONE;
    let mut smoothing = 0;
    for face in 0..model.soup.face_count() {
        if let Some(groups) = &model.face_groups
            && groups[face] != group
        {
            write_group(writer, model, group, groups[face])?;
            group = groups[face];
        }
        if let Some(materials) = &model.face_materials
            && materials[face] != material
        {
            material = materials[face];
            // The absence of a material is written as an empty name, which ends the material before.
            let name = names.get(material as usize).map_or("", String::as_str);
            writeln!(writer, "usemtl {name}")?;
        }
        if let Some(groups) = &model.face_smoothing
            && groups[face] != smoothing
        {
            smoothing = groups[face];
            match smoothing {
                0 => writeln!(writer, "s off")?,
                group => writeln!(writer, "s {group}")?,
            }
        }
        write!(writer, "f")?;
        for corner in model.soup.corner_range(face) {
            let vertex = model.soup.corners()[corner];
            let normal = match vertex_normals {
                Some(_) => Some(vertex),
                None => normals.index(corner),
            };
            write!(writer, " {}", vertex + 1)?;
            match (uvs.index(corner), normal) {
                (None, None) => {}
                (Some(uv), None) => write!(writer, "/{}", uv + 1)?,
                (None, Some(normal)) => write!(writer, "//{}", normal + 1)?,
                (Some(uv), Some(normal)) => write!(writer, "/{}/{}", uv + 1, normal + 1)?,
            }
        }
        writeln!(writer)?;
    }
    Ok(WriteReport::default())
}

fn write_vertices(writer: &mut dyn Write, model: &Model) -> std::io::Result<()> {
    for (vertex, position) in model.soup.positions().iter().enumerate() {
        let [x, y, z] = position.to_array().map(Decimal);
        write!(writer, "v {x} {y} {z}")?;
        if let Some(colors) = &model.vertex_colors {
            let [r, g, b, a] = colors[vertex].map(Decimal);
            write!(writer, " {r} {g} {b}")?;
            if a.0 != 1.0 {
                write!(writer, " {a}")?;
            }
        }
        writeln!(writer)?;
    }
    Ok(())
}

/// The lines that switch from one group to another. A new object resets the group.
fn write_group(writer: &mut dyn Write, model: &Model, from: u32, to: u32) -> std::io::Result<()> {
    let none = Group::default();
    let group = |id: u32| model.groups.get(id as usize).unwrap_or(&none);
    let (old, new) = (group(from), group(to));
    let new_object = old.object != new.object;
    if new_object {
        writeln!(writer, "o {}", one_line(&new.object))?;
    }
    if !new.name.is_empty() || !new_object {
        writeln!(writer, "g {}", one_line(&new.name))?;
    }
    Ok(())
}

/// The distinct values of the corners, in the order of first use.
struct Distinct<const N: usize> {
    values: Vec<[f32; N]>,
    /// The index for every corner.
    indices: Vec<Option<u32>>,
}

impl<const N: usize> Distinct<N> {
    fn new(corners: Option<&[[f32; N]]>) -> Self {
        let mut values = Vec::new();
        let mut places = HashMap::<_, _, foldhash::fast::RandomState>::default();
        let mut index_of = |value: &[f32; N]| {
            let next = as_u32(values.len());
            let index = *places.entry(value.map(f32::to_bits)).or_insert(next);
            if index == next {
                values.push(*value);
            }
            index
        };
        let indices = corners
            .unwrap_or_default()
            .iter()
            .map(|value| (!value[0].is_nan()).then(|| index_of(value)))
            .collect();
        Self { values, indices }
    }

    fn index(&self, corner: usize) -> Option<u32> {
        self.indices.get(corner).copied().flatten()
    }
}
