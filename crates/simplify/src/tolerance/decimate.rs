//! Decimation to a tolerance: collapses a level further while it stays within a distance of the original.
//!
//! A run that is ordered by squared distances reaches an error limit in a few places first. Everywhere else, more
//! collapses are possible within the limit.

use mesh_collapse::Phase;
use mesh_core::TriMesh;
use mesh_metric::Surface;
use mesh_refine::{CollapseBack, Observer, Refined, collapse_back_placed};

use crate::error::SimplifyError;
use crate::tolerance::distance_constraint::DistanceConstraint;
use crate::tolerance::measure::{AchievedError, Measuring};
use crate::tolerance::proofs::{Ball, Proofs, faces_near, unproved};

/// An attempt to collapse a mesh further.
struct Attempt {
    /// The margin below the limit, relative to the limit.
    slack: f64,
    proved: Proved,
}

/// Where every new face is proved to be close enough at all its points.
enum Proved {
    Nowhere,
    /// Near the faces that were too far away in earlier attempts.
    WhereItFailed,
    Everywhere,
}

const fn attempt(slack: f64, proved: Proved) -> Attempt {
    Attempt { slack, proved }
}

/// The first attempt nearly always succeeds. It fails where a face spans a fold: there, neither surface is a height
/// field over the other, and the largest distance may lie inside a face. If that is a face of the result, later
/// attempts prove new faces. If it is a face of the original, for example a wall inside a pipe whose edges all lie on
/// the pipe, later attempts keep the faces near it. After the last attempt the mesh stays as it is.
const ATTEMPTS: [Attempt; 7] = [
    attempt(0.01, Proved::Nowhere),
    attempt(0.01, Proved::WhereItFailed),
    attempt(0.01, Proved::WhereItFailed),
    attempt(0.01, Proved::Everywhere),
    attempt(0.03, Proved::Everywhere),
    attempt(0.1, Proved::Everywhere),
    attempt(0.3, Proved::Everywhere),
];

/// Collapses a level further while it stays within the limit. Returns the distance of the result from the original. If
/// even the level is beyond the limit, it stays unchanged, and the distance returned is the distance of the level.
/// `None` when the observer stops before any distance is known.
///
/// The level itself is measured only if an edge of the original is too far from it, or if an attempt fails. The result
/// of an attempt is measured even when the observer has asked to stop: without a measurement the attempt would be lost.
pub(crate) fn decimate_to_tolerance(
    level: &mut Refined,
    original: &TriMesh,
    measuring: &Measuring<'_>,
    limit: f64,
    to: &CollapseBack<'_>,
    observer: &mut Observer<'_>,
) -> Result<Option<AchievedError>, SimplifyError> {
    let (mut own, mut failed) = (None, None::<TriMesh>);
    let (mut places, mut lost) = (Vec::new(), Vec::new());
    for Attempt { slack, proved } in ATTEMPTS {
        if observer.stops(Phase::DecimateToTolerance, &level.mesh) {
            break;
        }
        let known = (places.len(), lost.len());
        if let Some(failed) = failed.take() {
            if matches!(proved, Proved::WhereItFailed) {
                let far = unproved(&failed, measuring.original, limit);
                places.extend(far.into_iter().map(Ball::round));
            }
            lost.extend(unproved(original, &Surface::new(&failed)?, limit));
        }
        let proofs = match proved {
            Proved::Nowhere => Proofs::None,
            // If every face is proved, another attempt of this kind would give the same result.
            Proved::WhereItFailed if known == (places.len(), lost.len()) => continue,
            Proved::WhereItFailed => Proofs::Near(&places),
            Proved::Everywhere => Proofs::All,
        };
        let aim = limit - slack * limit;
        let topology = original.topology();
        let mut distance_constraint =
            DistanceConstraint::new(&level.mesh, topology, measuring.original, aim, proofs)?;
        distance_constraint.keep(faces_near(&level.mesh, &lost, limit));
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

/// Whether a level is within the limit. `own` keeps its distance, which is measured once.
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
