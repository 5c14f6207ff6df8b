//! A region of a mesh, as data and as a file.
//!
//! The format of the file; all numbers are little-endian:
//!
//! | bytes | |
//! |---|---|
//! | 16 | `curvmesh region`, and a byte 0 |
//! | 4 | the version of the format, 1 |
//! | 4, 4 | the level, and the cell |
//! | 8 each | the numbers of own vertices, other vertices, non-manifold vertices, quadrics, triangles |
//! | 8 each | the index of each vertex in the input: own vertices first, ascending in both parts |
//! | 4 each | the cell of each other vertex |
//! | 4 each | the indices of non-manifold vertices in this file |
//! | 24 each | the position of each vertex, three numbers of 64 bits each |
//! | 80 each | the quadrics: xx, yy, zz, yz, zx, xy, the three linear terms, the constant |
//! | 12 each | the triangles, three indices of vertices in this file |
//! | 32 | the SHA-256 checksum of everything before |

use std::io::{BufReader, Read, Write};
use std::path::Path;

use glam::DVec3;
use mesh_core::as_u32;
use sha2::{Digest, Sha256};
use simplify::blocks::Fragment;
use simplify::{Quadric, Symmetric3};

use crate::error::Error;
use crate::non_manifold::non_manifold_vertices;
use crate::private_files;
use crate::renumber::{inverse, renumbered};
use crate::sealed_json::hex;

const MAGIC: &[u8; 16] = b"curvmesh region\0";
const VERSION: u32 = 1;
const HEADER: u64 = 16 + 12 + 40;
const CHECKSUM: u64 = 32;
/// The size of a buffer in bytes.
const BLOCK: usize = 1 << 16;

/// A region of a mesh: all faces with a corner in its cell.
///
/// The region owns the vertices in its cell. It also holds vertices of other cells that its faces use; these vertices
/// and their neighbours do not move until the cells are joined. The lowest of the cells of its corners owns a face. The
/// other cells hold copies of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    /// The level: how many times cells were joined.
    pub level: u32,
    /// The cell.
    pub cell: u32,
    /// The number of own vertices, which come first.
    pub own: usize,
    /// The index of each vertex in the input; ascending among own vertices, and among others.
    pub vertex_ids: Vec<u64>,
    /// The cell, on this level, of each vertex that is not owned.
    pub other_cells: Vec<u32>,
    /// Own vertices where the surface is not manifold, ascending. They stay until the regions are one mesh, which is
    /// then cut there.
    pub non_manifold: Vec<u32>,
    /// The positions of the vertices.
    pub positions: Vec<DVec3>,
    /// The quadric of each own vertex, relative to its position; empty before the first pass.
    pub quadrics: Vec<Quadric>,
    /// The faces, as indices of vertices in this region.
    pub triangles: Vec<[u32; 3]>,
}

impl Region {
    /// The cell of a vertex.
    pub(crate) fn home(&self, v: u32) -> u32 {
        match (v as usize).checked_sub(self.own) {
            Some(other) => self.other_cells[other],
            None => self.cell,
        }
    }

    /// Whether this cell owns a face.
    pub(crate) fn is_owner(&self, triangle: [u32; 3]) -> bool {
        triangle.into_iter().all(|v| self.home(v) >= self.cell)
    }

