//! Reading OFF.

use crate::Model;
use crate::budget::GROWING;
use crate::error::{Location, ReadErrorKind};
use crate::format::off_word;
use crate::input::{Input, Line, integer, number};
use crate::item::{Item, Visit, stopped};
use crate::lost::{Lost, STREAMED};
use crate::notes::Notes;
use crate::scalars::Scalars;
use crate::text::quote;
use glam::DVec3;
use mesh_core::PolygonSoup;
use std::ops::ControlFlow;

/// The note for indices into a colour map.
const IN_COLOR_MAP: &str =
    "colours are places in a colour map that is not in the file: kept as numbers named color_index";

/// The number of bytes that the reader examines before the vertices.
const LOOK_AHEAD: usize = 1 << 16;

/// A line without its comment and surrounding white space.
fn without_comment(line: &[u8]) -> &[u8] {
    line.split(|&byte| byte == b'#').next().unwrap_or_default().trim_ascii()
}

fn numbers_in(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// Whether a line holds three numbers that form a unit vector.
fn has_unit_length(line: &[u8]) -> bool {
    let numbers: Vec<f64> = numbers_in(line).filter_map(number).collect();
    numbers.len() == 3 && is_near_one(numbers.iter().map(|value| value * value).sum())
}

fn is_near_one(squared_length: f64) -> bool {
    (squared_length - 1.0).abs() < 0.01
}

/// The memory of a vertex with all possible attributes.
const VERTEX: u64 = 24 + GROWING * (12 + 16 + 8);

/// The memory of a face with a colour and texture coordinates.
fn face_cost(corners: usize) -> u64 {
    GROWING * (8 + 16 + 12 * corners as u64)
}

/// The attributes of every vertex, as announced by the header word.
#[derive(Clone, Copy, Debug, Default)]
struct Header {
    uv: bool,
    color: bool,
    normal: bool,
    /// A fourth coordinate, which divides the others.
    weight: bool,
    /// The number of coordinates is given before the counts.
    dimension: bool,
    binary: bool,
}

impl Header {
    fn parse(letters: &[u8]) -> Self {
        let has = |byte| letters.contains(&byte);
        Self {
            uv: has(b'S'),
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

    /// The number of values per vertex, without the colour.
    fn without_color(self) -> usize {
        self.coordinates() + if self.normal { 3 } else { 0 } + if self.uv { 2 } else { 0 }
    }
}

pub(crate) fn read(input: &mut Input<'_>) -> Result<Model, ReadErrorKind> {
    let mut reader = Reader::new(input, None);
    reader.read()?;
    Ok(reader.finish())
}

/// Reads vertices and faces one by one. Binary files have to be big-endian, as the format requires.
pub(crate) fn scan(
    input: &mut Input<'_>,
    visit: &mut Visit<'_>,
    notes: &mut Notes,
) -> Result<ControlFlow<()>, ReadErrorKind> {
    let mut flow = ControlFlow::Continue(());
    let visit = &mut |item: Item<'_>| {
        flow = visit(item);
        flow
    };
    let mut reader = Reader::new(input, Some(visit));
    let read = reader.read();
    let Header { normal, color, uv, .. } = reader.header;
    let has_face_colors = reader.has_face_colors;
    *notes = reader.finish_notes();
    for (is_lost, what) in [
        (normal, "vertex normals"),
        (color, "vertex colours"),
        (uv, "texture coordinates"),
        (has_face_colors, "face colours"),
    ] {
        if is_lost {
            notes.lose(Lost::new(what, STREAMED));
        }
    }
    if flow.is_break() { Ok(flow) } else { read.map(|()| flow) }
}

struct Reader<'i, 'a, 'v> {
    input: &'i mut Input<'a>,
    /// The receiver of vertices and faces in a scan. They are not kept then.
    visit: Option<&'i mut Visit<'v>>,
    /// Whether a face of a scan has a colour.
    has_face_colors: bool,
    header: Header,
    model: Model,
    uvs: Vec<[f32; 2]>,
    /// Faces of fewer than three corners.
    small_faces: u64,
    /// The indices of vertices into a colour map.
    vertex_places: Vec<i32>,
    /// Whether a vertex had more numbers than announced.
    surplus: bool,
    notes: Notes,
    /// The byte order of a binary file.
    little_endian: bool,
}

impl<'i, 'a, 'v> Reader<'i, 'a, 'v> {
    fn new(input: &'i mut Input<'a>, visit: Option<&'i mut Visit<'v>>) -> Self {
        Self {
            input,
            visit,
            has_face_colors: false,
            header: Header::default(),
            model: Model::default(),
            uvs: vec![],
            small_faces: 0,
            vertex_places: vec![],
            surplus: false,
            notes: Notes::default(),
            little_endian: false,
        }
    }

    fn read(&mut self) -> Result<(), ReadErrorKind> {
        let counts = self.header()?;
        if self.header.binary {
            self.binary()?;
        } else {
            self.text(counts)?;
        }
        if self.input.has_more(!self.header.binary)? {
            let what = "content after the last OFF face";
            self.notes.lose(Lost::new(what, "the counts do not announce it"));
        }
        Ok(())
    }

    /// Counts the memory of the vertex that was read; in a scan, passes it on instead.
    fn done_vertex(&mut self, at: &Location) -> Result<(), ReadErrorKind> {
        let Some(visit) = &mut self.visit else { return self.input.spend(VERTEX, || at.clone()) };
        let position = self.model.soup.positions_mut().pop().unwrap_or_default();
        self.model.vertex_normals = None;
        self.model.vertex_colors = None;
        self.vertex_places.clear();
        self.uvs.clear();
        if visit(Item::Vertex(position)).is_break() { Err(stopped()) } else { Ok(()) }
    }

    /// Reads up to the counts, whose position differs in binary files.
    fn header(&mut self) -> Result<[u32; 2], ReadErrorKind> {
        let line = self.input.data_line("OFF or the numbers of vertices and faces")?;
        let mut words = line.words();
        let word = words.next().unwrap_or_default();
        let Some((letters, digits)) = off_word(word) else { return read_counts(line, 0) };
        self.header = Header::parse(&letters);
        if let Some(vertices) = integer(digits) {
            let faces = words.next().unwrap_or_default();
            let faces = integer(faces).ok_or_else(|| line.unexpected("the number of faces", faces));
            return Ok([vertices, faces?]);
        }
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
        self.drop_empty_promises(vertices, faces)?;
        let least = 2 * self.header.without_color() as u64;
        let room = self.input.plausible(u64::from(vertices), least, here.clone(), "vertices")?;
        let face_room = self.input.plausible(u64::from(faces), 2, here, "faces");
        self.reserve_vertices(room)?;
        let mut numbers = Numbers::default();
        let mut fractions = false;
        for _ in 0..vertices {
            numbers.line(self.input, self.header.without_color(), "the numbers of a vertex")?;
            self.vertex(&numbers)?;
            self.done_vertex(&numbers.at)?;
            let uv = if self.header.uv { 2 } else { 0 };
            let color = self.header.without_color() - uv..numbers.values.len() - uv;
            fractions |= numbers.dotted[color].contains(&true);
        }
        let face_room = face_room?;
        if self.visit.is_none() {
            let at = Location::Line(self.input.line_number());
            self.input.require((face_room as u64).saturating_mul(16), || at)?;
            let positions = std::mem::take(self.model.soup.positions_mut());
            self.model.soup = PolygonSoup::with_capacity(0, face_room, 3 * face_room);
            *self.model.soup.positions_mut() = positions;
        }
        self.faces_text(faces, vertices)?;
        if let Some(colors) = &mut self.model.vertex_colors {
            to_unit_range(colors, fractions);
        }
        // Some vertices have an index into a colour map, others a colour.
        if self.model.vertex_colors.as_ref().is_some_and(|c| c.len() != vertices as usize) {
            self.model.vertex_colors = None;
            let why = "some vertices have a place in a colour map instead";
            self.notes.lose(Lost::new("colours of vertices", why));
        }
        Ok(())
    }

    /// Removes announced attributes that the vertices do not have: each vertex has one line, and these lines have too
    /// few numbers. Vertices may also have their numbers on two lines. Then the file has more lines, and every second
    /// line is a unit normal.
    fn drop_empty_promises(&mut self, vertices: u32, faces: u32) -> Result<(), ReadErrorKind> {
        let header = self.header;
        let coordinates = header.coordinates();
        let promised = header.without_color() + if header.color { 3 } else { 0 };
        if promised == coordinates {
            return Ok(());
        }
        let window = self.input.peek(LOOK_AHEAD)?;
        let is_whole = window.len() < LOOK_AHEAD;
        let lines = window.split(|&byte| byte == b'\n' || byte == b'\r');
        let mut lines: Vec<&[u8]> = lines.map(without_comment).filter(|l| !l.is_empty()).collect();
        if !is_whole {
            // The last line may be incomplete.
            lines.pop();
        }
        let (vertices, faces) = (vertices as usize, faces as usize);
        let of_vertices = lines.get(..lines.len().min(vertices)).unwrap_or_default();
        let Some(&first) = of_vertices.first() else { return Ok(()) };
        let count = numbers_in(first).count();
        let has_rows = count >= coordinates
            && count < promised
            && of_vertices.iter().all(|line| numbers_in(line).count() == count);
        let is_split = if is_whole {
            lines.len() >= vertices.saturating_mul(2).saturating_add(faces)
        } else {
            of_vertices.iter().skip(1).step_by(2).all(|line| has_unit_length(line))
        };
        if !has_rows || is_split {
            return Ok(());
        }
        let numbers: Vec<f64> = numbers_in(first).filter_map(number).collect();
        let rest = numbers.get(coordinates..).unwrap_or_default();
        let is_unit = rest.len() == 3 && is_near_one(rest.iter().map(|value| value * value).sum());
        // Three numbers of unit length are a normal; other groups of three or four are a colour; two are a texture
        // coordinate.
        self.header.normal &= is_unit || (rest.len() == 3 && !header.color);
        self.header.color &= (3..=4).contains(&rest.len()) && !self.header.normal;
        self.header.uv &= rest.len() == 2;
        for (before, now, what) in [
            (header.normal, self.header.normal, "normals"),
            (header.color, self.header.color, "colours"),
            (header.uv, self.header.uv, "texture coordinates"),
        ] {
            if before && !now {
                self.notes
                    .add(format!("the OFF header announces {what}, but the vertices have none"));
            }
        }
        Ok(())
    }

    fn reserve_vertices(&mut self, room: usize) -> Result<(), ReadErrorKind> {
        if self.visit.is_some() {
            return Ok(());
        }
        self.input.require((room as u64).saturating_mul(24), || self.input.here())?;
        self.model.soup = PolygonSoup::with_capacity(room, 0, 0);
        Ok(())
    }

    /// Reads position, normal, colour and texture coordinate, in this order.
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
        if let (true, &[place]) = (header.color, color) {
            self.vertex_places.push(color_index(place));
        } else if header.color {
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
            self.push_face((face, color), vertices, &mut colors, &numbers.at)?;
        }
        self.take_face_colors(colors, fractions);
        Ok(())
    }

    /// Keeps a face and its colour; in a scan, passes the face on.
    fn push_face(
        &mut self,
        (face, color): (&[f64], &[f64]),
        limit: u32,
        colors: &mut FaceColors,
        at: &Location,
    ) -> Result<(), ReadErrorKind> {
        let face: Result<Vec<u32>, _> = face
            .iter()
            .map(|&v| whole(v, limit, at, &format!("vertex indices from 0 to below {limit}")))
            .collect();
        let face = face?;
        if face.len() < 3 {
            self.small_faces += 1;
            return Ok(());
        }
        if let Some(visit) = &mut self.visit {
            self.has_face_colors |= !color.is_empty();
            let face: Vec<u64> = face.into_iter().map(u64::from).collect();
            return if visit(Item::Face(&face)).is_break() { Err(stopped()) } else { Ok(()) };
        }
        self.input.spend(face_cost(face.len()), || at.clone())?;
        self.model.soup.push_face(&face)?;
        colors.push(color);
        Ok(())
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
        if self.little_endian && self.visit.is_some() {
            return Err(ReadErrorKind::Unsupported {
                at,
                what: "reading little-endian binary OFF as a stream".into(),
                cure: "convert the file to PLY where there is memory for it",
            });
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
            self.done_vertex(&numbers.at)?;
        }
        self.faces_binary(faces, vertices)
    }

    /// Whether the counts of vertices and faces are little-endian, as OpenMesh writes them, contrary to the format.
    /// This is so if the file cannot hold the big-endian counts, or if it can hold both but the little-endian counts
    /// fill it better. If the length of the file is unknown, the smaller counts are used.
    fn counts_are_little_endian(&self, counts: [u8; 12], vertex: u64) -> bool {
        let (words, _) = counts.as_chunks::<4>();
        let bytes = |read: fn([u8; 4]) -> u32| {
            let [vertices, faces] = [words[0], words[1]].map(|word| u64::from(read(word)));
            // Five words for a triangle, or four without a number of colour components.
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
            self.push_face((&face, &color), vertices, &mut colors, &at)?;
        }
        self.take_face_colors(colors, true);
        Ok(())
    }

    fn take_face_colors(&mut self, colors: FaceColors, fractions: bool) {
        let (colors, places) = colors.finish(fractions);
        self.model.face_colors = colors;
        let vertex_places = std::mem::take(&mut self.vertex_places);
        let is_whole = vertex_places.len() == self.model.soup.vertex_count();
        if !vertex_places.is_empty() && is_whole {
            self.notes.add(IN_COLOR_MAP);
            self.model.vertex_scalars.push(Scalars::new("color_index", vertex_places));
        }
        if let Some(places) = places {
            self.notes.add(IN_COLOR_MAP);
            self.model.face_scalars.push(Scalars::new("color_index", places));
        }
    }

    /// Whether the number of colour components follows each face, as the format requires. OpenMesh omits it; then the
    /// file ends exactly after the faces without it.
    fn says_colors(&mut self, faces: u32) -> Result<bool, ReadErrorKind> {
        let Some(rest) = self.input.rest_known() else { return Ok(true) };
        // A face needs at least its number of corners; the window contains the examined bytes.
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

    fn finish_notes(mut self) -> Notes {
        let why = "a face needs three";
        self.notes.lose_some("faces of fewer than three corners", self.small_faces, why);
        self.notes
    }

    fn finish(mut self) -> Model {
        if self.header.uv {
            let uv = |&vertex: &u32| self.uvs.get(vertex as usize).copied().unwrap_or_default();
            self.model.corner_uvs = Some(self.model.soup.corners().iter().map(uv).collect());
        }
        let mut model = std::mem::take(&mut self.model);
        self.finish_notes().store(&mut model);
        model
    }
}

/// The numbers of vertices and faces. The number of edges may follow and is not used.
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
    /// Whether each value was written with a decimal point.
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

/// An index into a colour map; -1 if it is none.
#[expect(clippy::cast_possible_truncation, reason = "the range is checked")]
fn color_index(value: f64) -> i32 {
    let is_index = value >= 0.0 && value <= f64::from(i32::MAX) && value.fract() == 0.0;
    if is_index { value as i32 } else { -1 }
}

/// A value as an integer below `limit`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the range is checked")]
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

/// Converts colours to 0 to 1. Colours written without any fraction are in the range 0 to 255, unless none is above 1.
/// A colour without opacity is opaque.
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

/// The colours of the faces; some faces may have none.
#[derive(Default)]
struct FaceColors {
    colors: Vec<[f32; 4]>,
    any: bool,
    /// The indices into a colour map, -1 for faces without one.
    places: Vec<i32>,
}

impl FaceColors {
    /// Processes the values after the corners of a face: a colour, or an index into a colour map that is not in the
    /// file.
    fn push(&mut self, color: &[f64]) {
        self.places.push(if let [place] = *color { color_index(place) } else { -1 });
        let color = read_color(color);
        self.any |= color.is_some();
        self.colors.push(color.unwrap_or([f32::NAN; 4]));
    }

    /// The colours, and the indices into a colour map, if there are any.
    fn finish(mut self, fractions: bool) -> (Option<Vec<[f32; 4]>>, Option<Vec<i32>>) {
        to_unit_range(&mut self.colors, fractions);
        let has_places = self.places.iter().any(|&place| place >= 0);
        (self.any.then_some(self.colors), has_places.then_some(self.places))
    }
}
