//! The input as it streams by: vertices in one file, faces in another, and what is to be known of them.
//!
//! Formats without vertices of their own repeat positions. Their corners are dealt out by position into
//! files that fit into memory; in each, equal positions get the number of their first corner.

use core::ops::ControlFlow;
use std::io::Read;
use std::path::Path;

use glam::DVec3;
use mesh_core::BoundingBox;
use mesh_io::{Item, ReadOptions};

use crate::error::Error;
use crate::scratch::{Scratch, Sink, id_bytes, id_of, point_bytes, point_of, put_face};

/// An input in files.
pub(crate) struct Incoming {
    /// The points, by number.
    pub(crate) points: Scratch,
    /// The faces, by numbers of points.
    pub(crate) faces: Scratch,
    /// The vertices that faces may use: all points where there is nothing here, else these.
    pub(crate) vertices: Option<Scratch>,
    /// What is known of it.
    pub(crate) summary: Summary,
    /// Some of the vertices, evenly.
    pub(crate) sample: Vec<DVec3>,
}

/// What is known of an input after it was read.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Summary {
    /// Vertices; of formats without any, different positions of corners.
    pub vertices: u64,
    /// Faces of any number of corners.
    pub faces: u64,
    /// The triangles that the faces are cut into, before any are dropped.
    pub triangles: u64,
    /// The box round the vertices; nothing when there are none.
    pub bounds: Option<BoundingBox>,
    /// What the reader passed over.
    pub notes: Vec<String>,
}

impl Summary {
    /// The diagonal of the bounding box.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.bounds.map_or(0.0, |bounds| bounds.diagonal())
    }
}

/// No more vertices than these tell how they are spread; the half of them at least.
const SAMPLE: usize = 1 << 18;

/// Every so many of the points that come by: more and more of them are skipped.
struct Sampler {
    every: u64,
    seen: u64,
    sample: Vec<DVec3>,
}

impl Sampler {
    fn new() -> Self {
        Self { every: 1, seen: 0, sample: Vec::new() }
    }

    fn see(&mut self, point: DVec3) {
        if self.seen.is_multiple_of(self.every) {
            if self.sample.len() == SAMPLE {
                let mut place = 0;
                self.sample.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
                self.every *= 2;
            }
            if self.seen.is_multiple_of(self.every) {
                self.sample.push(point);
            }
        }
        self.seen += 1;
    }
}

/// Takes the items of a file.
struct Taking {
    points: Sink,
    faces: Sink,
    sampler: Sampler,
    summary: Summary,
    has_facets: bool,
}

impl Taking {
    fn take(&mut self, item: Item<'_>) -> Result<(), Error> {
        match item {
            Item::Vertex(point) => {
                self.point(point)?;
                self.summary.vertices += 1;
                Ok(())
            }
            Item::Face(corners) => {
                self.summary.faces += 1;
                self.summary.triangles += corners.len() as u64 - 2;
                put_face(&mut self.faces, corners)
            }
            Item::Facet(corners) => {
                self.has_facets = true;
                self.summary.faces += 1;
                self.summary.triangles += corners.len() as u64 - 2;
                let first = self.sampler.seen;
                for &corner in corners {
                    // Adding zero turns -0 into 0.
                    self.point(corner + DVec3::ZERO)?;
                }
                let corners: Vec<u64> = (first..self.sampler.seen).collect();
                put_face(&mut self.faces, &corners)
            }
        }
    }

    fn point(&mut self, point: DVec3) -> Result<(), Error> {
        if !point.is_finite() {
            let (vertex, position) = (self.sampler.seen, point.to_array());
            return Err(Error::NotFinite { vertex, position });
        }
        self.sampler.see(point);
        let start = BoundingBox { min: point, max: point };
        let bounds = self.summary.bounds.get_or_insert(start);
        *bounds = BoundingBox { min: bounds.min.min(point), max: bounds.max.max(point) };
        self.points.put(&point_bytes(point))
    }
}

/// Where an input comes from.
pub enum Input<'i> {
    /// A file.
    Path(&'i Path),
    /// A stream, with the name that its errors have.
    Stream(&'i mut dyn Read, &'i Path),
}

