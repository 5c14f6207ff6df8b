//! The refined regions of a level as one file, for results that do not fit into memory.

use std::collections::BTreeMap;
use std::path::Path;

use mesh_core::as_u32;
use mesh_io::{Staged, stage_file};

use crate::error::Error;
use crate::region::Region;
use crate::renumber::NONE;
use crate::work::Work;

/// Writes the refined regions of a level as binary PLY, vertices and faces cell by cell. Returns the number of faces.
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
    let cells = work.cells(level)?;
    // The vertices that faces of other cells use, by cell and index in the input, and their indices in the file.
    let mut shared: BTreeMap<(u32, u64), u32> = BTreeMap::new();
    let mut faces = 0_u64;
    for cell in 0..cells {
        let region = work.refined_region(level, cell)?;
        faces += region.own_face_count() as u64;
        let others = region.other_cells.iter().zip(&region.vertex_ids[region.own..]);
        shared.extend(others.map(|(&home, &id)| ((home, id), 0)));
    }
    // The index of the first own vertex of each cell in the file.
    let (mut starts, mut vertices) = (Vec::new(), 0_u64);
    for cell in 0..cells {
        let region = work.refined_region(level, cell)?;
        let ranks = ranks_of_used(&region, &shared);
        starts.push(vertices);
        let ids = &region.vertex_ids[..region.own];
        for (&(_, id), number) in shared.range_mut((cell, 0)..=(cell, u64::MAX)) {
            let missing = |_| Error::damaged(work.folder(), "a vertex of a neighbour is not there");
            let place = ids.binary_search(&id).map_err(missing)?;
            let too_many = |_| Error::RegionTooLarge { faces };
            *number = u32::try_from(vertices + u64::from(ranks[place])).map_err(too_many)?;
        }
        vertices += ranks.iter().filter(|&&rank| rank != NONE).count() as u64;
    }
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
        for cell in 0..cells {
            let region = region(cell)?;
            let ranks = ranks_of_used(&region, &shared);
            for (position, _) in region.positions.iter().zip(&ranks).filter(|(_, r)| **r != NONE) {
                for x in position.to_array() {
                    out.write_all(&x.to_le_bytes())?;
                }
            }
        }
        for cell in 0..cells {
            let region = region(cell)?;
            let ranks = ranks_of_used(&region, &shared);
            let number = |v: u32| match (v as usize).checked_sub(region.own) {
                // The file has fewer vertices than 2^31.
                None => as_u32(starts[cell as usize] as usize + ranks[v as usize] as usize),
                Some(other) => {
                    let key = (region.other_cells[other], region.vertex_ids[v as usize]);
                    shared.get(&key).copied().unwrap_or_default()
                }
            };
            for triangle in region.own_triangles() {
                out.write_all(&[3])?;
                for v in triangle.map(number) {
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
