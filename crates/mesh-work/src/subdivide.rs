//! Butterfly subdivision with transfer of attributes.

use mesh_core::butterfly::ButterflyOptions;
use mesh_core::subdivide_1_to_4::{SubdivisionMap, VertexOrigin};
use mesh_core::{HalfEdgeId, MeshError, Topology, TopologyError, TriMesh, as_u32};
use mesh_io::{Blend, Model, ModelError};

/// Errors of [`subdivide_step`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SubdivisionError {
    /// The mesh would be too large.
    #[error("{0}; ask for fewer steps")]
    Size(#[from] TopologyError),
    /// A new position is not finite.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The model does not match the mesh.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// One subdivision step. Attributes of new vertices and corners are interpolated; labels are copied.
///
/// # Errors
/// The result has more faces than 32-bit indices can address, or the model does not match the mesh.
pub fn subdivide_step(
    mesh: &TriMesh,
    model: &Model,
    rules: &ButterflyOptions,
) -> Result<(TriMesh, Model), SubdivisionError> {
    let coarse = mesh.topology();
    let (fine, origins) = coarse.subdivide_1_to_4()?;
    let positions = rules.refine(coarse, mesh.positions());
    let mesh = TriMesh::new(fine, positions)?;
    let fine = mesh.topology();
    let vertices: Vec<Blend> = fine
        .vertices()
        .map(|v| match origins.vertex_origin(v) {
            VertexOrigin::Vertex(v) => Blend::one(v.get()),
            VertexOrigin::Edge(edge) => {
                let h = edge.half_edge();
                middle([h, h.twin()].map(|h| coarse.origin(h).get()))
            }
        })
        .collect();
    let parents = fine.faces().map(|f| origins.parent_face(f).get()).collect::<Vec<_>>();
    let corners: Vec<[Blend; 3]> = fine
        .faces()
        .map(|f| fine.face_half_edges(f).map(|h| corner(coarse, fine, &origins, h)))
        .collect();
    let triangles: Vec<[u32; 3]> = fine.triangles().collect();
    let model = model.blended(mesh.positions(), &triangles, &vertices, &parents, &corners)?;
    Ok((mesh, model))
}

/// The corners of the parent face on both sides of the corner at the origin of a half-edge.
fn corner(coarse: &Topology, fine: &Topology, origins: &SubdivisionMap, h: HalfEdgeId) -> Blend {
    let Some(face) = fine.face(h) else { return Blend::one(0) };
    let parent = origins.parent_face(face);
    let at = |h: HalfEdgeId| {
        let vertices = coarse.face_vertices(parent);
        let k = vertices.into_iter().position(|v| v == coarse.origin(h)).unwrap_or(0);
        as_u32(3 * parent.index() + k)
    };
    match origins.vertex_origin(fine.origin(h)) {
        VertexOrigin::Vertex(v) => {
            let vertices = coarse.face_vertices(parent);
            let k = vertices.into_iter().position(|other| other == v).unwrap_or(0);
            Blend::one(as_u32(3 * parent.index() + k))
        }
        VertexOrigin::Edge(edge) => middle([edge.half_edge(), edge.half_edge().twin()].map(at)),
    }
}

/// Halfway between two.
fn middle([a, b]: [u32; 2]) -> Blend {
    Blend { sources: [a, b, a], weights: [0.5, 0.5, 0.0] }
}
