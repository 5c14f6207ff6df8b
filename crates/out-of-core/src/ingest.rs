//! Reading an input as a stream, into a file of vertices and a file of faces, with statistics of both.
//!
//! Formats without vertices repeat positions, as STL does, and so do files where every face has vertices of its own.
//! Their corners are distributed by position to files that fit into memory; in each file, equal positions get the index
//! of their first corner.

use core::ops::ControlFlow;
use std::io::Read;
use std::path::Path;

use glam::DVec3;
use mesh_core::build::Triangulator;
use mesh_core::{BoundingBox, as_u32};
use mesh_io::{Item, ReadOptions};

use crate::error::Error;
use crate::scratch_file::{
    MOST_VERTICES, PointTable, ScratchFile, ScratchWriter, id_bytes, id_of, point_bytes, point_of,
    put_face,
};

/// An input on disk.
pub(crate) struct Ingested {
    /// The positions of the vertices.
    pub(crate) points: ScratchFile,
    /// The faces, as indices of vertices.
    pub(crate) faces: ScratchFile,
    /// Its statistics.
    pub(crate) summary: Summary,
    /// A sample of the vertices.
    pub(crate) sample: Vec<DVec3>,
    /// The first vertex that was dropped since its position is not finite, or the first such corner, and its position.
    pub(crate) not_finite: Option<(u64, [f64; 3])>,
}

/// The statistics of an input.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Summary {
    /// The number of vertices. In formats without vertices, the number of different positions.
    pub vertices: u64,
    /// The number of faces, polygons included.
    pub faces: u64,
    /// The number of triangles that the faces are cut into, before any is dropped.
    pub triangles: u64,
    /// The bounding box of the vertices; `None` without vertices.
    pub bounds: Option<BoundingBox>,
    /// The number of faces with four corners.
    #[serde(default)]
    pub quadrilaterals: u64,
    /// The number of faces with more than four corners.
    #[serde(default)]
    pub larger: u64,
    /// The largest number of corners of a face.
    #[serde(default)]
    pub longest: u32,
    /// Whether each coordinate is exact with 32 bits.
    #[serde(default)]
    pub single: bool,
    /// Contents that the reader has left out.
    pub notes: Vec<String>,
}

impl Summary {
    /// Counts a face of at least three corners.
    fn count(&mut self, corners: usize) {
        self.faces += 1;
        self.triangles += corners as u64 - 2;
        self.quadrilaterals += u64::from(corners == 4);
        self.larger += u64::from(corners > 4);
        self.longest = self.longest.max(u32::try_from(corners).unwrap_or(u32::MAX));
    }

    /// Checks statistics that were read: counts are below the limit and consistent, and the box is valid.
    pub(crate) fn check(&self) -> Result<(), String> {
        let Self { vertices, faces, triangles, quadrilaterals, larger, .. } = *self;
        for (count, of) in [(vertices, "vertices"), (triangles, "triangles")] {
            if count > MOST_VERTICES {
                return Err(format!("{count} {of}, where there can be {MOST_VERTICES} at most"));
            }
        }
        if faces > triangles || quadrilaterals.saturating_add(larger) > faces {
            return Err(format!("{faces} faces of {triangles} triangles do not fit together"));
        }
        match self.bounds {
            Some(BoundingBox { min, max })
                if !(min.is_finite() && max.is_finite() && min.cmple(max).all()) =>
            {
                Err(format!("a bounding box from {min} to {max}"))
            }
            _ => Ok(()),
        }
    }

    /// The diagonal of the bounding box.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.bounds.map_or(0.0, |bounds| bounds.diagonal())
    }
}

/// The largest number of vertices in the sample. It has at least half as many, if the input does.
const SAMPLE: usize = 1 << 18;

/// Takes every n-th point of a stream. The stride doubles when the sample is full.
struct Sampler {
    every: u64,
    seen: u64,
    sample: Vec<DVec3>,
}

impl Sampler {
    fn new() -> Self {
        Self { every: 1, seen: 0, sample: Vec::new() }
    }

