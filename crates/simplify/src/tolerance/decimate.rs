//! Collapsing further for as long as the mesh stays within a distance of the original.
//!
//! A run that goes by a sum of squared distances meets a limit of the largest one in few places first.
//! Everywhere else there are collapses left that do not exceed it.

use mesh_collapse::Phase;
use mesh_core::TriMesh;
use mesh_refine::{CollapseBack, Observer, Refined, collapse_back_placed};

use crate::error::SimplifyError;
use crate::tolerance::distance_constraint::DistanceConstraint;
use crate::tolerance::measure::{AchievedError, Measuring};
use crate::tolerance::proofs::{Proofs, unproved};

/// An attempt to collapse a mesh further.
struct Attempt {
    /// How far below the limit it aims, relative to that.
    slack: f64,
    proved: Proved,
}

/// Where every new face is proved to be close enough at all its points.
enum Proved {
    Nowhere,
    /// Near the faces that were too far in the attempts before.
    WhereItFailed,
    Everywhere,
}

const fn attempt(slack: f64, proved: Proved) -> Attempt {
    Attempt { slack, proved }
}

/// The first one nearly always does. Where it does not, a face spans a fold: there the surfaces are no heights over
/// each other, and are farther apart than at their vertices and edges. That is so in few places as a rule. After the
/// last one the mesh is left as it is.
const ATTEMPTS: [Attempt; 7] = [
    attempt(0.01, Proved::Nowhere),
    attempt(0.01, Proved::WhereItFailed),
    attempt(0.01, Proved::WhereItFailed),
    attempt(0.01, Proved::Everywhere),
    attempt(0.03, Proved::Everywhere),
    attempt(0.1, Proved::Everywhere),
    attempt(0.3, Proved::Everywhere),
];

/// Collapses a level further, for as long as it stays within the limit. Returns how far what is there then is from
/// the original: that is beyond the limit only where the level is, which then is left as it was.
/// `None` when the observer says to stop before any of this is known.
///
/// The level itself is measured only when something is seen to be too far, or an attempt has failed: as a rule, what
/// becomes of it tells enough. So what an attempt has come to is measured even when the observer has said to
/// stop; without that there would be nothing to show for it.
pub(crate) fn decimate_to_tolerance(
    level: &mut Refined,
    original: &TriMesh,
    measuring: &Measuring<'_>,
    limit: f64,
    to: &CollapseBack<'_>,
    observer: &mut Observer<'_>,
) -> Result<Option<AchievedError>, SimplifyError> {
    let (mut own, mut failed, mut places) = (None, None, Vec::new());
    for Attempt { slack, proved } in ATTEMPTS {
        if observer.stops(Phase::DecimateToTolerance, &level.mesh) {
            break;
        }
        let proofs = match proved {
            Proved::Nowhere => Proofs::None,
            Proved::WhereItFailed => {
                let found = failed.take().map(|mesh| unproved(&mesh, measuring.original, limit));
                // Without any, the same would come of it again.
                let Some(found) = found.filter(|found| !found.is_empty()) else { continue };
                places.extend(found);
                Proofs::Near(&places)
            }
            Proved::Everywhere => Proofs::All,
        };
        let aim = limit - slack * limit;
        let topology = original.topology();
        let distance_constraint =
            DistanceConstraint::new(&level.mesh, topology, measuring.original, aim, proofs)?;
        if !distance_constraint.holds_all()
            && !is_within(&mut own, &level.mesh, measuring, limit, observer)?
        {
            break;
        }
        let (mut next, constraints) = (level.mesh.clone(), level.constraints.clone());
        let seen = (Phase::DecimateToTolerance, &mut *observer);
        let back = collapse_back_placed(&mut next, &constraints, to, distance_constraint, seen);
        let is_last = observer.stops(Phase::Measure, &next);
        let error = measuring.measure(&next, &mut Observer::none())?;
        if error.is_some_and(|error| error.is_within(limit)) {
            level.follow(&back.vertex_map);
            (level.mesh, level.constraints) = (next, back.constraints);
            return Ok(error);
        }
        if is_last || !is_within(&mut own, &level.mesh, measuring, limit, observer)? {
            break;
        }
        failed = Some(next);
    }
    Ok(own)
}

/// Whether a level is within the limit; `own` is how far it is, which is measured once.
fn is_within(
    own: &mut Option<AchievedError>,
    level: &TriMesh,
    measuring: &Measuring<'_>,
    limit: f64,
    observer: &mut Observer<'_>,
) -> Result<bool, SimplifyError> {
    if own.is_none() {
        *own = measuring.measure(level, observer)?;
    }
    Ok(own.is_some_and(|error| error.is_within(limit)))
}
