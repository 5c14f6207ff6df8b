//! Numbers that belong to vertices and are computed from the faces around each, region by region.
//!
//! In its region, a vertex has all of its faces, in the order of the file. So what depends on these alone
//! is the same, to the last bit, as in the whole mesh. Where one begins to go round a vertex depends on the
//! numbers of its neighbours, which are therefore in the order of the file too.

use glam::DVec3;
use mesh_core::{Handle, PolygonSoup, Repair, TriMesh, VertexId, build};

use crate::error::Error;
use crate::incoming::MOST_FILES;
use crate::region::Region;
use crate::scratch::{ID, Scratch, Sink, id_bytes, id_of};
use crate::split::Repairs;
use crate::spool::Spool;
use crate::work::Step;

/// Some numbers for each vertex of a mesh, in files.
pub struct VertexNumbers {
    width: usize,
    /// The vertices of each file, of which the first has those with the lowest numbers.
    window: u64,
    /// The number of a vertex and its row, in no order within a file.
    rows: Vec<Scratch>,
    /// The row of vertices that no face uses.
    blank: Vec<f64>,
    /// The finite numbers of the column that is chosen, of vertices in use.
    chosen: Scratch,
    count: u64,
    /// Whether all numbers of a column are numbers of 32 bits.
    single: Vec<bool>,
}

/// The bytes that a face takes while the mesh of its region is built.
const PER_FACE: u64 = 420;

impl Spool {
    /// Computes numbers of vertices. `of_mesh` is given the mesh of a region, and those of its vertices that have
    /// all their faces in it; it gives `width` numbers for each of these. One of these columns is `chosen` to be
    /// asked for its ranks.
    ///
    /// # Errors
    /// The surface is not an oriented manifold, a face uses a vertex twice or one that is not there, or the
    /// files cannot be read or written.
    pub fn vertex_numbers(
        &self,
        width: usize,
        chosen: usize,
        of_mesh: &mut dyn FnMut(&TriMesh, &[VertexId]) -> Vec<f64>,
        see: &mut dyn FnMut(Step) -> bool,
    ) -> Result<VertexNumbers, Error> {
        let vertices = self.summary().vertices;
        let row = (ID + 8 * width + 8 * width) as u64;
        let fits = (self.memory.stream() / row).max(1024);
        let windows = vertices.div_ceil(fits).clamp(1, MOST_FILES);
        let window = vertices.div_ceil(windows).max(1);
        let mut rows = Vec::new();
        for i in 0..windows {
            rows.push(Sink::new(self.folder.join(format!("rows-{i}")))?);
        }
        let mut column = Sink::new(self.folder.join("column"))?;
        let mut single = vec![true; width];
        let (mut used, mut count) = (0, 0);
        self.each_region(PER_FACE, Repairs::default(), see, &mut |region| {
            let ids = region.vertex_ids[..region.own].to_vec();
            let (mesh, own) = mesh_of(region)?;
            let numbers = of_mesh(&mesh, &own);
            used += ids.len() as u64;
            for (&id, row) in ids.iter().zip(numbers.chunks_exact(width)) {
                let sink = &mut rows[(id / window) as usize];
                sink.put(&id_bytes(id))?;
                for (&value, single) in row.iter().zip(&mut single) {
                    sink.put(&value.to_le_bytes())?;
                    *single &= is_single(value);
                }
                if row[chosen].is_finite() {
                    column.put(&row[chosen].to_le_bytes())?;
                    count += 1;
                }
            }
            Ok(())
        })?;
        let mut blank = Vec::new();
        if used < vertices {
            let lonely = TriMesh::from_triangles::<DVec3, u32>(&[DVec3::ZERO], &[])
                .map_err(|_| Error::RegionTooLarge { faces: 0 })?;
            blank = of_mesh(&lonely, &[VertexId::from_index(0)]);
            single.iter_mut().zip(&blank).for_each(|(single, &value)| *single &= is_single(value));
        }
        let rows: Result<Vec<Scratch>, Error> = rows.into_iter().map(Sink::finish).collect();
        Ok(VertexNumbers {
            width,
            window,
            rows: rows?,
            blank,
            chosen: column.finish()?,
            count,
            single,
        })
    }
}

fn is_single(value: f64) -> bool {
    value.is_nan() || f64::from(value as f32) == value
}

