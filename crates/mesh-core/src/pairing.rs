//! From index triples to a half-edge structure: pairing the sides of the triangles.
//!
//! Sides are bucketed by their smaller vertex with a counting sort, and paired inside a bucket
//! through one scratch slot per vertex, so the whole build is linear and hashes nothing.

use crate::handle::{FaceId, HalfEdgeId, Handle, VertexId};
use crate::revision::Revision;
use crate::topology::{HalfEdge, Topology};

/// Why triangles do not form a half-edge mesh; the first offence that was met.
///
/// [`crate::build()`] takes the same input, lists every offence, and can repair it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TopologyError {
    /// More elements than 32-bit indices can address.
    #[error("the mesh has more vertices or half-edges than 32-bit indices can address")]
    TooLarge,
    /// A corner refers to a vertex that is not there.
    #[error("face {face} refers to vertex {vertex}, but there are {vertex_count} vertices")]
    IndexOutOfRange {
        /// The face.
        face: u32,
        /// The index it holds.
        vertex: u32,
        /// The number of vertices.
        vertex_count: usize,
    },
    /// A face uses a vertex twice.
    #[error("face {face} uses vertex {vertex} more than once")]
    RepeatedVertex {
        /// The face.
        face: u32,
        /// The vertex.
        vertex: u32,
    },
    /// An edge belongs to more than two faces.
    #[error("the edge between vertices {} and {} belongs to {faces} faces", vertices[0], vertices[1])]
    NonManifoldEdge {
        /// The ends of the edge, smaller index first.
        vertices: [u32; 2],
        /// How many faces share it.
        faces: usize,
    },
    /// Two faces run along their common edge in the same direction.
    #[error(
        "faces {} and {} run along the edge between vertices {} and {} in the same direction",
        faces[0], faces[1], vertices[0], vertices[1]
    )]
    InconsistentOrientation {
        /// The ends of the edge, smaller index first.
        vertices: [u32; 2],
        /// The two faces.
        faces: [u32; 2],
    },
    /// The faces at a vertex form more than one fan.
    #[error("the faces at vertex {vertex} form more than one fan")]
    PinchedVertex {
        /// The vertex.
        vertex: u32,
    },
}

/// A slot that holds nothing.
const EMPTY: u32 = u32::MAX;

impl Topology {
    /// Builds the half-edge structure of triangles that already form an oriented 2-manifold, with
    /// or without boundary. Vertices that no triangle uses become isolated vertices.
    ///
    /// Vertex and face handles keep the given indices, and each face starts at its first corner.
    /// Edges are numbered by their smaller vertex; half-edge `2e` runs from the smaller vertex to
    /// the larger. Takes linear time.
    ///
    /// # Errors
    /// A [`TopologyError`] that names the first offence. Use [`crate::build()`] for polygons, for a
    /// full list of offences, and for repairs.
    pub fn from_triangles(
        vertex_count: usize,
        triangles: &[[u32; 3]],
    ) -> Result<Self, TopologyError> {
        // A mesh has at most one edge per side, so this bounds every index that is made below.
        if vertex_count >= VertexId::LIMIT || triangles.len() >= HalfEdgeId::LIMIT / 6 {
            return Err(TopologyError::TooLarge);
        }
        check_corners(vertex_count, triangles)?;
        let sides = pair_sides(vertex_count, triangles)?;
        let mut topology = link_faces(vertex_count, triangles, &sides);
        topology.link_boundary()?;
        topology.choose_vertex_half_edges()?;
        Ok(topology)
    }

    /// Links the exterior half-edges to boundary loops and gives boundary vertices their exterior
    /// half-edge.
    fn link_boundary(&mut self) -> Result<(), TopologyError> {
        for index in 0..self.half_edges.len() {
            if self.half_edges[index].face.is_some() {
                continue;
            }
            let exterior = HalfEdgeId::from_index(index);
            let origin = self.origin(exterior);
            let slot = &mut self.vertex_half_edge[origin.index()];
            if slot.is_some() {
                return Err(TopologyError::PinchedVertex { vertex: origin.get() });
            }
            *slot = Some(exterior);
        }
        for index in 0..self.half_edges.len() {
            if self.half_edges[index].face.is_none() {
                let end = self.half_edges[index].target;
                // Every end of an exterior half-edge is the origin of another: as many triangle
                // sides enter a vertex as leave it.
                let following = self.vertex_half_edge[end.index()];
                self.half_edges[index].next =
                    following.ok_or(TopologyError::PinchedVertex { vertex: end.get() })?;
            }
        }
        Ok(())
    }

    /// Gives interior vertices a half-edge, and checks that turning round a vertex meets all of
    /// its half-edges.
    fn choose_vertex_half_edges(&mut self) -> Result<(), TopologyError> {
        let mut valence = vec![0_u32; self.vertex_half_edge.len()];
        for index in 0..self.half_edges.len() {
            let h = HalfEdgeId::from_index(index);
            let origin = self.origin(h).index();
            valence[origin] += 1;
            self.vertex_half_edge[origin].get_or_insert(h);
        }
        for (vertex, &expected) in valence.iter().enumerate() {
            let vertex = VertexId::from_index(vertex);
            if self.outgoing(vertex).count() != expected as usize {
                return Err(TopologyError::PinchedVertex { vertex: vertex.get() });
            }
        }
        Ok(())
    }
}

