//! Collapsing further for as long as the mesh stays within a distance of the original.
//!
//! A run that goes by a sum of squared distances meets a limit of the largest one in few places first.
//! Everywhere else there are collapses left that do not exceed it.

use crate::collapse::run::Phase;
use crate::error::SimplifyError;
use crate::finish::collapse_back::{CollapseBack, collapse_back_placed};
use crate::finish::finishing::Finished;
use crate::finish::observer::Observer;
use crate::limit::measure::{AchievedError, Measuring};
use crate::limit::tether::{Tether, edges_of};

/// An attempt to collapse a mesh further.
struct Attempt {
    /// How far below the limit it aims, relative to that.
    slack: f64,
    /// Whether every new face is proved to be close enough at all its points.
    proves: bool,
}

const fn attempt(slack: f64, proves: bool) -> Attempt {
    Attempt { slack, proves }
}

/// The first one nearly always does. Where it does not, a face spans a fold: there the surfaces are no heights over
/// each other, and are farther apart than at their vertices and edges. After the last one the mesh is left
/// as it is.
const ATTEMPTS: [Attempt; 5] = [
    attempt(0.01, false),
    attempt(0.01, true),
    attempt(0.03, true),
    attempt(0.1, true),
    attempt(0.3, true),
];

/// Collapses a mesh further that is within the limit. Returns the distance then, or `None` when the
/// mesh was left as it is, also because the observer said to stop.
pub(crate) fn squeeze_within(
    done: &mut Finished,
    measuring: &Measuring<'_>,
    limit: f64,
    to: &CollapseBack<'_>,
    observer: &mut Observer<'_>,
) -> Result<Option<AchievedError>, SimplifyError> {
    let edges = edges_of(measuring.original);
    for Attempt { slack, proves } in ATTEMPTS {
        if observer.stops(Phase::Squeeze, &done.mesh) {
            return Ok(None);
        }
        let (mut next, constraints) = (done.mesh.clone(), done.constraints.clone());
        let aim = limit - slack * limit;
        let tether = Tether::new(&next, measuring.original, &edges, aim, proves)?;
        let seen = (Phase::Squeeze, &mut *observer);
        let back = collapse_back_placed(&mut next, &constraints, to, tether, seen);
        let (map, constraints) = (back.vertex_map, back.constraints);
        let Some(error) = measuring.measure(&next, observer)? else { return Ok(None) };
        if error.is_within(limit) {
            done.follow(&map);
            (done.mesh, done.constraints) = (next, constraints);
            return Ok(Some(error));
        }
    }
    Ok(None)
}