    /// The faces that this cell owns.
    pub fn own_triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.triangles.iter().copied().filter(|&t| self.is_owner(t))
    }

    /// The number of faces that this cell owns.
    #[must_use]
    pub fn own_face_count(&self) -> usize {
        self.own_triangles().count()
    }

    /// The fragment for the collapses, the index in this region of each of its vertices, and the rest of the region.
    /// Vertices that may move come first; non-manifold vertices are among the others.
    pub(crate) fn into_fragment(self) -> (Fragment, Vec<u32>, Self) {
        let Self { positions, quadrics, triangles, .. } = self;
        let mut is_held = vec![false; self.own];
        self.non_manifold.iter().for_each(|&v| is_held[v as usize] = true);
        let free = (0..as_u32(self.own)).filter(|&v| !is_held[v as usize]);
        let others = as_u32(self.own)..as_u32(positions.len());
        let mut places: Vec<u32> = free.collect();
        let own = places.len();
        places.extend(self.non_manifold.iter().copied().chain(others));
        let rest =
            Self { positions: Vec::new(), quadrics: Vec::new(), triangles: Vec::new(), ..self };
        if own == rest.own {
            return (
                Fragment { positions, own, quadrics, triangles, vertex_ids: Vec::new() },
                places,
                rest,
            );
        }
        let number = inverse(places.iter().copied());
        let fragment = Fragment {
            positions: places.iter().map(|&v| positions[v as usize]).collect(),
            own,
            quadrics: places[..own.min(quadrics.len())]
                .iter()
                .map(|&v| quadrics[v as usize])
                .collect(),
            triangles: renumbered(&triangles, &number),
            vertex_ids: Vec::new(),
        };
        (fragment, places, rest)
    }

    /// Writes the region, completely or not at all. Returns the checksum and the length of the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(String, u64), Error> {
        let written = private_files::replace(path, |writer| {
            let mut out = Summed { inner: writer, sum: Sha256::new(), bytes: 0 };
            self.put(&mut out)?;
            let Summed { inner, sum, bytes } = out;
            let sum = sum.finalize();
            inner.write_all(&sum)?;
            Ok((hex(&sum), bytes + CHECKSUM))
        });
        written.map_err(Error::io(path))
    }

    fn put(&self, out: &mut impl Write) -> std::io::Result<()> {
        out.write_all(MAGIC)?;
        for number in [VERSION, self.level, self.cell] {
            out.write_all(&number.to_le_bytes())?;
        }
        let counts = [
            self.own,
            self.other_cells.len(),
            self.non_manifold.len(),
            self.quadrics.len(),
            self.triangles.len(),
        ];
        for count in counts {
            out.write_all(&(count as u64).to_le_bytes())?;
        }
        put_all(out, &self.vertex_ids, |id, to| to.extend_from_slice(&id.to_le_bytes()))?;
        put_all(out, &self.other_cells, |home, to| to.extend_from_slice(&home.to_le_bytes()))?;
        put_all(out, &self.non_manifold, |v, to| to.extend_from_slice(&v.to_le_bytes()))?;
        put_all(out, &self.positions, |p, to| {
            p.to_array().iter().for_each(|x| to.extend_from_slice(&x.to_le_bytes()));
        })?;
        put_all(out, &self.quadrics, |q, to| {
            let (d, m, l) = (q.matrix.diagonal, q.matrix.mixed, q.linear);
            let rows = [d, m, l].map(|row| row.to_array());
            let numbers = rows.as_flattened().iter().chain(core::iter::once(&q.constant));
            numbers.for_each(|x| to.extend_from_slice(&x.to_le_bytes()));
        })?;
        put_all(out, &self.triangles, |t, to| {
            t.iter().for_each(|v| to.extend_from_slice(&v.to_le_bytes()));
        })
    }

    /// Reads a region, and checks its checksum and its content.
    ///
    /// # Errors
    /// The file cannot be read, is cut short, is not the file of a region, or was changed.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::read_checked(path).map(|(region, _)| region)
    }

    /// As [`Region::read`]; returns the checksum too.
    pub(crate) fn read_checked(path: &Path) -> Result<(Self, String), Error> {
        let file = private_files::open(path).map_err(Error::io(path))?;
        let size = file.metadata().map_err(Error::io(path))?.len();
        let buffered = BufReader::with_capacity(BLOCK, file);
        let mut input = Summing { inner: buffered, sum: Sha256::new(), path };
        let damaged = |reason: &str| Error::damaged(path, reason);
        if size < HEADER + CHECKSUM || &input.array::<16>()? != MAGIC {
            return Err(damaged("this is not the file of a region"));
        }
        let [version, level, cell] = [input.u32()?, input.u32()?, input.u32()?];
        if version != VERSION {
            return Err(damaged(&format!(
                "a region of version {version}; this program writes {VERSION}"
            )));
        }
        let mut counts = [0_u64; 5];
        for count in &mut counts {
            *count = u64::from_le_bytes(input.array()?);
        }
        let [own, others, non_manifold, quadrics, triangles] = counts;
        let bytes = |count: u64, each: u64| count.checked_mul(each);
        let expected =
            [(own, 32), (others, 36), (non_manifold, 4), (quadrics, 80), (triangles, 12)]
                .into_iter()
                .try_fold(HEADER + CHECKSUM, |sum, (count, each)| {
                    sum.checked_add(bytes(count, each)?)
                });
        if expected != Some(size) {
            return Err(damaged(&format!(
                "it is {size} bytes long, which is not what its header says; it was cut short"
            )));
        }
        // Both counts are below the length of the file, so their sum does not overflow.
        if own + others > u64::from(u32::MAX) || triangles > u64::from(u32::MAX) / 3 {
            return Err(Error::RegionTooLarge { faces: triangles });
        }
        if quadrics != 0 && quadrics != own {
            return Err(damaged("it has some quadrics, but not one for each own vertex"));
        }
        let vertices = (own + others) as usize;
        let region = Self {
            level,
            cell,
            own: own as usize,
            vertex_ids: input.all::<8, _>(vertices, u64::from_le_bytes)?,
            other_cells: input.all::<4, _>(others as usize, u32::from_le_bytes)?,
            non_manifold: input.all::<4, _>(non_manifold as usize, u32::from_le_bytes)?,
            positions: input
                .all::<24, _>(vertices, |bytes| DVec3::from(doubles::<24, 3>(bytes)))?,
            quadrics: input.all::<80, _>(quadrics as usize, |bytes| {
                let [xx, yy, zz, yz, zx, xy, x, y, z, constant] = doubles::<80, 10>(bytes);
                let (diagonal, mixed) = (DVec3::new(xx, yy, zz), DVec3::new(yz, zx, xy));
                let matrix = Symmetric3 { diagonal, mixed };
                Quadric { matrix, linear: DVec3::new(x, y, z), constant }
            })?,
            triangles: input.all::<12, _>(triangles as usize, |bytes| {
                let mut corners = [0; 3];
                for (corner, bytes) in corners.iter_mut().zip(bytes.as_chunks::<4>().0) {
                    *corner = u32::from_le_bytes(*bytes);
                }
                corners
            })?,
        };
        let sum = input.sum.finalize();
        let mut written = [0; CHECKSUM as usize];
        input.inner.read_exact(&mut written).map_err(Error::io(path))?;
        if sum[..] != written {
            return Err(damaged("its content does not fit its checksum; it was changed"));
        }
        region.check(path)?;
        Ok((region, hex(&sum)))
    }

    /// Checks the content: a checksum only shows that the file is unchanged since it was written.
    fn check(&self, path: &Path) -> Result<(), Error> {
        let damaged = |reason: &str| Err(Error::damaged(path, reason));
        if self.triangles.as_flattened().iter().any(|&v| v as usize >= self.positions.len()) {
            return damaged("a triangle uses a vertex that is not there");
        }
        if self.triangles.iter().any(|[a, b, c]| a == b || b == c || c == a) {
            return damaged("a triangle uses a vertex twice");
        }
        if self.non_manifold.iter().any(|&v| v as usize >= self.own)
            || !self.non_manifold.is_sorted_by(|a, b| a < b)
        {
            return damaged("its non-manifold vertices are out of range or order");
        }
        let found = non_manifold_vertices(self.own, &self.triangles);
        if found.iter().any(|v| self.non_manifold.binary_search(v).is_err()) {
            return damaged("the surface is not manifold at a vertex that is not marked so");
        }
        let (own, others) = self.vertex_ids.split_at(self.own);
        if !own.is_sorted_by(|a, b| a < b) || !others.is_sorted_by(|a, b| a < b) {
            return damaged("its vertices are out of order");
        }
        if self.other_cells.contains(&self.cell) {
            return damaged("a vertex of its own cell is listed for another cell");
        }
        if !self.positions.iter().all(|p| p.is_finite()) {
            return damaged("a coordinate is not finite");
        }
        if !self.quadrics.iter().all(is_finite) {
            return damaged("a quadric is not finite");
        }
        Ok(())
    }
}

