//! Writing OFF.

use mesh_core::as_u32;

use crate::color::as_bytes;
use crate::decimal::Decimal;
use crate::error::WriteError;
use crate::format::Format;
use crate::model::Model;
use crate::single::{finite_or, rounding};
use crate::write_options::WriteReport;
use std::io::Write;

/// The header word, which announces the attributes of every vertex.
fn header_word(model: &Model, uvs: bool) -> String {
    let letters =
        [(uvs, "ST"), (model.vertex_colors.is_some(), "C"), (model.vertex_normals.is_some(), "N")];
    letters.iter().filter_map(|&(has, letter)| has.then_some(letter)).chain(["OFF"]).collect()
}

pub(crate) fn write_text(writer: &mut dyn Write, model: &Model) -> Result<WriteReport, WriteError> {
    let uvs = model.vertex_uvs();
    let soup = &model.soup;
    writeln!(writer, "{}", header_word(model, uvs.is_some()))?;
    writeln!(writer, "{} {} 0", soup.vertex_count(), soup.face_count())?;
    let colors = TextColors::new(model.vertex_colors.as_deref());
    for (vertex, position) in soup.positions().iter().enumerate() {
        let [x, y, z] = position.to_array().map(Decimal);
        write!(writer, "{x} {y} {z}")?;
        if let Some(normals) = &model.vertex_normals {
            let [x, y, z] = finite_or(normals[vertex], 0.0).map(Decimal);
            write!(writer, " {x} {y} {z}")?;
        }
        colors.write(writer, vertex)?;
        if let Some(uvs) = &uvs {
            let [u, v] = finite_or(uvs[vertex], 0.0).map(Decimal);
            write!(writer, " {u} {v}")?;
        }
        writeln!(writer)?;
    }
    let colors = TextColors::new(model.face_colors.as_deref());
    for (index, face) in soup.faces().enumerate() {
        write!(writer, "{}", face.len())?;
        for vertex in face {
            write!(writer, " {vertex}")?;
        }
        colors.write(writer, index)?;
        writeln!(writer)?;
    }
    Ok(WriteReport::default())
}

/// Colours as integers up to 255 if that is exact, as fractions otherwise.
enum TextColors<'m> {
    None,
    Bytes(Vec<[u8; 4]>),
    Floats(&'m [[f32; 4]]),
}

impl<'m> TextColors<'m> {
    fn new(colors: Option<&'m [[f32; 4]]>) -> Self {
        let Some(colors) = colors else { return Self::None };
        match as_bytes(colors) {
            // Colours with only zeros and ones would be read as fractions.
            Some(bytes) if bytes.as_flattened().iter().any(|&byte| byte > 1) => Self::Bytes(bytes),
            _ => Self::Floats(colors),
        }
    }

    fn write(&self, writer: &mut dyn Write, index: usize) -> std::io::Result<()> {
        match self {
            Self::Bytes(colors) => {
                let [r, g, b, a] = colors[index];
                write!(writer, " {r} {g} {b} {a}")
            }
            Self::Floats(colors) if !colors[index][0].is_nan() => {
                let [r, g, b, a] = colors[index];
                // The decimal points distinguish them from integers up to 255.
                write!(writer, " {r:?} {g:?} {b:?} {a:?}")
            }
            Self::None | Self::Floats(_) => Ok(()),
        }
    }
}

pub(crate) fn write_binary(
    writer: &mut dyn Write,
    model: &Model,
) -> Result<WriteReport, WriteError> {
    let uvs = model.vertex_uvs();
    let soup = &model.soup;
    let counts = [count(soup.vertex_count(), "vertices")?, count(soup.face_count(), "faces")?, 0];
    writeln!(writer, "{} BINARY", header_word(model, uvs.is_some()))?;
    counts.iter().try_for_each(|count| writer.write_all(&count.to_be_bytes()))?;
    let floats = |writer: &mut dyn Write, values: &[f32]| {
        values.iter().try_for_each(|value| writer.write_all(&value.to_be_bytes()))
    };
    for (vertex, position) in soup.positions().iter().enumerate() {
        floats(writer, &position.as_vec3().to_array())?;
        if let Some(normals) = &model.vertex_normals {
            floats(writer, &finite_or(normals[vertex], 0.0))?;
        }
        if let Some(colors) = &model.vertex_colors {
            floats(writer, &finite_or(colors[vertex], 1.0))?;
        }
        if let Some(uvs) = &uvs {
            floats(writer, &finite_or(uvs[vertex], 0.0))?;
        }
    }
    for (index, face) in soup.faces().enumerate() {
        writer.write_all(&as_u32(face.len()).to_be_bytes())?;
        for vertex in face {
            writer.write_all(&vertex.to_be_bytes())?;
        }
        let color = model.face_colors.as_ref().map(|colors| colors[index]);
        let color = color.filter(|color| !color[0].is_nan());
        writer.write_all(&as_u32(color.as_slice().as_flattened().len()).to_be_bytes())?;
        floats(writer, color.as_slice().as_flattened())?;
    }
    Ok(WriteReport { rounding: rounding(soup.positions()), ..WriteReport::default() })
}

/// A count in 32 bits.
fn count(count: usize, what: &'static str) -> Result<u32, WriteError> {
    u32::try_from(count).map_err(|_| WriteError::TooLarge {
        format: Format::Off,
        what,
        limit: u64::from(u32::MAX),
        found: count as u64,
    })
}
