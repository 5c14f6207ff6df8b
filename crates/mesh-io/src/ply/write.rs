//! Writing PLY.

use super::columns::{COLORS, NORMAL, UVS};
use super::textures::{NUMBER, Textures};
use crate::color::{as_bytes, without_gaps};
use crate::decimal::Decimal;
use crate::distinct_names::distinct_names;
use crate::error::WriteError;
use crate::model::Model;
use crate::passing::Passing;
use crate::scalars::{ScalarType, ScalarValues, Scalars, each_type};
use crate::single::{are_finite, finite_or, rounding};
use crate::write_options::{Encoding, Precision, WriteOptions, WriteReport};
use glam::DVec3;
use mesh_core::as_u32;
use std::borrow::Cow;
use std::io::Write;

pub(crate) fn write(
    writer: &mut dyn Write,
    model: &Model,
    options: &WriteOptions,
) -> Result<WriteReport, WriteError> {
    let plan = Plan::new(model, options.precision);
    plan.header(writer, storage(options.encoding))?;
    match options.encoding {
        Encoding::Text => plan.body(&mut Text { writer, first: true })?,
        Encoding::BigEndian => plan.body(&mut Binary { writer, big_endian: true })?,
        _ => plan.body(&mut Binary { writer, big_endian: false })?,
    }
    let rounding = if plan.wide_positions { 0.0 } else { rounding(model.soup.positions()) };
    Ok(WriteReport { rounding, ..WriteReport::default() })
}

/// The word for an encoding.
fn storage(encoding: Encoding) -> &'static str {
    match encoding {
        Encoding::Text => "ascii",
        Encoding::Usual | Encoding::LittleEndian => "binary_little_endian",
        Encoding::BigEndian => "binary_big_endian",
    }
}

/// The type of a number.
fn float(wide: bool) -> &'static str {
    if wide { "double" } else { "float" }
}

/// The type of the number of corners of a face.
fn length(long_lists: bool) -> &'static str {
    if long_lists { "uint" } else { "uchar" }
}

/// The header of a file with streamed vertices and faces.
pub(super) fn header_of_passing(
    writer: &mut dyn Write,
    passing: &Passing,
    encoding: Encoding,
    wide_positions: bool,
    wide_scalars: &[bool],
    long_lists: bool,
) -> std::io::Result<()> {
    writeln!(writer, "ply\nformat {} 1.0", storage(encoding))?;
    writeln!(writer, "element vertex {}", passing.vertices)?;
    for axis in ["x", "y", "z"] {
        writeln!(writer, "property {} {axis}", float(wide_positions))?;
    }
    if passing.colors {
        Colors::Bytes(Vec::new()).header(writer)?;
    }
    for ((name, _), &wide) in passing.scalars.iter().zip(wide_scalars) {
        writeln!(writer, "property {} {name}", float(wide))?;
    }
    writeln!(writer, "element face {}", passing.faces)?;
    writeln!(writer, "property list {} int vertex_indices\nend_header", length(long_lists))
}

/// The storage of texture coordinates.
enum Uvs<'m> {
    None,
    /// One per vertex: all corners at a vertex agree.
    Vertex(Vec<[f32; 2]>),
    /// In a list per face.
    Corner(&'m [[f32; 2]]),
}

/// The output structure, and the widths of numbers.
struct Plan<'m> {
    model: &'m Model,
    wide_positions: bool,
    /// The type of every column of vertices, and of every column of faces.
    vertex_types: Vec<ScalarType>,
    face_types: Vec<ScalarType>,
    vertex_names: Vec<String>,
    face_names: Vec<String>,
    vertex_colors: Colors<'m>,
    face_colors: Colors<'m>,
    uvs: Uvs<'m>,
    textures: Option<Textures<'m>>,
    /// Some face has more corners than a byte can count.
    long_lists: bool,
}

enum Colors<'m> {
    None,
    Bytes(Vec<[u8; 4]>),
    Floats(Cow<'m, [[f32; 4]]>),
}

impl<'m> Colors<'m> {
    fn new(colors: Option<&'m [[f32; 4]]>) -> Self {
        match colors {
            None => Self::None,
            Some(colors) => {
                let colors = without_gaps(colors);
                as_bytes(&colors).map_or(Self::Floats(colors), Self::Bytes)
            }
        }
    }

    fn header(&self, writer: &mut dyn Write) -> std::io::Result<()> {
        let kind = match self {
            Self::None => return Ok(()),
            Self::Bytes(_) => "uchar",
            Self::Floats(_) => "float",
        };
        for channel in ["red", "green", "blue", "alpha"] {
            writeln!(writer, "property {kind} {channel}")?;
        }
        Ok(())
    }

