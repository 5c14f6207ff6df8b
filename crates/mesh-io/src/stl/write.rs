//! Writing STL.

use super::color::StlColors;
use super::header;
use crate::cutter::Cutter;
use crate::decimal::Decimal;
use crate::error::WriteError;
use crate::format::Format;
use crate::model::Model;
use crate::single::rounding;
use crate::write_options::WriteReport;
use glam::DVec3;
use std::io::Write;

/// Calls `write` for the triangles of every face.
fn for_each_triangle(
    model: &Model,
    mut write: impl FnMut(usize, [DVec3; 3]) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let positions = model.soup.positions();
    let mut cutter = Cutter::default();
    for (index, face) in model.soup.faces().enumerate() {
        for triangle in cutter.cut(&model.soup, index) {
            write(index, triangle.map(|corner| positions[face[corner as usize] as usize]))?;
        }
    }
    Ok(())
}

pub(crate) fn write_binary(
    writer: &mut dyn Write,
    model: &Model,
    convention: StlColors,
) -> Result<WriteReport, WriteError> {
    let count = model.soup.faces().map(|face| face.len() as u64 - 2).sum();
    let colors = model.face_colors.as_deref();
    let of_object = colors.and_then(|_| convention.of_object());
    binary_head(writer, count, &header::with(comment(model, convention), of_object))?;
    for_each_triangle(model, |face, triangle| {
        let color = colors.map(|colors| convention.attribute(colors[face]));
        binary_facet(writer, triangle, color.unwrap_or(0))
    })?;
    Ok(report(model))
}

/// The comment for the header of a binary file: the first one for which there is room.
pub(crate) fn comment(model: &Model, convention: StlColors) -> Option<&str> {
    let has_color = model.face_colors.is_some() && convention.of_object().is_some();
    let mut comments = model.comments.iter().map(String::as_str);
    comments.find(|comment| header::has_room(comment, has_color))
}

/// Writes the start of a binary file.
pub(super) fn binary_head(
    writer: &mut dyn Write,
    count: u64,
    header: &[u8],
) -> Result<(), WriteError> {
    let count = u32::try_from(count).map_err(|_| WriteError::TooLarge {
        format: Format::Stl,
        what: "triangles",
        limit: u64::from(u32::MAX),
        found: count,
    })?;
    writer.write_all(header)?;
    Ok(writer.write_all(&count.to_le_bytes())?)
}

/// A triangle of a binary file, with its two attribute bytes.
pub(super) fn binary_facet(
    writer: &mut dyn Write,
    triangle: [DVec3; 3],
    attribute: u16,
) -> std::io::Result<()> {
    let mut facet = [0; 50];
    let [a, b, c] = triangle.map(DVec3::as_vec3);
    let rows = [normal(triangle).as_vec3(), a, b, c].map(|row| row.to_array());
    for (bytes, value) in facet.as_chunks_mut().0.iter_mut().zip(rows.as_flattened()) {
        *bytes = value.to_le_bytes();
    }
    facet[48..].copy_from_slice(&attribute.to_le_bytes());
    writer.write_all(&facet)
}

/// Writes a solid for every sequence of faces of the same group.
pub(crate) fn write_text(writer: &mut dyn Write, model: &Model) -> Result<WriteReport, WriteError> {
    let group = |face: usize| model.face_groups.as_ref().map_or(Model::NONE, |g| g[face]);
    let name = |group: u32| match model.groups.get(group as usize) {
        Some(group) if group.name.is_empty() => one_line(&group.object),
        Some(group) => one_line(&group.name),
        None => String::new(),
    };
    let first = model.face_groups.as_ref().and_then(|groups| groups.first());
    let mut current = first.copied().unwrap_or(Model::NONE);
    writeln!(writer, "solid {}", name(current))?;
    for_each_triangle(model, |face, triangle| {
        if group(face) != current {
            writeln!(writer, "endsolid {}", name(current))?;
            current = group(face);
            writeln!(writer, "solid {}", name(current))?;
        }
        text_facet(writer, triangle)
    })?;
    writeln!(writer, "endsolid {}", name(current))?;
    Ok(report(model))
}

/// A triangle of a text file.
pub(super) fn text_facet(writer: &mut dyn Write, triangle: [DVec3; 3]) -> std::io::Result<()> {
    let line = |v: DVec3| {
        let [x, y, z] = v.as_vec3().to_array().map(Decimal);
        format!("{x} {y} {z}")
    };
    writeln!(writer, "facet normal {}\n  outer loop", line(normal(triangle)))?;
    for corner in triangle {
        writeln!(writer, "    vertex {}", line(corner))?;
    }
    writeln!(writer, "  endloop\nendfacet")
}

/// The unit normal of a triangle, or zero for a triangle without area.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

fn one_line(name: &str) -> String {
    name.replace(char::is_control, " ").trim().to_owned()
}

fn report(model: &Model) -> WriteReport {
    WriteReport { rounding: rounding(model.soup.positions()), ..WriteReport::default() }
}