    fn take(&mut self, point: DVec3) {
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

/// Writes the items of an input to files.
struct Ingester {
    points: ScratchWriter,
    faces: ScratchWriter,
    sampler: Sampler,
    summary: Summary,
    has_facets: bool,
    /// Whether the corners of the faces so far are the vertices 0, 1, 2 and so on.
    is_loose: bool,
    /// The number of corners of the faces so far.
    corners: u64,
    /// The first vertex or corner whose position is not finite, and its position.
    not_finite: Option<(u64, [f64; 3])>,
    /// The number of facets that were left out since a corner is not finite.
    left_out: u64,
}

impl Ingester {
    fn take(&mut self, item: Item<'_>) -> Result<(), Error> {
        match item {
            Item::Vertex(point) => {
                self.point(point)?;
                self.summary.vertices += 1;
                Ok(())
            }
            Item::Face(corners) => {
                self.summary.count(corners.len());
                let first = self.corners;
                self.corners += corners.len() as u64;
                self.is_loose &= corners.iter().copied().eq(first..self.corners);
                if let Some(&vertex) = corners.iter().find(|&&vertex| vertex >= MOST_VERTICES) {
                    let (face, count) = (self.summary.faces - 1, self.summary.vertices);
                    return Err(Error::NoSuchVertex { face, vertex, count });
                }
                put_face(&mut self.faces, corners)
            }
            Item::Facet(corners) => {
                self.has_facets = true;
                if let Some(bad) = corners.iter().find(|corner| !corner.is_finite()) {
                    self.not_finite.get_or_insert((self.sampler.seen, bad.to_array()));
                    self.left_out += 1;
                    return Ok(());
                }
                self.summary.count(corners.len());
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
        if self.sampler.seen >= MOST_VERTICES {
            return Err(Error::TooManyVertices { most: MOST_VERTICES });
        }
        if !point.is_finite() {
            self.not_finite.get_or_insert((self.sampler.seen, point.to_array()));
            self.sampler.seen += 1;
            return self.points.put(&point_bytes(point));
        }
        self.sampler.take(point);
        self.summary.single &= point.to_array().iter().all(|&x| f64::from(x as f32) == x);
        let start = BoundingBox { min: point, max: point };
        let bounds = self.summary.bounds.get_or_insert(start);
        *bounds = BoundingBox { min: bounds.min.min(point), max: bounds.max.max(point) };
        self.points.put(&point_bytes(point))
    }
}

/// The source of an input.
pub enum Input<'i> {
    /// A file.
    Path(&'i Path),
    /// A stream, and its name for errors.
    Stream(&'i mut dyn Read, &'i Path),
}

impl Ingested {
    /// Reads an input into files of a folder, within about `memory` bytes.
    pub(crate) fn read(
        input: Input<'_>,
        options: &ReadOptions,
        joins_loose: bool,
        folder: &Path,
        memory: u64,
        goes_on: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Self, Error> {
        let mut taking = Ingester {
            points: ScratchWriter::new(folder.join("points"))?,
            faces: ScratchWriter::new(folder.join("faces"))?,
            sampler: Sampler::new(),
            summary: Summary { single: true, ..Summary::default() },
            has_facets: false,
            is_loose: true,
            corners: 0,
            not_finite: None,
            left_out: 0,
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
        let Ingester { points, faces, sampler, summary, has_facets, not_finite, .. } = taking;
        let vertices = summary.vertices;
        let is_loose = taking.is_loose && vertices > 0 && taking.corners == vertices;
        let mut all = Self {
            points: points.finish()?,
            faces: faces.finish()?,
            summary: Summary { notes: scanned.notes, ..summary },
            sample: sampler.sample,
            not_finite,
        };
        if let Some((vertex, position)) = not_finite {
            let dropped =
                if has_facets { taking.left_out } else { all.drop_not_finite(is_loose, folder)? };
            if all.summary.faces == 0 && dropped > 0 {
                return Err(Error::NotFinite { vertex, position });
            }
            all.summary.notes.push(format!(
                "dropped vertices at infinite or undefined positions, and the faces at them: {dropped}"
            ));
        }
        if has_facets {
            return all.welded(folder, memory);
        }
        if is_loose && joins_loose {
            let vertices = all.summary.vertices;
            all = all.welded(folder, memory)?;
            let joined = vertices - all.summary.vertices;
            if joined > 0 {
                let note =
                    "merged vertices at equal positions, since every face has vertices of its own";
                all.summary.notes.push(format!("{note}: {joined} (--strict keeps them apart)"));
            }
        }
        Ok(all)
    }

    /// Drops vertices whose position is not finite, and the faces with such a corner. If each face has vertices of its
    /// own, all vertices of a dropped face go. Returns the number of dropped faces. Takes one bit of memory for each
    /// vertex.
    fn drop_not_finite(&mut self, are_loose: bool, folder: &Path) -> Result<u64, Error> {
        let mut ranks = Ranks::default();
        let (mut given, mut face, mut face_end) = (self.faces.reader()?, Vec::new(), 0);
        self.each_vertex(|_, point| {
            ranks.push(point.is_finite());
            Ok(())
        })?;
        if are_loose {
            let finite = core::mem::take(&mut ranks);
            while given.next_face(&mut face)? {
                let corners = face_end..face_end + face.len() as u64;
                let is_kept = corners.clone().all(|corner| finite.is_marked(corner));
                corners.for_each(|_| ranks.push(is_kept));
                face_end += face.len() as u64;
            }
            given = self.faces.reader()?;
        }
        let mut points = ScratchWriter::new(folder.join("finite-points"))?;
        self.each_vertex(|vertex, point| {
            if ranks.is_marked(vertex) { points.put(&point_bytes(point)) } else { Ok(()) }
        })?;
        let mut faces = ScratchWriter::new(folder.join("finite-faces"))?;
        let Summary { bounds, single, .. } = self.summary;
        let notes = core::mem::take(&mut self.summary.notes);
        let mut summary =
            Summary { vertices: ranks.marked, bounds, single, notes, ..Summary::default() };
        let mut number = 0;
        while given.next_face(&mut face)? {
            if let Some(&vertex) = face.iter().find(|&&vertex| vertex >= ranks.count) {
                return Err(Error::NoSuchVertex { face: number, vertex, count: ranks.count });
            }
            if face.iter().all(|&vertex| ranks.is_marked(vertex)) {
                summary.count(face.len());
                face.iter_mut().for_each(|vertex| *vertex = ranks.below(*vertex));
                put_face(&mut faces, &face)?;
            }
            number += 1;
        }
        drop(given);
        let dropped = number - summary.faces;
        (self.points, self.faces, self.summary) = (points.finish()?, faces.finish()?, summary);
        Ok(dropped)
    }

    /// Welds equal positions to one vertex, in the order of their first corners. Takes one bit of memory for each
    /// corner.
    fn welded(mut self, folder: &Path, memory: u64) -> Result<Self, Error> {
        let corners = PointTable::new(&self.points, 0)?.count();
        // A corner takes 32 bytes while it is sorted: its position and its index.
        let files = (corners * 64).div_ceil(memory.max(1 << 20)).clamp(1, u64::from(MOST_FILES));
        let mut files_of = Vec::new();
        for i in 0..files {
            files_of.push(ScratchWriter::new(folder.join(format!("corners-{i}")))?);
        }
        let mut source = self.points.reader()?;
        for number in 0..corners {
            let point: [u8; 24] = source.expect()?;
            let sink = &mut files_of[hash(&point, files)];
            sink.put(&id_bytes(number))?;
            sink.put(&point)?;
        }
        let mut numbers = Vec::new();
        for (i, sink) in files_of.into_iter().enumerate() {
            let scratch = sink.finish()?;
            numbers.push(first_corners(&scratch, folder.join(format!("numbers-{i}")))?);
        }
        let mut numbers_of = Vec::new();
        for scratch in &numbers {
            numbers_of.push(scratch.reader()?);
        }
        let mut vertices = ScratchWriter::new(folder.join("vertices"))?;
        let mut ranks = Ranks::default();
        let mut faces = ScratchWriter::new(folder.join("welded-faces"))?;
        let (mut points, mut given) = (self.points.reader()?, self.faces.reader()?);
        let (mut face, mut number) = (Vec::new(), 0_u64);
        self.summary.vertices = 0;
        while given.next_face(&mut face)? {
            for corner in &mut face {
                let point: [u8; 24] = points.expect()?;
                let first = id_of(numbers_of[hash(&point, files)].expect()?);
                ranks.push(first == number);
                if first == number {
                    vertices.put(&point)?;
                    self.summary.vertices += 1;
                }
                *corner = ranks.below(first);
                number += 1;
            }
            put_face(&mut faces, &face)?;
        }
        drop((points, given));
        self.faces = faces.finish()?;
        self.points = vertices.finish()?;
        Ok(self)
    }

    /// Calls `visit` with the index and the position of each vertex, in order.
    pub(crate) fn each_vertex(
        &self,
        mut visit: impl FnMut(u64, DVec3) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let (mut source, mut number) = (self.points.reader()?, 0);
        while let Some(point) = source.next()? {
            visit(number, point_of(&point))?;
            number += 1;
        }
        Ok(())
    }

    /// Calls `visit` with the vertices of each face and their positions, within about `memory` bytes.
    pub(crate) fn each_face(
        &self,
        memory: u64,
        mut visit: impl FnMut(&[u64], &[DVec3]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut table = PointTable::new(&self.points, memory)?;
        let mut source = self.faces.reader()?;
        let (mut vertices, mut corners) = (Vec::new(), Vec::new());
        let mut face = 0;
        while source.next_face(&mut vertices)? {
            corners.clear();
            for &vertex in &vertices {
                if vertex >= table.count() {
                    return Err(Error::NoSuchVertex { face, vertex, count: table.count() });
                }
                corners.push(table.get(vertex)?);
            }
            visit(&vertices, &corners)?;
            face += 1;
        }
        Ok(())
    }

    /// As [`Ingested::each_face`], for the triangles that the faces are cut into. Triangles that use a vertex twice are
    /// included.
    pub(crate) fn each_triangle(
        &self,
        memory: u64,
        mut visit: impl FnMut([u64; 3], [DVec3; 3]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut triangulator = Triangulator::default();
        let mut triangles = Vec::new();
        self.each_face(memory, |vertices, corners| {
            if let (&[a, b, c], &[p, q, r]) = (vertices, corners) {
                return visit([a, b, c], [p, q, r]);
            }
            triangles.clear();
            triangulator.triangulate(corners, &local_numbers(vertices), &mut triangles);
            triangles.iter().try_for_each(|triangle| {
                visit(triangle.map(|i| vertices[i as usize]), triangle.map(|i| corners[i as usize]))
            })
        })
    }
}

/// Numbers of 32 bits, equal for equal vertices of the face.
fn local_numbers(face: &[u64]) -> Vec<u32> {
    let mut sorted = face.to_vec();
    sorted.sort_unstable();
    let place = |v: &u64| as_u32(sorted.partition_point(|other| other < v));
    face.iter().map(place).collect()
}

/// A bit for each of many numbers, and the number of bits that are set below each.
#[derive(Default)]
struct Ranks {
    bits: Vec<u64>,
    /// The number of bits that are set before every eighth word.
    before: Vec<u64>,
    count: u64,
    marked: u64,
}

impl Ranks {
    /// Appends the bit of the next number.
    fn push(&mut self, is_marked: bool) {
        let (word, bit) = (self.count / 64, self.count % 64);
        if bit == 0 {
            if word.is_multiple_of(8) {
                self.before.push(self.marked);
            }
            self.bits.push(0);
        }
        self.bits[word as usize] |= u64::from(is_marked) << bit;
        self.marked += u64::from(is_marked);
        self.count += 1;
    }

    /// The bit of a number that was pushed.
    fn is_marked(&self, number: u64) -> bool {
        self.bits[(number / 64) as usize] >> (number % 64) & 1 == 1
    }

    /// The number of bits that are set below a number that was pushed.
    fn below(&self, number: u64) -> u64 {
        let (word, bit) = ((number / 64) as usize, number % 64);
        let whole = &self.bits[word / 8 * 8..word];
        let last = self.bits[word] & ((1 << bit) - 1);
        let ones = whole.iter().chain(core::iter::once(&last)).map(|w| u64::from(w.count_ones()));
        self.before[word / 8] + ones.sum::<u64>()
    }
}

/// The largest number of open files.
pub(crate) const MOST_FILES: u32 = 256;

/// The file for a position, one of `files`: the hash FNV-1a of Fowler, Noll and Vo.
pub(crate) fn hash(point: &[u8], files: u64) -> usize {
    let step = |sum: u64, &byte: &u8| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    (point.iter().fold(0xcbf2_9ce4_8422_2325, step) % files) as usize
}

/// For each corner of a file, the first corner at the same position, in the order of the file.
fn first_corners(
    corners_file: &ScratchFile,
    path: std::path::PathBuf,
) -> Result<ScratchFile, Error> {
    let mut corners: Vec<([u64; 3], u64)> = Vec::new();
    let mut source = corners_file.reader()?;
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
    let mut sink = ScratchWriter::new(path)?;
    firsts.iter().try_for_each(|&(_, first)| sink.put(&id_bytes(first)))?;
    sink.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_count_marks() {
        let mut random = fastrand::Rng::with_seed(2);
        let (mut ranks, mut below) = (Ranks::default(), Vec::new());
        for _ in 0..3000 {
            let is_marked = random.bool();
            below.push(ranks.marked);
            ranks.push(is_marked);
        }
        assert!((0..3000).all(|number| ranks.below(number) == below[number as usize]));
    }
}
