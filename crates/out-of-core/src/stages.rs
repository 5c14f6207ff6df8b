//! Results that fit into memory, of a run with several: stages of one row of collapses over what is left.

use core::ops::Range;

use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::{CollapseLog, SimplifyError};

use crate::error::Error;
use crate::finish::{Finishing, refinement};
use crate::region::Region;
use crate::rest::{collapse_rest, rest_of};
use crate::star::stuck_vertices;
use crate::work::{Record, Step, Work};

/// Makes the results of these numbers from all that is left of a level, each of them a region on disk. The
/// collapses are recorded; a result is what the first of them have left, finished if the options say so.
pub(crate) fn finish_stages(
    work: &Work,
    level: u32,
    numbers: Range<u32>,
    see: &mut dyn FnMut(Step) -> bool,
) -> Result<Vec<Record>, Error> {
    let records = || -> Option<Vec<Record>> {
        numbers.clone().map(|number| work.stage(level, number)).collect()
    };
    if let Some(done) = records() {
        return Ok(done);
    }
    let targets = work.targets();
    let log = collapses(work, level, targets.last().copied().unwrap_or(0), see)?;
    let rest = rest_of(work.whole(level)?)?;
    let start = TriMesh::from_triangles(&rest.positions, &rest.triangles)
        .map_err(|error| Error::damaged(work.folder(), error.to_string()))?;
    drop(rest);
    let before = work.tolerance().map(|_| Surface::new(&start)).transpose()?;
    let mut made = Vec::new();
    for number in numbers {
        if let Some(done) = work.stage(level, number) {
            made.push(done);
            continue;
        }
        let faces = usize::try_from(targets[number as usize]).unwrap_or(usize::MAX);
        let (mesh, _) =
            log.level(&start, log.count_for_faces(faces)).map_err(SimplifyError::from)?;
        let finishing = Finishing {
            work,
            cells: 0..work.manifest().cells.count(),
            folder: work.folder().join("finish"),
            options: &refinement(&work.manifest().settings.options),
        };
        let mesh = finishing.finish(mesh, see)?.mesh;
        let moved = match (&before, work.tolerance()) {
            (Some(before), Some(tolerance)) => {
                let options = CertifyOptions { tolerance, ..CertifyOptions::default() };
                Some(hausdorff_bounds(before, &Surface::new(&mesh)?, &options).upper)
            }
            _ => None,
        };
        made.push(work.put_stage(&region_of(&mesh, level, number), moved)?);
    }
    Ok(made)
}

/// The collapses that lead from what is left of a level to so many faces.
fn collapses(
    work: &Work,
    level: u32,
    faces: u64,
    see: &mut dyn FnMut(Step) -> bool,
) -> Result<CollapseLog, Error> {
    let mut options = work.manifest().settings.options.clone();
    options.target.ratio = None;
    options.target.faces = usize::try_from(faces).ok();
    options.record = true;
    let rest = rest_of(work.whole(level)?)?;
    Ok(collapse_rest(rest, &options, &work.manifest().summary, level, see)?.1.log)
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
        stuck: stuck_vertices(own, &triangles),
        positions: mesh.positions().to_vec(),
        triangles,
        ..Region::default()
    }
}
