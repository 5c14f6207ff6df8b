//! The refined regions of a level as one file, for results that do not fit into memory.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::Path;

use glam::DVec3;
use mesh_core::{as_u32, cut_non_manifold};
use mesh_io::{Staged, stage_file};

use crate::error::Error;
use crate::region::Region;
use crate::renumber::{NONE, renumbered};
use crate::work::Work;

/// Writes the refined regions of a level as binary PLY, vertices and faces cell by cell. The surface is cut where it is
/// not manifold; the copies of vertices come last. Returns the number of faces.
///
/// # Errors
/// A region is missing or damaged, there are too many vertices for PLY, or the file cannot be written.
pub fn assemble(work: &Work, level: u32, path: &Path) -> Result<u64, Error> {
    let (staged, faces) = stage_assembled(work, level, path)?;
    staged.commit()?;
    Ok(faces)
}

/// As [`assemble()`], but the file only takes its place when it is committed.
///
/// # Errors
/// As [`assemble()`].
pub fn stage_assembled(work: &Work, level: u32, path: &Path) -> Result<(Staged, u64), Error> {
    let numbering = Numbering::new(work, level)?;
    let Cuts { copies, mut triangles } = numbering.cuts(work, level)?;
    let Numbering { cells, faces, .. } = numbering;
    let vertices = numbering.vertices + copies.len() as u64;
    if vertices > i32::MAX as u64 {
        return Err(Error::RegionTooLarge { faces });
    }
    let mut failed = None;
    let written = stage_file(path, |out| {
        writeln!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}")?;
        writeln!(out, "property double x\nproperty double y\nproperty double z")?;
        writeln!(out, "element face {faces}")?;
        writeln!(out, "property list uchar int vertex_indices\nend_header")?;
        let mut region = |cell| {
            work.refined_region(level, cell).map_err(|error| {
                failed = Some(error);
                std::io::Error::other("a region cannot be read")
            })
        };
        let place = |out: &mut dyn Write, position: &DVec3| {
            position.to_array().iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
        };
        for cell in 0..cells {
            let region = region(cell)?;
            let ranks = ranks_of_used(&region, &numbering.shared);
            for (position, _) in region.positions.iter().zip(&ranks).filter(|(_, r)| **r != NONE) {
                place(out, position)?;
            }
        }
        copies.iter().try_for_each(|position| place(out, position))?;
        for cell in 0..cells {
            for triangle in numbering.triangles(&region(cell)?) {
                let cut = if numbering.is_stuck(triangle) { triangles.next() } else { None };
                out.write_all(&[3])?;
                for v in cut.unwrap_or(triangle) {
                    out.write_all(&v.to_le_bytes())?;
                }
            }
        }
        Ok(())
    });
    match failed {
        Some(error) => Err(error),
        None => Ok((written?, faces)),
    }
}

/// The numbers of all vertices in the file, before the surface is cut.
struct Numbering {
    cells: u32,
    /// The vertices that faces of other cells use, by cell and index in the input.
    shared: BTreeMap<(u32, u64), u32>,
    /// The number of the first own vertex of each cell.
    starts: Vec<u64>,
    vertices: u64,
    faces: u64,
    /// The vertices where the surface is not manifold.
    stuck: BTreeSet<u32>,
}

impl Numbering {
    fn new(work: &Work, level: u32) -> Result<Self, Error> {
        let cells = work.cells(level)?;
        let mut shared = BTreeMap::new();
        let mut faces = 0_u64;
        for cell in 0..cells {
            let region = work.refined_region(level, cell)?;
            faces += region.own_face_count() as u64;
            let others = region.other_cells.iter().zip(&region.vertex_ids[region.own..]);
            shared.extend(others.map(|(&home, &id)| ((home, id), 0)));
        }
        let too_many = |_| Error::RegionTooLarge { faces };
        let (mut starts, mut vertices, mut stuck) = (Vec::new(), 0_u64, BTreeSet::new());
        for cell in 0..cells {
            let region = work.refined_region(level, cell)?;
            let ranks = ranks_of_used(&region, &shared);
            let number = |place: usize| u32::try_from(vertices + u64::from(ranks[place]));
            let ids = &region.vertex_ids[..region.own];
            for (&(_, id), shared) in shared.range_mut((cell, 0)..=(cell, u64::MAX)) {
                let missing =
                    |_| Error::damaged(work.folder(), "a vertex of a neighbour is not there");
                let place = ids.binary_search(&id).map_err(missing)?;
                *shared = number(place).map_err(too_many)?;
            }
            for &v in region.non_manifold.iter().filter(|&&v| ranks[v as usize] != NONE) {
                stuck.insert(number(v as usize).map_err(too_many)?);
            }
            starts.push(vertices);
            vertices += ranks.iter().filter(|&&rank| rank != NONE).count() as u64;
        }
        if vertices > i32::MAX as u64 {
            return Err(Error::RegionTooLarge { faces });
        }
        Ok(Self { cells, shared, starts, vertices, faces, stuck })
    }

