//! Butterfly subdivision with transfer of attributes.

use glam::DVec3;
use mesh_core::butterfly::ButterflyOptions;
use mesh_core::diagnose::is_sliver;
use mesh_core::subdivide_1_to_4::{SubdivisionMap, VertexOrigin};
use mesh_core::{
    FaceId, HalfEdgeId, MeshError, Topology, TopologyError, TriMesh, as_u32, unit_sized,
};
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

/// A subdivided mesh.
#[derive(Clone, Debug)]
pub struct Subdivided {
    /// The mesh.
    pub mesh: TriMesh,
    /// The mesh with its attributes.
    pub model: Model,
    /// Number of new vertices at the middle of their edge, because the scheme would have made a sliver there, or turned
    /// a face over.
    pub straight_edges: usize,
}

/// One subdivision step. Attributes of new vertices and corners are interpolated; labels are copied. Where the point of
/// the scheme would turn a new face over against the face that it was cut from, or make a sliver of it, the middles of
/// the edges are used.
///
/// # Errors
/// The result has more faces than 32-bit indices can address, or the model does not match the mesh.
pub fn subdivide_step(
    mesh: &TriMesh,
    model: &Model,
    rules: &ButterflyOptions,
) -> Result<Subdivided, SubdivisionError> {
    let coarse = mesh.topology();
    let (fine, origins) = coarse.subdivide_1_to_4()?;
    let mut positions = rules.refine(coarse, mesh.positions());
    let straight_edges = straighten(mesh, &fine, &origins, &mut positions);
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
    Ok(Subdivided { mesh, model, straight_edges })
}

/// Moves new vertices to the middle of their edges where a new face would be turned over or a sliver. Faces cut from a
/// sliver stay as they are. Returns the number of moved vertices.
fn straighten(
    coarse: &TriMesh,
    fine: &Topology,
    origins: &SubdivisionMap,
    positions: &mut [DVec3],
) -> usize {
    let is_worse = |face: FaceId, positions: &[DVec3]| {
        let parent = coarse.triangle(origins.parent_face(face));
        let child = fine.face_vertices(face).map(|v| positions[v.index()]);
        let is_turned = cross(child).dot(cross(parent)) <= 0.0;
        (is_turned || is_sliver(child)) && !is_sliver(parent)
    };
    let mut is_straight = fine.vertex_map(false);
    let mut count = 0;
    let mut faces: Vec<FaceId> = fine.faces().collect();
    // A straight edge can make a neighbour worse. Four children with straight edges are similar to their parent, so
    // this ends.
    while !faces.is_empty() {
        let worse = faces.into_iter().filter(|&face| is_worse(face, positions));
        let corners: Vec<_> = worse.flat_map(|face| fine.face_vertices(face)).collect();
        let mut changed = Vec::new();
        for v in corners {
            if let VertexOrigin::Edge(edge) = origins.vertex_origin(v)
                && !is_straight[v]
            {
                let [a, b] = coarse.topology().edge_vertices(edge).map(|v| coarse.position(v));
                positions[v.index()] = a + 0.5 * (b - a);
                is_straight[v] = true;
                count += 1;
                changed.push(v);
            }
        }
        faces = changed.into_iter().flat_map(|v| fine.faces_of_vertex(v)).collect();
    }
    count
}

/// Twice the vector area of a triangle, times a power of two.
fn cross(corners: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = unit_sized(corners);
    (b - a).cross(c - a)
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
