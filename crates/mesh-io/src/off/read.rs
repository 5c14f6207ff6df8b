//! Reading OFF.

use crate::Model;
use crate::budget::GROWING;
use crate::error::{Location, ReadErrorKind};
use crate::format::is_off_word;
use crate::input::{Input, Line, integer, number};
use crate::notes::Notes;
use crate::text::quote;
use glam::DVec3;
use mesh_core::PolygonSoup;

/// The memory that a vertex takes, with everything that it may have.
const VERTEX: u64 = 24 + GROWING * (12 + 16 + 8);

/// The memory that a face takes, with a colour and texture coordinates.
fn face_cost(corners: usize) -> u64 {
    GROWING * (4 + 16 + 12 * corners as u64)
}

/// What the header word announces for every vertex.
#[derive(Clone, Copy, Debug, Default)]
struct Header {
    uv: bool,
    color: bool,
    normal: bool,
    /// A fourth coordinate, by which the others are divided.
    weight: bool,
    /// The number of coordinates is given before the counts.
    dimension: bool,
    binary: bool,
}

impl Header {
    fn parse(word: &[u8]) -> Self {
        let has = |byte| word.contains(&byte);
        Self {
            uv: word.starts_with(b"ST"),
            color: has(b'C'),
            normal: has(b'N'),
            weight: has(b'4'),
            dimension: has(b'n'),
            binary: false,
        }
    }

    fn coordinates(self) -> usize {
        if self.weight { 4 } else { 3 }
    }

    /// The numbers per vertex, those of the colour left out.
    fn without_color(self) -> usize {
        self.coordinates() + if self.normal { 3 } else { 0 } + if self.uv { 2 } else { 0 }
    }
}

pub(crate) fn read(input: &mut Input<'_>) -> Result<Model, ReadErrorKind> {
    let mut reader = Reader {
        input,
        header: Header::default(),
        model: Model::default(),
        uvs: vec![],
        small_faces: 0,
        surplus: false,
        notes: Notes::default(),
        little_endian: false,
    };
    let counts = reader.header()?;
    if reader.header.binary {
        reader.binary()?;
    } else {
        reader.text(counts)?;
    }
    Ok(reader.finish())
}

struct Reader<'i, 'a> {
    input: &'i mut Input<'a>,
    header: Header,
    model: Model,
    uvs: Vec<[f32; 2]>,
    /// Faces of fewer than three corners.
    small_faces: u64,
    /// Whether a vertex had more numbers than announced.
    surplus: bool,
    notes: Notes,
    /// The order of the bytes of a binary file.
    little_endian: bool,
}

impl Reader<'_, '_> {
    /// Reads up to the counts, which binary files have elsewhere.
    fn header(&mut self) -> Result<[u32; 2], ReadErrorKind> {
        let line = self.input.data_line("OFF or the numbers of vertices and faces")?;
        let mut words = line.words();
        let word = words.next().unwrap_or_default();
        if !is_off_word(word) {
            return read_counts(line, 0);
        }
        self.header = Header::parse(word);
        let mut used = 1;
        if words.clone().next() == Some(b"BINARY") {
            self.header.binary = true;
            return Ok([0; 2]);
        }
        let mut line = line;
        if self.header.dimension {
            if words.next().is_none() {
                line = self.input.data_line("the number of dimensions")?;
                used = 0;
            }
            let word = line.words().nth(used).unwrap_or_default();
            if word != b"3" {
                return Err(ReadErrorKind::Unsupported {
                    at: line.location(),
                    what: format!("OFF in {} dimensions", quote(word)),
                    cure: "project the mesh to three dimensions",
                });
            }
            used += 1;
        }
        if line.words().nth(used).is_none() {
            line = self.input.data_line("the numbers of vertices and faces")?;
            used = 0;
        }
        read_counts(line, used)
    }

