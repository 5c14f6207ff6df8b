//! A run from an input to a mesh, step after step on this machine.

use core::ops::ControlFlow;

use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::{Progress, StopReason};

use crate::error::Error;
use crate::finish::finish;
use crate::rest::collapse_rest;
use crate::work::{Next, Step, Work, add_up};

/// A simplified mesh and how it came about.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The mesh.
    pub mesh: TriMesh,
    /// The faces on each level, from the input up.
    pub levels: Vec<u64>,
    /// The cells on each level.
    pub cells: Vec<u32>,
    /// Why it stopped.
    pub stop: StopReason,
    /// No point of the input or of the result is farther from the other one than this, if that was proved.
    pub error: Option<f64>,
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
    let region = work.whole(level)?;
    let prove = work.tolerance();
    let before = match prove {
        Some(_) => Some(Surface::from_triangles(&region.positions, &region.triangles)?),
        None => None,
    };
    let options = &work.manifest().settings.options;
    let summary = &work.manifest().summary;
    let faces_before = usize::try_from(summary.triangles).unwrap_or(usize::MAX);
    let mut observe = |now: &Progress| {
        let of = (faces_before - now.face_target.min(faces_before)) as u64;
        let done = (faces_before - now.faces.min(faces_before)) as u64;
        let step = Step { what: "collapsing", done, of, level };
        if see(step) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let (mesh, run) = match last.next {
        Next::InOnePiece => {
            collapse_rest(region, options, summary.size(), faces_before, &mut observe)?
        }
        _ => return Err(Error::Unsupported("a result larger than memory", "allow more memory")),
    };
    if run.stop == StopReason::Cancelled {
        return Err(Error::Stopped);
    }
    let mesh = finish(work, mesh, &options.finish, see)?;
    let error = match (prove, before, work.moved(level)?) {
        (Some(tolerance), Some(before), Some(moved)) => {
            let options = CertifyOptions { tolerance, ..CertifyOptions::default() };
            let bounds = hausdorff_bounds(&before, &Surface::new(&mesh)?, &options);
            Some(add_up(moved, bounds.upper))
        }
        _ => None,
    };
    Ok(Outcome { mesh, levels, cells: cell_counts, stop: run.stop, error })
}
