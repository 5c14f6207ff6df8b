//! Collapses by a [`Plan`], and the continuation of out-of-core runs.

use core::ops::ControlFlow;
use std::time::Instant;

use mesh_collapse::blocks::{
    BlockRun, Drive, Extent, FlatMesh, Fragment, Precision, collapse_driven, collapse_flat_mesh,
    collapse_in_blocks,
};
use mesh_collapse::{
    CollapseLog, Level, LogEntry, Progress, Protected, Quadric, Run, Snapshot, StopReason, Target,
};
use mesh_core::{HalfEdgeId, TriMesh, VertexMap};

use crate::dispatch::{collapse, collapse_on};
use crate::error::SimplifyError;
use crate::options::Options;
use crate::plan::{BlockRules, Plan, switch_at};

/// Collapses the edges of a mesh as the plan says.
pub(crate) fn collapse_to_level(
    mesh: &TriMesh,
    plan: Plan,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> (Level, Run) {
    let target = &options.target;
    let faces = mesh.topology().face_count();
    let start = Instant::now();
    // An error limit needs levels to choose from.
    let snapshots = options.tolerance.distance.is_some();
    match plan {
        Plan::Blocks { rules } => {
            let extent = Extent { limits: target, precision: Precision::Exact, snapshots };
            let BlockRun { left, vertex_map, run, .. } =
                collapse_in_blocks(mesh, rules, extent, observe);
            (Level { mesh: left.mesh, protected: Protected::default(), vertex_map }, run)
        }
        Plan::BlocksThenGreedy { rules, switch_at } => {
            let rough = Target { faces: Some(switch_at), ratio: None, ..*target };
            let extent = Extent { limits: &rough, precision: Precision::About, snapshots };
            let first = collapse_in_blocks(mesh, rules, extent, observe);
            let left = Target {
                faces: Some(target.face_target(faces)),
                ratio: None,
                time: target.time.map(|time| time.saturating_sub(start.elapsed())),
                ..*target
            };
            go_on(first, options, left, faces, observe)
        }
        Plan::GreedyInBlocks => {
            let mut working = mesh.clone();
            let run = greedy_in_blocks(&mut working, Vec::new(), options, target, observe);
            (Level::at_end(working, &run), run)
        }
        Plan::Greedy => {
            let mut working = mesh.clone();
            let run = collapse(&mut working, options, observe);
            (Level::at_end(working, &run), run)
        }
    }
}

/// Continues after block passes that other processes made: collapses to the number of faces in the options. The result
/// has the same bits as a run in one process. It neither refines nor measures. `diagonal` is the diagonal of the
/// bounding box before the first pass, and `faces_before` the number of faces then. If collapses are recorded, the log
/// belongs to the mesh `TriMesh::from_triangles(&fragment.positions, &fragment.triangles)`.
///
/// # Errors
/// An option is out of range, or needs the whole mesh; the fragment has vertices that it does not own.
///
/// # Panics
/// The fragment is not an oriented manifold.
pub fn finish_collapses(
    fragment: Fragment,
    options: &Options,
    diagonal: f64,
    faces_before: usize,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(TriMesh, Run), SimplifyError> {
    options.check()?;
    let BlockRules { rules, is_start } =
        BlockRules::without_mesh(options, diagonal).ok_or(SimplifyError::Conflict {
            option: "a run in blocks",
            with: "options that need the whole mesh",
            cure: "use quadrics and a number of faces alone, or the whole mesh",
        })?;
    if fragment.own < fragment.positions.len() {
        return Err(SimplifyError::Conflict {
            option: "the end of a run",
            with: "a fragment that does not own all of its vertices",
            cure: "join all fragments first",
        });
    }
    let target = options.target.face_target(faces_before);
    let limits = Target { faces: Some(target), ratio: None, ..options.target };
    let (capacity, start) = (fragment.positions.len(), Instant::now());
    let mut flat = FlatMesh::from_fragment(fragment);
    if rules.record {
        flat.number_half_edges();
    }
    let observe = &mut |now: &Progress| observe(&Progress { faces_before, ..*now });
    if !is_start {
        let extent = Extent { limits: &limits, precision: Precision::Exact, snapshots: false };
        let done = collapse_flat_mesh(flat, capacity, rules, extent, observe);
        return Ok((done.left.mesh, done.run));
    }
    let switch_at = switch_at(options, faces_before, target).unwrap_or(faces_before);
    let rough = Target { faces: Some(switch_at), ..limits };
    let extent = Extent { limits: &rough, precision: Precision::About, snapshots: false };
    let first = collapse_flat_mesh(flat, capacity, rules, extent, observe);
    let time = limits.time.map(|time| time.saturating_sub(start.elapsed()));
    let (level, run) = go_on(first, options, Target { time, ..limits }, faces_before, observe);
    Ok((level.mesh, run))
}

/// Runs the greedy loop on the result of the blocks for a mesh that had `faces_before` faces.
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
    let rest = greedy_in_blocks(&mut mesh, quadrics, options, &limits, &mut |now| {
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

/// Runs the greedy loop, block by block while there are enough faces. `quadrics` are the quadrics that the vertices
/// have accumulated in an earlier run; empty if there was none.
fn greedy_in_blocks(
    mesh: &mut TriMesh,
    quadrics: Vec<Quadric>,
    options: &Options,
    limits: &Target,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Run {
    let drive: &Drive<'_> = &|mesh, quadrics, start, limits, observe| {
        let mut options = options.clone();
        options.target = *limits;
        collapse_on(mesh, quadrics, start, &options, observe)
    };
    let protect = &options.protect;
    collapse_driven(mesh, quadrics, protect, limits, drive, observe)
}