    fn put(&self, index: usize, values: &mut impl Values) -> std::io::Result<()> {
        match self {
            Self::None => Ok(()),
            Self::Bytes(colors) => colors[index].into_iter().try_for_each(|c| values.u8(c)),
            Self::Floats(colors) => {
                finite_or(colors[index], 1.0).into_iter().try_for_each(|c| values.f32(c))
            }
        }
    }
}

impl<'m> Plan<'m> {
    fn new(model: &'m Model, precision: Precision) -> Self {
        let types =
            |scalars: &[Scalars]| scalars.iter().map(|s| type_of(&s.values, precision)).collect();
        let positions = model.soup.positions().iter().flat_map(DVec3::to_array);
        let textures = Textures::new(model);
        let uvs = plan_uvs(model, textures.is_some());
        let has = Has {
            is_vertex: true,
            normals: model.vertex_normals.is_some(),
            colors: model.vertex_colors.is_some(),
            uvs: matches!(uvs, Uvs::Vertex(_)),
            ..Has::default()
        };
        let numbered = textures.as_ref().is_some_and(|textures| textures.numbers.is_some());
        let face_has = Has { colors: model.face_colors.is_some(), numbered, ..Has::default() };
        Self {
            model,
            wide_positions: is_wide(positions, precision),
            vertex_types: types(&model.vertex_scalars),
            face_types: types(&model.face_scalars),
            vertex_names: has.scalar_names(&model.vertex_scalars),
            face_names: face_has.scalar_names(&model.face_scalars),
            vertex_colors: Colors::new(model.vertex_colors.as_deref()),
            face_colors: Colors::new(model.face_colors.as_deref()),
            uvs,
            textures,
            long_lists: model.soup.faces().any(|face| face.len() > 127),
        }
    }

    fn header(&self, writer: &mut dyn Write, storage: &str) -> std::io::Result<()> {
        let model = self.model;
        writeln!(writer, "ply\nformat {storage} 1.0")?;
        for name in self.textures.iter().flat_map(|textures| &textures.names) {
            writeln!(writer, "comment TextureFile {name}")?;
        }
        for comment in &model.comments {
            let keyword = if comment.starts_with("obj_info ") { "" } else { "comment " };
            writeln!(writer, "{keyword}{}", comment.replace(char::is_control, " "))?;
        }
        writeln!(writer, "element vertex {}", model.soup.vertex_count())?;
        for axis in ["x", "y", "z"] {
            writeln!(writer, "property {} {axis}", float(self.wide_positions))?;
        }
        if model.vertex_normals.is_some() {
            writeln!(writer, "property float nx\nproperty float ny\nproperty float nz")?;
        }
        self.vertex_colors.header(writer)?;
        if matches!(self.uvs, Uvs::Vertex(_)) {
            writeln!(writer, "property float s\nproperty float t")?;
        }
        for (name, kind) in self.vertex_names.iter().zip(&self.vertex_types) {
            writeln!(writer, "property {} {name}", kind.ply_name())?;
        }
        let count = length(self.long_lists);
        writeln!(writer, "element face {}", model.soup.face_count())?;
        writeln!(writer, "property list {count} int vertex_indices")?;
        if matches!(self.uvs, Uvs::Corner(_)) {
            writeln!(writer, "property list {count} float texcoord")?;
        }
        if self.texture_numbers().is_some() {
            writeln!(writer, "property int {NUMBER}")?;
        }
        self.face_colors.header(writer)?;
        for (name, kind) in self.face_names.iter().zip(&self.face_types) {
            writeln!(writer, "property {} {name}", kind.ply_name())?;
        }
        writeln!(writer, "end_header")
    }

    fn body(&self, values: &mut impl Values) -> std::io::Result<()> {
        for vertex in 0..self.model.soup.vertex_count() {
            self.vertex(vertex, values)?;
            values.end()?;
        }
        for face in 0..self.model.soup.face_count() {
            self.face(face, values)?;
            values.end()?;
        }
        Ok(())
    }

