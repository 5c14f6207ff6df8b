//! About how far a run may go for its level to be within a distance of the original.

use core::ops::Range;

use glam::DVec3;
use mesh_core::{Remap, RemapOf, TriMesh};
use mesh_metric::Surface;

use crate::collapse::constraint::Marks;
use crate::collapse::level::{Level, with_gaps};
use crate::collapse::log::{CollapseLog, LogEntry};
use crate::collapse::run::Phase;
use crate::error::SimplifyError;
use crate::finish::observer::Observer;
use crate::limit::levels::{between, scaled};

/// What is guessed about.
pub(crate) struct Guess<'a> {
    pub(crate) mesh: &'a TriMesh,
    pub(crate) marks: &'a Marks,
    /// The run on the mesh.
    pub(crate) log: &'a CollapseLog,
    pub(crate) original: &'a Surface,
    pub(crate) limit: f64,
    /// Whether the level, too, has to be as close to the original as that: there its vertices and the middles
    /// of its edges tell.
    pub(crate) both_ways: bool,
}

/// A level on the way, without its gaps much smaller than the mesh, and the collapses that follow, in its numbers.
struct Stage {
    level: Level,
    log: CollapseLog,
    /// How many collapses there were before it.
    done: usize,
}

/// The part of the vertices that is left from one stage to the next, until that is too few.
const STEP: f64 = 0.125;

/// Vertices of the original that are looked at together.
const BLOCK: usize = 1 << 16;

impl Guess<'_> {
    /// The level before the vertices of the original are farther from it, as it is before it is finished, than the
    /// limit, or a finer one, when the observer says to stop; and the number of collapses to it.
    pub(crate) fn level(
        &self,
        observer: &mut Observer<'_>,
    ) -> Result<(Level, usize), SimplifyError> {
        let (used, total) = (self.original.used_vertices(), self.log.len());
        let (mut stage, mut bad): (Option<Stage>, Option<usize>) = (None, None);
        loop {
            let done = stage.as_ref().map_or(0, |stage| stage.done);
            let next = match bad {
                Some(bad) => between(used.len(), done, bad),
                None => (done < total).then(|| scaled(used.len(), done, STEP).min(total)),
            };
            let Some(next) = next.filter(|_| !observer.stops(Phase::Search, self.mesh)) else {
                break;
            };
            let (mesh, marks, log) = match &stage {
                Some(Stage { level, log, .. }) => (&level.mesh, &level.marks, log),
                None => (self.mesh, self.marks, self.log),
            };
            let (mesh, marks) = with_gaps(mesh, marks, log, next - done)?;
            if self.is_within(&mesh, &used)? {
                let (level, remap) = Level::compacted(mesh, &marks, log, next - done);
                let log = following(log, next - done..bad.unwrap_or(total) - done, &remap);
                let level = match stage {
                    Some(stage) => stage.level.followed_by(level),
                    None => level,
                };
                stage = Some(Stage { level, log, done: next });
            } else {
                bad = Some(next);
            }
        }
        match stage {
            Some(Stage { level, done, .. }) => Ok((level, done)),
            None => Ok((Level::new(self.mesh, self.marks, self.log, 0)?, 0)),
        }
    }

    fn is_within(&self, level: &TriMesh, used: &[u32]) -> Result<bool, SimplifyError> {
        // These points are fewer.
        if self.both_ways && !self.original.are_within(&vertices_and_middles(level), self.limit) {
            return Ok(false);
        }
        let surface = Surface::new(level)?;
        let at = |&v: &u32| self.original.positions()[v as usize];
        let mut blocks = used.chunks(BLOCK);
        Ok(blocks
            .all(|some| surface.are_within(&some.iter().map(at).collect::<Vec<_>>(), self.limit)))
    }
}

/// Some of the collapses of a log, in the numbers of a level without gaps that comes before them.
fn following(log: &CollapseLog, collapses: Range<usize>, remap: &Remap) -> CollapseLog {
    let of_level = |entry: &LogEntry| {
        Some(LogEntry {
            half_edge: remap.new_handle(entry.half_edge)?,
            removed: remap.new_handle(entry.removed)?,
            kept: remap.new_handle(entry.kept)?,
            ..*entry
        })
    };
    let entries = log.entries().iter().take(collapses.end).skip(collapses.start);
    CollapseLog::from_entries(entries.map_while(of_level).collect())
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
    use crate::options::Options;
    use crate::preset::Preset;
    use crate::simplify::simplify;
    use mesh_core::shapes::{Irregular, Wave};

    /// Found by going on from levels without gaps; looked at by replays of the original.
    #[test]
    fn the_level_is_within_the_limit_and_much_coarser_ones_are_not() {
        let wave = Wave { amplitude: 0.15, wavelength: 0.7, half_width: 1.0 };
        let soup = wave.irregular_mesh(60, Irregular { jitter: 0.2, seed: 4 }).unwrap();
        let mesh = TriMesh::from_soup(&soup).unwrap();
        let log = simplify(&mesh, &Options::preset(Preset::Fast).to_faces(0)).unwrap().log;
        let original = &Surface::new(&mesh).unwrap();
        let (used, vertices) = (original.used_vertices(), mesh.topology().vertex_count());
        let mut found = Vec::new();
        for (limit, both_ways) in [(0.002, true), (0.01, true), (0.01, false), (10.0, true)] {
            let marks = &Marks::default();
            let guess = Guess { mesh: &mesh, marks, log: &log, original, limit, both_ways };
            let is_within =
                |count| guess.is_within(&log.replay(&mesh, count).unwrap(), &used).unwrap();
            let (level, count) = guess.level(&mut Observer::none()).unwrap();
            let replayed = Level::new(&mesh, marks, &log, count).unwrap();
            assert_eq!(level.mesh.positions(), replayed.mesh.positions());
            assert!(level.mesh.topology().triangles().eq(replayed.mesh.topology().triangles()));
            assert_eq!(level.became, replayed.became);
            let coarser = vertices - ((vertices - count) as f64 / 1.05) as usize;
            assert!(is_within(count) && (count == log.len() || !is_within(coarser)));
            found.push(count);
        }
        assert!(found.is_sorted() && found[0] > 100 && found[2] < log.len());
        assert_eq!(found[3], log.len());
    }
}
