//! Collapsing further for as long as the mesh stays within a distance of the original.
//!
//! A run that goes by a sum of squared distances meets a limit of the largest one in few places first.
//! Everywhere else there are collapses left that do not exceed it.

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_metric::{Surface, SurfaceError, sample_surface};

use crate::collapse::run::Phase;
use crate::error::SimplifyError;
use crate::finish::collapse_back::{CollapseBack, collapse_back_placed};
use crate::finish::finishing::Finished;
use crate::finish::fit::constraints::FitConstraints;
use crate::finish::observer::Observer;
use crate::limit::measure::{AchievedError, Measuring};
use crate::limit::tether::Tether;

/// How far below the limit the attempts to collapse a mesh further aim, relative to it. The points
/// that one has missed count in the next; after the last one the mesh is left as it is.
const SLACKS: [f64; 8] = [0.01, 0.02, 0.03, 0.04, 0.05, 0.1, 0.2, 0.3];

/// Samples that tell where an attempt has missed the limit.
const PROBES: usize = 200_000;

/// Collapses a mesh further that is within the limit. Returns the distance then, or `None` when the
/// mesh was left as it is, also because the observer said to stop.
pub(crate) fn squeeze_within(
    done: &mut Finished,
    measuring: &Measuring<'_>,
    limit: f64,
    to: &CollapseBack<'_>,
    observer: &mut Observer<'_>,
) -> Result<Option<AchievedError>, SimplifyError> {
    let original = measuring.original;
    let mut missed = Vec::new();
    for (slack, seed) in SLACKS.into_iter().zip(0..) {
        if observer.stops(Phase::Squeeze, &done.mesh) {
            return Ok(None);
        }
        let (mut next, mut constraints) = (done.mesh.clone(), done.constraints.clone());
        let aim = limit - slack * limit;
        let map = squeeze(&mut next, original, &mut constraints, aim, &missed, to, observer)?;
        if observer.stops(Phase::Measure, &next) {
            return Ok(None);
        }
        let (error, at) = measuring.measure(&next)?;
        if error.is_within(limit) {
            done.follow(&map);
            (done.mesh, done.constraints) = (next, constraints);
            return Ok(Some(error));
        }
        missed.push(at);
        missed.extend(beyond(original, aim, &next, seed)?);
    }
    Ok(None)
}

/// Samples of the original that are farther from a mesh than `limit`.
fn beyond(
    original: &Surface,
    limit: f64,
    mesh: &TriMesh,
    seed: u64,
) -> Result<Vec<DVec3>, SurfaceError> {
    let samples = sample_surface(original, PROBES, seed);
    let samples: Vec<DVec3> = samples.iter().map(|sample| sample.position).collect();
    let distances = Surface::new(mesh)?.distances(&samples);
    let far = samples.into_iter().zip(distances).filter(|&(_, distance)| distance > limit);
    Ok(far.map(|(sample, _)| sample).collect())
}

/// Samples of each face of the original, on average.
const SAMPLES_PER_FACE: usize = 8;

/// The most points, so that 32-bit numbers do for them.
const MOST_POINTS: usize = u32::MAX as usize - 1;

/// How many samples there are of so many triangles, besides `others`.
fn sample_count(triangles: usize, others: usize) -> usize {
    SAMPLES_PER_FACE.saturating_mul(triangles).min(MOST_POINTS.saturating_sub(others))
}

/// Collapses edges while the vertices, samples and some more points of the original stay within
/// `limit` of the mesh, and all faces that change within `limit` of the original. Returns, for each
/// vertex, the one that it has become.
fn squeeze(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &mut FitConstraints,
    limit: f64,
    more: &[DVec3],
    to: &CollapseBack<'_>,
    observer: &mut Observer<'_>,
) -> Result<VertexMap<Option<VertexId>>, SurfaceError> {
    let vertices = original.used_vertices().into_iter();
    let mut points: Vec<DVec3> = vertices.map(|v| original.positions()[v as usize]).collect();
    let samples = sample_count(original.triangle_count(), points.len() + more.len());
    points.extend(sample_surface(original, samples, 1).iter().map(|sample| sample.position));
    points.extend(more);
    let tether = Tether::new(mesh, original, &points, limit)?;
    let seen = (Phase::Squeeze, observer);
    let back = collapse_back_placed(mesh, constraints, to, tether, seen);
    *constraints = back.constraints;
    Ok(back.vertex_map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_numbered_by_32_bits_however_large_the_mesh_is() {
        assert_eq!(sample_count(1000, 502), 8000);
        let most = u32::MAX as usize;
        for (triangles, others) in [(500_000_000, 250_000_000), (600_000_000, 0), (most, most)] {
            assert!(sample_count(triangles, others).saturating_add(others) <= most);
        }
    }
}
