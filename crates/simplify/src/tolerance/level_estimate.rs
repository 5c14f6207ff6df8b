//! Estimate of the number of collapses whose level is within a distance of the original.

use core::ops::Range;

use glam::DVec3;
use mesh_core::{Handle, Remap, RemapOf, TriMesh, VertexMap};
use mesh_metric::Surface;

use crate::error::SimplifyError;
use crate::tolerance::bisection::{between, scaled};
use mesh_collapse::{CollapseLog, Level, LogEntry, Phase, Protected, Snapshot, with_gaps};
use mesh_refine::Observer;

/// Input of the estimate.
pub(crate) struct LevelEstimate<'a> {
    pub(crate) mesh: &'a TriMesh,
    pub(crate) protected: &'a Protected,
    /// The run on the mesh.
    pub(crate) log: &'a CollapseLog,
    pub(crate) original: &'a Surface,
    pub(crate) limit: f64,
    /// Whether the level must also be close to the original. This is tested at its vertices and at the middles of its
    /// edges.
    pub(crate) both_ways: bool,
}

/// A level of the run, stored without gaps, and the collapses that follow, with the handles of this level.
struct Stage {
    level: Level,
    log: CollapseLog,
    /// Number of collapses before this level.
    done: usize,
}

/// The ratio of vertices between two stages, as long as the levels are within the limit.
const STEP: f64 = 0.125;

/// The fraction of the limit at which points of a level must lie. Between these points the level may be a little
/// farther away; without the margin, all work on it could be wasted. The margin leaves a few more faces, which later
/// collapses remove.
const BETWEEN: f64 = 0.97;

/// Vertices of the original in one query.
const BLOCK: usize = 1 << 16;

impl LevelEstimate<'_> {
    /// The number of collapses at which the vertices of the original are still within the limit of the level before it
    /// is finished, and that level. A finer level when the observer stops the search. If the run has left snapshots,
    /// the search continues from them.
    pub(crate) fn level(
        &self,
        snapshots: Vec<Snapshot>,
        observer: &mut Observer<'_>,
    ) -> Result<(Level, usize), SimplifyError> {
        let (used, total) = (self.original.used_vertices(), self.log.len());
        // Stages after the current one. Whether they are within the limit is not known yet.
        let (mut stage, mut bad): (Option<Stage>, Option<usize>) = (None, None);
        let mut others: Vec<Stage> =
            snapshots.into_iter().map(|snapshot| self.stage(snapshot)).collect();
        loop {
            let done = stage.as_ref().map_or(0, |stage| stage.done);
            let next = match bad {
                // A stage that exists already needs no replay.
                Some(bad) => between(used.len(), done, bad)
                    .map(|next| others.last().map_or(next, |other| other.done)),
                None => (done < total).then(|| scaled(used.len(), done, STEP).min(total)),
            };
            let Some(next) = next.filter(|_| !observer.stops(Phase::Search, self.mesh)) else {
                break;
            };
            let coarser = others.split_off(others.partition_point(|other| other.done <= next));
            let (mesh, protected, log, done) = match others.last().or(stage.as_ref()) {
                Some(Stage { level, log, done }) => (&level.mesh, &level.protected, log, *done),
                None => (self.mesh, self.protected, self.log, 0),
            };
            let within = self.within((mesh, protected, log), next - done, &used)?;
            if let Some((level, remap)) = within {
                let new = |entry: &LogEntry| {
                    entry.renumbered(|h| remap.new_handle(h), |v| remap.new_handle(v))
                };
                let log = following(log, next - done..bad.unwrap_or(total) - done, new);
                let level = match others.pop().or(stage) {
                    Some(stage) => stage.level.followed_by(level),
                    None => level,
                };
                (stage, others) = (Some(Stage { level, log, done: next }), coarser);
            } else {
                bad = Some(next);
                others.retain(|other| other.done < next);
            }
        }
        match stage {
            Some(Stage { level, done, .. }) => Ok((level, done)),
            None => Ok((Level::new(self.mesh, self.protected, self.log, 0)?, 0)),
        }
    }

    /// The stage of a snapshot of a run without protected elements.
    fn stage(&self, snapshot: Snapshot) -> Stage {
        let Snapshot { mesh, vertices, half_edges, collapses: done } = snapshot;
        let topology = self.mesh.topology();
        let vertices = inverse(&vertices, topology.vertex_capacity());
        let half_edges = inverse(&half_edges, topology.half_edge_capacity());
        let new =
            |entry: &LogEntry| entry.renumbered(|h| half_edges[h.index()], |v| vertices[v.index()]);
        let log = following(self.log, done..self.log.len(), new);
        let vertex_map = self.log.representatives(self.mesh, done);
        let vertex_map = vertex_map.as_slice().iter().map(|v| vertices[v.index()]).collect();
        let level = Level {
            mesh,
            protected: Protected::default(),
            vertex_map: VertexMap::from_vec(vertex_map),
        };
        Stage { level, log, done }
    }

    /// The level after `collapses` collapses on a mesh, with the map of its handles, if it is within the limit.
    fn within(
        &self,
        (mesh, protected, log): (&TriMesh, &Protected, &CollapseLog),
        collapses: usize,
        used: &[u32],
    ) -> Result<Option<(Level, Remap)>, SimplifyError> {
        let (mesh, protected) = with_gaps(mesh, protected, log, collapses)?;
        if !self.is_near(&mesh) {
            return Ok(None);
        }
        // Without gaps the search tree of the surface takes less memory.
        let (level, remap) = Level::compacted(mesh, &protected, log, collapses);
        Ok(self.has_near(&level.mesh, used)?.then_some((level, remap)))
    }

    /// Whether the points of the level are near the original, if that is required. There are fewer of them than
    /// vertices of the original.
    fn is_near(&self, level: &TriMesh) -> bool {
        !self.both_ways
            || self.original.are_within(&vertices_and_middles(level), BETWEEN * self.limit)
    }

    /// Whether the vertices of the original are near the level.
    fn has_near(&self, level: &TriMesh, used: &[u32]) -> Result<bool, SimplifyError> {
        let surface = Surface::new(level)?;
        let at = |&v: &u32| self.original.positions()[v as usize];
        let mut blocks = used.chunks(BLOCK);
        Ok(blocks
            .all(|some| surface.are_within(&some.iter().map(at).collect::<Vec<_>>(), self.limit)))
    }
}

