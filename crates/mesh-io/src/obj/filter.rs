//! The filter between an OBJ file and `tobj`.
//!
//! `tobj` numbers the vertices of every object anew, and keeps neither the vertices that no face
//! uses nor the numbers of lines. The filter therefore reads positions, texture coordinates and
//! normals itself and passes on, in their place, their index: `v 1.5 2 3` as the eighth vertex
//! becomes `v 7 0 0`. Names of groups and materials stay here too, as runs of faces. Faces are
//! passed on as they are once their indices are known to be in range, since `tobj` wraps around
//! or leaves out the line otherwise; now and then a new object is begun, so that `tobj` never
//! holds many faces in its bulky first form.

use crate::error::{Location, ReadErrorKind, quote};
use crate::input::{Input, Line, integer, number};
use crate::{Group, Model};
use glam::DVec3;
use std::collections::HashMap;
use std::io::{BufRead, Read, Write};

/// Corners after which a new object is begun.
const BATCH: usize = 1 << 14;

/// Consecutive faces of the same kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Run {
    pub first_face: usize,
    pub group: u32,
    pub material: u32,
    pub has_uv: bool,
    pub has_normal: bool,
}

/// What the filter keeps of the file.
#[derive(Default)]
pub(super) struct Kept {
    pub positions: Vec<DVec3>,
    /// Empty, or as long as `positions`; white where a vertex has no colour.
    pub colors: Vec<[f32; 4]>,
    pub uvs: Vec<[f32; 2]>,
    pub normals: Vec<[f32; 3]>,
    pub runs: Vec<Run>,
    pub groups: Vec<Group>,
    pub materials: Vec<String>,
    pub libraries: Vec<String>,
    pub faces: usize,
    pub corners: usize,
    pub notes: Vec<String>,
    group_ids: HashMap<Group, u32>,
    material_ids: HashMap<String, u32>,
    group: Group,
    group_id: Option<u32>,
    material_id: Option<u32>,
    /// Corners since an object was begun.
    batch: usize,
    unknown_lines: u64,
    small_faces: u64,
}

/// The file as `tobj` is to see it.
pub(super) struct Filter<'i, 'a> {
    input: &'i mut Input<'a>,
    kept: Kept,
    /// The line that `tobj` is reading, and how much of it it has.
    out: Vec<u8>,
    given: usize,
    /// A line joined from several.
    joined: Vec<u8>,
    failure: Option<ReadErrorKind>,
}

impl<'i, 'a> Filter<'i, 'a> {
    pub(super) fn new(input: &'i mut Input<'a>) -> Self {
        let (out, joined) = (Vec::new(), Vec::new());
        Self { input, kept: Kept::default(), out, given: 0, joined, failure: None }
    }

    /// What was kept; or why the filter, and thereby `tobj`, failed.
    pub(super) fn finish<T>(
        self,
        parsed: Result<T, tobj::LoadError>,
    ) -> Result<(Kept, T), ReadErrorKind> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        let parsed = parsed.map_err(|error| {
            let at = Location::Line(self.input.line_number());
            ReadErrorKind::malformed(at, "a line of an OBJ file", error.to_string())
        })?;
        let mut kept = self.kept;
        if kept.small_faces > 0 {
            let count = kept.small_faces;
            kept.notes.push(format!("skipped {count} faces of fewer than three corners"));
        }
        if kept.unknown_lines > 1 {
            kept.notes.push(format!("skipped {} such lines in all", kept.unknown_lines));
        }
        Ok((kept, parsed))
    }

    /// Takes lines of the file until there is one for `tobj`, or the file ends.
    fn advance(&mut self) -> Result<(), ReadErrorKind> {
        self.out.clear();
        self.given = 0;
        while self.out.is_empty() {
            let Some(line) = self.input.line()? else { return Ok(()) };
            if line.text.ends_with(b"\\") {
                let number = line.number;
                self.joined.clear();
                self.joined.extend_from_slice(line.text);
                self.join_lines()?;
                let line = Line { number, text: &self.joined };
                self.kept.take(line, &mut self.out)?;
            } else {
                self.kept.take(line, &mut self.out)?;
            }
        }
        Ok(())
    }

    /// Appends lines as long as the last one ends in a backslash.
    fn join_lines(&mut self) -> Result<(), ReadErrorKind> {
        while self.joined.pop_if(|last| *last == b'\\').is_some() {
            self.joined.push(b' ');
            match self.input.line()? {
                Some(line) => self.joined.extend_from_slice(line.text),
                None => break,
            }
        }
        Ok(())
    }
}

