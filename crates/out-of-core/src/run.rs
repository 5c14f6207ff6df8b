//! A run from an input to a mesh, step after step on this machine.

use core::ops::ControlFlow;

use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::{Progress, StopReason};

use crate::error::Error;
use crate::finish::Finishing;
use crate::finish_region::finish_region;
use crate::reduce::proved_distance;
use crate::rest::collapse_rest;
use crate::work::{Next, Record, Step, Work, add_up};

/// What is left of a mesh.
#[derive(Clone, Debug)]
pub enum Left {
    /// A mesh.
    Mesh(TriMesh),
    /// More than fits into memory: the regions of a level, which [`assemble`](crate::assemble()) puts together.
    Regions {
        /// The level.
        level: u32,
    },
}

/// A simplified mesh and how it came about.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What is left.
    pub left: Left,
    /// The number of its faces.
    pub faces: u64,
    /// The faces on each level, from the input up.
    pub levels: Vec<u64>,
    /// The cells on each level.
    pub cells: Vec<u32>,
    /// Why it stopped.
    pub stop: StopReason,
    /// No point of the input or of the result is farther from the other one than this, if that was proved.
    pub error: Option<f64>,
}

impl Outcome {
    /// The mesh, if it fits into memory.
    #[must_use]
    pub fn into_mesh(self) -> Option<TriMesh> {
        match self.left {
            Left::Mesh(mesh) => Some(mesh),
            Left::Regions { .. } => None,
        }
    }
}

/// Does what is left to do in the folder of a run. `see` is asked all the time whether to go on.
///
/// # Errors
/// A step fails; what was done before stays done.
pub fn run(work: &Work, see: &mut dyn FnMut(Step) -> bool) -> Result<Outcome, Error> {
    let mut level = 0;
    let (mut levels, mut cell_counts) = (Vec::new(), Vec::new());
    let last = loop {
        let plan = work.plan(level)?;
        levels.push(plan.faces);
        cell_counts.push(plan.cells);
        let Next::Pass { bits, .. } = plan.next else { break plan };
        if !work.is_joined(level + 1) {
            let mut goes_on = |what, cell: u32, of: u32| {
                let step = Step { what, done: u64::from(cell), of: u64::from(of), level };
                if see(step) { Ok(()) } else { Err(Error::Stopped) }
            };
            for cell in 0..plan.cells.div_ceil(1 << bits) {
                if work.has_region(level + 1, cell) {
                    continue;
                }
                for part in (cell << bits)..((cell + 1) << bits).min(plan.cells) {
                    goes_on("reducing", part, plan.cells)?;
                    work.reduce(level, part)?;
                }
                work.join(level + 1, cell)?;
            }
        }
        work.tidy(level);
        level += 1;
    };
    let prove = work.tolerance();
    let options = &work.manifest().settings.options;
    if last.next == Next::Cells {
        let (mut faces, mut moved) = (0, 0.0_f64);
        for cell in 0..last.cells {
            let record = finish_cell(work, level, cell, see)?;
            faces += record.faces;
            moved = moved.max(record.moved.unwrap_or(0.0));
        }
        return Ok(Outcome {
            left: Left::Regions { level },
            faces,
            levels,
            cells: cell_counts,
            stop: StopReason::Faces,
            error: work.moved(level)?.map(|sum| add_up(sum, moved)),
        });
    }
    let region = work.whole(level)?;
    let before = match prove {
        Some(_) => Some(Surface::from_triangles(&region.positions, &region.triangles)?),
        None => None,
    };
    let summary = &work.manifest().summary;
    let faces_before = usize::try_from(summary.triangles).unwrap_or(usize::MAX);
    let mut observe = |now: &Progress| {
        let of = (faces_before - now.face_target.min(faces_before)) as u64;
        let done = (faces_before - now.faces.min(faces_before)) as u64;
        let step = Step { what: "collapsing", done, of, level };
        if see(step) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let (mesh, run) = collapse_rest(region, options, summary.size(), faces_before, &mut observe)?;
    if run.stop == StopReason::Cancelled {
        return Err(Error::Stopped);
    }
    let folder = work.folder().join("finish");
    let cells = 0..work.manifest().cells.count();
    let finishing = Finishing { work, cells, folder, options: &options.finish };
    let mesh = finishing.finish(mesh, see)?.mesh;
    let error = match (prove, before, work.moved(level)?) {
        (Some(tolerance), Some(before), Some(moved)) => {
            let options = CertifyOptions { tolerance, ..CertifyOptions::default() };
            let bounds = hausdorff_bounds(&before, &Surface::new(&mesh)?, &options);
            Some(add_up(moved, bounds.upper))
        }
        _ => None,
    };
    let faces = mesh.topology().face_count() as u64;
    let left = Left::Mesh(mesh);
    Ok(Outcome { left, faces, levels, cells: cell_counts, stop: run.stop, error })
}

/// Finishes a cell of a level that is the result, against its own part of the original. It needs the regions of
/// level 0 and its own, and nothing of its neighbours.
///
/// # Errors
/// The level is not the last one, a region is missing or damaged, or the result cannot be written.
pub fn finish_cell(
    work: &Work,
    level: u32,
    cell: u32,
    see: &mut dyn FnMut(Step) -> bool,
) -> Result<Record, Error> {
    if let Some(done) = work.finished(level, cell) {
        return Ok(done);
    }
    let region = work.region_to_finish(level, cell)?;
    let options = &work.manifest().settings.options.finish;
    let before = work.tolerance().map(|tolerance| (region.clone(), tolerance));
    let folder = work.folder().join(format!("finish-{level}-{cell}"));
    let finished = finish_region(work, region, options, &folder, see)?;
    let moved = match before {
        Some((before, tolerance)) => Some(proved_distance(&before, &finished, tolerance)?),
        None => None,
    };
    work.put_finished(&finished, moved)
}
