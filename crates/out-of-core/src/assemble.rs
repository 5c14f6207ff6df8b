//! Regions as one file, without ever being one mesh in memory: for results that are larger than that.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;
use mesh_io::replace_file;

use crate::error::Error;
use crate::work::Work;

/// Writes the finished regions of a level as binary PLY, vertices and faces cell by cell; returns the number of
/// faces.
///
/// # Errors
/// A region is missing or damaged, there are too many vertices for PLY, or the file cannot be written.
pub fn assemble(work: &Work, level: u32, path: &Path) -> Result<u64, Error> {
    let cells = work.cells(level)?;
    // Where the own vertices of each cell begin, and which vertices of other cells are asked for.
    let (mut starts, mut vertices, mut faces) = (Vec::new(), 0_u64, 0_u64);
    let mut asked: BTreeMap<(u32, u64), u32> = BTreeMap::new();
    for cell in 0..cells {
        let region = work.finished_region(level, cell)?;
        starts.push(vertices);
        vertices += region.own as u64;
        faces += region.own_face_count() as u64;
        let others = region.homes.iter().zip(&region.vertex_ids[region.own..]);
        asked.extend(others.map(|(&home, &id)| ((home, id), 0)));
    }
    if vertices > i32::MAX as u64 {
        return Err(Error::RegionTooLarge { faces });
    }
    for cell in 0..cells {
        let region = work.finished_region(level, cell)?;
        let ids = &region.vertex_ids[..region.own];
        for (&(_, id), number) in asked.range_mut((cell, 0)..=(cell, u64::MAX)) {
            let missing = |_| Error::damaged(work.folder(), "a vertex of a neighbour is not there");
            let place = ids.binary_search(&id).map_err(missing)?;
            *number = (starts[cell as usize] + place as u64) as u32;
        }
    }
    let mut failed = None;
    let written = replace_file(path, |out| {
        writeln!(out, "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}")?;
        writeln!(out, "property double x\nproperty double y\nproperty double z")?;
        writeln!(out, "element face {faces}")?;
        writeln!(out, "property list uchar int vertex_indices\nend_header")?;
        let mut region = |cell| {
            work.finished_region(level, cell).map_err(|error| {
                failed = Some(error);
                std::io::Error::other("a region cannot be read")
            })
        };
        for cell in 0..cells {
            let region = region(cell)?;
            for x in region.positions[..region.own].iter().flat_map(DVec3::to_array) {
                out.write_all(&x.to_le_bytes())?;
            }
        }
        for cell in 0..cells {
            let region = region(cell)?;
            let number = |v: u32| match (v as usize).checked_sub(region.own) {
                None => (starts[cell as usize] + u64::from(v)) as u32,
                Some(other) => {
                    let key = (region.homes[other], region.vertex_ids[v as usize]);
                    asked.get(&key).copied().unwrap_or_default()
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
        None => Ok(written.map(|()| faces)?),
    }
}