    /// The number of each vertex of a region that an own face uses, in the order of the region.
    fn of_region(&self, region: &Region) -> Vec<u32> {
        let start = self.starts[region.cell as usize];
        // The file has fewer vertices than 2^31.
        let own = ranks_of_used(region, &self.shared).into_iter();
        let own = own
            .map(|rank| if rank == NONE { NONE } else { as_u32(start as usize + rank as usize) });
        let others = region.other_cells.iter().zip(&region.vertex_ids[region.own..]);
        let others =
            others.map(|(&home, &id)| self.shared.get(&(home, id)).copied().unwrap_or(NONE));
        own.chain(others).collect()
    }

    /// The faces that a region owns, with the numbers of their vertices.
    fn triangles(&self, region: &Region) -> Vec<[u32; 3]> {
        let number = self.of_region(region);
        region.own_triangles().map(|triangle| triangle.map(|v| number[v as usize])).collect()
    }

    /// Whether a face has a vertex where the surface is not manifold.
    fn is_stuck(&self, triangle: [u32; 3]) -> bool {
        triangle.iter().any(|v| self.stuck.contains(v))
    }

    /// Cuts the surface where it is not manifold. All faces there fit into memory.
    fn cuts(&self, work: &Work, level: u32) -> Result<Cuts, Error> {
        let mut positions: BTreeMap<u32, DVec3> = BTreeMap::new();
        let mut triangles = Vec::new();
        for cell in (0..self.cells).filter(|_| !self.stuck.is_empty()) {
            let region = work.refined_region(level, cell)?;
            let number = self.of_region(&region);
            for triangle in region.own_triangles() {
                let numbered = triangle.map(|v| number[v as usize]);
                if self.is_stuck(numbered) {
                    let places = triangle.map(|v| region.positions[v as usize]);
                    positions.extend(numbered.into_iter().zip(places));
                    triangles.push(numbered);
                }
            }
        }
        let (used, positions): (Vec<u32>, Vec<DVec3>) = positions.into_iter().unzip();
        // Every vertex of these triangles is in the list.
        let place = |v: u32| as_u32(used.partition_point(|&other| other < v));
        triangles.iter_mut().for_each(|triangle: &mut [u32; 3]| *triangle = triangle.map(place));
        let copied = cut_non_manifold(&positions, &mut triangles)
            .map_err(|_| Error::damaged(work.folder(), "a face uses a vertex twice"))?;
        // Beside the faces that are gathered here, vertices of their rims have others.
        let mut copies = Vec::new();
        let mut number = used.clone();
        number.extend(copied.iter().map(|&source| match used[source as usize] {
            v if !self.stuck.contains(&v) => v,
            _ => {
                copies.push(positions[source as usize]);
                as_u32(self.vertices as usize + copies.len() - 1)
            }
        }));
        let triangles = renumbered(&triangles, &number).into_iter();
        Ok(Cuts { copies, triangles })
    }
}

/// The cuts of the surface where it is not manifold.
struct Cuts {
    /// The positions of the copies of vertices.
    copies: Vec<DVec3>,
    /// The faces with a vertex where the surface is not manifold, with new numbers, in the order of the file.
    triangles: std::vec::IntoIter<[u32; 3]>,
}

/// Numbers the own vertices of a region that an own face or another region uses; [`NONE`] for others. (If one neighbour
/// owns all faces of a vertex, the vertex lies within the faces of that neighbour, which owns it after the refinement.)
fn ranks_of_used(region: &Region, shared: &BTreeMap<(u32, u64), u32>) -> Vec<u32> {
    let mut is_used = vec![false; region.own];
    for v in region.own_triangles().flatten().filter(|&v| (v as usize) < region.own) {
        is_used[v as usize] = true;
    }
    let ids = &region.vertex_ids[..region.own];
    for (&(_, id), _) in shared.range((region.cell, 0)..=(region.cell, u64::MAX)) {
        if let Ok(place) = ids.binary_search(&id) {
            is_used[place] = true;
        }
    }
    let mut ranks = 0..;
    let rank = |is_used: bool| if is_used { ranks.next() } else { None };
    is_used.into_iter().map(rank).map(|rank| rank.unwrap_or(NONE)).collect()
}