impl BufRead for Filter<'_, '_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.given == self.out.len() && self.failure.is_none() {
            self.failure = self.advance().err();
        }
        match &self.failure {
            None => Ok(&self.out[self.given..]),
            Some(_) => Err(std::io::ErrorKind::InvalidData.into()),
        }
    }

    fn consume(&mut self, count: usize) {
        self.given = (self.given + count).min(self.out.len());
    }
}

impl Read for Filter<'_, '_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

impl Kept {
    /// Takes a line of the file, and puts into `out` what `tobj` is to read instead.
    fn take(&mut self, line: Line<'_>, out: &mut Vec<u8>) -> Result<(), ReadErrorKind> {
        let mut words = line.words();
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            b"v" => self.position(line, out),
            b"vt" => {
                let [u, v] = floats(line, 1)?;
                pass_index(out, "vt", self.uvs.len(), "0");
                self.uvs.push([u, v]);
                Ok(())
            }
            b"vn" => {
                let normal = floats(line, 3)?;
                pass_index(out, "vn", self.normals.len(), "0 0");
                self.normals.push(normal);
                Ok(())
            }
            b"f" | b"fo" => self.face(line, out),
            b"o" | b"g" => {
                let name = String::from_utf8_lossy(words.remainder()).into_owned();
                if keyword == b"o" {
                    self.group = Group { object: name, name: String::new() };
                } else {
                    self.group.name = name;
                }
                let next = self.groups.len() as u32;
                let id = *self.group_ids.entry(self.group.clone()).or_insert(next);
                if id == next {
                    self.groups.push(self.group.clone());
                }
                self.group_id = Some(id);
                Ok(())
            }
            b"usemtl" => {
                let name = String::from_utf8_lossy(words.remainder()).into_owned();
                let next = self.materials.len() as u32;
                let id = *self.material_ids.entry(name.clone()).or_insert(next);
                if id == next {
                    self.materials.push(name);
                }
                self.material_id = Some(id);
                Ok(())
            }
            b"mtllib" => {
                let name = String::from_utf8_lossy(words.remainder()).into_owned();
                if !self.libraries.contains(&name) {
                    self.libraries.push(name);
                }
                Ok(())
            }
            b"s" | b"l" | b"p" | b"vp" => Ok(()),
            other => {
                if self.unknown_lines == 0 {
                    self.notes.push(format!("{}: skipped {}", line.location(), quote(other)));
                }
                self.unknown_lines += 1;
                Ok(())
            }
        }
    }

    /// `x y z`, then nothing, a weight, or a colour with or without opacity.
    fn position(&mut self, line: Line<'_>, out: &mut Vec<u8>) -> Result<(), ReadErrorKind> {
        let mut values = [0.0; 7];
        let mut count = 0;
        for word in line.words().skip(1) {
            let value = number(word);
            match (values.get_mut(count), value) {
                (Some(slot), Some(value)) => *slot = value,
                _ => return Err(line.unexpected("3 to 7 numbers", word)),
            }
            count += 1;
        }
        let [x, y, z, fourth, g, b, opacity] = values;
        let mut position = DVec3::new(x, y, z);
        let mut color = [1.0; 4];
        match count {
            3 => {}
            4 if fourth != 0.0 => position /= fourth,
            4 => return Err(line.unexpected("a weight other than zero", b"0")),
            6 => color = [fourth as f32, g as f32, b as f32, 1.0],
            7 => color = [fourth as f32, g as f32, b as f32, opacity as f32],
            _ => return Err(line.unexpected("3, 4, 6 or 7 numbers", line.text)),
        }
        if count >= 6 && self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 4]);
        }
        if count >= 6 || !self.colors.is_empty() {
            self.colors.push(color);
        }
        pass_index(out, "v", self.positions.len(), "0 0");
        self.positions.push(position);
        Ok(())
    }

    fn face(&mut self, line: Line<'_>, out: &mut Vec<u8>) -> Result<(), ReadErrorKind> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let mut corners = 0;
        let mut given = [true; 3];
        out.push(b'f');
        for corner in line.words().skip(1) {
            for (all, has) in given.iter_mut().zip(check_corner(line, corner, counts)?) {
                *all &= has;
            }
            out.push(b' ');
            out.extend_from_slice(corner);
            corners += 1;
        }
        out.push(b'\n');
        if corners < 3 {
            out.clear();
            self.small_faces += 1;
            return Ok(());
        }
        if self.batch >= BATCH {
            out.splice(..0, *b"o -\n");
            self.batch = 0;
        }
        let run = Run {
            first_face: self.faces,
            group: self.group_id.unwrap_or(Model::NONE),
            material: self.material_id.unwrap_or(Model::NONE),
            has_uv: given[1],
            has_normal: given[2],
        };
        let same = |last: &Run| Run { first_face: run.first_face, ..*last } == run;
        if !self.runs.last().is_some_and(same) {
            self.runs.push(run);
        }
        self.faces += 1;
        self.corners += corners;
        self.batch += corners;
        Ok(())
    }
}

