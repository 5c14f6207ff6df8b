//! Collapsing further for as long as the mesh stays within a distance of the original.
//!
//! A mesh that was fitted is close to its original almost everywhere, and a limit binds in few
//! places only. Everywhere else there are collapses left that do not exceed it.

use glam::DVec3;
use mesh_core::{Handle, TriMesh, VertexId, VertexMap};
use mesh_metric::{Surface, SurfaceError, sample_surface};

use crate::collapse_back::{CollapseBack, collapse_guarded};
use crate::fit::FitConstraints;
use crate::tether::Tether;

/// Samples of each face of the original, on average.
const SAMPLES_PER_FACE: usize = 2;

/// Collapses edges while the vertices, samples and some more points of the original stay within
/// `limit` of the mesh, and all faces that change within `limit` of the original. Returns, for each vertex, the one that it has become.
pub(crate) fn squeeze(
    mesh: &mut TriMesh,
    original: &Surface,
    constraints: &mut FitConstraints,
    limit: f64,
    more: &[DVec3],
    to: &CollapseBack<'_>,
) -> Result<VertexMap<Option<VertexId>>, SurfaceError> {
    let mut used: Vec<u32> = original.triangles().as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let mut points: Vec<DVec3> = used.iter().map(|&v| original.positions()[v as usize]).collect();
    let samples = SAMPLES_PER_FACE * original.triangle_count();
    points.extend(sample_surface(original, samples, 1).iter().map(|sample| sample.position));
    points.extend(more);
    let identity = (0..mesh.topology().vertex_capacity()).map(VertexId::from_index).map(Some);
    let mut map: VertexMap<Option<VertexId>> = VertexMap::from_vec(identity.collect());
    let tether = Tether::new(mesh, original, &points, limit)?;
    let back = collapse_guarded(mesh, constraints, to, &tether, Some(Box::new(&tether)));
    for new in map.as_mut_slice() {
        *new = new.and_then(|v| back.vertex_map.get(v).copied().flatten());
    }
    *constraints = back.constraints;
    Ok(map)
}
