//! Writing a streamed mesh, first the vertices and then the faces, without holding it.

use crate::Format;
use crate::atomic;
use crate::decimal::Decimal;
use crate::error::WriteError;
use crate::lost::Lost;
use crate::passing::{NO_COLOR, Passing};
use crate::ply::PlyPassing;
use crate::single::{flattened, is_flattened};
use crate::stl::StlPassing;
use crate::write::{Staged, check_compression, check_encoding, format_of};
use crate::write_options::{Encoding, WriteOptions, WriteReport};
use glam::DVec3;
use std::io::Write;
use std::path::Path;

/// Receives a streamed mesh; made by [`stage_passing`] and [`write_passing`].
pub struct Passer<'w> {
    writer: Writer<'w>,
    format: Format,
    /// Whether coordinates are written in 32 bits.
    single: bool,
    vertex: usize,
    rounding: f64,
    /// The number of faces that lost their area by it.
    flattened: u64,
    beyond: Option<WriteError>,
    lost: Vec<Lost>,
}

enum Writer<'w> {
    Ply(PlyPassing<'w>),
    Stl(StlPassing<'w>),
    Obj(&'w mut dyn Write),
}

impl<'w> Passer<'w> {
    fn new(
        writer: &'w mut dyn Write,
        passing: &Passing,
        format: Format,
        options: &WriteOptions,
    ) -> Result<Self, WriteError> {
        check_encoding(format, options.encoding)?;
        check_compression(format, options)?;
        let (writer, single) = match format {
            Format::Ply => {
                let ply = PlyPassing::new(writer, passing, options)?;
                let single = ply.is_single();
                (Writer::Ply(ply), single)
            }
            Format::Stl => {
                let is_text = options.encoding == Encoding::Text;
                (Writer::Stl(StlPassing::new(writer, passing.triangles, is_text)?), true)
            }
            Format::Obj => (Writer::Obj(writer), false),
            Format::Off | Format::Gltf | Format::Glb => return Err(WriteError::NoPassing(format)),
        };
        let kinds = [
            (passing.longest > 3 && format == Format::Stl, "polygons (cut into triangles)"),
            (passing.colors && format == Format::Stl, "vertex colours"),
            (!passing.scalars.is_empty() && format != Format::Ply, "numbers per vertex"),
        ];
        let lost = kinds.iter().filter(|(is_lost, _)| *is_lost);
        let lost = lost.map(|(_, what)| Lost::by_format(what, None, format, &[Format::Ply]));
        let lost = lost.collect();
        Ok(Self {
            writer,
            format,
            single,
            vertex: 0,
            rounding: 0.0,
            flattened: 0,
            beyond: None,
            lost,
        })
    }

    /// Writes the next vertex, with the announced numbers, and a colour if one was announced.
    ///
    /// # Errors
    /// The file cannot be written, or a coordinate is beyond what it can hold.
    pub fn vertex(&mut self, at: DVec3, color: [u8; 4], scalars: &[f64]) -> std::io::Result<()> {
        if self.single {
            self.look_at(at)?;
        }
        self.vertex += 1;
        match &mut self.writer {
            Writer::Ply(ply) => ply.vertex(at, color, scalars),
            Writer::Stl(_) => Ok(()),
            Writer::Obj(writer) => {
                let [x, y, z] = at.to_array().map(Decimal);
                write!(writer, "v {x} {y} {z}")?;
                if color != NO_COLOR {
                    let [r, g, b, _] = color.map(|c| Decimal(f32::from(c) / 255.0));
                    write!(writer, " {r} {g} {b}")?;
                }
                writeln!(writer)
            }
        }
    }

    /// Checks the rounding of a coordinate to 32 bits.
    fn look_at(&mut self, at: DVec3) -> std::io::Result<()> {
        for value in at.to_array() {
            let narrow = value as f32;
            if value.is_finite() && !narrow.is_finite() {
                let (format, vertex) = (self.format, self.vertex);
                self.beyond = Some(WriteError::OutOfSingleRange { format, vertex, value });
                return Err(std::io::Error::other("a coordinate is too large"));
            }
            self.rounding = self.rounding.max((value - f64::from(narrow)).abs());
        }
        Ok(())
    }

    /// Writes the next face, given by its vertices and their positions.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn face(&mut self, vertices: &[u64], corners: &[DVec3]) -> std::io::Result<()> {
        if self.single && self.rounding > 0.0 && is_flattened(corners, DVec3::ZERO) {
            self.flattened += 1;
        }
        match &mut self.writer {
            Writer::Ply(ply) => ply.face(vertices),
            Writer::Stl(stl) => stl.face(vertices, corners),
            Writer::Obj(writer) => {
                write!(writer, "f")?;
                vertices.iter().try_for_each(|v| write!(writer, " {}", v + 1))?;
                writeln!(writer)
            }
        }
    }

    fn finish(self) -> std::io::Result<WriteReport> {
        let (rounding, format) = (self.rounding, self.format);
        let mut lost = self.lost;
        lost.extend(flattened(self.flattened, format));
        if let Writer::Stl(stl) = self.writer {
            stl.finish()?;
        }
        Ok(WriteReport { rounding, lost, ..WriteReport::default() })
    }
}

/// Writes a mesh of any size as PLY, STL or OBJ, in memory that does not depend on its size. `content` must pass all
/// vertices and then all faces, as many as announced in `passing`. The file appears at its path when it is committed.
/// It equals, byte for byte, the file of a [`Model`](crate::Model) with the same content.
///
/// # Errors
/// The file cannot be written, the format is not supported, or it cannot hold so many elements.
pub fn stage_passing(
    path: impl AsRef<Path>,
    passing: &Passing,
    options: &WriteOptions,
    content: impl FnOnce(&mut Passer<'_>) -> std::io::Result<()>,
) -> Result<Staged, WriteError> {
    let path = path.as_ref();
    let format = format_of(path, options)?;
    let (file, report) =
        atomic::prepare(path, |writer| write_passing(writer, passing, format, options, content))?;
    Ok(Staged::new(file, report))
}

/// As [`stage_passing`], to a stream, which should be buffered.
///
/// # Errors
/// As [`stage_passing`]; part of the file may have been written.
pub fn write_passing(
    writer: &mut dyn Write,
    passing: &Passing,
    format: Format,
    options: &WriteOptions,
    content: impl FnOnce(&mut Passer<'_>) -> std::io::Result<()>,
) -> Result<WriteReport, WriteError> {
    let mut passer = Passer::new(&mut *writer, passing, format, options)?;
    if let Err(error) = content(&mut passer) {
        return Err(passer.beyond.unwrap_or(error.into()));
    }
    let report = passer.finish()?;
    writer.flush()?;
    Ok(report)
}
