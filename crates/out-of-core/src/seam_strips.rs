//! The strips of faces along the seams between the cells of a level. They are collapsed before the last passes to a
//! result that does not fit into memory.
//!
//! Vertices along seams between cells that were never joined still have their positions of the input. A strip consists
//! of all faces within some rings of such a seam. All strips together are collapsed like a region; the vertices at
//! their border are held. Then each cell takes back the vertices that it owned, and their faces.

use std::path::Path;

use glam::DVec3;
use mesh_core::as_u32;
use simplify::Quadric;

use crate::error::Error;
use crate::id_index::IdIndex;
use crate::non_manifold::non_manifold_vertices;
use crate::region::Region;
use crate::renumber::NONE;

/// The number of rings of vertices on either side of a seam that belong to its strip.
const RINGS: usize = 4;

/// The strips of a level, with the cell of each of their vertices.
pub(crate) struct SeamStrips {
    /// The index in the input of each vertex, and its cell; ascending.
    other_cells: Vec<(u64, u32)>,
}

impl SeamStrips {
    /// Collects the strips between cells as one region. The cells are read one by one. `None` if there are no seams, or
    /// the strips have more faces than allowed.
    pub(crate) fn gather(
        level: u32,
        cells: u32,
        most_faces: u64,
        folder: &Path,
        mut read: impl FnMut(u32) -> Result<Region, Error>,
    ) -> Result<Option<(Self, Region)>, Error> {
        let mut triangles: Vec<[u64; 3]> = Vec::new();
        let mut own: Vec<Vertex> = Vec::new();
        let mut held: Vec<Vertex> = Vec::new();
        let mut has_quadrics = true;
        for cell in 0..cells {
            let region = read(cell)?;
            has_quadrics &= region.quadrics.len() == region.own;
            let is_near = near_seam(&region);
            let is_near = |v: u32| is_near.get(v as usize).is_none_or(|&is_near| is_near);
            let mut is_used = vec![false; region.own];
            for triangle in region.triangles.iter().filter(|t| t.iter().any(|&v| is_near(v))) {
                for &v in triangle.iter().filter(|&&v| (v as usize) < region.own) {
                    is_used[v as usize] = true;
                }
                if region.is_owner(*triangle) {
                    triangles.push(triangle.map(|v| region.vertex_ids[v as usize]));
                }
            }
            if triangles.len() as u64 > most_faces {
                return Ok(None);
            }
            for v in (0..region.own).filter(|&v| is_used[v]) {
                let list = if is_near(as_u32(v)) { &mut own } else { &mut held };
                list.push(Vertex {
                    id: region.vertex_ids[v],
                    cell,
                    position: region.positions[v],
                    quadric: region.quadrics.get(v).copied().unwrap_or_default(),
                });
            }
        }
        if own.is_empty() {
            return Ok(None);
        }
        let mut other_cells: Vec<(u64, u32)> =
            own.iter().chain(&held).map(|vertex| (vertex.id, vertex.cell)).collect();
        other_cells.sort_unstable();
        let region = region_of(own, held, has_quadrics, triangles, folder)?;
        let nowhere = vec![NONE; region.other_cells.len()];
        Ok(Some((Self { other_cells }, Region { level, other_cells: nowhere, ..region })))
    }

    /// The region of a cell on the next level: the old region, with the old strips replaced by its part of the
    /// collapsed strips.
    pub(crate) fn put_back(
        &self,
        reduced: &Region,
        old: &Region,
        folder: &Path,
    ) -> Result<Region, Error> {
        let is_near = near_seam(old);
        let stays = |v: u32| is_near.get(v as usize).is_some_and(|&is_near| !is_near);
        let home = |id: u64| {
            let found = self.other_cells.binary_search_by_key(&id, |&(id, _)| id);
            found.map_or(NONE, |place| self.other_cells[place].1)
        };
        let mut triangles: Vec<[u64; 3]> = Vec::new();
        for triangle in old.triangles.iter().filter(|t| t.iter().all(|&v| stays(v))) {
            triangles.push(triangle.map(|v| old.vertex_ids[v as usize]));
        }
        // From the strips: faces with vertices of this cell, and all vertices of these faces.
        let of_cell: Vec<u32> = reduced.vertex_ids.iter().map(|&id| home(id)).collect();
        let mut is_used = vec![false; reduced.positions.len()];
        for triangle in &reduced.triangles {
            if triangle.iter().any(|&v| of_cell[v as usize] == old.cell) {
                triangle.iter().for_each(|&v| is_used[v as usize] = true);
                triangles.push(triangle.map(|v| reduced.vertex_ids[v as usize]));
            }
        }
        let has_quadrics = old.quadrics.len() == old.own && reduced.quadrics.len() == reduced.own;
        let vertex = |region: &Region, v: usize, cell: u32| Vertex {
            id: region.vertex_ids[v],
            cell,
            position: region.positions[v],
            quadric: region.quadrics.get(v).copied().unwrap_or_default(),
        };
        let mut own: Vec<Vertex> =
            (0..old.own).filter(|&v| stays(as_u32(v))).map(|v| vertex(old, v, old.cell)).collect();
        let mut others = Vec::new();
        for v in (0..reduced.positions.len()).filter(|&v| is_used[v]) {
            if of_cell[v] != old.cell {
                others.push(vertex(reduced, v, of_cell[v]));
            } else if v < reduced.own {
                own.push(vertex(reduced, v, old.cell));
            }
        }
        let region = region_of(own, others, has_quadrics, triangles, folder)?;
        Ok(Region { level: old.level + 1, cell: old.cell, ..region })
    }
}

