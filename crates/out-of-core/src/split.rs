//! From a stream of faces to regions on disk.
//!
//! The input is read once, into a file of vertices and one of faces; then vertices and faces are dealt
//! out by cell, and each cell is put together by itself. A face goes to every cell that it has a corner
//! in. No step holds more than one cell, or a window of the vertices.

use std::path::{Path, PathBuf};

use glam::DVec3;
use simplify::blocks::{FlatMesh, Forecast, Rules};

use crate::cells::Cells;
use crate::error::Error;
use crate::incoming::{Incoming, MOST_FILES};
use crate::region::Region;
use crate::scratch::{ID, Scratch, Sink, id_bytes, id_of, point_bytes, point_of};
use crate::star::stuck_vertices;

/// What becomes of faces and vertices that no mesh can have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Repairs {
    /// Whether faces that use a vertex twice are dropped.
    pub drop_degenerate: bool,
    /// Whether the surface is cut where it is not manifold, in the end; before, nothing is changed there.
    pub cut: bool,
}

/// Deals out an input by cell; calls `done` with every region in the order of the cells.
pub(crate) fn split(
    incoming: &Incoming,
    cells: &Cells,
    repairs: Repairs,
    folder: &Path,
    memory: u64,
    done: &mut dyn FnMut(Region) -> Result<(), Error>,
) -> Result<(), Error> {
    let most = MOST_FILES as u32;
    for first in (0..cells.count()).step_by(MOST_FILES as usize) {
        let range = first..cells.count().min(first + most);
        let vertices = deal_vertices(incoming, cells, range.clone(), folder)?;
        let faces = deal_faces(incoming, cells, range.clone(), repairs, folder, memory)?;
        for (cell, (vertices, faces)) in range.zip(vertices.into_iter().zip(faces)) {
            done(assemble(cell, &vertices, &faces, repairs)?)?;
        }
    }
    Ok(())
}

fn sinks(range: core::ops::Range<u32>, path: impl Fn(u32) -> PathBuf) -> Result<Vec<Sink>, Error> {
    range.map(|cell| Sink::new(path(cell))).collect()
}

fn deal_vertices(
    incoming: &Incoming,
    cells: &Cells,
    range: core::ops::Range<u32>,
    folder: &Path,
) -> Result<Vec<Scratch>, Error> {
    let mut dealt = sinks(range.clone(), |cell| folder.join(format!("cell-{cell}-vertices")))?;
    incoming.each_vertex(|id, point| {
        let cell = cells.cell_of(point);
        if range.contains(&cell) {
            let sink = &mut dealt[(cell - range.start) as usize];
            sink.put(&id_bytes(id))?;
            sink.put(&point_bytes(point))?;
        }
        Ok(())
    })?;
    dealt.into_iter().map(Sink::finish).collect()
}

/// A triangle in the file of a cell: a byte whose bits say which corners are of other cells, the three
/// numbers, and the position and cell of each of these corners.
fn deal_faces(
    incoming: &Incoming,
    cells: &Cells,
    range: core::ops::Range<u32>,
    repairs: Repairs,
    folder: &Path,
    memory: u64,
) -> Result<Vec<Scratch>, Error> {
    let mut dealt = sinks(range.clone(), |cell| folder.join(format!("cell-{cell}-faces")))?;
    let mut record = Vec::new();
    incoming.each_triangle(memory, |ids, at| {
        if let Some(vertex) = repeated(ids) {
            if repairs.drop_degenerate {
                return Ok(());
            }
            return Err(Error::Degenerate { vertex });
        }
        let homes = at.map(|point| cells.cell_of(point));
        for (i, &cell) in homes.iter().enumerate() {
            if homes[..i].contains(&cell) || !range.contains(&cell) {
                continue;
            }
            record.clear();
            let others = homes.map(|home| home != cell);
            record.push((0..3).fold(0, |bits, k| bits | u8::from(others[k]) << k));
            ids.iter().for_each(|&id| record.extend_from_slice(&id_bytes(id)));
            for k in (0..3).filter(|&k| others[k]) {
                record.extend_from_slice(&point_bytes(at[k]));
                record.extend_from_slice(&homes[k].to_le_bytes());
            }
            dealt[(cell - range.start) as usize].put(&record)?;
        }
        Ok(())
    })?;
    dealt.into_iter().map(Sink::finish).collect()
}

fn repeated([a, b, c]: [u64; 3]) -> Option<u64> {
    if a == b || a == c { Some(a) } else { (b == c).then_some(b) }
}

