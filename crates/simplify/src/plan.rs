//! In which steps edges are collapsed: by the driver, in regions, or first in these and then by the
//! driver.

use core::ops::ControlFlow;
use std::time::Instant;

use mesh_core::{HalfEdgeId, TriMesh, VertexMap};

use crate::dispatch::{Regional, collapse, collapse_on, regional, regional_at};
use crate::error::SimplifyError;
use crate::options::Options;
use mesh_collapse::blocks::{
    BlockRun, Drive, Extent, FlatMesh, Fragment, Precision, Rules, collapse_driven,
    collapse_flat_mesh, collapse_in_blocks,
};
use mesh_collapse::{
    CollapseLog, Level, LogEntry, Progress, Protected, Quadric, Run, Snapshot, StopReason, Target,
};

/// The largest part of the faces at which another metric takes over: with more of them left, the second
/// start takes the time that the regions save.
const MOST_OF_ALL: f64 = 0.6;

/// Where that is later than asked for, it takes over with that part left nevertheless, if this is so many times the
/// wanted number: on ten models mean errors are the same within .1 %, in .9 of the time.
const LATE_ENOUGH: f64 = 1.9;

/// At how many faces a metric takes over that regions do not know, if it is not to do it all.
fn rest(options: &Options, faces: usize, target: usize) -> Option<usize> {
    let (asked, most) =
        (options.collapse.switch_ratio? * target as f64, MOST_OF_ALL * faces as f64);
    let is_early_enough = most >= asked.min(LATE_ENOUGH * target as f64);
    (target > 0 && is_early_enough).then_some(asked.min(most) as usize)
}

