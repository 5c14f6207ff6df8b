//! All steps of a run in sequence, in this process.

use mesh_core::{TriMesh, as_u32};
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::StopReason;

use crate::error::Error;
use crate::final_collapse::{collapse_in_memory, final_fragment};
use crate::lod_outputs::write_lod_outputs;
use crate::manifest::Manifest;
use crate::plan::{Next, Plan};
use crate::record::Record;
use crate::reduce::proved_distance;
use crate::refine::{Refinement, refinement};
use crate::refine_region::refine_region;
use crate::step::Step;
use crate::work::{Work, add_up};

/// A result.
#[derive(Clone, Debug)]
pub enum ResultMesh {
    /// A mesh in memory.
    InMemory(TriMesh),
    /// Refined regions of a level on disk, which [`assemble`](crate::assemble()) joins to a file.
    OnDisk {
        /// The level.
        level: u32,
    },
}

/// The results of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The coarsest result.
    pub result: ResultMesh,
    /// The number of its faces.
    pub faces: u64,
    /// The number of faces of each level, from the input up.
    pub levels: Vec<u64>,
    /// The number of cells of each level.
    pub cells: Vec<u32>,
    /// The reason for the end of the collapses.
    pub stop: StopReason,
    /// A proved upper bound of the Hausdorff distance between input and result, in model units. `None` if no proof was
    /// requested, or no finite bound could be proved.
    pub error: Option<f64>,
    /// The other results, from the finest, if [`Settings::finer_levels`](crate::Settings::finer_levels) names any.
    pub finer_levels: Vec<DetailLevel>,
}

/// A result on disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailLevel {
    /// The number of its faces.
    pub faces: u64,
    /// As [`Outcome::error`].
    pub error: Option<f64>,
    place: Place,
}

/// The place of a result on disk.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// In the refined cells of a level.
    Cells { level: u32 },
    /// In a file: it was made in memory from all regions of a level.
    LodOutput { level: u32, number: u32 },
}

impl DetailLevel {
    /// Reads the mesh, or returns the level of its regions.
    ///
    /// # Errors
    /// The file is missing or damaged.
    pub fn load(&self, work: &Work) -> Result<ResultMesh, Error> {
        Ok(match self.place {
            Place::Cells { level } => ResultMesh::OnDisk { level },
            Place::LodOutput { level, number } => {
                ResultMesh::InMemory(work.lod_output_mesh(level, number)?)
            }
        })
    }
}

impl Outcome {
    /// The mesh, if it is in memory.
    #[must_use]
    pub fn into_mesh(self) -> Option<TriMesh> {
        match self.result {
            ResultMesh::InMemory(mesh) => Some(mesh),
            ResultMesh::OnDisk { .. } => None,
        }
    }
}

/// Does the remaining steps of a run. `observer` is called before each step, and returns whether to go on.
///
/// # Errors
/// Another process works in the folder, or a step fails. Finished steps stay done.
pub fn run(work: &Work, observer: &mut dyn FnMut(Step) -> bool) -> Result<Outcome, Error> {
    let _alone = work.alone()?;
    // Regions of lower levels were joined, and may have been removed since.
    let joined = work.current()?.level;
    let mut level = 0;
    let (mut levels, mut cells, mut finer_levels) = (Vec::new(), Vec::new(), Vec::new());
    let last = loop {
        let plan = work.plan(level)?;
        levels.push(plan.faces);
        cells.push(plan.cells);
        if plan.results > 0 {
            let made = refine_cells(work, &plan, observer)?;
            finer_levels.extend((0..plan.results).map(|_| made));
        }
        match plan.next {
            Next::InMemory | Next::Done => break plan,
            _ if level < joined => {}
            Next::Pass { bits, .. } => pass(work, &plan, bits, observer)?,
            Next::SeamStrips { .. } => {
                let of = u64::from(plan.cells);
                if !observer(Step { what: "collapsing seams", done: 0, of, level }) {
                    return Err(Error::Stopped);
                }
                (0..plan.cells).try_for_each(|cell| work.join(level + 1, cell).map(drop))?;
            }
        }
        work.tidy(level, plan.cells);
        level += 1;
    };
    if last.next == Next::InMemory {
        if work.targets().len() == 1 {
            let (mesh, stop, error) = simplify_in_memory(work, level, observer)?;
            let faces = mesh.topology().face_count() as u64;
            let result = ResultMesh::InMemory(mesh);
            return Ok(Outcome { result, faces, levels, cells, stop, error, finer_levels });
        }
        // There are as many results as were named.
        let first = as_u32(finer_levels.len());
        finer_levels.extend(lod_outputs(work, level, first, observer)?);
    }
    let no_result = || Error::damaged(work.folder(), "the plans lead to no result");
    let coarsest = finer_levels.pop().ok_or_else(no_result)?;
    let is_short = last.next == Next::InMemory && coarsest.faces > work.target();
    Ok(Outcome {
        result: coarsest.load(work)?,
        faces: coarsest.faces,
        levels,
        cells,
        stop: if is_short { StopReason::NothingLeft } else { StopReason::Faces },
        error: coarsest.error,
        finer_levels,
    })
}

