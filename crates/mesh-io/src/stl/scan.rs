//! STL as a stream.

use super::facets::{CORNERS, FACET, Facets, HEADER, Part, corners_of, is_text};
use super::header;
use crate::error::ReadErrorKind;
use crate::input::Input;
use crate::item::{Item, Visit};
use crate::lost::{Lost, STREAMED};
use crate::notes::Notes;
use std::ops::ControlFlow;

pub(crate) fn scan(
    input: &mut Input<'_>,
    size: Option<u64>,
    visit: &mut Visit<'_>,
    notes: &mut Notes,
) -> Result<ControlFlow<()>, ReadErrorKind> {
    if is_text(input, size)? { scan_text(input, visit) } else { scan_binary(input, visit, notes) }
}

fn scan_binary(
    input: &mut Input<'_>,
    visit: &mut Visit<'_>,
    notes: &mut Notes,
) -> Result<ControlFlow<()>, ReadErrorKind> {
    let header: [u8; HEADER as usize] = input.array("the header")?;
    let comments = u64::from(header::comment(&header).is_some());
    notes.lose_some("comments of the STL header", comments, STREAMED);
    let at = input.here();
    let count = u32::from_le_bytes(input.array("the number of facets")?);
    input.plausible(u64::from(count), FACET as u64, at, "facets")?;
    let mut extra = false;
    for _ in 0..count {
        let facet: [u8; FACET] = input.array("a facet")?;
        extra |= facet[CORNERS.end..] != [0, 0];
        if visit(Item::Facet(&corners_of(&facet))).is_break() {
            return Ok(ControlFlow::Break(()));
        }
    }
    if extra {
        notes.lose(Lost::new("attribute bytes of STL facets", STREAMED));
    }
    if !input.peek(1)?.is_empty() {
        notes.lose(Lost::new("bytes after the last STL facet", "they are no part of the format"));
    }
    Ok(ControlFlow::Continue(()))
}

fn scan_text(
    input: &mut Input<'_>,
    visit: &mut Visit<'_>,
) -> Result<ControlFlow<()>, ReadErrorKind> {
    let mut facets = Facets::default();
    let mut flow = ControlFlow::Continue(());
    while let Some(line) = input.line()? {
        facets.line(line, &mut |part| {
            if let Part::Facet(corners) = part
                && flow.is_continue()
            {
                flow = visit(Item::Facet(corners));
            }
            Ok(())
        })?;
        if flow.is_break() {
            return Ok(flow);
        }
    }
    facets.finish(input)?;
    Ok(flow)
}