    fn text(&mut self, [vertices, faces]: [u32; 2]) -> Result<(), ReadErrorKind> {
        let here = Location::Line(self.input.line_number());
        let least = 2 * self.header.without_color() as u64;
        let room = self.input.plausible(u64::from(vertices), least, here.clone(), "vertices")?;
        let face_room = self.input.plausible(u64::from(faces), 2, here, "faces");
        self.reserve_vertices(room)?;
        let mut numbers = Numbers::default();
        let mut fractions = false;
        for _ in 0..vertices {
            numbers.line(self.input, self.header.without_color(), "the numbers of a vertex")?;
            self.vertex(&numbers)?;
            self.input.spend(VERTEX, || numbers.at.clone())?;
            let uv = if self.header.uv { 2 } else { 0 };
            let color = self.header.without_color() - uv..numbers.values.len() - uv;
            fractions |= numbers.dotted[color].contains(&true);
        }
        let face_room = face_room?;
        let at = Location::Line(self.input.line_number());
        self.input.require((face_room as u64).saturating_mul(16), || at)?;
        let positions = std::mem::take(self.model.soup.positions_mut());
        self.model.soup = PolygonSoup::with_capacity(0, face_room, 3 * face_room);
        *self.model.soup.positions_mut() = positions;
        self.faces_text(faces, vertices)?;
        if let Some(colors) = &mut self.model.vertex_colors {
            to_unit_range(colors, fractions);
        }
        Ok(())
    }

    fn reserve_vertices(&mut self, room: usize) -> Result<(), ReadErrorKind> {
        self.input.require((room as u64).saturating_mul(24), || self.input.here())?;
        self.model.soup = PolygonSoup::with_capacity(room, 0, 0);
        Ok(())
    }

    /// Takes position, normal, colour and texture coordinate, in this order.
    fn vertex(&mut self, numbers: &Numbers) -> Result<(), ReadErrorKind> {
        let all = numbers.values.as_slice();
        let header = self.header;
        let (position, rest) = all.split_at(header.coordinates());
        let weight = if header.weight { position[3] } else { 1.0 };
        self.model.soup.push_vertex(DVec3::from_slice(position) / weight);
        let (normal, rest) = rest.split_at(if header.normal { 3 } else { 0 });
        if let Some(&normal) = normal.first_chunk::<3>() {
            let normals = self.model.vertex_normals.get_or_insert_default();
            normals.push(normal.map(|value| value as f32));
        }
        let uv_length = if header.uv { 2 } else { 0 };
        let (color, uv) = rest.split_at(rest.len() - uv_length);
        if let Some(&uv) = uv.first_chunk::<2>() {
            self.uvs.push(uv.map(|value| value as f32));
        }
        if header.color {
            let color = read_color(color).ok_or_else(|| {
                let expected = "three or four numbers of a colour";
                ReadErrorKind::malformed(numbers.at.clone(), expected, color.len().to_string())
            })?;
            self.model.vertex_colors.get_or_insert_default().push(color);
        } else if !color.is_empty() && !std::mem::replace(&mut self.surplus, true) {
            let at = &numbers.at;
            self.notes.add(format!("{at}: ignored numbers that the OFF header does not announce"));
        }
        Ok(())
    }

    fn faces_text(&mut self, faces: u32, vertices: u32) -> Result<(), ReadErrorKind> {
        let mut numbers = Numbers::default();
        let mut colors = FaceColors::default();
        let mut fractions = false;
        for _ in 0..faces {
            numbers.line(self.input, 1, "the corners of a face")?;
            let corners = whole(numbers.values[0], u32::MAX, &numbers.at, "a number of corners")?;
            numbers.more(self.input, 1 + corners as usize, "the corners of a face")?;
            let (face, color) = numbers.values[1..].split_at(corners as usize);
            fractions |= numbers.dotted[1 + face.len()..].contains(&true);
            self.push_face(face, vertices, &numbers.at)?;
            if face.len() >= 3 {
                colors.push(color);
            }
            self.input.spend(face_cost(face.len()), || numbers.at.clone())?;
        }
        self.model.face_colors = colors.finish(fractions);
        Ok(())
    }

    fn push_face(&mut self, face: &[f64], limit: u32, at: &Location) -> Result<(), ReadErrorKind> {
        let face: Result<Vec<u32>, _> = face
            .iter()
            .map(|&v| whole(v, limit, at, &format!("vertex indices from 0 to below {limit}")))
            .collect();
        let face = face?;
        if face.len() < 3 {
            self.small_faces += 1;
            return Ok(());
        }
        Ok(self.model.soup.push_face(&face)?)
    }

