//! OBJ as a stream.

use super::polypaint;
use super::read::{corner, join_lines, lost_line, position};
use crate::error::ReadErrorKind;
use crate::input::{Input, Line};
use crate::item::{Item, Visit};
use crate::lost::{Lost, STREAMED};
use crate::notes::Notes;
use std::ops::ControlFlow;

pub(crate) fn scan(
    input: &mut Input<'_>,
    visit: &mut Visit<'_>,
    notes: &mut Notes,
) -> Result<ControlFlow<()>, ReadErrorKind> {
    let mut scan = Scan { counts: [0; 3], face: Vec::new(), small_faces: 0, notes };
    // A line joined from several.
    let mut joined = Vec::new();
    while let Some(line) = input.line()? {
        let flow = if line.text.ends_with(b"\\") {
            let number = line.number;
            joined.clear();
            joined.extend_from_slice(line.text);
            join_lines(&mut joined, input)?;
            scan.line(Line { number, text: &joined }, visit)?
        } else {
            scan.line(line, visit)?
        };
        if flow.is_break() {
            return Ok(flow);
        }
    }
    let why = "a face needs three";
    scan.notes.lose_some("faces of fewer than three corners", scan.small_faces, why);
    Ok(ControlFlow::Continue(()))
}

struct Scan<'n> {
    /// The numbers of vertices, texture coordinates and normals so far.
    counts: [usize; 3],
    face: Vec<u64>,
    small_faces: u64,
    notes: &'n mut Notes,
}

impl Scan<'_> {
    fn line(
        &mut self,
        line: Line<'_>,
        visit: &mut Visit<'_>,
    ) -> Result<ControlFlow<()>, ReadErrorKind> {
        let Some(keyword) = line.words().next() else {
            if polypaint::digits(&line).is_some() {
                self.notes.lose(Lost::new("colours of OBJ vertices", STREAMED));
            }
            return Ok(ControlFlow::Continue(()));
        };
        match keyword {
            b"v" => {
                let (position, color) = position(line)?;
                if color.is_some() {
                    self.notes.lose(Lost::new("colours of OBJ vertices", STREAMED));
                }
                self.counts[0] += 1;
                return Ok(visit(Item::Vertex(position)));
            }
            b"f" | b"fo" => {
                self.face.clear();
                for word in line.words().skip(1) {
                    let [vertex, ..] = corner(line, word, self.counts)?;
                    self.face.extend(vertex.map(u64::from));
                }
                if self.face.len() >= 3 {
                    return Ok(visit(Item::Face(&self.face)));
                }
                self.small_faces += 1;
            }
            b"vt" => {
                self.counts[1] += 1;
                self.notes.lose(Lost::new("OBJ texture coordinates", STREAMED));
            }
            b"vn" => {
                self.counts[2] += 1;
                self.notes.lose(Lost::new("OBJ normals", STREAMED));
            }
            b"usemtl" | b"mtllib" => self.notes.lose(Lost::new("OBJ materials", STREAMED)),
            b"o" | b"g" => self.notes.lose(Lost::new("OBJ objects and groups", STREAMED)),
            b"s" => self.notes.lose(Lost::new("smoothing groups", STREAMED)),
            other => {
                let (what, why) = lost_line(&String::from_utf8_lossy(other));
                self.notes.lose(Lost::new(what, why));
            }
        }
        Ok(ControlFlow::Continue(()))
    }
}