/// A range of the collapses of a log, translated by `new` into the handles of a level without gaps.
fn following(
    log: &CollapseLog,
    collapses: Range<usize>,
    new: impl Fn(&LogEntry) -> Option<LogEntry>,
) -> CollapseLog {
    let entries = log.entries().iter().take(collapses.end).skip(collapses.start);
    CollapseLog::from_entries(entries.map_while(new).collect())
}

/// The inverse of a list of old handles: for each old handle below `capacity`, the new one.
fn inverse<H: Handle>(old: &[H], capacity: usize) -> Vec<Option<H>> {
    let mut new = vec![None; capacity];
    old.iter().enumerate().for_each(|(i, old)| new[old.index()] = Some(H::from_index(i)));
    new
}

/// The vertices of a mesh that have faces, and the middles of its edges.
fn vertices_and_middles(mesh: &TriMesh) -> Vec<DVec3> {
    let topology = mesh.topology();
    let middles = topology.edges().map(|edge| {
        let [p, q] = topology.edge_vertices(edge).map(|v| mesh.position(v));
        p + 0.5 * (q - p)
    });
    let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
    used.map(|v| mesh.position(v)).chain(middles).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collapse::collapse_to_level;
    use crate::options::Options;
    use crate::plan::Plan;
    use crate::preset::Preset;
    use crate::tolerance::measure::ErrorCheck;
    use core::ops::ControlFlow;
    use mesh_shapes::{Irregular, Wave};

    fn wave(cells: usize) -> TriMesh {
        let wave = Wave { amplitude: 0.15, wavelength: 0.7, half_width: 1.0 };
        let soup = wave.irregular_mesh(cells, Irregular { jitter: 0.2, seed: 4 }).unwrap();
        TriMesh::from_soup(&soup).unwrap()
    }

    fn assert_same(level: &Level, other: &Level) {
        assert_eq!(level.mesh.positions(), other.mesh.positions());
        assert!(level.mesh.topology().triangles().eq(other.mesh.topology().triangles()));
        assert_eq!(level.vertex_map, other.vertex_map);
    }

    /// The estimate continues from compacted levels, and from snapshots of block passes if there are any. The test
    /// compares it with replays on the original.
    #[test]
    fn the_level_is_within_the_limit_and_much_coarser_ones_are_not() {
        for (cells, passes) in [(60, 0), (220, 1)] {
            let mesh = wave(cells);
            let options = Options::preset(Preset::Fast).to_faces(0);
            let options = options.within(1.0, ErrorCheck::Sampled);
            let (_, run) = {
                let plan = Plan::of(&options, &mesh);
                collapse_to_level(&mesh, plan, &options, &mut |_| ControlFlow::Continue(()))
            };
            let (log, snapshots) = (run.log, run.snapshots);
            assert_eq!(snapshots.len(), passes);
            let original = &Surface::new(&mesh).unwrap();
            let (used, vertices) = (original.used_vertices(), mesh.topology().vertex_count());
            let protected = &Protected::default();
            let mut found = Vec::new();
            for (limit, both_ways) in
                [(1e-5, true), (0.002, true), (0.01, true), (0.01, false), (10.0, true)]
            {
                let estimate =
                    LevelEstimate { mesh: &mesh, protected, log: &log, original, limit, both_ways };
                for snapshot in &snapshots {
                    let stage = estimate.stage(snapshot.clone());
                    let replayed = Level::new(&mesh, protected, &log, stage.done).unwrap();
                    assert_same(&stage.level, &replayed);
                    assert!(stage.done > 0 && stage.log.len() == log.len() - stage.done);
                }
                let is_within = |count| {
                    let level = log.replay(&mesh, count).unwrap();
                    estimate.is_near(&level) && estimate.has_near(&level, &used).unwrap()
                };
                let (level, count) =
                    estimate.level(snapshots.clone(), &mut Observer::none()).unwrap();
                assert_same(&level, &Level::new(&mesh, protected, &log, count).unwrap());
                let coarser = vertices - ((vertices - count) as f64 / 1.05) as usize;
                assert!(is_within(count) && (count == log.len() || !is_within(coarser)));
                found.push(count);
            }
            assert!(found.is_sorted() && found[1] > 100 && found[3] < log.len());
            assert_eq!(found[4], log.len());
            // The snapshots lie between the finest and the coarsest result.
            assert!(snapshots.iter().all(|left| (found[0]..found[4]).contains(&left.collapses)));
        }
    }
}
