//! The coarsest level of a run that is within a distance of the original once it is finished.

use std::borrow::Cow;

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;

use crate::collapse::constraint::Marks;
use crate::collapse::level::Level;
use crate::collapse::log::CollapseLog;
use crate::collapse::run::Phase;
use crate::error::SimplifyError;
use crate::finish::collapse_back::CollapseBack;
use crate::finish::finishing::{Finished, Finishing};
use crate::finish::observer::Observer;
use crate::limit::measure::{AchievedError, Measuring};
use crate::limit::squeeze::squeeze_within;

/// What is searched, and for what.
pub(crate) struct Search<'a> {
    pub(crate) mesh: &'a TriMesh,
    /// The locked vertices and feature edges of the mesh.
    pub(crate) marks: Marks,
    /// The run on the mesh.
    pub(crate) log: &'a CollapseLog,
    pub(crate) finishing: &'a Finishing<'a>,
    pub(crate) measuring: Measuring<'a>,
    pub(crate) limit: f64,
    /// Whether and to what end a level within the limit is collapsed further, instead of being
    /// finished.
    pub(crate) squeeze: Option<CollapseBack<'a>>,
}

/// What a search found: a level, by what the vertices of the original are in it, what was made of it,
/// and how far that is from the original.
pub(crate) struct Found {
    pub(crate) collapses: usize,
    pub(crate) became: VertexMap<Option<VertexId>>,
    pub(crate) finished: Finished,
    pub(crate) error: AchievedError,
}

/// Levels whose numbers of faces are closer than this ratio are not told apart.
const RESOLUTION: f64 = 1.03;