/// Puts a cell together from its files.
fn assemble(
    cell: u32,
    vertices: &Scratch,
    faces: &Scratch,
    repairs: Repairs,
) -> Result<Region, Error> {
    let (mut ids, mut positions) = (Vec::new(), Vec::new());
    let mut source = vertices.source()?;
    while let Some(id) = source.next()? {
        ids.push(id_of(id));
        positions.push(point_of(&source.expect()?));
    }
    let finder = Finder::new(&ids);
    // Corners that belong elsewhere are counted from above until all of them are known.
    let mut others: Vec<(u64, u32, DVec3)> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut is_used = vec![false; ids.len()];
    let mut source = faces.source()?;
    while let Some([bits]) = source.next()? {
        let mut corners = [0_u64; 3];
        for corner in &mut corners {
            let id: [u8; ID] = source.expect()?;
            *corner = id_of(id);
        }
        let mut triangle = [0; 3];
        for k in 0..3 {
            if bits >> k & 1 == 0 {
                let place = finder.find(corners[k]).unwrap_or(0);
                is_used[place as usize] = true;
                triangle[k] = place;
                continue;
            }
            let point = point_of(&source.expect()?);
            let home = u32::from_le_bytes(source.expect()?);
            triangle[k] = u32::MAX - others.len() as u32;
            others.push((corners[k], home, point));
        }
        triangles.push(triangle);
    }
    let faces = triangles.len() as u64;
    if ids.len() + others.len() >= u32::MAX as usize / 2 || faces > u64::from(u32::MAX) / 3 {
        return Err(Error::RegionTooLarge { faces });
    }
    drop(finder);
    // Vertices that no face uses stay out.
    let mut number = vec![0_u32; ids.len()];
    let mut used = 0;
    for (v, _) in is_used.iter().enumerate().filter(|&(_, &is_used)| is_used) {
        (number[v], ids[used], positions[used]) = (used as u32, ids[v], positions[v]);
        used += 1;
    }
    ids.truncate(used);
    positions.truncate(used);
    let mut order: Vec<u32> = (0..others.len() as u32).collect();
    order.sort_unstable_by_key(|&i| others[i as usize].0);
    let mut place = vec![0_u32; others.len()];
    let mut homes = Vec::new();
    for i in order {
        let (id, home, point) = others[i as usize];
        if homes.is_empty() || ids.last() != Some(&id) {
            ids.push(id);
            homes.push(home);
            positions.push(point);
        }
        place[i as usize] = (ids.len() - 1) as u32;
    }
    for corner in triangles.as_flattened_mut() {
        let other = (u32::MAX - *corner) as usize;
        *corner = if other < place.len() { place[other] } else { number[*corner as usize] };
    }
    let stuck = stuck_vertices(used, &triangles);
    if let (Some(&v), false) = (stuck.first(), repairs.cut) {
        return Err(Error::NotManifold { vertex: ids[v as usize] });
    }
    let quadrics = Vec::new();
    Ok(Region {
        level: 0,
        cell,
        own: used,
        vertex_ids: ids,
        homes,
        stuck,
        positions,
        quadrics,
        triangles,
    })
}

/// Finds numbers in a sorted list.
pub(crate) struct Finder<'i> {
    ids: &'i [u64],
    /// By number less the first one, where they lie close together: one more than the place.
    direct: Vec<u32>,
}

impl<'i> Finder<'i> {
    pub(crate) fn new(ids: &'i [u64]) -> Self {
        let span = match (ids.first(), ids.last()) {
            (Some(first), Some(last)) => last - first + 1,
            _ => 0,
        };
        let mut direct = Vec::new();
        if span <= 8 * ids.len() as u64 {
            direct.resize(span as usize, 0);
            for (place, id) in ids.iter().enumerate() {
                direct[(id - ids[0]) as usize] = place as u32 + 1;
            }
        }
        Self { ids, direct }
    }

    pub(crate) fn find(&self, id: u64) -> Option<u32> {
        if self.direct.is_empty() {
            return self.ids.binary_search(&id).ok().map(|place| place as u32);
        }
        let place = self.direct.get(usize::try_from(id.checked_sub(self.ids[0])?).ok()?)?;
        place.checked_sub(1)
    }
}

/// One in so many of the smallest regions is looked at to tell what goes at which cost.
const FORECAST: usize = 16;

/// What a pass over a region would take away at which costs.
pub(crate) fn forecast(region: Region, rules: &Rules) -> Forecast {
    let pass = region.level as usize;
    let (fragment, ..) = region.into_fragment();
    FlatMesh::from_fragment(fragment).forecast(pass, rules, DEEPEST, FORECAST)
}

/// The share of its faces down to which a region is collapsed to see what that costs.
const DEEPEST: f64 = 0.1;