/// Puts an index where the numbers of a position, texture coordinate or normal were.
fn pass_index(out: &mut Vec<u8>, keyword: &str, index: usize, zeros: &str) {
    // Writing to memory cannot fail.
    let _ = writeln!(out, "{keyword} {index} {zeros}");
}

/// The numbers after the keyword, of which at least `least` must be there; more are ignored.
fn floats<const N: usize>(line: Line<'_>, least: usize) -> Result<[f32; N], ReadErrorKind> {
    let mut values = [0.0; N];
    let mut words = line.words().skip(1);
    for (index, value) in values.iter_mut().enumerate() {
        match words.next() {
            None if index >= least => {}
            word => {
                let word = word.unwrap_or_default();
                let read = number(word);
                *value = read.ok_or_else(|| line.unexpected("a number", word))? as f32;
            }
        }
    }
    Ok(values)
}

/// Whether `v/vt/vn` names a vertex, a texture coordinate and a normal; those that it names must
/// have been given before.
fn check_corner(
    line: Line<'_>,
    corner: &[u8],
    counts: [usize; 3],
) -> Result<[bool; 3], ReadErrorKind> {
    const NAMES: [&str; 3] = ["vertex", "texture coordinate", "normal"];
    let mut given = [false; 3];
    for (place, word) in corner.split(|&byte| byte == b'/').enumerate() {
        let (Some(&count), Some(name)) = (counts.get(place), NAMES.get(place)) else {
            return Err(line.unexpected("no more than vertex/texture/normal", corner));
        };
        if word.is_empty() {
            continue;
        }
        let index: i64 = integer(word)
            .ok_or_else(|| line.unexpected(format!("the index of a {name}"), corner))?;
        if index == 0 || index.unsigned_abs() > count as u64 {
            let expected = format!(
                "the index of one of the {count} {name}s before this line (from 1, or from -1 back)"
            );
            return Err(line.unexpected(expected, word));
        }
        given[place] = true;
    }
    if given[0] { Ok(given) } else { Err(line.unexpected("the index of a vertex", corner)) }
}
