//! About how far a run may go for its level to be within a distance of the original.

use std::borrow::Cow;

use glam::DVec3;
use mesh_core::{RemapOf, TriMesh};
use mesh_metric::Surface;

use crate::collapse::log::{CollapseLog, LogEntry, ReplayError};
use crate::collapse::run::Phase;
use crate::error::SimplifyError;
use crate::finish::observer::Observer;
use crate::limit::levels::between;

/// What is guessed about.
pub(crate) struct Guess<'a> {
    pub(crate) mesh: &'a TriMesh,
    /// The run on the mesh.
    pub(crate) log: &'a CollapseLog,
    pub(crate) original: &'a Surface,
    pub(crate) limit: f64,
    /// Whether the level, too, has to be as close to the original as that: there its vertices and the middles
    /// of its edges tell.
    pub(crate) both_ways: bool,
}

/// A mesh on the way, and the collapses that follow, in its numbers.
struct Stage<'a> {
    mesh: Cow<'a, TriMesh>,
    log: Cow<'a, CollapseLog>,
    /// How many collapses there were before it.
    done: usize,
}

/// Vertices of the original that are looked at together.
const BLOCK: usize = 1 << 16;

impl Guess<'_> {
    /// How many collapses there may be before the vertices of the original are farther from the level,
    /// as it is before it is finished, than the limit; or fewer, when the observer says to stop.
    pub(crate) fn collapses(&self, observer: &mut Observer<'_>) -> Result<usize, SimplifyError> {
        let used = self.original.used_vertices();
        let mut stage =
            Stage { mesh: Cow::Borrowed(self.mesh), log: Cow::Borrowed(self.log), done: 0 };
        let mut bad = self.log.len();
        let mut next = Some(bad);
        while let Some(collapses) = next {
            if observer.stops(Phase::Search, self.mesh) {
                break;
            }
            let level = stage.level(collapses)?;
            if self.is_within(&level, &used)? {
                stage = stage.moved_to(level, collapses, bad);
            } else {
                bad = collapses;
            }
            next = between(used.len(), stage.done, bad);
        }
        Ok(stage.done)
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

impl<'a> Stage<'a> {
    /// The mesh after more collapses, with the gaps that these leave.
    fn level(&self, collapses: usize) -> Result<TriMesh, ReplayError> {
        let mut mesh = TriMesh::clone(&self.mesh);
        self.log.carry_out(0..collapses - self.done, &mut mesh, |_, _, _| {})?;
        Ok(mesh)
    }

    /// The stage that a level is from which no more than `bad` collapses matter. Without its gaps it is
    /// much smaller than the mesh before.
    fn moved_to(self, mut level: TriMesh, collapses: usize, bad: usize) -> Self {
        let remap = level.compact();
        let of_level = |entry: &LogEntry| {
            Some(LogEntry {
                half_edge: remap.new_handle(entry.half_edge)?,
                removed: remap.new_handle(entry.removed)?,
                kept: remap.new_handle(entry.kept)?,
                ..*entry
            })
        };
        let left = &self.log.entries()[collapses - self.done..bad - self.done];
        let entries = left.iter().map_while(of_level).collect();
        let log = CollapseLog::from_entries(entries);
        Stage { mesh: Cow::Owned(level), log: Cow::Owned(log), done: collapses }
    }
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
            let guess = Guess { mesh: &mesh, log: &log, original, limit, both_ways };
            let is_within =
                |count| guess.is_within(&log.replay(&mesh, count).unwrap(), &used).unwrap();
            let count = guess.collapses(&mut Observer::none()).unwrap();
            let coarser = vertices - ((vertices - count) as f64 / 1.05) as usize;
            assert!(is_within(count) && (count == log.len() || !is_within(coarser)));
            found.push(count);
        }
        assert!(found.is_sorted() && found[0] > 100 && found[2] < log.len());
        assert_eq!(found[3], log.len());
    }
}
