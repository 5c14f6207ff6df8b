//! Reading STL.

use super::color::Convention;
use super::facets::{CORNERS, FACET, Facets, HEADER, Part, corners_of, is_text};
use super::header;
use crate::budget::GROWING;
use crate::color_range::NO_COLOR;
use crate::error::ReadErrorKind;
use crate::input::Input;
use crate::lost::Lost;
use crate::notes::Notes;
use crate::{Group, Model};
use glam::DVec3;
use mesh_core::{PolygonSoup, as_u32, soup::TooManyCorners};
use std::collections::HashMap;

/// The memory of a vertex, including its entry in the table of positions.
const VERTEX: u64 = GROWING * (24 + 40);
/// The memory of a facet, without its vertices.
const FACE: u64 = GROWING * (20 + 16);

pub(crate) fn read(input: &mut Input<'_>, size: Option<u64>) -> Result<Model, ReadErrorKind> {
    if is_text(input, size)? { read_text(input) } else { read_binary(input) }
}

/// Welds equal positions, numbered in the order of first use.
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
    let header: [u8; HEADER as usize] = input.array("the header")?;
    let convention = Convention::of(&header);
    let at = input.here();
    let count = u32::from_le_bytes(input.array("the number of facets")?);
    let room = input.plausible(u64::from(count), FACET as u64, at.clone(), "facets")?;
    // Two faces per vertex, as reserved here.
    input.require((VERTEX / GROWING + 2 * FACE / GROWING) * (room as u64 / 2), || at)?;
    let mut weld = Weld {
        // A closed mesh has half as many vertices as faces.
        vertices: HashMap::with_capacity_and_hasher(room / 2, Default::default()),
        soup: PolygonSoup::with_capacity(room / 2, room, 3 * room),
    };
    let mut colors = FacetColors::default();
    for _ in 0..count {
        let before = weld.soup.vertex_count();
        let facet: [u8; FACET] = input.array("a facet")?;
        let mut triangle = [0; 3];
        for (vertex, corner) in triangle.iter_mut().zip(corners_of(&facet)) {
            *vertex = weld.vertex(corner.to_array())?;
        }
        weld.soup.push_face(&triangle)?;
        colors.push(&facet, convention);
        let cost = FACE + VERTEX * (weld.soup.vertex_count() - before) as u64;
        let at = input.here();
        input.spend(cost, || at)?;
    }
    let mut model = Model::from(weld.soup);
    model.comments.extend(header::comment(&header));
    let mut notes = Notes::default();
    model.face_colors = colors.finish(&mut notes);
    if !input.peek(1)?.is_empty() {
        notes.lose(Lost::new("bytes after the last STL facet", "they are no part of the format"));
    }
    notes.store(&mut model);
    Ok(model)
}

/// The colours of the facets, stored from the first facet with a colour on.
#[derive(Default)]
struct FacetColors {
    colors: Vec<[f32; 4]>,
    count: usize,
    /// The number of facets whose two bytes are neither zero nor a colour.
    others: u64,
}

impl FacetColors {
    fn push(&mut self, facet: &[u8; FACET], convention: Convention) {
        let attribute = facet[CORNERS.end..].first_chunk().map_or(0, |&b| u16::from_le_bytes(b));
        let color = convention.color(attribute);
        self.others += u64::from(color.is_none() && attribute != 0);
        if color.is_some() || !self.colors.is_empty() {
            self.colors.resize(self.count, NO_COLOR);
            self.colors.push(color.unwrap_or(NO_COLOR));
        }
        self.count += 1;
    }

    fn finish(mut self, notes: &mut Notes) -> Option<Vec<[f32; 4]>> {
        let why = "they are no colour in the convention of VisCAM or Magics";
        notes.lose_some("attribute bytes of STL facets", self.others, why);
        if self.colors.is_empty() {
            return None;
        }
        self.colors.resize(self.count, NO_COLOR);
        Some(self.colors)
    }
}

fn read_text(input: &mut Input<'_>) -> Result<Model, ReadErrorKind> {
    let mut reader = TextReader::default();
    let mut facets = Facets::default();
    while let Some(line) = input.line()? {
        let before = reader.weld.soup.vertex_count();
        // A facet has three numbers for each corner; a solid has a name.
        let cost = GROWING * 8 * line.text.len() as u64;
        facets.line(line, &mut |part| reader.take(part))?;
        let vertices = reader.weld.soup.vertex_count() - before;
        input.spend_on_line(cost + VERTEX * vertices as u64)?;
    }
    facets.finish(input)?;
    Ok(reader.finish())
}

#[derive(Default)]
struct TextReader {
    weld: Weld,
    groups: Vec<Group>,
    face_groups: Vec<u32>,
}

impl TextReader {
    fn take(&mut self, part: Part<'_>) -> Result<(), ReadErrorKind> {
        match part {
            Part::Solid(name) => self.groups.push(Group { object: String::new(), name }),
            Part::Facet(corners) => {
                let corners: Result<Vec<u32>, TooManyCorners> =
                    corners.iter().map(|corner| self.weld.vertex(corner.to_array())).collect();
                self.weld.soup.push_face(&corners?)?;
                self.face_groups.push(as_u32(self.groups.len()).wrapping_sub(1));
            }
        }
        Ok(())
    }

    fn finish(self) -> Model {
        let mut model = Model::from(self.weld.soup);
        // A single solid without a name gives no information.
        if self.groups.len() > 1 || self.groups.iter().any(|group| !group.name.is_empty()) {
            model.groups = self.groups;
            model.face_groups = Some(self.face_groups);
        }
        model
    }
}
