//! PLY as a stream.

use super::columns::{FaceColumns, positions};
use super::header::{self, Element};
use super::read::vertex_index;
use super::records::{each_record, note_more};
use crate::error::{Location, ReadErrorKind};
use crate::input::Input;
use crate::item::{Item, Visit, stopped};
use crate::lost::{Lost, STREAMED};
use crate::notes::Notes;
use crate::text::quote;
use glam::DVec3;
use std::ops::ControlFlow;

pub(crate) fn scan(
    input: &mut Input<'_>,
    visit: &mut Visit<'_>,
    notes: &mut Notes,
) -> Result<ControlFlow<()>, ReadErrorKind> {
    let header = header::read(input)?;
    let comments = header.comments.len() as u64;
    notes.lose_some("comments of the PLY header", comments, STREAMED);
    let vertex_count = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let (mut has_vertices, mut has_faces) = (false, false);
    let mut flow = ControlFlow::Continue(());
    for element in &header.elements {
        if !element.properties.is_empty() {
            let here = match header.storage {
                header::Storage::Text => Location::Line(element.line),
                _ => input.here(),
            };
            let what = format!("{} records", quote(element.name.as_bytes()));
            input.plausible(element.count, element.least_bytes(header.storage), here, &what)?;
        }
        let scan = Scan { input, storage: header.storage, element, notes };
        match element.name.as_str() {
            "vertex" if !has_vertices => {
                has_vertices = element.count > 0;
                scan.vertices(visit, &mut flow)?;
            }
            "face" if !has_faces => {
                has_faces = element.count > 0;
                scan.faces(vertex_count, visit, &mut flow)?;
            }
            "tristrips" if !has_faces && element.count > 0 => {
                return Err(ReadErrorKind::Unsupported {
                    at: Location::Line(element.line),
                    what: "reading triangle strips as a stream".to_owned(),
                    cure: "convert the file to one with faces where there is memory for it",
                });
            }
            _ => scan.pass_over()?,
        }
        if flow.is_break() {
            return Ok(flow);
        }
    }
    note_more(input, header.storage, notes)?;
    Ok(flow)
}

struct Scan<'s, 'i, 'a> {
    input: &'i mut Input<'a>,
    storage: header::Storage,
    element: &'s Element,
    notes: &'i mut Notes,
}

impl Scan<'_, '_, '_> {
    fn note_others(&mut self, used: &[usize]) {
        for (place, property) in self.element.properties.iter().enumerate() {
            if !used.contains(&place) {
                let name = quote(property.name.as_bytes());
                self.notes.lose(Lost::new(format!("PLY property {name}"), STREAMED));
            }
        }
    }

    fn vertices(
        mut self,
        visit: &mut Visit<'_>,
        flow: &mut ControlFlow<()>,
    ) -> Result<(), ReadErrorKind> {
        let places = positions(self.element)?;
        self.note_others(&places);
        let read = each_record(self.input, self.storage, self.element, |record| {
            *flow = visit(Item::Vertex(DVec3::from(places.map(|place| record.values[place]))));
            if flow.is_break() { Err(stopped()) } else { Ok(0) }
        });
        if flow.is_break() { Ok(()) } else { read }
    }

    fn faces(
        mut self,
        vertex_count: u64,
        visit: &mut Visit<'_>,
        flow: &mut ControlFlow<()>,
    ) -> Result<(), ReadErrorKind> {
        let Some(columns) = FaceColumns::new(self.element) else {
            self.notes.lose_some("faces", self.element.count, "there is no list of vertex indices");
            return each_record(self.input, self.storage, self.element, |_| Ok(0));
        };
        self.note_others(&[columns.index_list()]);
        let mut face: Vec<u64> = Vec::new();
        let mut too_small = 0_u64;
        let read = each_record(self.input, self.storage, self.element, |record| {
            face.clear();
            for &value in columns.indices(record) {
                face.push(vertex_index(value, vertex_count, record)?);
            }
            if face.len() < 3 {
                too_small += 1;
                return Ok(0);
            }
            *flow = visit(Item::Face(&face));
            if flow.is_break() { Err(stopped()) } else { Ok(0) }
        });
        self.notes.lose_some("faces of fewer than three corners", too_small, "a face needs three");
        if flow.is_break() { Ok(()) } else { read }
    }

    fn pass_over(self) -> Result<(), ReadErrorKind> {
        let name = quote(self.element.name.as_bytes());
        self.notes.lose_some(format!("PLY element {name}"), self.element.count, STREAMED);
        each_record(self.input, self.storage, self.element, |_| Ok(0))
    }
}
