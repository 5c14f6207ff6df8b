//! From a stream of faces to regions on disk.
//!
//! The input has been read into a file of vertices and a file of faces. Both are distributed by cell, and the region of
//! each cell is built from its own files. A face goes to each cell that has one of its corners. No step holds more than
//! one region, or a window of the vertices, in memory.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mesh_core::as_u32;
use simplify::blocks::{FlatMesh, Forecast, Rules};

use crate::cells::Cells;
use crate::error::Error;
use crate::id_index::IdIndex;
use crate::ingest::{Ingested, MOST_FILES};
use crate::non_manifold::non_manifold_vertices;
use crate::region::Region;
use crate::scratch_file::{ID, ScratchFile, ScratchWriter, id_bytes, id_of, point_bytes, point_of};

/// The defects of the input that are repaired.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Repairs {
    /// Drop vertices at infinite or undefined positions, and the faces at them.
    #[serde(default)]
    pub drop_not_finite: bool,
    /// Merge vertices at equal positions if every face has vertices of its own.
    #[serde(default)]
    pub join_loose_faces: bool,
    /// Drop faces that use a vertex twice.
    pub drop_degenerate: bool,
    /// Cut the surface where it is not manifold. The cut is made at the end; until then, these places are not changed.
    pub cut_non_manifold: bool,
}

/// The defects that were repaired when an input was split.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repaired {
    /// The number of triangles that use a vertex twice. They were dropped.
    pub degenerate_triangles: u64,
    /// The number of vertices where the surface is not manifold. It is cut there at the end.
    pub non_manifold_vertices: u64,
}

/// Distributes an input by cell, and calls `done` with the region of each cell, in order. Returns the repairs.
pub(crate) fn split(
    ingested: &Ingested,
    cells: &Cells,
    repairs: Repairs,
    folder: &Path,
    memory: u64,
    done: &mut dyn FnMut(Region) -> Result<(), Error>,
) -> Result<Repaired, Error> {
    let most = MOST_FILES;
    let mut repaired = Repaired::default();
    for first in (0..cells.count()).step_by(most as usize) {
        let range = first..cells.count().min(first + most);
        let vertices = distribute_vertices(ingested, cells, range.clone(), folder)?;
        let (faces, degenerate) =
            distribute_faces(ingested, cells, range.clone(), repairs, folder, memory)?;
        // Each of these steps meets all faces.
        repaired.degenerate_triangles = degenerate;
        for (cell, (vertices, faces)) in range.zip(vertices.into_iter().zip(faces)) {
            let region = build_region(cell, &vertices, &faces, repairs)?;
            repaired.non_manifold_vertices += region.non_manifold.len() as u64;
            done(region)?;
        }
    }
    Ok(repaired)
}

fn writers(
    range: core::ops::Range<u32>,
    path: impl Fn(u32) -> PathBuf,
) -> Result<Vec<ScratchWriter>, Error> {
    range.map(|cell| ScratchWriter::new(path(cell))).collect()
}

fn distribute_vertices(
    ingested: &Ingested,
    cells: &Cells,
    range: core::ops::Range<u32>,
    folder: &Path,
) -> Result<Vec<ScratchFile>, Error> {
    let mut files = writers(range.clone(), |cell| folder.join(format!("cell-{cell}-vertices")))?;
    ingested.each_vertex(|id, point| {
        let cell = cells.cell_of(point);
        if range.contains(&cell) {
            let file = &mut files[(cell - range.start) as usize];
            file.put(&id_bytes(id))?;
            file.put(&point_bytes(point))?;
        }
        Ok(())
    })?;
    files.into_iter().map(ScratchWriter::finish).collect()
}

/// Writes each triangle to the files of its cells: a byte whose bits say which corners belong to other cells, the three
/// vertices, and the position and the cell of each corner that belongs to another cell. Returns the files, and the
/// number of triangles that use a vertex twice.
fn distribute_faces(
    ingested: &Ingested,
    cells: &Cells,
    range: core::ops::Range<u32>,
    repairs: Repairs,
    folder: &Path,
    memory: u64,
) -> Result<(Vec<ScratchFile>, u64), Error> {
    let mut files = writers(range.clone(), |cell| folder.join(format!("cell-{cell}-faces")))?;
    let mut record = Vec::new();
    let mut degenerate = 0;
    ingested.each_triangle(memory, |ids, at| {
        if let Some(vertex) = repeated(ids) {
            if repairs.drop_degenerate {
                degenerate += 1;
                return Ok(());
            }
            return Err(Error::Degenerate { vertex });
        }
        let other_cells = at.map(|point| cells.cell_of(point));
        for (i, &cell) in other_cells.iter().enumerate() {
            if other_cells[..i].contains(&cell) || !range.contains(&cell) {
                continue;
            }
            record.clear();
            let others = other_cells.map(|home| home != cell);
            record.push((0..3).fold(0, |bits, k| bits | u8::from(others[k]) << k));
            ids.iter().for_each(|&id| record.extend_from_slice(&id_bytes(id)));
            for k in (0..3).filter(|&k| others[k]) {
                record.extend_from_slice(&point_bytes(at[k]));
                record.extend_from_slice(&other_cells[k].to_le_bytes());
            }
            files[(cell - range.start) as usize].put(&record)?;
        }
        Ok(())
    })?;
    let files = files.into_iter().map(ScratchWriter::finish).collect::<Result<_, _>>()?;
    Ok((files, degenerate))
}

