//! The coarsest level of a run that is within a distance of the original once it is finished.

use mesh_core::TriMesh;
use mesh_metric::{Surface, SurfaceError};

use crate::collapse::constraint::Marks;
use crate::collapse::level::Level;
use crate::collapse::log::CollapseLog;
use crate::error::SimplifyError;
use crate::finish::collapse_back::CollapseBack;
use crate::finish::finishing::{Finished, Finishing};
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

/// What a search found: a level, what was made of it, and how far that is from the original.
pub(crate) struct Found {
    pub(crate) collapses: usize,
    pub(crate) level: Level,
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
    pub(crate) fn run(&self) -> Result<Found, SimplifyError> {
        let total = self.log.len();
        let mut collapses = self.guess()?;
        let (mut good, mut bad): (Option<Found>, Option<usize>) = (None, None);
        loop {
            let found = self.attempt(collapses)?;
            if found.error.is_within(self.limit) {
                if collapses == total {
                    return Ok(found);
                }
                good = Some(found);
            } else if collapses == 0 {
                return Ok(found);
            } else {
                bad = Some(collapses);
            }
            let next = match (&good, bad) {
                (Some(_), _) if self.squeeze.is_some() => None,
                (Some(good), Some(bad)) => self.between(good.collapses, bad),
                (Some(good), None) => Some(self.scaled(good.collapses, 0.8).min(total)),
                (None, _) => Some(self.scaled(collapses, 1.3)),
            };
            match (next, good.take_if(|_| next.is_none())) {
                (Some(next), _) => collapses = next,
                (None, Some(found)) => return Ok(self.squeezed(found)?),
                (None, None) => collapses = 0,
            }
        }
    }

    /// A level, finished unless it is to be collapsed further, and measured.
    fn attempt(&self, collapses: usize) -> Result<Found, SimplifyError> {
        let level = self.level(collapses)?;
        let finished = if self.squeeze.is_some() && collapses < self.log.len() {
            self.finishing.leave(&level)
        } else {
            self.finishing.finish(&level)?
        };
        let (error, _) = self.measuring.measure(&finished.mesh)?;
        Ok(Found { collapses, level, finished, error })
    }

    fn squeezed(&self, mut found: Found) -> Result<Found, SurfaceError> {
        if let Some(to) = &self.squeeze
            && let Some(error) =
                squeeze_within(&mut found.finished, &self.measuring, self.limit, to)?
        {
            found.error = error;
        }
        Ok(found)
    }

    /// The number of collapses that leaves `factor` times as many vertices, at least one more or
    /// less.
    fn scaled(&self, collapses: usize, factor: f64) -> usize {
        let vertices = self.mesh.topology().vertex_count();
        let left = ((vertices - collapses) as f64 * factor) as usize;
        let changed = vertices - left.min(vertices);
        if factor < 1.0 { changed.max(collapses + 1) } else { changed.min(collapses - 1) }
    }

    /// A number of collapses between two; `None` when they are close enough.
    fn between(&self, good: usize, bad: usize) -> Option<usize> {
        let vertices = self.mesh.topology().vertex_count();
        let [more, fewer] = [good, bad].map(|collapses| (vertices - collapses).max(1) as f64);
        if bad <= good + 1 || more < RESOLUTION * fewer {
            return None;
        }
        let middle = vertices - (more * fewer).sqrt() as usize;
        Some(middle.clamp(good + 1, bad - 1))
    }

    /// How many collapses there may be before the vertices of the original are farther from the
    /// level, as it is before it is finished, than the limit.
    fn guess(&self) -> Result<usize, SimplifyError> {
        let is_within = |collapses: usize| -> Result<bool, SimplifyError> {
            let surface = Surface::new(&self.level(collapses)?.mesh)?;
            let distances = surface.distances(self.measuring.original.positions());
            Ok(distances.into_iter().all(|distance| distance <= self.limit))
        };
        let (mut good, mut bad) = (0, self.log.len());
        if is_within(bad)? {
            return Ok(bad);
        }
        while let Some(middle) = self.between(good, bad) {
            *(if is_within(middle)? { &mut good } else { &mut bad }) = middle;
        }
        Ok(good)
    }

    fn level(&self, collapses: usize) -> Result<Level, SimplifyError> {
        Ok(Level::new(self.mesh, &self.marks, self.log, collapses)?)
    }
}