impl Incoming {
    /// Reads an input, in about so many bytes of memory, into files of a folder.
    pub(crate) fn read(
        input: Input<'_>,
        options: &ReadOptions,
        folder: &Path,
        memory: u64,
        goes_on: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Self, Error> {
        let mut taking = Taking {
            points: Sink::new(folder.join("points"))?,
            faces: Sink::new(folder.join("faces"))?,
            sampler: Sampler::new(),
            summary: Summary {
                vertices: 0,
                faces: 0,
                triangles: 0,
                bounds: None,
                notes: Vec::new(),
            },
            has_facets: false,
        };
        let mut failed = None;
        let mut seen = 0_u64;
        let visit = &mut |item: Item<'_>| {
            seen += 1;
            if seen.is_multiple_of(1 << 16) && !goes_on(seen) {
                failed = Some(Error::Stopped);
                return ControlFlow::Break(());
            }
            match taking.take(item) {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    failed = Some(error);
                    ControlFlow::Break(())
                }
            }
        };
        let scanned = match input {
            Input::Path(path) => mesh_io::scan(path, options, visit),
            Input::Stream(stream, name) => mesh_io::scan_from(stream, options, visit)
                .map_err(|error| mesh_io::ReadError { path: Some(name.to_owned()), ..error }),
        }?;
        if let Some(error) = failed {
            return Err(error);
        }
        let Taking { points, faces, sampler, mut summary, has_facets } = taking;
        summary.notes = scanned.notes;
        let all = Self {
            points: points.finish()?,
            faces: faces.finish()?,
            vertices: None,
            summary,
            sample: sampler.sample,
        };
        if has_facets { all.joined(folder, memory) } else { Ok(all) }
    }

    /// The same with one number for equal positions, that of the first corner there.
    fn joined(mut self, folder: &Path, memory: u64) -> Result<Self, Error> {
        let corners = crate::scratch::Table::new(&self.points, 0)?.count();
        // A corner takes 32 bytes while it is sorted, with its number.
        let files = (corners * 64).div_ceil(memory.max(1 << 20)).clamp(1, MOST_FILES);
        let mut dealt = Vec::new();
        for i in 0..files {
            dealt.push(Sink::new(folder.join(format!("corners-{i}")))?);
        }
        let mut source = self.points.source()?;
        for number in 0..corners {
            let point: [u8; 24] = source.expect()?;
            let sink = &mut dealt[hash(&point, files)];
            sink.put(&id_bytes(number))?;
            sink.put(&point)?;
        }
        let mut numbers = Vec::new();
        for (i, sink) in dealt.into_iter().enumerate() {
            let scratch = sink.finish()?;
            numbers.push(first_corners(&scratch, folder.join(format!("numbers-{i}")))?);
        }
        let mut numbers_of = Vec::new();
        for scratch in &numbers {
            numbers_of.push(scratch.source()?);
        }
        let mut vertices = Sink::new(folder.join("vertices"))?;
        let mut faces = Sink::new(folder.join("joined-faces"))?;
        let (mut points, mut given) = (self.points.source()?, self.faces.source()?);
        let (mut face, mut number) = (Vec::new(), 0_u64);
        self.summary.vertices = 0;
        while given.next_face(&mut face)? {
            for corner in &mut face {
                let point: [u8; 24] = points.expect()?;
                *corner = id_of(numbers_of[hash(&point, files)].expect()?);
                if *corner == number {
                    vertices.put(&id_bytes(number))?;
                    vertices.put(&point)?;
                    self.summary.vertices += 1;
                }
                number += 1;
            }
            put_face(&mut faces, &face)?;
        }
        drop((points, given));
        self.faces = faces.finish()?;
        self.vertices = Some(vertices.finish()?);
        Ok(self)
    }

    /// Calls `visit` with every vertex that faces may use, in the order of their numbers.
    pub(crate) fn each_vertex(
        &self,
        mut visit: impl FnMut(u64, DVec3) -> Result<(), Error>,
    ) -> Result<(), Error> {
        match &self.vertices {
            Some(vertices) => {
                let mut source = vertices.source()?;
                while let Some(id) = source.next()? {
                    visit(id_of(id), point_of(&source.expect()?))?;
                }
            }
            None => {
                let (mut source, mut number) = (self.points.source()?, 0);
                while let Some(point) = source.next()? {
                    visit(number, point_of(&point))?;
                    number += 1;
                }
            }
        }
        Ok(())
    }
}

/// Files that are open at a time.
pub(crate) const MOST_FILES: u64 = 256;

/// In which of so many files a position goes (Fowler, Noll, Vo: FNV-1a).
fn hash(point: &[u8; 24], files: u64) -> usize {
    let step = |sum: u64, &byte: &u8| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    (point.iter().fold(0xcbf2_9ce4_8422_2325, step) % files) as usize
}

/// For each corner of a file the first one at the same place, in the order of the file.
fn first_corners(dealt: &Scratch, path: std::path::PathBuf) -> Result<Scratch, Error> {
    let mut corners: Vec<([u64; 3], u64)> = Vec::new();
    let mut source = dealt.source()?;
    while let Some(number) = source.next()? {
        let point = point_of(&source.expect()?);
        corners.push((point.to_array().map(f64::to_bits), id_of(number)));
    }
    corners.sort_unstable();
    let mut firsts: Vec<(u64, u64)> = Vec::with_capacity(corners.len());
    for group in corners.chunk_by(|a, b| a.0 == b.0) {
        firsts.extend(group.iter().map(|&(_, number)| (number, group[0].1)));
    }
    firsts.sort_unstable();
    let mut sink = Sink::new(path)?;
    firsts.iter().try_for_each(|&(_, first)| sink.put(&id_bytes(first)))?;
    sink.finish()
}