    fn vertex(&self, vertex: usize, values: &mut impl Values) -> std::io::Result<()> {
        let model = self.model;
        for value in model.soup.positions()[vertex].to_array() {
            values.float(value, self.wide_positions)?;
        }
        if let Some(normals) = &model.vertex_normals {
            finite_or(normals[vertex], 0.0).into_iter().try_for_each(|value| values.f32(value))?;
        }
        self.vertex_colors.put(vertex, values)?;
        if let Uvs::Vertex(uvs) = &self.uvs {
            uvs[vertex].into_iter().try_for_each(|value| values.f32(value))?;
        }
        for (scalars, &kind) in model.vertex_scalars.iter().zip(&self.vertex_types) {
            scalar(values, &scalars.values, vertex, kind)?;
        }
        Ok(())
    }

    fn face(&self, face: usize, values: &mut impl Values) -> std::io::Result<()> {
        let model = self.model;
        let corners = model.soup.face(face);
        self.count(corners.len(), values)?;
        corners.iter().try_for_each(|&vertex| values.u32(vertex))?;
        if let Uvs::Corner(uvs) = &self.uvs {
            let uvs = &uvs[model.soup.corner_range(face)];
            // Faces without texture coordinates have an empty list.
            let uvs = if uvs.iter().any(are_finite) { uvs } else { &[] };
            self.count(2 * uvs.len(), values)?;
            let mut all = uvs.iter().flat_map(|&uv| finite_or(uv, 0.0));
            all.try_for_each(|value| values.f32(value))?;
        }
        if let Some(numbers) = self.texture_numbers() {
            values.number(&mut numbers[face].to_le_bytes(), &numbers[face])?;
        }
        self.face_colors.put(face, values)?;
        for (scalars, &kind) in model.face_scalars.iter().zip(&self.face_types) {
            scalar(values, &scalars.values, face, kind)?;
        }
        Ok(())
    }

    fn texture_numbers(&self) -> Option<&[i32]> {
        self.textures.as_ref()?.numbers.as_deref()
    }

    fn count(&self, count: usize, values: &mut impl Values) -> std::io::Result<()> {
        match u8::try_from(count) {
            Ok(count) if !self.long_lists => values.u8(count),
            _ => values.u32(as_u32(count)),
        }
    }
}

/// Where there are textures, the coordinates belong to corners: other programs look for them there.
fn plan_uvs(model: &Model, textured: bool) -> Uvs<'_> {
    let of_vertices = if textured { None } else { model.vertex_uvs() };
    let of_vertices = of_vertices.filter(|uvs| uvs.iter().all(are_finite));
    match (of_vertices, model.corner_uvs.as_deref()) {
        (Some(uvs), _) => Uvs::Vertex(uvs),
        (None, Some(uvs)) => Uvs::Corner(uvs),
        (None, None) => Uvs::None,
    }
}

/// Whether to write these numbers in 64 bits.
fn is_wide(mut values: impl Iterator<Item = f64>, precision: Precision) -> bool {
    match precision {
        Precision::Single => false,
        Precision::Double => true,
        Precision::Exact => values.any(|value| f64::from(value as f32) != value && !value.is_nan()),
    }
}

/// The type of a written column. Integers keep their type, and so does floating point unless the precision option says
/// otherwise.
fn type_of(values: &ScalarValues, precision: Precision) -> ScalarType {
    match (values, precision) {
        (ScalarValues::F64(_), Precision::Single) => ScalarType::F32,
        (ScalarValues::F32(_), Precision::Double) => ScalarType::F64,
        (values, _) => values.scalar_type(),
    }
}

/// Writes a number of a column, in the type of the column.
fn scalar(
    values: &mut impl Values,
    column: &ScalarValues,
    place: usize,
    kind: ScalarType,
) -> std::io::Result<()> {
    match (column, kind) {
        (ScalarValues::F64(all), _) => values.float(all[place], kind == ScalarType::F64),
        (ScalarValues::F32(all), ScalarType::F64) => values.float(f64::from(all[place]), true),
        (ScalarValues::F32(all), _) => values.f32(all[place]),
        (whole, _) => {
            each_type!(whole, all => values.number(&mut all[place].to_le_bytes(), &all[place]))
        }
    }
}

/// The attributes of an element, without named numbers.
#[derive(Clone, Copy, Default)]
struct Has {
    /// Vertices have positions, and their normals and texture coordinates are read as such; those of faces are not.
    is_vertex: bool,
    normals: bool,
    colors: bool,
    uvs: bool,
    /// Faces say which picture they have.
    numbered: bool,
}