/// The mesh of a region, and its own vertices in it. Vertices of other cells are here with some of their faces
/// only, which may come apart there.
fn mesh_of(region: Region) -> Result<(TriMesh, Vec<VertexId>), Error> {
    let Region { own, vertex_ids, positions, mut triangles, .. } = region;
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&v| vertex_ids[v as usize]);
    let mut number = vec![0_u32; order.len()];
    order.iter().zip(0..).for_each(|(&v, new)| number[v as usize] = new);
    triangles.as_flattened_mut().iter_mut().for_each(|v| *v = number[*v as usize]);
    drop((vertex_ids, number));
    let corners = triangles.len() * 3;
    let mut soup = PolygonSoup::with_capacity(positions.len(), triangles.len(), corners);
    order.iter().for_each(|&v| {
        soup.push_vertex(positions[v as usize]);
    });
    drop(positions);
    let too_large = || Error::RegionTooLarge { faces: corners as u64 / 3 };
    for triangle in &triangles {
        soup.push_face(triangle).map_err(|_| too_large())?;
    }
    drop(triangles);
    let mut cut = Repair::strict();
    cut.cut_non_manifold = true;
    let built = build(&soup, &cut).map_err(|error| Error::Build(Box::new(error)))?;
    drop(soup);
    let source = built.provenance.vertex_source;
    let is_own = |source: u32| (order[source as usize] as usize) < own;
    if source.is_sorted() {
        let own = (0..source.len()).filter(|&v| is_own(source[v])).map(VertexId::from_index);
        return Ok((built.mesh, own.collect()));
    }
    // The parts of a vertex that came apart belong beside each other.
    let mut again: Vec<u32> = (0..source.len() as u32).collect();
    again.sort_by_key(|&v| source[v as usize]);
    let mut number = vec![0_u32; again.len()];
    again.iter().zip(0..).for_each(|(&v, new)| number[v as usize] = new);
    let triangles: Vec<[u32; 3]> =
        built.mesh.topology().triangles().map(|t| t.map(|v| number[v as usize])).collect();
    let positions: Vec<DVec3> = again.iter().map(|&v| built.mesh.positions()[v as usize]).collect();
    drop(built.mesh);
    let mesh = TriMesh::from_triangles(&positions, &triangles).map_err(|_| too_large())?;
    let own = (0..again.len()).filter(|&v| is_own(source[again[v] as usize]));
    Ok((mesh, own.map(VertexId::from_index).collect()))
}

impl VertexNumbers {
    /// Whether all numbers of each column are numbers of 32 bits.
    pub(crate) fn single(&self) -> &[bool] {
        &self.single
    }

    /// The chosen column: how many of its numbers are finite, vertices that no face uses left out.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The number that so many others of the chosen column come before, in ascending order.
    ///
    /// # Errors
    /// The files cannot be read.
    pub fn at_rank(&self, rank: u64) -> Result<Option<f64>, Error> {
        if rank >= self.count {
            return Ok(None);
        }
        // Digit by digit, from the front: each time through the file, those with the digits so far are counted.
        let (mut prefix, mut left) = (0_u64, rank);
        for digit in (0..4).rev() {
            let mut counts = vec![0_u64; 1 << 16];
            let mut source = self.chosen.source()?;
            while let Some(bytes) = source.next()? {
                let key = ordered(f64::from_le_bytes(bytes));
                if digit == 3 || key >> (16 * (digit + 1)) == prefix {
                    counts[(key >> (16 * digit) & 0xffff) as usize] += 1;
                }
            }
            let mut here = 0;
            while left >= counts[here] {
                left -= counts[here];
                here += 1;
            }
            prefix = prefix << 16 | here as u64;
        }
        Ok(Some(from_ordered(prefix)))
    }

    /// Calls `visit` with the row of each vertex, in their order.
    pub(crate) fn each_row(
        &self,
        vertices: u64,
        mut visit: impl FnMut(&[f64]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        for (rows, first) in self.rows.iter().zip((0..).step_by(self.window as usize)) {
            let here = self.window.min(vertices.saturating_sub(first)) as usize;
            let mut all = vec![0.0; here * self.width];
            if !self.blank.is_empty() {
                all.chunks_exact_mut(self.width).for_each(|row| row.copy_from_slice(&self.blank));
            }
            let mut source = rows.source()?;
            while let Some(id) = source.next::<ID>()? {
                let place = (id_of(id) - first) as usize * self.width;
                for value in &mut all[place..place + self.width] {
                    *value = f64::from_le_bytes(source.expect()?);
                }
            }
            all.chunks_exact(self.width).try_for_each(&mut visit)?;
        }
        Ok(())
    }
}

/// Bits that are in the same order as the numbers.
fn ordered(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn from_ordered(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
}