/// Collapses the cells of a level, and joins them to the cells of the next level.
fn pass(
    work: &Work,
    plan: &Plan,
    bits: u32,
    observer: &mut dyn FnMut(Step) -> bool,
) -> Result<(), Error> {
    let Plan { level, cells, .. } = *plan;
    let mut goes_on = |cell: u32| {
        let step = Step { what: "reducing", done: u64::from(cell), of: u64::from(cells), level };
        if observer(step) { Ok(()) } else { Err(Error::Stopped) }
    };
    for cell in 0..cells.div_ceil(1 << bits) {
        if work.has_region(level + 1, cell)? {
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

/// Refines the cells of a level that is a result.
fn refine_cells(
    work: &Work,
    plan: &Plan,
    observer: &mut dyn FnMut(Step) -> bool,
) -> Result<DetailLevel, Error> {
    let level = plan.level;
    let (mut faces, mut moved) = (0, 0.0_f64);
    for cell in 0..plan.cells {
        let record = refine_cell(work, level, cell, observer)?;
        faces += record.faces;
        moved = moved.max(record.moved.unwrap_or(f64::INFINITY));
    }
    let error = work.moved(level)?.and_then(|sum| bound(sum, moved));
    Ok(DetailLevel { faces, error, place: Place::Cells { level } })
}

/// The results from number `first` on, which are made in memory from all regions of a level.
fn lod_outputs(
    work: &Work,
    level: u32,
    first: u32,
    observer: &mut dyn FnMut(Step) -> bool,
) -> Result<impl Iterator<Item = DetailLevel>, Error> {
    let numbers = first..as_u32(work.targets().len());
    let before = work.moved(level)?;
    let records = write_lod_outputs(work, level, numbers.clone(), observer)?;
    Ok(numbers.zip(records).map(move |(number, record)| DetailLevel {
        faces: record.faces,
        error: before.zip(record.moved).and_then(|(sum, moved)| bound(sum, moved)),
        place: Place::LodOutput { level, number },
    }))
}

/// Collapses and refines all regions of a level as one mesh. Returns the mesh, the reason for the end of its collapses,
/// and the bound of its distance from the input.
fn simplify_in_memory(
    work: &Work,
    level: u32,
    observer: &mut dyn FnMut(Step) -> bool,
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
    let (mesh, run) =
        collapse_in_memory(final_fragment(region)?, &options, summary, level, observer)?;
    let refine = Refinement { work, cells: 0..cells.count(), options: &refinement(&options) };
    let mesh = refine.refine(mesh, observer)?.mesh;
    let error = match (prove, before, work.moved(level)?) {
        (Some(tolerance), Some(before), Some(moved)) => {
            let options = CertifyOptions { tolerance, ..CertifyOptions::default() };
            let bounds = hausdorff_bounds(&before, &Surface::new(&mesh)?, &options);
            bound(moved, bounds.upper)
        }
        _ => None,
    };
    Ok((mesh, run.stop, error))
}

/// Refines a cell of a level that is a result, against its own part of the original. The step reads regions of level 0
/// and its own region, and none of its neighbours.
///
/// # Errors
/// The level is no result, a region is missing or damaged, or the refined region cannot be written.
pub fn refine_cell(
    work: &Work,
    level: u32,
    cell: u32,
    observer: &mut dyn FnMut(Step) -> bool,
) -> Result<Record, Error> {
    if let Some(done) = work.refined(level, cell)? {
        return Ok(done);
    }
    let region = work.region_to_refine(level, cell)?;
    let options = &refinement(&work.manifest().settings.options);
    let before = work.tolerance().map(|tolerance| (region.clone(), tolerance));
    let refined = refine_region(work, region, options, observer)?;
    let moved = match before {
        Some((before, tolerance)) => Some(proved_distance(&before, &refined, tolerance)?),
        None => None,
    };
    work.put_refined(&refined, moved)
}

/// The bound of the sum of two distances; `None` if it is not finite.
fn bound(before: f64, after: f64) -> Option<f64> {
    Some(add_up(before, after)).filter(|sum| sum.is_finite())
}
