//! OBJ as a stream.

use super::read::{corner, join_lines, position};
use crate::error::ReadErrorKind;
use crate::input::{Input, Line};
use crate::item::{Item, Visit};
use crate::notes::Notes;
use crate::text::quote;
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
    if scan.small_faces > 0 {
        let count = scan.small_faces;
        scan.notes.add(format!("skipped {count} faces of fewer than three corners"));
    }
    Ok(ControlFlow::Continue(()))
}

struct Scan<'n> {
    /// How many vertices, texture coordinates and normals there are so far.
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
        let Some(keyword) = line.words().next() else { return Ok(ControlFlow::Continue(())) };
        match keyword {
            b"v" => {
                let (position, color) = position(line)?;
                if color.is_some() {
                    self.notes.add("passed over the colours of OBJ vertices");
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
            b"vt" => self.counts[1] += 1,
            b"vn" => self.counts[2] += 1,
            b"usemtl" | b"mtllib" => self.notes.add("passed over the OBJ materials"),
            b"o" | b"g" => self.notes.add("passed over the OBJ objects and groups"),
            b"s" | b"l" | b"p" | b"vp" => {}
            other => self.notes.add(format!("skipped OBJ lines of {}", quote(other))),
        }
        if matches!(keyword, b"vt" | b"vn") {
            let what = if keyword == b"vt" { "texture coordinates" } else { "normals" };
            self.notes.add(format!("passed over the OBJ {what}"));
        }
        Ok(ControlFlow::Continue(()))
    }
}
