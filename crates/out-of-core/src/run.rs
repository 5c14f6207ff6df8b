//! A run from an input to a mesh, step after step on this machine.

use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::StopReason;

use crate::error::Error;
use crate::finish::{Finishing, refinement};
use crate::finish_region::finish_region;
use crate::plan::{Next, Plan};
use crate::reduce::proved_distance;
use crate::rest::{collapse_rest, rest_of};
use crate::stages::finish_stages;
use crate::work::{Manifest, Record, Step, Work, add_up};

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
    /// What is left: of several results, the coarsest.
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
    /// The finer levels of detail, from the finest, where [`Settings::finer`](crate::Settings::finer) names any.
    pub finer: Vec<Finer>,
}

/// A level of detail that lies in the folder of its run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finer {
    /// The number of its faces.
    pub faces: u64,
    /// As [`Outcome::error`].
    pub error: Option<f64>,
    place: Place,
}

/// What a level of detail is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// The cells of a level.
    Cells { level: u32 },
    /// The rest that a level has left, in one piece.
    Stage { level: u32, number: u32 },
}

impl Finer {
    /// The mesh, or where its regions are.
    ///
    /// # Errors
    /// It is missing or damaged.
    pub fn left(&self, work: &Work) -> Result<Left, Error> {
        Ok(match self.place {
            Place::Cells { level } => Left::Regions { level },
            Place::Stage { level, number } => Left::Mesh(work.stage_mesh(level, number)?),
        })
    }
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
    // What is below was joined, and may have been removed since.
    let joined = work.current()?.level;
    let mut level = 0;
    let (mut levels, mut cells, mut finer) = (Vec::new(), Vec::new(), Vec::new());
    let last = loop {
        let plan = work.plan(level)?;
        levels.push(plan.faces);
        cells.push(plan.cells);
        if plan.results > 0 {
            let made = finish_cells(work, &plan, see)?;
            finer.extend((0..plan.results).map(|_| made));
        }
        match plan.next {
            Next::InOnePiece | Next::Cells => break plan,
            _ if level < joined => {}
            Next::Pass { bits, .. } => pass(work, &plan, bits, see)?,
            Next::Strips { .. } => {
                let of = u64::from(plan.cells);
                if !see(Step { what: "collapsing rims", done: 0, of, level }) {
                    return Err(Error::Stopped);
                }
                (0..plan.cells).try_for_each(|cell| work.join(level + 1, cell).map(drop))?;
            }
        }
        work.tidy(level);
        level += 1;
    };
    if last.next == Next::InOnePiece {
        if work.targets().len() == 1 {
            let (mesh, stop, error) = finish_rest(work, level, see)?;
            let faces = mesh.topology().face_count() as u64;
            let left = Left::Mesh(mesh);
            return Ok(Outcome { left, faces, levels, cells, stop, error, finer });
        }
        let first = finer.len() as u32;
        finer.extend(stages(work, level, first, see)?);
    }
    let no_result = || Error::damaged(work.folder(), "its plans lead to no result");
    let coarsest = finer.pop().ok_or_else(no_result)?;
    let is_short = last.next == Next::InOnePiece && coarsest.faces > work.target();
    Ok(Outcome {
        left: coarsest.left(work)?,
        faces: coarsest.faces,
        levels,
        cells,
        stop: if is_short { StopReason::NothingLeft } else { StopReason::Faces },
        error: coarsest.error,
        finer,
    })
}

/// A pass over the cells of a level, and the joining of what it leaves.
fn pass(
    work: &Work,
    plan: &Plan,
    bits: u32,
    see: &mut dyn FnMut(Step) -> bool,
) -> Result<(), Error> {
    let Plan { level, cells, .. } = *plan;
    let mut goes_on = |cell: u32| {
        let step = Step { what: "reducing", done: u64::from(cell), of: u64::from(cells), level };
        if see(step) { Ok(()) } else { Err(Error::Stopped) }
    };
    for cell in 0..cells.div_ceil(1 << bits) {
        if work.has_region(level + 1, cell) {
            continue;
        }
        for part in (cell << bits)..((cell + 1) << bits).min(cells) {
            goes_on(part)?;
            work.reduce(level, part)?;
        }
        work.join(level + 1, cell)?;
    }
    Ok(())
}

/// Finishes the cells of a level that is a result.
fn finish_cells(
    work: &Work,
    plan: &Plan,
    see: &mut dyn FnMut(Step) -> bool,
) -> Result<Finer, Error> {
    let level = plan.level;
    let (mut faces, mut moved) = (0, 0.0_f64);
    for cell in 0..plan.cells {
        let record = finish_cell(work, level, cell, see)?;
        faces += record.faces;
        moved = moved.max(record.moved.unwrap_or(0.0));
    }
    let error = work.moved(level)?.map(|sum| add_up(sum, moved));
    Ok(Finer { faces, error, place: Place::Cells { level } })
}

/// The results from this number on, which are made of the rest in one piece.
fn stages(
    work: &Work,
    level: u32,
    first: u32,
    see: &mut dyn FnMut(Step) -> bool,
) -> Result<impl Iterator<Item = Finer>, Error> {
    let numbers = first..work.targets().len() as u32;
    let before = work.moved(level)?;
    let records = finish_stages(work, level, numbers.clone(), see)?;
    Ok(numbers.zip(records).map(move |(number, record)| Finer {
        faces: record.faces,
        error: before.zip(record.moved).map(|(sum, moved)| add_up(sum, moved)),
        place: Place::Stage { level, number },
    }))
}

/// Does the rest in one piece: the mesh, why its collapses ended, and how far it is from the input.
fn finish_rest(
    work: &Work,
    level: u32,
    see: &mut dyn FnMut(Step) -> bool,
) -> Result<(TriMesh, StopReason, Option<f64>), Error> {
    let Manifest { settings, summary, cells, .. } = work.manifest();
    let prove = work.tolerance();
    let region = work.whole(level)?;
    let before = match prove {
        Some(_) => Some(Surface::from_triangles(&region.positions, &region.triangles)?),
        None => None,
    };
    let mut options = settings.options.clone();
    options.record = false;
    let (mesh, run) = collapse_rest(rest_of(region)?, &options, summary, level, see)?;
    let folder = work.folder().join("finish");
    let finishing =
        Finishing { work, cells: 0..cells.count(), folder, options: &refinement(&options) };
    let mesh = finishing.finish(mesh, see)?.mesh;
    let error = match (prove, before, work.moved(level)?) {
        (Some(tolerance), Some(before), Some(moved)) => {
            let options = CertifyOptions { tolerance, ..CertifyOptions::default() };
            let bounds = hausdorff_bounds(&before, &Surface::new(&mesh)?, &options);
            Some(add_up(moved, bounds.upper))
        }
        _ => None,
    };
    Ok((mesh, run.stop, error))
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
    let options = &refinement(&work.manifest().settings.options);
    let before = work.tolerance().map(|tolerance| (region.clone(), tolerance));
    let folder = work.folder().join(format!("finish-{level}-{cell}"));
    let finished = finish_region(work, region, options, &folder, see)?;
    let moved = match before {
        Some((before, tolerance)) => Some(proved_distance(&before, &finished, tolerance)?),
        None => None,
    };
    work.put_finished(&finished, moved)
}