fn repeated([a, b, c]: [u64; 3]) -> Option<u64> {
    if a == b || a == c { Some(a) } else { (b == c).then_some(b) }
}

/// Builds the region of a cell from its files.
fn build_region(
    cell: u32,
    vertices: &ScratchFile,
    faces: &ScratchFile,
    repairs: Repairs,
) -> Result<Region, Error> {
    let (mut ids, mut positions) = (Vec::new(), Vec::new());
    let mut source = vertices.reader()?;
    while let Some(id) = source.next()? {
        ids.push(id_of(id));
        positions.push(point_of(&source.expect()?));
    }
    let finder = IdIndex::new(&ids);
    let too_large = |faces: usize| Error::RegionTooLarge { faces: faces as u64 };
    // Corners in other cells get temporary numbers, counted down from the largest one, until all of them are known.
    let mut others: Vec<(u64, u32, DVec3)> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut is_used = vec![false; ids.len()];
    let mut source = faces.reader()?;
    while let Some([bits]) = source.next()? {
        let mut corners = [0_u64; 3];
        for corner in &mut corners {
            let id: [u8; ID] = source.expect()?;
            *corner = id_of(id);
        }
        let mut triangle = [0; 3];
        for k in 0..3 {
            if bits >> k & 1 == 0 {
                let place = finder
                    .find(corners[k])
                    .ok_or_else(|| faces.damaged("a vertex is not there"))?;
                is_used[place as usize] = true;
                triangle[k] = place;
                continue;
            }
            let point = point_of(&source.expect()?);
            let home = u32::from_le_bytes(source.expect()?);
            let others_before =
                u32::try_from(others.len()).map_err(|_| too_large(triangles.len()))?;
            triangle[k] = u32::MAX - others_before;
            others.push((corners[k], home, point));
        }
        triangles.push(triangle);
    }
    // From here on, numbers of vertices and corners fit into 32 bits.
    if ids.len() + others.len() >= u32::MAX as usize / 2 || triangles.len() > u32::MAX as usize / 3
    {
        return Err(too_large(triangles.len()));
    }
    drop(finder);
    // Vertices that no face uses are left out.
    let mut number = vec![0_u32; ids.len()];
    let mut used = 0;
    for (v, _) in is_used.iter().enumerate().filter(|&(_, &is_used)| is_used) {
        (number[v], ids[used], positions[used]) = (as_u32(used), ids[v], positions[v]);
        used += 1;
    }
    ids.truncate(used);
    positions.truncate(used);
    let mut order: Vec<u32> = (0..as_u32(others.len())).collect();
    order.sort_unstable_by_key(|&i| others[i as usize].0);
    let mut place = vec![0_u32; others.len()];
    let mut other_cells = Vec::new();
    for i in order {
        let (id, home, point) = others[i as usize];
        if other_cells.is_empty() || ids.last() != Some(&id) {
            ids.push(id);
            other_cells.push(home);
            positions.push(point);
        }
        place[i as usize] = as_u32(ids.len() - 1);
    }
    for corner in triangles.as_flattened_mut() {
        let other = (u32::MAX - *corner) as usize;
        *corner = if other < place.len() { place[other] } else { number[*corner as usize] };
    }
    let non_manifold = non_manifold_vertices(used, &triangles);
    if let (Some(&v), false) = (non_manifold.first(), repairs.cut_non_manifold) {
        return Err(Error::NotManifold { vertex: ids[v as usize] });
    }
    let quadrics = Vec::new();
    Ok(Region {
        level: 0,
        cell,
        own: used,
        vertex_ids: ids,
        other_cells,
        non_manifold,
        positions,
        quadrics,
        triangles,
    })
}

/// One in this many of the smallest blocks is collapsed as a sample for a forecast.
const FORECAST: usize = 16;

/// The number of faces of a region that a pass would remove at each cost.
pub(crate) fn forecast(region: Region, rules: &Rules) -> Forecast {
    let pass = region.level as usize;
    let (fragment, ..) = region.into_fragment();
    FlatMesh::from_fragment(fragment).forecast(pass, rules, DEEPEST, FORECAST)
}

/// The share of its faces to which a block is collapsed for a forecast.
pub(crate) const DEEPEST: f64 = 0.1;
