//! Results that fit into memory, of a run with several: stages of one recorded sequence of collapses.

use core::ops::Range;

use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::{CollapseLog, SimplifyError};

use crate::error::Error;
use crate::final_collapse::{collapse_in_memory, final_fragment};
use crate::non_manifold::non_manifold_vertices;
use crate::record::Record;
use crate::refine::{Refinement, refinement};
use crate::region::Region;
use crate::step::Step;
use crate::work::Work;

/// Makes the numbered results from all regions of a level, and writes each result as a region. The collapses are
/// recorded. A result is the mesh after a part of the recorded collapses, refined as the options say.
pub(crate) fn write_lod_outputs(
    work: &Work,
    level: u32,
    numbers: Range<u32>,
    observer: &mut dyn FnMut(Step) -> bool,
) -> Result<Vec<Record>, Error> {
    let records: Result<Option<Vec<Record>>, Error> = numbers
        .clone()
        .map(|number| work.lod_output(level, number))
        .map(Result::transpose)
        .collect::<Option<_>>()
        .transpose();
    if let Some(done) = records? {
        return Ok(done);
    }
    let targets = work.targets();
    let log = collapses(work, level, targets.last().copied().unwrap_or(0), observer)?;
    let fragment = final_fragment(work.whole(level)?)?;
    let start = TriMesh::from_triangles(&fragment.positions, &fragment.triangles)
        .map_err(|error| Error::damaged(work.folder(), error.to_string()))?;
    drop(fragment);
    let before = work.tolerance().map(|_| Surface::new(&start)).transpose()?;
    let mut made = Vec::new();
    for number in numbers {
        if let Some(done) = work.lod_output(level, number)? {
            made.push(done);
            continue;
        }
        let target = targets.get(number as usize).copied().unwrap_or(0);
        let faces = usize::try_from(target).unwrap_or(usize::MAX);
        let (mesh, _) =
            log.level(&start, log.count_for_faces(faces)).map_err(SimplifyError::from)?;
        let cells = 0..work.manifest().cells.count();
        let options = &refinement(&work.manifest().settings.options);
        let mesh = Refinement { work, cells, options }.refine(mesh, observer)?.mesh;
        let moved = match (&before, work.tolerance()) {
            (Some(before), Some(tolerance)) => {
                let options = CertifyOptions { tolerance, ..CertifyOptions::default() };
                Some(hausdorff_bounds(before, &Surface::new(&mesh)?, &options).upper)
            }
            _ => None,
        };
        made.push(work.put_lod_output(&region_of(&mesh, level, number), moved)?);
    }
    Ok(made)
}

/// Records the collapses from all regions of a level down to `faces` faces.
fn collapses(
    work: &Work,
    level: u32,
    faces: u64,
    observer: &mut dyn FnMut(Step) -> bool,
) -> Result<CollapseLog, Error> {
    let mut options = work.manifest().settings.options.clone();
    options.target.ratio = None;
    options.target.faces = usize::try_from(faces).ok();
    options.record = true;
    let fragment = final_fragment(work.whole(level)?)?;
    Ok(collapse_in_memory(fragment, &options, &work.manifest().summary, level, observer)?.1.log)
}

/// A whole mesh as a region.
fn region_of(mesh: &TriMesh, level: u32, number: u32) -> Region {
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
    let own = mesh.positions().len();
    Region {
        level,
        cell: number,
        own,
        vertex_ids: (0..own as u64).collect(),
        non_manifold: non_manifold_vertices(own, &triangles),
        positions: mesh.positions().to_vec(),
        triangles,
        ..Region::default()
    }
}