    fn binary(&mut self) -> Result<(), ReadErrorKind> {
        if self.header.dimension {
            let at = self.input.here();
            let bytes: [u8; 4] = self.input.array("the number of dimensions")?;
            self.little_endian = u32::from_le_bytes(bytes) < u32::from_be_bytes(bytes);
            let dimension = self.whole(bytes);
            if dimension != 3 {
                return Err(ReadErrorKind::Unsupported {
                    at,
                    what: format!("OFF in {dimension} dimensions"),
                    cure: "project the mesh to three dimensions",
                });
            }
        }
        let color = if self.header.color { 4 } else { 0 };
        let width = self.header.without_color() + color;
        let at = self.input.here();
        let counts: [u8; 12] = self.input.array("the numbers of vertices, faces and edges")?;
        if !self.header.dimension {
            self.little_endian = self.counts_are_little_endian(counts, 4 * width as u64);
        }
        let (words, _) = counts.as_chunks::<4>();
        let [vertices, faces] = [words[0], words[1]].map(|bytes| self.whole(bytes));
        let room = self.input.plausible(u64::from(vertices), 4 * width as u64, at, "vertices")?;
        self.reserve_vertices(room)?;
        let mut numbers = Numbers::default();
        for _ in 0..vertices {
            numbers.at = self.input.here();
            numbers.values.clear();
            for _ in 0..width {
                numbers.values.push(f64::from(self.float("a vertex")?));
            }
            self.vertex(&numbers)?;
            self.input.spend(VERTEX, || numbers.at.clone())?;
        }
        self.faces_binary(faces, vertices)
    }

    /// Whether the numbers of vertices and faces are written with the least significant byte first,
    /// as OpenMesh does it, against the format: the file cannot hold what they are otherwise, or if
    /// it can hold both, they fill less of it otherwise. Without the length of the file, the smaller
    /// numbers are the right ones.
    fn counts_are_little_endian(&self, counts: [u8; 12], vertex: u64) -> bool {
        let (words, _) = counts.as_chunks::<4>();
        let bytes = |read: fn([u8; 4]) -> u32| {
            let [vertices, faces] = [words[0], words[1]].map(|word| u64::from(read(word)));
            // Five words for a triangle, one less without a number of colour components.
            vertices.saturating_mul(vertex).saturating_add(faces.saturating_mul(8))
        };
        let (big, little) = (bytes(u32::from_be_bytes), bytes(u32::from_le_bytes));
        match self.input.rest_known() {
            Some(rest) if big <= rest && little <= rest => little > big,
            Some(rest) => little <= rest,
            None => little < big,
        }
    }

    fn faces_binary(&mut self, faces: u32, vertices: u32) -> Result<(), ReadErrorKind> {
        self.input.plausible(u64::from(faces), 8, self.input.here(), "faces")?;
        let has_colors = !self.little_endian || self.says_colors(faces)?;
        let (mut face, mut color) = (Vec::new(), Vec::new());
        let mut colors = FaceColors::default();
        for _ in 0..faces {
            let at = self.input.here();
            let corners = self.int("the number of corners")?;
            self.input.plausible(u64::from(corners), 4, at.clone(), "corners")?;
            face.clear();
            for _ in 0..corners {
                face.push(f64::from(self.int("a corner")?));
            }
            let components =
                if has_colors { self.int("the number of colour components")? } else { 0 };
            self.input.plausible(u64::from(components), 4, at.clone(), "colour components")?;
            color.clear();
            for _ in 0..components {
                color.push(f64::from(self.float("a colour")?));
            }
            self.push_face(&face, vertices, &at)?;
            if face.len() >= 3 {
                colors.push(&color);
            }
            self.input.spend(face_cost(face.len()), || at)?;
        }
        self.model.face_colors = colors.finish(true);
        Ok(())
    }

    /// Whether the number of colour components follows each face, as the format has it. OpenMesh
    /// leaves it out; then the faces end where the file does without it.
    fn says_colors(&mut self, faces: u32) -> Result<bool, ReadErrorKind> {
        let Some(rest) = self.input.rest_known() else { return Ok(true) };
        // A face takes at least its number of corners; the window holds what is looked at.
        self.input.spend(rest, || Location::Byte(0))?;
        let (words, odd) = self.input.peek(rest as usize)?.as_chunks::<4>();
        let mut place = 0_usize;
        for _ in 0..faces {
            let Some(&corners) = words.get(place) else { return Ok(true) };
            place = place.saturating_add(1 + u32::from_le_bytes(corners) as usize);
        }
        Ok(place != words.len() || !odd.is_empty())
    }

    fn int(&mut self, what: &str) -> Result<u32, ReadErrorKind> {
        let bytes = self.input.array(what)?;
        Ok(self.whole(bytes))
    }

    fn float(&mut self, what: &str) -> Result<f32, ReadErrorKind> {
        let bytes = self.input.array(what)?;
        Ok(f32::from_bits(self.whole(bytes)))
    }

