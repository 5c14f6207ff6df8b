//! Collapsing further for as long as the mesh stays within a distance of the original.
//!
//! A run that goes by a sum of squared distances meets a limit of the largest one in few places first.
//! Everywhere else there are collapses left that do not exceed it.

use glam::DVec3;
use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_metric::{Surface, SurfaceError, sample_surface};

use crate::finish::collapse_back::{CollapseBack, collapse_guarded};
use crate::finish::fit::constraints::FitConstraints;
use crate::limit::tether::Tether;

/// Samples of each face of the original, on average.
const SAMPLES_PER_FACE: usize = 8;

/// Collapses edges while the vertices, samples and some more points of the original stay within
/// `limit` of the mesh, and all faces that change within `limit` of the original. Returns, for each
/// vertex, the one that it has become.
pub(crate) fn squeeze(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &mut FitConstraints,
    limit: f64,
    more: &[DVec3],
    to: &CollapseBack<'_>,
) -> Result<VertexMap<Option<VertexId>>, SurfaceError> {
    let vertices = original.used_vertices().into_iter();
    let mut points: Vec<DVec3> = vertices.map(|v| original.positions()[v as usize]).collect();
    let samples = SAMPLES_PER_FACE * original.triangle_count();
    points.extend(sample_surface(original, samples, 1).iter().map(|sample| sample.position));
    points.extend(more);
    let tether = Tether::new(mesh, original, &points, limit)?;
    let back = collapse_guarded(mesh, constraints, to, &tether, Some(Box::new(&tether)));
    *constraints = back.constraints;
    Ok(back.vertex_map)
}