impl Has {
    /// The names of the numbers, each as one word. They are unique, differ from the names of all other properties, and
    /// do not form a colour or similar group by accident.
    fn scalar_names(self, scalars: &[Scalars]) -> Vec<String> {
        const LISTS: [&str; 3] = ["vertex_indices", "vertex_index", "texcoord"];
        let words: Vec<String> = scalars.iter().map(|scalars| one_word(&scalars.name)).collect();
        let mut taken = LISTS.to_vec();
        if self.numbered {
            taken.push(NUMBER);
        }
        let mut take = |has: bool, written: &[&'static str], groups: &[&[&'static str]]| {
            if has {
                taken.extend(written);
                return;
            }
            let complete = |group: &&&[&str]| group.iter().all(|n| words.iter().any(|w| w == n));
            groups.iter().filter(complete).for_each(|group| taken.extend(*group));
        };
        take(self.colors, &["red", "green", "blue", "alpha"], &COLORS.each_ref().map(|c| &c[..]));
        if self.is_vertex {
            take(true, &["x", "y", "z"], &[]);
            take(self.normals, &NORMAL, &[&NORMAL]);
            take(self.uvs, &UVS[0], &UVS.each_ref().map(|uv| &uv[..]));
        }
        distinct_names(words, &taken)
    }
}

/// A name without white space, which PLY does not support, and without the start of a comment.
fn one_word(name: &str) -> String {
    let unfit = |c: char| c.is_whitespace() || c.is_control();
    let word = name.replace(unfit, "_");
    match word.strip_prefix('#') {
        Some(rest) => format!("_{rest}"),
        None if word.is_empty() => "_".to_owned(),
        None => word,
    }
}

/// The destination of a sequence of values.
pub(super) trait Values {
    /// Writes a number, given by its bytes in little-endian order and by its text.
    fn number(&mut self, bytes: &mut [u8], text: &dyn std::fmt::Display) -> std::io::Result<()>;
    fn u8(&mut self, value: u8) -> std::io::Result<()>;
    fn u32(&mut self, value: u32) -> std::io::Result<()>;
    fn f32(&mut self, value: f32) -> std::io::Result<()>;
    fn float(&mut self, value: f64, wide: bool) -> std::io::Result<()>;
    /// Ends a record.
    fn end(&mut self) -> std::io::Result<()>;
}

pub(super) struct Text<'w> {
    pub(super) writer: &'w mut dyn Write,
    pub(super) first: bool,
}

impl Text<'_> {
    fn word(&mut self, word: impl std::fmt::Display) -> std::io::Result<()> {
        let separator = if std::mem::take(&mut self.first) { "" } else { " " };
        write!(self.writer, "{separator}{word}")
    }
}

impl Values for Text<'_> {
    fn number(&mut self, _: &mut [u8], text: &dyn std::fmt::Display) -> std::io::Result<()> {
        self.word(text)
    }

    fn u8(&mut self, value: u8) -> std::io::Result<()> {
        self.word(value)
    }

    fn u32(&mut self, value: u32) -> std::io::Result<()> {
        self.word(value)
    }

    fn f32(&mut self, value: f32) -> std::io::Result<()> {
        self.word(Decimal(value))
    }

    fn float(&mut self, value: f64, wide: bool) -> std::io::Result<()> {
        // Readers may parse a number as 64 bits, as this one does. If 32 bits hold the number exactly, its text has all
        // digits.
        let narrow = value as f32;
        if wide || f64::from(narrow) == value {
            self.word(Decimal(value))
        } else {
            self.word(Decimal(narrow))
        }
    }

    fn end(&mut self) -> std::io::Result<()> {
        self.first = true;
        self.writer.write_all(b"\n")
    }
}

pub(super) struct Binary<'w> {
    pub(super) writer: &'w mut dyn Write,
    pub(super) big_endian: bool,
}

impl Values for Binary<'_> {
    fn number(&mut self, bytes: &mut [u8], _: &dyn std::fmt::Display) -> std::io::Result<()> {
        if self.big_endian {
            bytes.reverse();
        }
        self.writer.write_all(bytes)
    }

    fn u8(&mut self, value: u8) -> std::io::Result<()> {
        self.writer.write_all(&[value])
    }

    fn u32(&mut self, value: u32) -> std::io::Result<()> {
        let bytes = if self.big_endian { value.to_be_bytes() } else { value.to_le_bytes() };
        self.writer.write_all(&bytes)
    }

    fn f32(&mut self, value: f32) -> std::io::Result<()> {
        self.u32(value.to_bits())
    }

    fn float(&mut self, value: f64, wide: bool) -> std::io::Result<()> {
        if !wide {
            return self.f32(value as f32);
        }
        let bytes = if self.big_endian { value.to_be_bytes() } else { value.to_le_bytes() };
        self.writer.write_all(&bytes)
    }

    fn end(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
