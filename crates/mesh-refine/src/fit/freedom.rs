//! The directions in which each vertex may move in a fit.

use glam::DVec3;
use mesh_core::{Handle, TriMesh, VertexId, as_u32, parallel};
use mesh_metric::Surface;

use crate::curve::Curve;
use crate::fit::constraints::FitConstraints;

/// The positions that a vertex may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Freedom {
    Fixed,
    Free,
    AlongBoundary,
    AlongFeature,
}

impl Freedom {
    /// The line that a vertex moves along, if any.
    pub(crate) fn curve(self, constraints: &FitConstraints) -> Option<&Curve> {
        match self {
            Self::AlongBoundary => constraints.boundary_curve.as_deref(),
            Self::AlongFeature => constraints.feature_curve.as_deref(),
            Self::Free | Self::Fixed => None,
        }
    }
}

/// The freedom of each vertex, by index.
pub(crate) fn freedoms(mesh: &TriMesh, constraints: &FitConstraints) -> Vec<Freedom> {
    let topology = mesh.topology();
    let of_vertex = |index: usize| {
        let v = VertexId::from_index(index);
        let fixed = constraints.fixed.as_ref().and_then(|map| map.get(v)) == Some(&true);
        if fixed || !topology.contains_vertex(v) {
            return Freedom::Fixed;
        }
        let features = topology.edges_of_vertex(v).filter(|&e| constraints.is_feature(e)).count();
        match (topology.is_boundary_vertex(v), features) {
            (false, 0) => Freedom::Free,
            (true, 0) if constraints.boundary_curve.is_some() => Freedom::AlongBoundary,
            (false, 2) if constraints.feature_curve.is_some() => Freedom::AlongFeature,
            _ => Freedom::Fixed,
        }
    };
    let mut freedoms: Vec<Freedom> = parallel::collect(topology.vertex_capacity(), of_vertex);
    let curves = [
        (Freedom::AlongBoundary, &constraints.boundary_curve),
        (Freedom::AlongFeature, &constraints.feature_curve),
    ];
    for (kind, curve) in curves {
        let corners = curve.as_ref().map_or(&[][..], |curve| curve.corners());
        fix_closest(mesh, &mut freedoms, kind, corners);
    }
    freedoms
}

/// Fixes the vertex of this kind that is closest to each corner.
fn fix_closest(mesh: &TriMesh, freedoms: &mut [Freedom], kind: Freedom, corners: &[DVec3]) {
    let of_kind = (0..as_u32(freedoms.len())).filter(|&v| freedoms[v as usize] == kind);
    let points: Vec<[u32; 3]> = of_kind.map(|v| [v; 3]).collect();
    // Without such vertices there is nothing to fix.
    let Ok(surface) = Surface::from_triangles(mesh.positions(), &points) else { return };
    for closest in surface.closest_points(corners) {
        let [v, ..] = points[closest.triangle as usize];
        freedoms[v as usize] = Freedom::Fixed;
    }
}
