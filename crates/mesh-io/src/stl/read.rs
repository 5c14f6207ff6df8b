//! Reading STL.

use crate::budget::GROWING;
use crate::error::{Location, ReadErrorKind};
use crate::format::is_binary_stl;
use crate::input::{Input, Line, Words, number};
use crate::{Group, Model};
use glam::DVec3;
use mesh_core::{PolygonSoup, soup::TooManyCorners};
use std::collections::HashMap;

const HEADER: u64 = 80;
/// A normal, three corners, and two bytes for whatever the writer likes.
const FACET: usize = 50;
/// Where in a facet the corners are.
const CORNERS: std::ops::Range<usize> = 12..48;
/// The memory that a vertex takes, its entry in the table of positions included.
const VERTEX: u64 = GROWING * (24 + 40);
/// The memory that a facet takes, its vertices left out.
const FACE: u64 = GROWING * 20;

pub(crate) fn read(input: &mut Input<'_>, size: Option<u64>) -> Result<Model, ReadErrorKind> {
    let head = input.peek(512)?;
    let text = head.trim_ascii_start();
    let says_text = [&b"solid"[..], b"facet"]
        .iter()
        .any(|word| text.get(..5).is_some_and(|start| start.eq_ignore_ascii_case(word)));
    if says_text && !is_binary_stl(head, size) { read_text(input) } else { read_binary(input) }
}

/// Makes equal positions one vertex, numbered in the order of their first use.
#[derive(Default)]
struct Weld {
    soup: PolygonSoup,
    vertices: HashMap<[u64; 3], u32, foldhash::fast::RandomState>,
}

impl Weld {
    fn vertex(&mut self, position: [f64; 3]) -> Result<u32, TooManyCorners> {
        // Adding zero turns -0 into 0.
        let key = position.map(|value| (value + 0.0).to_bits());
        let next = u32::try_from(self.vertices.len()).map_err(|_| TooManyCorners)?;
        Ok(*self.vertices.entry(key).or_insert_with(|| {
            self.soup.push_vertex(DVec3::from(position));
            next
        }))
    }
}

fn read_binary(input: &mut Input<'_>) -> Result<Model, ReadErrorKind> {
    input.skip(HEADER, "the header")?;
    let at = input.here();
    let count = u32::from_le_bytes(input.array("the number of facets")?);
    let room = input.plausible(u64::from(count), FACET as u64, at.clone(), "facets")?;
    // Two faces for a vertex, as reserved here.
    input.require((VERTEX / GROWING + 2 * FACE / GROWING) * (room as u64 / 2), || at)?;
    let mut weld = Weld {
        // A closed mesh has half as many vertices as faces.
        vertices: HashMap::with_capacity_and_hasher(room / 2, Default::default()),
        soup: PolygonSoup::with_capacity(room / 2, room, 3 * room),
    };
    let mut extra = false;
    for _ in 0..count {
        let before = weld.soup.vertex_count();
        let facet: [u8; FACET] = input.array("a facet")?;
        let mut triangle = [0; 3];
        let numbers = facet[CORNERS].as_chunks::<4>().0.as_chunks::<3>().0;
        for (vertex, corner) in triangle.iter_mut().zip(numbers) {
            *vertex = weld.vertex(corner.map(|bytes| f64::from(f32::from_le_bytes(bytes))))?;
        }
        weld.soup.push_face(&triangle)?;
        extra |= facet[CORNERS.end..] != [0, 0];
        let cost = FACE + VERTEX * (weld.soup.vertex_count() - before) as u64;
        let at = input.here();
        input.spend(cost, || at)?;
    }
    let mut model = Model::from(weld.soup);
    if extra {
        model.notes.push("ignored the two extra bytes of the STL facets".to_owned());
    }
    if !input.peek(1)?.is_empty() {
        model.notes.push("ignored what follows the last STL facet".to_owned());
    }
    Ok(model)
}

fn read_text(input: &mut Input<'_>) -> Result<Model, ReadErrorKind> {
    let mut reader = TextReader::default();
    while let Some(line) = input.line()? {
        let before = reader.weld.soup.vertex_count();
        // A facet has three numbers for each corner, a solid a name.
        let cost = GROWING * 8 * line.text.len() as u64;
        reader.line(line)?;
        let vertices = reader.weld.soup.vertex_count() - before;
        input.spend_on_line(cost + VERTEX * vertices as u64)?;
    }
    if reader.within_solid || reader.corners.is_some() {
        return Err(ReadErrorKind::malformed(
            Location::Line(input.line_number()),
            "endsolid",
            "the end of the file",
        ));
    }
    Ok(reader.finish())
}

#[derive(Default)]
struct TextReader {
    weld: Weld,
    groups: Vec<Group>,
    face_groups: Vec<u32>,
    within_solid: bool,
    /// The corners of the facet that is being read.
    corners: Option<Vec<u32>>,
}

impl TextReader {
    /// Keywords in any case, usually but not necessarily one to a line.
    fn line(&mut self, line: Line<'_>) -> Result<(), ReadErrorKind> {
        let mut words = line.words();
        while let Some(word) = words.next() {
            match word.to_ascii_lowercase().as_slice() {
                b"solid" => {
                    self.within_solid = true;
                    let name = String::from_utf8_lossy(words.remainder()).into_owned();
                    self.groups.push(Group { object: String::new(), name });
                    return Ok(());
                }
                b"endsolid" => {
                    self.within_solid = false;
                    return Ok(());
                }
                b"facet" => {
                    if self.corners.replace(Vec::with_capacity(3)).is_some() {
                        return Err(line.unexpected("endfacet", word));
                    }
                    // The word "normal" and its numbers, which are not needed.
                    words.by_ref().take(4).for_each(drop);
                }
                b"vertex" => self.vertex(line, &mut words)?,
                b"endfacet" => self.end_facet(line, word)?,
                b"outer" | b"loop" | b"endloop" => {}
                _ => {
                    let expected = "solid, facet, outer loop, vertex, endloop, endfacet, endsolid";
                    return Err(line.unexpected(expected, word));
                }
            }
        }
        Ok(())
    }

    fn vertex(&mut self, line: Line<'_>, words: &mut Words<'_>) -> Result<(), ReadErrorKind> {
        let mut position = [0.0; 3];
        for value in &mut position {
            let word = words.next().unwrap_or_default();
            *value = number(word).ok_or_else(|| line.unexpected("three coordinates", word))?;
        }
        let corners = self.corners.as_mut().ok_or_else(|| line.unexpected("facet", b"vertex"))?;
        corners.push(self.weld.vertex(position)?);
        Ok(())
    }

    fn end_facet(&mut self, line: Line<'_>, word: &[u8]) -> Result<(), ReadErrorKind> {
        let corners = self.corners.take().ok_or_else(|| line.unexpected("facet", word))?;
        if corners.len() < 3 {
            let expected = format!("a third vertex after {} of them", corners.len());
            return Err(line.unexpected(expected, word));
        }
        self.weld.soup.push_face(&corners)?;
        self.face_groups.push((self.groups.len() as u32).wrapping_sub(1));
        Ok(())
    }

    fn finish(self) -> Model {
        let mut model = Model::from(self.weld.soup);
        // A single solid without a name tells nothing.
        if self.groups.len() > 1 || self.groups.iter().any(|group| !group.name.is_empty()) {
            model.groups = self.groups;
            model.face_groups = Some(self.face_groups);
        }
        model
    }
}