    fn whole(&self, bytes: [u8; 4]) -> u32 {
        if self.little_endian { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) }
    }

    fn finish(mut self) -> Model {
        if self.header.uv {
            let uv = |&vertex: &u32| self.uvs.get(vertex as usize).copied().unwrap_or_default();
            self.model.corner_uvs = Some(self.model.soup.corners().iter().map(uv).collect());
        }
        if self.small_faces > 0 {
            let count = self.small_faces;
            self.notes.add(format!("skipped {count} faces of fewer than three corners"));
        }
        self.model.notes = self.notes.finish();
        self.model
    }
}

/// The numbers of vertices and faces; that of edges may follow and is not needed.
fn read_counts(line: Line<'_>, skip: usize) -> Result<[u32; 2], ReadErrorKind> {
    let mut words = line.words().skip(skip);
    let mut counts = [0; 2];
    for (count, what) in counts.iter_mut().zip(["vertices", "faces"]) {
        let word = words.next().unwrap_or_default();
        *count =
            integer(word).ok_or_else(|| line.unexpected(format!("the number of {what}"), word))?;
    }
    Ok(counts)
}

/// The numbers of a vertex or face, usually but not necessarily on one line.
struct Numbers {
    values: Vec<f64>,
    at: Location,
    /// Which of the values were written with a fraction.
    dotted: Vec<bool>,
}

impl Default for Numbers {
    fn default() -> Self {
        Self { values: Vec::new(), at: Location::Line(0), dotted: Vec::new() }
    }
}

impl Numbers {
    /// Reads a line, and more while there are fewer than `least` numbers.
    fn line(
        &mut self,
        input: &mut Input<'_>,
        least: usize,
        what: &str,
    ) -> Result<(), ReadErrorKind> {
        self.values.clear();
        self.dotted.clear();
        self.append(input, what)?;
        self.more(input, least, what)
    }

    fn more(
        &mut self,
        input: &mut Input<'_>,
        least: usize,
        what: &str,
    ) -> Result<(), ReadErrorKind> {
        while self.values.len() < least {
            self.append(input, what)?;
        }
        Ok(())
    }

    fn append(&mut self, input: &mut Input<'_>, what: &str) -> Result<(), ReadErrorKind> {
        let line = input.data_line(what)?;
        self.at = line.location();
        for word in line.words() {
            let value = number(word).ok_or_else(|| line.unexpected(what, word))?;
            self.dotted.push(word.contains(&b'.'));
            self.values.push(value);
        }
        Ok(())
    }
}

/// A value as a whole number below `limit`.
fn whole(value: f64, limit: u32, at: &Location, expected: &str) -> Result<u32, ReadErrorKind> {
    if value >= 0.0 && value < f64::from(limit) && value.fract() == 0.0 {
        Ok(value as u32)
    } else {
        Err(ReadErrorKind::malformed(at.clone(), expected, value.to_string()))
    }
}

fn read_color(values: &[f64]) -> Option<[f32; 4]> {
    match *values {
        [r, g, b] => Some([r as f32, g as f32, b as f32, f32::NAN]),
        [r, g, b, a] => Some([r as f32, g as f32, b as f32, a as f32]),
        _ => None,
    }
}

/// Colours from 0 to 1: those without any fraction are meant from 0 to 255, unless none is above
/// one. A colour without an opacity is opaque.
fn to_unit_range(colors: &mut [[f32; 4]], fractions: bool) {
    let bytes = !fractions && colors.as_flattened().iter().any(|&value| value > 1.0);
    for [channels @ .., opacity] in colors {
        let all = channels.iter_mut().chain(std::iter::once(&mut *opacity));
        if bytes {
            all.for_each(|value| *value /= 255.0);
        }
        if opacity.is_nan() {
            *opacity = 1.0;
        }
    }
}

/// The colours of the faces, of which only some may have one.
#[derive(Default)]
struct FaceColors {
    colors: Vec<[f32; 4]>,
    any: bool,
}

impl FaceColors {
    /// Takes what follows the corners of a face; a single number is an index into a table of
    /// colours that is not in the file.
    fn push(&mut self, color: &[f64]) {
        let color = read_color(color);
        self.any |= color.is_some();
        self.colors.push(color.unwrap_or([f32::NAN; 4]));
    }

    fn finish(mut self, fractions: bool) -> Option<Vec<[f32; 4]>> {
        if !self.any {
            return None;
        }
        to_unit_range(&mut self.colors, fractions);
        Some(self.colors)
    }
}
