//! Writing PLY from streamed vertices and faces.

use super::write::{Binary, Text, Values, header_of_passing};
use crate::error::WriteError;
use crate::format::Format;
use crate::passing::Passing;
use crate::write_options::{Encoding, Precision, WriteOptions};
use glam::DVec3;
use std::io::Write;

/// A file that is being written.
pub(crate) struct PlyPassing<'w> {
    values: Box<dyn Values + 'w>,
    wide_positions: bool,
    wide_scalars: Vec<bool>,
    has_colors: bool,
    long_lists: bool,
}

impl<'w> PlyPassing<'w> {
    pub(crate) fn new(
        writer: &'w mut dyn Write,
        passing: &Passing,
        options: &WriteOptions,
    ) -> Result<Self, WriteError> {
        let limit = i32::MAX as u64;
        for (what, found) in [("vertices", passing.vertices), ("faces", passing.faces)] {
            if found > limit {
                return Err(WriteError::TooLarge { format: Format::Ply, what, limit, found });
            }
        }
        let is_wide = |single: bool| match options.precision {
            Precision::Single => false,
            Precision::Double => true,
            Precision::Exact => !single,
        };
        let wide_positions = is_wide(passing.single);
        let wide_scalars: Vec<bool> = passing.scalars.iter().map(|s| is_wide(s.1)).collect();
        let long_lists = passing.longest > 127;
        let storage = options.encoding;
        header_of_passing(writer, passing, storage, wide_positions, &wide_scalars, long_lists)?;
        let values: Box<dyn Values + 'w> = match storage {
            Encoding::Text => Box::new(Text { writer, first: true }),
            Encoding::BigEndian => Box::new(Binary { writer, big_endian: true }),
            _ => Box::new(Binary { writer, big_endian: false }),
        };
        let has_colors = passing.colors;
        Ok(Self { values, wide_positions, wide_scalars, has_colors, long_lists })
    }

    /// Whether coordinates take 32 bits.
    pub(crate) fn is_single(&self) -> bool {
        !self.wide_positions
    }

    pub(crate) fn vertex(
        &mut self,
        at: DVec3,
        color: [u8; 4],
        scalars: &[f64],
    ) -> std::io::Result<()> {
        for value in at.to_array() {
            self.values.float(value, self.wide_positions)?;
        }
        if self.has_colors {
            color.into_iter().try_for_each(|channel| self.values.u8(channel))?;
        }
        for (&value, &wide) in scalars.iter().zip(&self.wide_scalars) {
            self.values.float(value, wide)?;
        }
        self.values.end()
    }

    pub(crate) fn face(&mut self, vertices: &[u64]) -> std::io::Result<()> {
        let beyond = |_| std::io::Error::other("a face does not fit what was announced");
        if self.long_lists {
            self.values.u32(u32::try_from(vertices.len()).map_err(beyond)?)?;
        } else {
            self.values.u8(u8::try_from(vertices.len()).map_err(beyond)?)?;
        }
        for &v in vertices {
            self.values.u32(u32::try_from(v).map_err(beyond)?)?;
        }
        self.values.end()
    }
}
