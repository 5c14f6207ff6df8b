//! The facets of text or binary STL, before any interpretation.

use crate::error::{Location, ReadErrorKind};
use crate::format::is_binary_stl;
use crate::input::{Input, Line, Words, number};
use crate::text::BYTE_ORDER_MARK;
use glam::DVec3;

pub(super) const HEADER: u64 = 80;
/// The bytes of a facet: a normal, three corners, and two bytes for free use.
pub(super) const FACET: usize = 50;
/// The range of the corners in a facet.
pub(super) const CORNERS: std::ops::Range<usize> = 12..48;

/// Whether the file is text.
pub(super) fn is_text(input: &mut Input<'_>, size: Option<u64>) -> Result<bool, ReadErrorKind> {
    let head = input.peek(512)?;
    let text = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head).trim_ascii_start();
    let says_text = [&b"solid"[..], b"facet"]
        .iter()
        .any(|word| text.get(..5).is_some_and(|start| start.eq_ignore_ascii_case(word)));
    Ok(says_text && !is_binary_stl(head, size))
}

/// The corners of a facet of a binary file.
pub(super) fn corners_of(facet: &[u8; FACET]) -> [DVec3; 3] {
    let mut corners = [DVec3::ZERO; 3];
    let numbers = facet[CORNERS].as_chunks::<4>().0.as_chunks::<3>().0;
    for (corner, bytes) in corners.iter_mut().zip(numbers) {
        *corner = DVec3::from(bytes.map(|bytes| f64::from(f32::from_le_bytes(bytes))));
    }
    corners
}

/// A part of a text file.
pub(super) enum Part<'p> {
    /// The name of a solid that starts.
    Solid(String),
    /// The corners of a facet, three or more.
    Facet(&'p [DVec3]),
}

/// Finds the parts of a text file from its lines.
#[derive(Default)]
pub(super) struct Facets {
    within_solid: bool,
    within_facet: bool,
    /// Whether the loop of the current facet has ended.
    is_loop_over: bool,
    /// The corners of the current facet.
    corners: Vec<DVec3>,
}

impl Facets {
    /// Processes a line. Keywords may be in any case, and there may be several on a line.
    pub(super) fn line(
        &mut self,
        line: Line<'_>,
        take: &mut dyn FnMut(Part<'_>) -> Result<(), ReadErrorKind>,
    ) -> Result<(), ReadErrorKind> {
        let mut words = line.words();
        while let Some(word) = words.next() {
            match word.to_ascii_lowercase().as_slice() {
                b"solid" => {
                    self.within_solid = true;
                    let name = String::from_utf8_lossy(words.remainder()).into_owned();
                    return take(Part::Solid(name));
                }
                b"endsolid" => {
                    self.within_solid = false;
                    return Ok(());
                }
                b"facet" => {
                    if core::mem::replace(&mut self.within_facet, true) {
                        return Err(line.unexpected("endfacet", word));
                    }
                    self.corners.clear();
                    self.is_loop_over = false;
                    // The word "normal" and its numbers are ignored.
                    words.by_ref().take(4).for_each(drop);
                }
                b"vertex" => self.vertex(line, &mut words)?,
                b"endfacet" => {
                    self.end_facet(line, word)?;
                    take(Part::Facet(&self.corners))?;
                }
                b"outer" | b"loop" if !self.corners.is_empty() => {
                    return Err(line.unexpected("one loop of vertices in a facet", word));
                }
                b"outer" | b"loop" => {}
                b"endloop" => self.is_loop_over = true,
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
        if !self.within_facet {
            return Err(line.unexpected("facet", b"vertex"));
        }
        if self.is_loop_over {
            return Err(line.unexpected("endfacet", b"vertex"));
        }
        self.corners.push(DVec3::from(position));
        Ok(())
    }

    fn end_facet(&mut self, line: Line<'_>, word: &[u8]) -> Result<(), ReadErrorKind> {
        if !core::mem::take(&mut self.within_facet) {
            return Err(line.unexpected("facet", word));
        }
        if self.corners.len() < 3 {
            let expected = format!("a third vertex after {} of them", self.corners.len());
            return Err(line.unexpected(expected, word));
        }
        Ok(())
    }

    /// Whether the file may end here.
    pub(super) fn finish(&self, input: &Input<'_>) -> Result<(), ReadErrorKind> {
        if self.within_solid || self.within_facet {
            return Err(ReadErrorKind::malformed(
                Location::Line(input.line_number()),
                "endsolid",
                "the end of the file",
            ));
        }
        Ok(())
    }
}