/// Collapses the edges of a mesh as the options say.
pub(crate) fn collapse_to_level(
    mesh: &TriMesh,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> (Level, Run) {
    let limits = &options.collapse.limits;
    let faces = mesh.topology().face_count();
    let target = limits.face_target(faces);
    let start = Instant::now();
    // A largest error has levels looked for.
    let snapshots = options.limit.distance.is_some();
    let found = regional(mesh, options);
    let rest = rest(options, faces, target);
    match found.map(|Regional { rules, is_start }| (rules, is_start, rest)) {
        Some((rules, false, _)) => {
            let extent = Extent { limits, precision: Precision::Exact, snapshots };
            let BlockRun { left, vertex_map, run, .. } =
                collapse_in_blocks(mesh, rules, extent, observe);
            (Level { mesh: left.mesh, protected: Protected::default(), vertex_map }, run)
        }
        Some((rules, true, Some(rest))) => {
            let rough = Target { faces: Some(rest), ratio: None, ..*limits };
            let extent = Extent { limits: &rough, precision: Precision::About, snapshots };
            let first = collapse_in_blocks(mesh, rules, extent, observe);
            let left = Target {
                faces: Some(target),
                ratio: None,
                time: limits.time.map(|time| time.saturating_sub(start.elapsed())),
                ..*limits
            };
            go_on(first, options, left, faces, observe)
        }
        found => {
            let mut working = mesh.clone();
            let run = match found {
                Some(_) if options.collapse.switch_ratio.is_some() => {
                    drive_in_regions(&mut working, Vec::new(), options, limits, observe)
                }
                _ => collapse(&mut working, options, observe),
            };
            (Level::at_end(working, &run), run)
        }
    }
}

/// The rules by which regions do what the options ask for, or the beginning of it, with a mesh of this
/// size, the diagonal of its bounding box; `None` where the options ask for something that regions do
/// not know.
#[must_use]
pub fn rules(options: &Options, size: f64) -> Option<Rules> {
    regional_elsewhere(size, options).map(|regional| Rules { record: false, ..regional.rules })
}

/// What regions can do of what the options ask for where nobody has the whole mesh, to measure how far it is.
fn regional_elsewhere(size: f64, options: &Options) -> Option<Regional> {
    regional_at(size, options).filter(|_| options.limit.distance.is_none())
}

/// Goes on with what is left of a mesh after passes that were made elsewhere, as if they had been made
/// here: collapses to the number of faces that the options name, and does nothing else of what they
/// say. `size` is that of the mesh before the first pass, and `faces_before` the number of its faces. Where
/// the options say that collapses are recorded, the log is one of the mesh that the fragment is:
/// `TriMesh::from_triangles(&fragment.positions, &fragment.triangles)`.
///
/// # Errors
/// The options make no sense, or ask for what regions do not know; the fragment has vertices that are not its own.
///
/// # Panics
/// The fragment is no oriented manifold.
pub fn finish_collapses(
    fragment: Fragment,
    options: &Options,
    size: f64,
    faces_before: usize,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(TriMesh, Run), SimplifyError> {
    options.check()?;
    let rejection = SimplifyError::Conflict {
        option: "regions",
        with: "what the options ask for",
        cure: "take quadrics without protect, or the whole mesh",
    };
    let Regional { rules, is_start } = regional_elsewhere(size, options).ok_or(rejection)?;
    if fragment.own < fragment.positions.len() {
        return Err(SimplifyError::Conflict {
            option: "the end of a run",
            with: "a fragment that is a part of a mesh",
            cure: "put the parts together first, so that all vertices are its own",
        });
    }
    let target = options.collapse.limits.face_target(faces_before);
    let limits = Target { faces: Some(target), ratio: None, ..options.collapse.limits };
    let (capacity, start) = (fragment.positions.len(), Instant::now());
    let mut sheet = FlatMesh::from_fragment(fragment);
    if rules.record {
        sheet.number_half_edges();
    }
    let observe = &mut |now: &Progress| observe(&Progress { faces_before, ..*now });
    if !is_start {
        let extent = Extent { limits: &limits, precision: Precision::Exact, snapshots: false };
        let done = collapse_flat_mesh(sheet, capacity, rules, extent, observe);
        return Ok((done.left.mesh, done.run));
    }
    let rest = rest(options, faces_before, target).unwrap_or(faces_before);
    let rough = Target { faces: Some(rest), ..limits };
    let extent = Extent { limits: &rough, precision: Precision::About, snapshots: false };
    let first = collapse_flat_mesh(sheet, capacity, rules, extent, observe);
    let time = limits.time.map(|time| time.saturating_sub(start.elapsed()));
    let (level, run) = go_on(first, options, Target { time, ..limits }, faces_before, observe);
    Ok((level.mesh, run))
}

/// Runs the driver on what regions have left of a mesh of so many faces.
fn go_on(
    first: BlockRun,
    options: &Options,
    limits: Target,
    faces_before: usize,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> (Level, Run) {
    let BlockRun { left, vertex_map, quadrics, mut run } = first;
    let Snapshot { mut mesh, vertices, half_edges, .. } = left;
    if matches!(run.stop, StopReason::Time | StopReason::Cancelled) {
        return (Level { mesh, protected: Protected::default(), vertex_map }, run);
    }
    let done = run.collapses;
    let rest = drive_in_regions(&mut mesh, quadrics, options, &limits, &mut |now| {
        observe(&Progress { faces_before, collapses: done + now.collapses, ..*now })
    });
    let level = Level::at_end(mesh, &rest);
    let vertex_map =
        vertex_map.as_slice().iter().map(|v| v.and_then(|v| level.vertex_map[v])).collect();
    if !half_edges.is_empty() {
        let of_original = |entry: &LogEntry| {
            let half_edge = |h: HalfEdgeId| half_edges.get(h.index()).copied();
            entry.renumbered(half_edge, |v| vertices.get(v.index()).copied())
        };
        let mut entries = run.log.into_entries();
        entries.extend(rest.log.entries().iter().filter_map(of_original));
        run.log = CollapseLog::from_entries(entries);
    }
    run.rejections.add(&rest.rejections);
    let run =
        Run { stop: rest.stop, collapses: done + rest.collapses, max_cost: rest.max_cost, ..run };
    (Level { vertex_map: VertexMap::from_vec(vertex_map), ..level }, run)
}

/// Collapses edges by the driver, in regions as far as possible. `quadrics` are what the vertices remember of a
/// run before; nothing where there was none.
fn drive_in_regions(
    mesh: &mut TriMesh,
    quadrics: Vec<Quadric>,
    options: &Options,
    limits: &Target,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let drive: &Drive<'_> = &|mesh, quadrics, start, limits, observe| {
        let mut options = options.clone();
        options.collapse.limits = *limits;
        collapse_on(mesh, quadrics, start, &options, observe)
    };
    let protect = &options.collapse.protect;
    collapse_driven(mesh, quadrics, protect, limits, drive, observe)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::Preset;

    #[test]
    fn another_metric_takes_over_where_that_is_worth_it() {
        let left = |switch_ratio: f64, faces: usize, target: usize| {
            let mut options = Options::preset(Preset::Default);
            options.collapse.switch_ratio = Some(switch_ratio);
            rest(&options, faces, target)
        };
        assert_eq!(left(8.0, 50_000, 1_000), Some(8_000));
        // Six tenths of the faces are the most, if they are enough more than wanted.
        assert_eq!([3_750, 5_000].map(|target| left(8.0, 50_000, target)), [Some(30_000); 2]);
        assert_eq!([3_100, 3_200].map(|n| left(8.0, 10_000, n)), [Some(6_000), None]);
        assert_eq!([4_000, 4_100].map(|n| left(1.5, 10_000, n)), [Some(6_000), None]);
        assert_eq!(left(8.0, 100_000, 0), None);
    }
}