/// Whether all numbers of a quadric are finite.
fn is_finite(quadric: &Quadric) -> bool {
    let Quadric { matrix, linear, constant } = quadric;
    matrix.diagonal.is_finite()
        && matrix.mixed.is_finite()
        && linear.is_finite()
        && constant.is_finite()
}

fn doubles<const N: usize, const M: usize>(bytes: [u8; N]) -> [f64; M] {
    let mut numbers = [0.0; M];
    for (number, bytes) in numbers.iter_mut().zip(bytes.as_chunks::<8>().0) {
        *number = f64::from_le_bytes(*bytes);
    }
    numbers
}

fn put_all<T>(
    out: &mut impl Write,
    values: &[T],
    put: impl Fn(&T, &mut Vec<u8>),
) -> std::io::Result<()> {
    let mut bytes = Vec::with_capacity(BLOCK);
    for chunk in values.chunks(512) {
        bytes.clear();
        chunk.iter().for_each(|value| put(value, &mut bytes));
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// A writer that computes the checksum of its output.
struct Summed<W> {
    inner: W,
    sum: Sha256,
    bytes: u64,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.sum.update(&bytes[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

/// A reader of arrays that computes the checksum of its input.
struct Summing<'p, R> {
    inner: R,
    sum: Sha256,
    path: &'p Path,
}

impl<R: Read> Summing<'_, R> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut bytes = [0; N];
        self.inner.read_exact(&mut bytes).map_err(Error::io(self.path))?;
        self.sum.update(bytes);
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, Error> {
        self.array().map(u32::from_le_bytes)
    }

    /// Reads values of `N` bytes each. The caller must check that the file is long enough.
    fn all<const N: usize, T>(
        &mut self,
        count: usize,
        value: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        let mut values = Vec::with_capacity(count);
        let mut block = vec![0; (BLOCK / N).min(count) * N];
        while values.len() < count {
            let there = (count - values.len()).min(BLOCK / N) * N;
            let bytes = &mut block[..there];
            self.inner.read_exact(bytes).map_err(Error::io(self.path))?;
            self.sum.update(&*bytes);
            values.extend(bytes.as_chunks::<N>().0.iter().map(|&bytes| value(bytes)));
        }
        Ok(values)
    }
}
