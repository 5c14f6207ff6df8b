//! The curvature of a mesh as a table of the terms that collapses change.

use dcurv::{
    CurvatureOptions, Curvatures, Integral, VertexArea, VertexCurvature, edge_mean_curvatures,
    triangle_angles,
};
use mesh_core::{
    EdgeMap, FaceId, FaceMap, HalfEdgeMap, Handle, Remap, TriMesh, VertexMap, parallel,
};

use crate::cost::curvature_change::measure::{Measure, Term};

/// The curvature data of the current mesh.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    pub(super) vertices: VertexMap<Term>,
    /// For each edge, the share of its integrated mean curvature that each of its ends receives.
    pub(super) hinges: EdgeMap<f64>,
    /// The interior angle of each face at the origin of each of its half-edges.
    pub(super) corners: HalfEdgeMap<f64>,
    /// A third of the area of each face.
    pub(super) thirds: FaceMap<f64>,
}

/// The factor from the length of a doubled vector area to a third of the area.
pub(super) const DOUBLED_TO_THIRD: f64 = 1.0 / 6.0;

impl Tables {
    /// Empty tables.
    pub(super) fn empty() -> Self {
        Self {
            vertices: VertexMap::from_vec(Vec::new()),
            hinges: EdgeMap::from_vec(Vec::new()),
            corners: HalfEdgeMap::from_vec(Vec::new()),
            thirds: FaceMap::from_vec(Vec::new()),
        }
    }

    /// The tables for the mesh without gaps.
    pub(super) fn compact(&self, remap: &Remap) -> Self {
        Self {
            vertices: self.vertices.compact(remap),
            hinges: self.hinges.compact(remap),
            corners: self.corners.compact(remap),
            thirds: self.thirds.compact(remap),
        }
    }

    pub(super) fn new(mesh: &TriMesh, measure: Measure) -> Self {
        let topology = mesh.topology();
        let options = CurvatureOptions { area: VertexArea::Barycentric };
        let term = |c: &VertexCurvature| Term::new(*c.integrals(), c.is_boundary(), measure);
        let mean = edge_mean_curvatures(mesh);
        // Each end of an edge has half of its mean curvature.
        let mut hinges = mean.map(|mean| mean.map_or(0.0, |mean| 0.5 * mean.value()));
        let mut vertices = Curvatures::of(mesh, &options).map(term);
        if measure.is_unsigned() {
            for e in topology.edges() {
                hinges[e] = hinges[e].abs();
            }
            for v in topology.vertices() {
                let mean = topology.outgoing(v).map(|h| hinges[h.edge()]).sum();
                let Term { mut integrals, boundary, .. } = vertices[v];
                integrals.mean = Integral::new(mean);
                vertices[v] = Term::new(integrals, boundary, measure);
            }
        }
        let per_face = parallel::collect(topology.face_capacity(), |i| {
            let f = FaceId::from_index(i);
            if topology.contains_face(f) { measure_face(mesh, f) } else { ([0.0; 3], 0.0) }
        });
        let mut corners = HalfEdgeMap::from_vec(vec![0.0; 2 * topology.edge_capacity()]);
        for f in topology.faces() {
            let angles = per_face[f.index()].0;
            let sides = topology.face_half_edges(f).into_iter();
            sides.zip(angles).for_each(|(side, angle)| corners[side] = angle);
        }
        Self {
            vertices,
            hinges,
            corners,
            // Collecting from references avoids the excess capacity of an in-place collection.
            thirds: FaceMap::from_vec(per_face.iter().map(|&(_, third)| third).collect()),
        }
    }
}

/// The interior angles of a face, and a third of its area.
fn measure_face(mesh: &TriMesh, f: FaceId) -> ([f64; 3], f64) {
    let [a, b, c] = mesh.triangle(f);
    let cross = mesh.face_cross(f).length();
    (triangle_angles(b - a, c - a, cross), DOUBLED_TO_THIRD * cross)
}
