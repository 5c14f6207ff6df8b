//! In which steps edges are collapsed: by the driver, in regions, or first in these and then by the
//! driver.

use core::ops::ControlFlow;
use std::time::Instant;

use mesh_core::{TriMesh, VertexMap};

use crate::collapse::constraint::Marks;
use crate::collapse::level::Level;
use crate::collapse::log::{CollapseLog, LogEntry};
use crate::collapse::run::{Progress, Run};
use crate::collapse::stop::{Limits, StopReason};
use crate::named::{Regional, collapse, collapse_rest, regional};
use crate::options::Options;
use crate::regions::run::{self as regions, End, collapse_in_regions};

/// The metrics that regions do not know take over at so many times the faces that are wanted.
const REST: usize = 24;

/// With fewer faces there is little time to be saved, and the largest error is a matter of single edges.
const LARGE: usize = 100_000;

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
    match regional(mesh, options) {
        Some(Regional { rules, is_start: false }) => {
            let regions::Regional { mesh, became, run, .. } =
                collapse_in_regions(mesh, rules, limits, End::Exact, observe);
            (Level { mesh, marks: Marks::default(), became }, run)
        }
        Some(Regional { rules, is_start: true })
            if faces >= LARGE.max(2 * REST * target) && target > 0 =>
        {
            let rough = Limits { faces: Some(REST * target), ratio: None, ..*limits };
            let first = collapse_in_regions(mesh, rules, &rough, End::Rough, observe);
            let left = Limits {
                faces: Some(target),
                ratio: None,
                time: limits.time.map(|time| time.saturating_sub(start.elapsed())),
                ..*limits
            };
            go_on(first, options, left, faces, observe)
        }
        _ => {
            let mut working = mesh.clone();
            let run = collapse(&mut working, options, observe);
            (Level::at_end(working, &run), run)
        }
    }
}

/// Runs the driver on what regions have left of a mesh of so many faces.
fn go_on(
    first: regions::Regional,
    options: &Options,
    limits: Limits,
    faces_before: usize,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> (Level, Run) {
    let regions::Regional { mut mesh, became, quadrics, vertices, half_edges, mut run } = first;
    if run.stop != StopReason::Faces || quadrics.is_empty() {
        return (Level { mesh, marks: Marks::default(), became }, run);
    }
    let mut options = options.clone();
    options.collapse.limits = limits;
    let done = run.collapses;
    let rest = collapse_rest(&mut mesh, quadrics, &options, &mut |now| {
        observe(&Progress { faces_before, collapses: done + now.collapses, ..*now })
    });
    let level = Level::at_end(mesh, &rest);
    let became = became.as_slice().iter().map(|v| v.and_then(|v| level.became[v])).collect();
    if options.collapse.record {
        let entry = |entry: &LogEntry| LogEntry {
            half_edge: half_edges[entry.half_edge.index()],
            removed: vertices[entry.removed.index()],
            kept: vertices[entry.kept.index()],
            ..*entry
        };
        let mut entries = run.log.into_entries();
        entries.extend(rest.log.entries().iter().map(entry));
        run.log = CollapseLog::from_entries(entries);
    }
    run.refusals.add(&rest.refusals);
    let run =
        Run { stop: rest.stop, collapses: done + rest.collapses, max_cost: rest.max_cost, ..run };
    (Level { became: VertexMap::from_vec(became), ..level }, run)
}
