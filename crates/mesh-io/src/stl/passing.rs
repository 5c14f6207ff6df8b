//! Writing STL from streamed faces.

use super::header;
use super::write::{binary_facet, binary_head, text_facet};
use crate::cutter::Cutter;
use crate::error::WriteError;
use glam::DVec3;
use std::io::Write;

/// A file that is being written.
pub(crate) struct StlPassing<'w> {
    writer: &'w mut dyn Write,
    is_text: bool,
    cutter: Cutter,
}

impl<'w> StlPassing<'w> {
    pub(crate) fn new(
        writer: &'w mut dyn Write,
        triangles: u64,
        is_text: bool,
    ) -> Result<Self, WriteError> {
        if is_text {
            writeln!(writer, "solid ")?;
        } else {
            binary_head(writer, triangles, &header::with(None, None))?;
        }
        Ok(Self { writer, is_text, cutter: Cutter::default() })
    }

    pub(crate) fn face(&mut self, vertices: &[u64], corners: &[DVec3]) -> std::io::Result<()> {
        for triangle in self.cutter.cut_polygon(vertices, corners) {
            let triangle = triangle.map(|corner| corners[corner as usize]);
            if self.is_text {
                text_facet(self.writer, triangle)?;
            } else {
                binary_facet(self.writer, triangle, 0)?;
            }
        }
        Ok(())
    }

    pub(crate) fn finish(self) -> std::io::Result<()> {
        if self.is_text { writeln!(self.writer, "endsolid ") } else { Ok(()) }
    }
}
