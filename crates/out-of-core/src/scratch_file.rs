//! Temporary files for lists that are too long for memory, written once from front to end.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::error::Error;
use crate::private_files;

/// The size of a buffer in bytes.
const BUFFER: usize = 1 << 16;

/// The bytes of the index of a vertex.
pub(crate) const ID: usize = 5;
/// The largest number of vertices: their indices fit into [`ID`] bytes.
pub(crate) const MOST_VERTICES: u64 = 1 << (8 * ID);

pub(crate) fn id_bytes(id: u64) -> [u8; ID] {
    let [a, b, c, d, e, ..] = id.to_le_bytes();
    [a, b, c, d, e]
}

pub(crate) fn id_of([a, b, c, d, e]: [u8; ID]) -> u64 {
    u64::from_le_bytes([a, b, c, d, e, 0, 0, 0])
}

pub(crate) fn point_bytes(point: DVec3) -> [u8; 24] {
    let mut bytes = [0; 24];
    for (bytes, x) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(point.to_array()) {
        *bytes = x.to_le_bytes();
    }
    bytes
}

pub(crate) fn point_of(bytes: &[u8; 24]) -> DVec3 {
    let mut point = [0.0; 3];
    for (x, bytes) in point.iter_mut().zip(bytes.as_chunks::<8>().0) {
        *x = f64::from_le_bytes(*bytes);
    }
    DVec3::from(point)
}

/// A temporary file that is being written. It is removed when this is dropped.
pub(crate) struct ScratchWriter {
    writer: BufWriter<File>,
    file: ScratchFile,
    bytes: u64,
}

impl ScratchWriter {
    pub(crate) fn new(path: PathBuf) -> Result<Self, Error> {
        let file = private_files::create_file(&path).map_err(Error::io(&path))?;
        let writer = BufWriter::with_capacity(BUFFER, file);
        Ok(Self { writer, file: ScratchFile { path }, bytes: 0 })
    }

    pub(crate) fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.bytes += bytes.len() as u64;
        self.writer.write_all(bytes).map_err(Error::io(&self.file.path))
    }

    /// The number of bytes so far.
    pub(crate) fn len(&self) -> u64 {
        self.bytes
    }

    /// Ends the file.
    pub(crate) fn finish(self) -> Result<ScratchFile, Error> {
        let Self { file, writer, .. } = self;
        writer.into_inner().map_err(|error| Error::io(&file.path)(error.into_error()))?;
        Ok(file)
    }
}

/// A temporary file that was written. It is removed when this is dropped.
pub(crate) struct ScratchFile {
    path: PathBuf,
}

impl Drop for ScratchFile {
    fn drop(&mut self) {
        // A file that cannot be removed only takes space.
        let _ = std::fs::remove_file(&self.path);
    }
}

impl ScratchFile {
    /// The error of a file whose content was changed.
    pub(crate) fn damaged(&self, reason: &str) -> Error {
        Error::damaged(&self.path, reason)
    }

    /// Reads the file from the front.
    pub(crate) fn reader(&self) -> Result<ScratchReader<'_>, Error> {
        let file = private_files::open(&self.path).map_err(Error::io(&self.path))?;
        Ok(ScratchReader { path: &self.path, reader: BufReader::with_capacity(BUFFER, file) })
    }
}

/// A temporary file that is being read.
pub(crate) struct ScratchReader<'s> {
    path: &'s Path,
    reader: BufReader<File>,
}

impl ScratchReader<'_> {
    /// Reads the next bytes; `None` at the end.
    pub(crate) fn next<const N: usize>(&mut self) -> Result<Option<[u8; N]>, Error> {
        let mut bytes = [0; N];
        match self.reader.read_exact(&mut bytes) {
            Ok(()) => Ok(Some(bytes)),
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => Err(Error::io(self.path)(error)),
        }
    }

    /// Reads the next bytes; an error at the end.
    pub(crate) fn expect<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        self.next()?.ok_or_else(|| Error::damaged(self.path, "the file ends too soon"))
    }

    /// Reads the next face into a list of its corners; `false` at the end.
    pub(crate) fn next_face(&mut self, corners: &mut Vec<u64>) -> Result<bool, Error> {
        let Some([short]) = self.next()? else { return Ok(false) };
        let count = match short {
            LONG => u32::from_le_bytes(self.expect()?),
            short => u32::from(short),
        };
        corners.clear();
        for _ in 0..count {
            corners.push(id_of(self.expect()?));
        }
        Ok(true)
    }
}

/// A number of corners that means: the actual number follows in four bytes.
const LONG: u8 = u8::MAX;

/// Appends a face of vertices below [`MOST_VERTICES`].
pub(crate) fn put_face(to: &mut ScratchWriter, corners: &[u64]) -> Result<(), Error> {
    match u8::try_from(corners.len()) {
        Ok(short) if short < LONG => to.put(&[short])?,
        _ => {
            to.put(&[LONG])?;
            let too_large = |_| Error::RegionTooLarge { faces: 1 };
            let count = u32::try_from(corners.len()).map_err(too_large)?;
            to.put(&count.to_le_bytes())?;
        }
    }
    corners.iter().try_for_each(|&v| to.put(&id_bytes(v)))
}

/// Points by index. The most recently used blocks are in memory.
pub(crate) struct PointTable<'s> {
    path: &'s Path,
    file: File,
    count: u64,
    /// A block and its points, at the index given by the remainder of its number.
    slots: Vec<(u64, Vec<DVec3>)>,
    bytes: Vec<u8>,
}

/// The number of points in a block.
const BLOCK: u64 = 1024;

impl<'s> PointTable<'s> {
    /// Opens a file of points, and uses about `memory` bytes.
    pub(crate) fn new(points: &'s ScratchFile, memory: u64) -> Result<Self, Error> {
        let path = &points.path;
        let file = private_files::open(path).map_err(Error::io(path))?;
        let count = file.metadata().map_err(Error::io(path))?.len() / 24;
        let blocks = count.div_ceil(BLOCK).min(memory / (24 * BLOCK)).max(16);
        let slots = vec![(u64::MAX, Vec::new()); blocks as usize];
        Ok(Self { path, file, count, slots, bytes: Vec::new() })
    }

    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    pub(crate) fn get(&mut self, number: u64) -> Result<DVec3, Error> {
        let block = number / BLOCK;
        let slot = (block % self.slots.len() as u64) as usize;
        if self.slots[slot].0 != block {
            let first = block * BLOCK;
            let points = BLOCK.min(self.count.saturating_sub(first));
            self.bytes.resize(24 * points as usize, 0);
            self.file
                .seek(SeekFrom::Start(24 * first))
                .and_then(|_| self.file.read_exact(&mut self.bytes))
                .map_err(Error::io(self.path))?;
            let (there, list) = &mut self.slots[slot];
            *there = block;
            list.clear();
            list.extend(self.bytes.as_chunks::<24>().0.iter().map(point_of));
        }
        let point = self.slots[slot].1.get((number % BLOCK) as usize);
        point.copied().ok_or_else(|| Error::damaged(self.path, "a vertex is not there"))
    }
}