impl Search<'_> {
    /// The coarsest level whose finished mesh is within the limit; the original when not even that
    /// is measured to be within the limit of itself. Errors do not grow strictly with the number of
    /// collapses, so that a coarser one may exist. Where the level is collapsed further anyway, the
    /// first one that is found will do, and it is not finished.
    ///
    /// When the observer says to stop, it is the coarsest one that was measured to be within the
    /// limit by then; `None` when none was.
    pub(crate) fn run(&self, observer: &mut Observer<'_>) -> Result<Option<Found>, SimplifyError> {
        let total = self.log.len();
        let mut collapses = self.guess(observer)?;
        let (mut good, mut bad): (Option<Found>, Option<usize>) = (None, None);
        loop {
            let Some(found) = self.attempt(collapses, observer)? else { return Ok(good) };
            let is_within = found.error.is_within(self.limit);
            if collapses == if is_within { total } else { 0 }
                || (is_within && self.squeeze.is_some())
            {
                return Ok(Some(found));
            } else if is_within {
                good = Some(found);
            } else {
                bad = Some(collapses);
            }
            collapses = match (good.as_ref().map(|good| good.collapses), bad) {
                (Some(good), None) => self.scaled(good, 0.8).min(total),
                // Collapsing further makes up for what is gone back too far.
                (None, _) => self.scaled(collapses, if self.squeeze.is_some() { 1.7 } else { 1.3 }),
                (Some(more), Some(fewer)) => match self.between(more, fewer) {
                    Some(middle) => middle,
                    None => return Ok(good),
                },
            };
        }
    }

    /// A level, collapsed further or finished, and measured; `None` when the observer says to stop before
    /// that.
    fn attempt(
        &self,
        collapses: usize,
        observer: &mut Observer<'_>,
    ) -> Result<Option<Found>, SimplifyError> {
        if observer.stops(Phase::Search, self.mesh) {
            return Ok(None);
        }
        let level = self.level(collapses)?;
        let (finished, became, error) = match &self.squeeze {
            Some(to) if collapses < self.log.len() => {
                let (mut level, became) = self.finishing.leave(level);
                let error = squeeze_within(&mut level, &self.measuring, self.limit, to, observer)?;
                (level, became, error)
            }
            _ => {
                let (finished, became) = self.finishing.finish(level, observer)?;
                let error = self.measuring.measure(&finished.mesh, observer)?;
                (finished, became, error)
            }
        };
        Ok(error.map(|error| Found { collapses, became, finished, error }))
    }

    fn scaled(&self, collapses: usize, factor: f64) -> usize {
        scaled(used_vertices(self.mesh), collapses, factor)
    }

    /// A number of collapses between two; `None` when they are close enough.
    fn between(&self, good: usize, bad: usize) -> Option<usize> {
        let vertices = used_vertices(self.mesh);
        let [more, fewer] = [good, bad].map(|collapses| (vertices - collapses).max(1) as f64);
        if bad <= good + 1 || more < RESOLUTION * fewer {
            return None;
        }
        let middle = vertices - (more * fewer).sqrt() as usize;
        Some(middle.clamp(good + 1, bad - 1))
    }

    /// How many collapses there may be before the vertices of the original are farther from the
    /// level, as it is before it is finished, than the limit; or fewer, when the observer says to
    /// stop. What is not finished has to be as close to the original as that in the other direction,
    /// too: there its vertices and the middles of its edges tell.
    fn guess(&self, observer: &mut Observer<'_>) -> Result<usize, SimplifyError> {
        let original = self.measuring.original;
        let at = |v: u32| original.positions()[v as usize];
        let used: Vec<DVec3> = original.used_vertices().into_iter().map(at).collect();
        let is_within = |mesh: &TriMesh| -> Result<bool, SimplifyError> {
            // These points are fewer.
            if self.squeeze.is_some()
                && !original.are_within(&vertices_and_middles(mesh), self.limit)
            {
                return Ok(false);
            }
            Ok(Surface::new(mesh)?.are_within(&used, self.limit))
        };
        // The coarsest one that is, with the gaps that collapses leave: others go on from there.
        let mut coarsest = Cow::Borrowed(self.mesh);
        let (mut good, mut bad) = (0, self.log.len());
        let mut next = Some(bad);
        while let Some(collapses) = next {
            if observer.stops(Phase::Search, self.mesh) {
                break;
            }
            let mut mesh = TriMesh::clone(&coarsest);
            self.log.carry_out(good..collapses, &mut mesh, &mut Marks::default())?;
            if is_within(&mesh)? {
                (good, coarsest) = (collapses, Cow::Owned(mesh));
            } else {
                bad = collapses;
            }
            next = self.between(good, bad);
        }
        Ok(good)
    }

    fn level(&self, collapses: usize) -> Result<Level, SimplifyError> {
        Ok(Level::new(self.mesh, &self.marks, self.log, collapses)?)
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

/// The number of vertices that have faces.
fn used_vertices(mesh: &TriMesh) -> usize {
    let topology = mesh.topology();
    topology.vertices().filter(|&v| !topology.is_isolated_vertex(v)).count()
}

/// The number of collapses that leaves `factor` times as many of the vertices, at least one more or less.
fn scaled(vertices: usize, collapses: usize, factor: f64) -> usize {
    let left = ((vertices - collapses) as f64 * factor) as usize;
    let changed = vertices - left.min(vertices);
    if factor < 1.0 { changed.max(collapses + 1) } else { changed.min(collapses - 1) }
}

#[cfg(test)]
mod tests {
    use super::scaled;

    #[test]
    fn a_number_of_collapses_is_scaled_by_the_vertices_that_it_leaves() {
        // 80 are left, then 64; 40 are left, then 52.
        assert_eq!(scaled(100, 20, 0.8), 36);
        assert_eq!(scaled(100, 60, 1.3), 48);
        assert_eq!(scaled(100, 0, 0.8), 20);
        // There are no more than all.
        assert_eq!(scaled(100, 10, 1.3), 0);
        // Three are left, which is too few for the factor to matter; four fifths of one are none.
        assert_eq!(scaled(10, 7, 1.3), 6);
        assert_eq!(scaled(10, 9, 0.8), 10);
    }
}