/// A vertex that moves between regions.
struct Vertex {
    id: u64,
    cell: u32,
    position: DVec3,
    quadric: Quadric,
}

/// Builds a region from own vertices, other vertices, and triangles of indices in the input.
fn region_of(
    mut own: Vec<Vertex>,
    mut others: Vec<Vertex>,
    has_quadrics: bool,
    triangles: Vec<[u64; 3]>,
    folder: &Path,
) -> Result<Region, Error> {
    own.sort_unstable_by_key(|vertex| vertex.id);
    others.sort_unstable_by_key(|vertex| vertex.id);
    let vertex_ids: Vec<u64> = own.iter().chain(&others).map(|vertex| vertex.id).collect();
    let (of_own, of_others) = vertex_ids.split_at(own.len());
    let (of_own, of_others) = (IdIndex::new(of_own), IdIndex::new(of_others));
    let too_large = |_| Error::RegionTooLarge { faces: triangles.len() as u64 };
    let first_other = u32::try_from(own.len()).map_err(too_large)?;
    u32::try_from(vertex_ids.len()).map_err(too_large)?;
    let place = |id: u64| {
        let others = || of_others.find(id).map(|place| place + first_other);
        let missing = || Error::damaged(folder, "a vertex of a neighbour is not there");
        of_own.find(id).or_else(others).ok_or_else(missing)
    };
    let places = |[a, b, c]: [u64; 3]| Ok([place(a)?, place(b)?, place(c)?]);
    let triangles: Vec<[u32; 3]> =
        triangles.into_iter().map(places).collect::<Result<_, Error>>()?;
    Ok(Region {
        own: own.len(),
        other_cells: others.iter().map(|vertex| vertex.cell).collect(),
        non_manifold: non_manifold_vertices(own.len(), &triangles),
        positions: own.iter().chain(&others).map(|vertex| vertex.position).collect(),
        quadrics: match has_quadrics {
            true => own.iter().map(|vertex| vertex.quadric).collect(),
            false => Vec::new(),
        },
        triangles,
        vertex_ids,
        ..Region::default()
    })
}

/// Whether each own vertex of a region is in the strips. Vertices of other cells always are.
fn near_seam(region: &Region) -> Vec<bool> {
    let own = region.own;
    let mut is_near = vec![false; own];
    for triangle in region.triangles.iter().filter(|t| t.iter().any(|&v| v as usize >= own)) {
        triangle.iter().filter(|&&v| (v as usize) < own).for_each(|&v| is_near[v as usize] = true);
    }
    for _ in 1..RINGS {
        let reached = is_near.clone();
        for triangle in &region.triangles {
            if triangle.iter().any(|&v| reached.get(v as usize).is_some_and(|&reached| reached)) {
                let own = triangle.iter().filter(|&&v| (v as usize) < own);
                own.for_each(|&v| is_near[v as usize] = true);
            }
        }
    }
    is_near
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use mesh_core::TriMesh;
    use mesh_io::{ReadOptions, WriteOptions};
    use mesh_shapes::Torus;
    use simplify::{Options, Preset};

    use super::*;
    use crate::capacity::Capacity;
    use crate::ingest::Input;
    use crate::manifest::Settings;
    use crate::split::Repairs;
    use crate::work::Work;

    fn sorted(region: &Region) -> Vec<[u64; 3]> {
        let mut faces: Vec<[u64; 3]> = Vec::new();
        for triangle in &region.triangles {
            let mut ids = triangle.map(|v| region.vertex_ids[v as usize]);
            let least = (0..3).min_by_key(|&i| ids[i]).unwrap();
            ids.rotate_left(least);
            faces.push(ids);
        }
        faces.sort_unstable();
        faces
    }

    /// Seam strips that were not changed leave every cell unchanged.
    #[test]
    fn what_is_taken_out_fits_in_again() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("in.ply");
        let soup = Torus { major: 5.0, minor: 2.0 }.mesh(160, 60).unwrap();
        let mesh = TriMesh::from_soup(&soup).unwrap();
        mesh_io::write(&input, &mesh, &WriteOptions::default()).unwrap();
        let settings = Settings {
            options: Options::preset(Preset::Fast).to_faces(100),
            finer_levels: Vec::new(),
            repairs: Repairs::default(),
            capacity: Capacity { region_faces: 3000, in_memory_faces: 100, stream: 1 << 20 },
            prove: None,
        };
        let work = folder.path().join("work");
        let input = Input::Path(&input);
        let work = Work::split(&work, input, &ReadOptions::default(), settings, &mut |_| true);
        let work = work.unwrap();
        let cells = work.cells(0).unwrap();
        assert_eq!(cells, 8);
        let read = |cell| work.region(0, cell);
        let gather = |most| SeamStrips::gather(0, cells, most, folder.path(), read).unwrap();
        let (strips, region) = gather(u64::MAX).unwrap();
        let faces = region.triangles.len();
        assert!((500..mesh.topology().face_count()).contains(&faces), "{faces}");
        assert!(gather(faces as u64 - 1).is_none());
        for cell in 0..cells {
            let old = work.region(0, cell).unwrap();
            let new = strips.put_back(&region, &old, folder.path()).unwrap();
            assert_eq!((new.level, new.own), (1, old.own));
            assert_eq!(new.vertex_ids, old.vertex_ids);
            assert_eq!(new.other_cells, old.other_cells);
            assert_eq!(new.positions, old.positions);
            assert_eq!(sorted(&new), sorted(&old));
        }
    }
}
