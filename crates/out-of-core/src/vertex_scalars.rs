//! Scalars of vertices that are computed from the faces around each vertex, region by region.
//!
//! The region of a vertex holds all of its faces, in the order of the file, and their vertices in the order of the
//! file. So the one-ring of the vertex, and all scalars computed from it, are the same as in the whole mesh, bit for
//! bit.

use glam::DVec3;
use mesh_core::{Handle, PolygonSoup, Repair, TriMesh, VertexId, as_u32, build};

use crate::disk_mesh::DiskMesh;
use crate::error::Error;
use crate::ingest::MOST_FILES;
use crate::region::Region;
use crate::renumber::{inverse, renumbered};
use crate::scratch_file::{ID, ScratchFile, ScratchWriter, id_bytes, id_of};
use crate::split::Repairs;
use crate::step::Step;

/// Some scalars for each vertex of a mesh, in files.
pub struct VertexScalars {
    width: usize,
    /// The number of vertices of each file. The first file has those with the lowest indices.
    window: u64,
    /// The index of each vertex and its scalars, unsorted within a file.
    rows: Vec<ScratchFile>,
    /// The scalars of vertices that no face uses.
    blank: Vec<f64>,
    /// The finite scalars of the column for ranks, of vertices that faces use.
    chosen: ScratchFile,
    count: u64,
    /// Whether all scalars of a column are exact with 32 bits.
    single: Vec<bool>,
}

/// The bytes per face while the mesh of its region is built.
const PER_FACE: u64 = 420;

impl DiskMesh {
    /// Computes scalars of vertices. `of_mesh` receives the mesh of a region, and the vertices that have all their
    /// faces in it; it returns `width` scalars for each of them. Ranks can later be queried in the column `chosen`.
    ///
    /// # Errors
    /// The surface is not an oriented manifold, a face uses a vertex twice or uses a missing vertex, or the files
    /// cannot be read or written.
    pub fn vertex_scalars(
        &self,
        width: usize,
        chosen: usize,
        of_mesh: &mut dyn FnMut(&TriMesh, &[VertexId]) -> Vec<f64>,
        observer: &mut dyn FnMut(Step) -> bool,
    ) -> Result<VertexScalars, Error> {
        let vertices = self.summary().vertices;
        let row = (ID + 8 * width + 8 * width) as u64;
        let fits = (self.memory.stream() / row).max(1024);
        let windows = vertices.div_ceil(fits).clamp(1, u64::from(MOST_FILES));
        let window = vertices.div_ceil(windows).max(1);
        let mut rows = Vec::new();
        for i in 0..windows {
            rows.push(ScratchWriter::new(self.folder.join(format!("rows-{i}")))?);
        }
        let mut column = ScratchWriter::new(self.folder.join("column"))?;
        let mut single = vec![true; width];
        let (mut used, mut count) = (0, 0);
        self.each_region(PER_FACE, Repairs::default(), observer, &mut |region| {
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
        let rows: Result<Vec<ScratchFile>, Error> =
            rows.into_iter().map(ScratchWriter::finish).collect();
        Ok(VertexScalars {
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

/// The mesh of a region, and its own vertices in it. Vertices of other cells have only some of their faces here, and
/// may be cut into several.
fn mesh_of(region: Region) -> Result<(TriMesh, Vec<VertexId>), Error> {
    let Region { own, vertex_ids, positions, mut triangles, .. } = region;
    let mut order: Vec<u32> = (0..as_u32(positions.len())).collect();
    order.sort_unstable_by_key(|&v| vertex_ids[v as usize]);
    let number = inverse(order.iter().copied());
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
    // The parts of a vertex that was cut become consecutive.
    let mut again: Vec<u32> = (0..as_u32(source.len())).collect();
    again.sort_by_key(|&v| source[v as usize]);
    let number = inverse(again.iter().copied());
    let triangles: Vec<[u32; 3]> = built.mesh.topology().triangles().collect();
    let triangles = renumbered(&triangles, &number);
    let positions: Vec<DVec3> = again.iter().map(|&v| built.mesh.positions()[v as usize]).collect();
    drop(built.mesh);
    let mesh = TriMesh::from_triangles(&positions, &triangles).map_err(|_| too_large())?;
    let own = (0..again.len()).filter(|&v| is_own(source[again[v] as usize]));
    Ok((mesh, own.map(VertexId::from_index).collect()))
}

impl VertexScalars {
    /// Whether all scalars of each column are exact with 32 bits.
    pub(crate) fn single(&self) -> &[bool] {
        &self.single
    }

    /// The number of finite scalars in the chosen column, of vertices that faces use.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The scalar of a rank in the chosen column, in ascending order from rank 0.
    ///
    /// # Errors
    /// The files cannot be read.
    pub fn at_rank(&self, rank: u64) -> Result<Option<f64>, Error> {
        if rank >= self.count {
            return Ok(None);
        }
        // Radix selection with digits of 16 bits: each pass over the file counts scalars that start with the digits
        // found so far.
        let (mut prefix, mut left) = (0_u64, rank);
        for digit in (0..4).rev() {
            let mut counts = vec![0_u64; 1 << 16];
            let mut source = self.chosen.reader()?;
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

    /// Calls `visit` with the scalars of each vertex, in order.
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
            let mut source = rows.reader()?;
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

/// Bits whose order is the order of the numbers.
fn ordered(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn from_ordered(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
}