/// Refuses indices out of range and triangles that use a vertex twice.
fn check_corners(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<(), TopologyError> {
    for (face, &[a, b, c]) in triangles.iter().enumerate() {
        let face = face as u32;
        let largest = a.max(b).max(c);
        if largest as usize >= vertex_count {
            return Err(TopologyError::IndexOutOfRange { face, vertex: largest, vertex_count });
        }
        if a == b || b == c || c == a {
            let vertex = if b == c { b } else { a };
            return Err(TopologyError::RepeatedVertex { face, vertex });
        }
    }
    Ok(())
}

/// The two ends of side `side % 3` of triangle `side / 3`.
#[inline]
pub(crate) fn side_ends(triangles: &[[u32; 3]], side: usize) -> [u32; 2] {
    let triangle = triangles[side / 3];
    let corner = side % 3;
    [triangle[corner], triangle[if corner == 2 { 0 } else { corner + 1 }]]
}

/// What pairing finds: the half-edge of every triangle side, and the number of edges.
struct Sides {
    half_edge: Vec<u32>,
    edge_count: usize,
}

/// Gives the sides of all triangles their half-edges.
fn pair_sides(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Sides, TopologyError> {
    let (starts, bucketed) = bucket_by_smaller_vertex(vertex_count, triangles);
    let mut half_edge = vec![EMPTY; 3 * triangles.len()];
    // Per vertex: the edge to it from the vertex whose bucket is being read.
    let mut edge_to = vec![EMPTY; vertex_count];
    // Which side took each half-edge, to recognise a second claim.
    let mut taken_by: Vec<[u32; 2]> = Vec::with_capacity(triangles.len() * 3 / 2 + 16);
    for smaller in 0..vertex_count {
        let bucket = &bucketed[starts[smaller] as usize..starts[smaller + 1] as usize];
        for &side in bucket {
            let [from, to] = side_ends(triangles, side as usize);
            let larger = from.max(to);
            let slot = &mut edge_to[larger as usize];
            if *slot == EMPTY {
                *slot = taken_by.len() as u32;
                taken_by.push([EMPTY; 2]);
            }
            let direction = usize::from(from > to);
            let claim = &mut taken_by[*slot as usize][direction];
            if *claim != EMPTY {
                return Err(conflict(triangles, bucket, [smaller as u32, larger], [*claim, side]));
            }
            *claim = side;
            half_edge[side as usize] = 2 * *slot + direction as u32;
        }
        for &side in bucket {
            let [from, to] = side_ends(triangles, side as usize);
            edge_to[from.max(to) as usize] = EMPTY;
        }
    }
    Ok(Sides { half_edge, edge_count: taken_by.len() })
}

/// All triangle sides, grouped by their smaller vertex, and where each group starts.
pub(crate) fn bucket_by_smaller_vertex(
    vertex_count: usize,
    triangles: &[[u32; 3]],
) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0_u32; vertex_count + 2];
    for &[a, b, c] in triangles {
        for smaller in [a.min(b), b.min(c), c.min(a)] {
            starts[smaller as usize + 2] += 1;
        }
    }
    for i in 2..starts.len() {
        starts[i] += starts[i - 1];
    }
    // Filling advances each start to the next one, which leaves the array shifted by one.
    let mut bucketed = vec![0_u32; 3 * triangles.len()];
    for (face, &[a, b, c]) in triangles.iter().enumerate() {
        for (corner, smaller) in [a.min(b), b.min(c), c.min(a)].into_iter().enumerate() {
            let position = &mut starts[smaller as usize + 1];
            bucketed[*position as usize] = (3 * face + corner) as u32;
            *position += 1;
        }
    }
    starts.pop();
    (starts, bucketed)
}

/// Tells an edge of three or more faces from two faces that disagree about their orientation.
fn conflict(
    triangles: &[[u32; 3]],
    bucket: &[u32],
    vertices: [u32; 2],
    sides: [u32; 2],
) -> TopologyError {
    let faces = bucket
        .iter()
        .map(|&side| side_ends(triangles, side as usize))
        .filter(|[from, to]| from.max(to) == &vertices[1])
        .count();
    if faces > 2 {
        TopologyError::NonManifoldEdge { vertices, faces }
    } else {
        TopologyError::InconsistentOrientation { vertices, faces: sides.map(|side| side / 3) }
    }
}

/// The arrays with everything set but what the boundary and the vertices need.
fn link_faces(vertex_count: usize, triangles: &[[u32; 3]], sides: &Sides) -> Topology {
    let half_edges = 2 * sides.edge_count;
    let mut topology = Topology {
        half_edges: vec![HalfEdge::UNSET; half_edges],
        vertex_half_edge: vec![None; vertex_count],
        face_half_edge: Vec::with_capacity(triangles.len()),
        live_vertices: vertex_count,
        live_edges: sides.edge_count,
        live_faces: triangles.len(),
        revision: Revision::new(),
    };
    for (face, (triangle, sides)) in
        triangles.iter().zip(sides.half_edge.chunks_exact(3)).enumerate()
    {
        let h = [HalfEdgeId::new(sides[0]), HalfEdgeId::new(sides[1]), HalfEdgeId::new(sides[2])];
        topology.face_half_edge.push(h[0]);
        for corner in 0..3 {
            let following = (corner + 1) % 3;
            topology.half_edges[h[corner].index()] = HalfEdge {
                next: h[following],
                target: VertexId::new(triangle[following]),
                face: Some(FaceId::from_index(face)),
            };
            topology.half_edges[h[corner].twin().index()].target = VertexId::new(triangle[corner]);
        }
    }
    topology
}
