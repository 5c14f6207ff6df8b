//! From index triples to a half-edge structure: pairing the sides of the triangles.
//!
//! A counting sort groups the sides by their smaller vertex; sides are paired inside each group. Groups are
//! independent, so blocks of them are paired in parallel. Edges keep the order of the groups.

use crate::index::as_u32;
use crate::parallel;
use crate::topology::half_edges::{HalfEdge, Topology};
use crate::topology::handle::{FaceId, HalfEdgeId, Handle, VertexId};
use crate::topology::revision::Revision;

/// Why triangles do not form a half-edge mesh: the first defect found.
///
/// [`crate::build()`] takes the same input, lists all defects of a kind, and can repair them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TopologyError {
    /// More elements than 32-bit indices can address.
    #[error("the mesh has more vertices or half-edges than 32-bit indices can address")]
    TooLarge,
    /// A corner refers to a vertex that does not exist.
    #[error("face {face} refers to vertex {vertex}, but there are only {vertex_count} vertices")]
    IndexOutOfRange {
        /// The face.
        face: u32,
        /// The index it holds.
        vertex: u32,
        /// The number of vertices.
        vertex_count: usize,
    },
    /// A face uses a vertex twice.
    #[error("face {face} is degenerate: it uses vertex {vertex} twice")]
    RepeatedVertex {
        /// The face.
        face: u32,
        /// The vertex.
        vertex: u32,
    },
    /// An edge belongs to more than two faces.
    #[error("edge {}-{} is non-manifold: {faces} faces share it", vertices[0], vertices[1])]
    NonManifoldEdge {
        /// The ends of the edge, smaller index first.
        vertices: [u32; 2],
        /// The number of faces that share it.
        faces: usize,
    },
    /// Two faces run along their common edge in the same direction.
    #[error(
        "faces {} and {} have opposite orientations: both traverse edge {}-{} in the same direction",
        faces[0], faces[1], vertices[0], vertices[1]
    )]
    InconsistentOrientation {
        /// The ends of the edge, smaller index first.
        vertices: [u32; 2],
        /// The two faces.
        faces: [u32; 2],
    },
    /// The faces at a vertex form more than one fan.
    #[error("vertex {vertex} is non-manifold: surfaces touch only at this point")]
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
    /// the larger one. Time: linear, plus k log k at a vertex with a large number k of edges.
    ///
    /// # Errors
    /// A [`TopologyError`] that names the first defect. Use [`crate::build()`] for polygons, for a
    /// list of all defects, and for repairs.
    pub fn from_triangles(
        vertex_count: usize,
        triangles: &[[u32; 3]],
    ) -> Result<Self, TopologyError> {
        check_corners(vertex_count, triangles)?;
        let edges = pair_sides(vertex_count, triangles)?;
        let mut topology = link_faces(vertex_count, triangles, &edges);
        topology.link_boundary()?;
        topology.choose_vertex_half_edges()?;
        Ok(topology)
    }

    /// Links the exterior half-edges to boundary loops and gives boundary vertices their exterior
    /// half-edge.
    fn link_boundary(&mut self) -> Result<(), TopologyError> {
        if self.half_edges.len() == 3 * self.live_faces {
            return Ok(());
        }
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
                // Every end of an exterior half-edge is the origin of another: the numbers of triangle sides that enter
                // and leave a vertex are equal.
                let following = self.vertex_half_edge[end.index()];
                self.half_edges[index].next =
                    following.ok_or(TopologyError::PinchedVertex { vertex: end.get() })?;
            }
        }
        Ok(())
    }

    /// Gives interior vertices a half-edge, and checks that turning around a vertex meets all of its half-edges.
    fn choose_vertex_half_edges(&mut self) -> Result<(), TopologyError> {
        let mut valence = vec![0_u32; self.vertex_half_edge.len()];
        for index in 0..self.half_edges.len() {
            let h = HalfEdgeId::from_index(index);
            let origin = self.origin(h).index();
            valence[origin] += 1;
            self.vertex_half_edge[origin].get_or_insert(h);
        }
        let is_one_fan =
            |v: usize| self.outgoing(VertexId::from_index(v)).count() == valence[v] as usize;
        let pinched = |v: usize| (!is_one_fan(v)).then_some(as_u32(v));
        match parallel::fold(valence.len(), None, pinched, Option::or) {
            Some(vertex) => Err(TopologyError::PinchedVertex { vertex }),
            None => Ok(()),
        }
    }
}

/// Refuses indices out of range, triangles that use a vertex twice, and too many triangles.
pub(crate) fn check_corners(
    vertex_count: usize,
    triangles: &[[u32; 3]],
) -> Result<(), TopologyError> {
    // A mesh has at most one edge per side, so this bounds every index that is made of them.
    if vertex_count >= VertexId::LIMIT || triangles.len() >= HalfEdgeId::LIMIT / 6 {
        return Err(TopologyError::TooLarge);
    }
    for (face, &[a, b, c]) in triangles.iter().enumerate() {
        let face = as_u32(face);
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

/// The next side of the triangle; as a corner, the one where `side` ends.
#[inline]
pub(crate) fn next(side: u32) -> u32 {
    if side % 3 == 2 { side - 2 } else { side + 1 }
}

/// The two ends of side `side % 3` of triangle `side / 3`.
#[inline]
pub(crate) fn side_ends(triangles: &[[u32; 3]], side: u32) -> [u32; 2] {
    let corners = triangles.as_flattened();
    [corners[side as usize], corners[next(side) as usize]]
}

/// The side of a triangle that runs along an edge from its smaller to its larger vertex, and the one that runs
/// back; [`EMPTY`] where there is none.
type EdgeSides = [u32; 2];

/// The edges of triangles as pairs of sides, ordered by smaller vertex and then by the first side.
fn pair_sides(
    vertex_count: usize,
    triangles: &[[u32; 3]],
) -> Result<Vec<EdgeSides>, TopologyError> {
    /// Vertices whose edges are found together.
    const BLOCK: usize = 1 << 13;
    let (starts, bucketed) = bucket_by_smaller_vertex(vertex_count, triangles);
    let blocks = parallel::collect_each(vertex_count.div_ceil(BLOCK), |block| {
        let vertices = BLOCK * block..vertex_count.min(BLOCK * (block + 1));
        let sides = (starts[vertices.end] - starts[vertices.start]) as usize;
        let mut edges = Vec::with_capacity(sides / 2 + sides / 16 + 2);
        let mut ends = Vec::new();
        for v in vertices {
            let bucket = &bucketed[starts[v] as usize..starts[v + 1] as usize];
            pair_bucket(triangles, as_u32(v), bucket, &mut ends, &mut edges)?;
        }
        Ok(edges)
    });
    drop((starts, bucketed));
    let blocks = blocks.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok(blocks.concat())
}

/// Appends the edges from a vertex to larger ones, in order of their first side. `ends` is scratch memory.
fn pair_bucket(
    triangles: &[[u32; 3]],
    smaller: u32,
    bucket: &[u32],
    ends: &mut Vec<u32>,
    edges: &mut Vec<EdgeSides>,
) -> Result<(), TopologyError> {
    /// Up to this number of sides, all pairs are compared.
    const FEW: usize = 32;
    let first = edges.len();
    ends.clear();
    // With more sides, their larger ends are sorted.
    let mut edge_to = Vec::new();
    if bucket.len() > FEW {
        ends.extend(bucket.iter().map(|&side| larger_end(triangles, side)));
        ends.sort_unstable();
        ends.dedup();
        edge_to.resize(ends.len(), EMPTY);
    }
    for &side in bucket {
        let [from, to] = side_ends(triangles, side);
        let larger = from.max(to);
        let edge = if bucket.len() > FEW {
            let slot = &mut edge_to[ends.partition_point(|&end| end < larger)];
            if *slot == EMPTY {
                *slot = as_u32(edges.len());
            }
            *slot as usize
        } else {
            let known = ends.iter().position(|&end| end == larger);
            if known.is_none() {
                ends.push(larger);
            }
            first + known.unwrap_or(ends.len() - 1)
        };
        if edge == edges.len() {
            edges.push([EMPTY; 2]);
        }
        let claim = &mut edges[edge][usize::from(from > to)];
        if *claim != EMPTY {
            return Err(conflict(triangles, bucket, [smaller, larger], [*claim, side]));
        }
        *claim = side;
    }
    Ok(())
}

/// The larger end of a side.
pub(crate) fn larger_end(triangles: &[[u32; 3]], side: u32) -> u32 {
    let [from, to] = side_ends(triangles, side);
    from.max(to)
}

/// All triangle sides, grouped by their smaller vertex, and the start of each group.
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
            bucketed[*position as usize] = as_u32(3 * face + corner);
            *position += 1;
        }
    }
    starts.pop();
    (starts, bucketed)
}

/// The error for an edge of three or more faces, or of two faces with opposite orientations.
fn conflict(
    triangles: &[[u32; 3]],
    bucket: &[u32],
    vertices: [u32; 2],
    sides: [u32; 2],
) -> TopologyError {
    let faces = bucket.iter().filter(|&&side| larger_end(triangles, side) == vertices[1]).count();
    if faces > 2 {
        TopologyError::NonManifoldEdge { vertices, faces }
    } else {
        TopologyError::InconsistentOrientation { vertices, faces: sides.map(|side| side / 3) }
    }
}

/// The arrays without boundary loops and without the half-edges of vertices.
fn link_faces(vertex_count: usize, triangles: &[[u32; 3]], edges: &[EdgeSides]) -> Topology {
    let (corners, sides) = (triangles.as_flattened(), edges.as_flattened());
    let mut half_edge = vec![HalfEdgeId::REMOVED; corners.len()];
    for (h, &side) in sides.iter().enumerate() {
        if side != EMPTY {
            half_edge[side as usize] = HalfEdgeId::from_index(h);
        }
    }
    let half_edges = parallel::collect(sides.len(), |h| {
        let side = sides[h];
        if side == EMPTY {
            // An edge has a side.
            let start = corners[sides[h ^ 1] as usize];
            return HalfEdge { target: VertexId::new(start), ..HalfEdge::UNSET };
        }
        let following = next(side) as usize;
        HalfEdge {
            next: half_edge[following],
            target: VertexId::new(corners[following]),
            face: Some(FaceId::new(side / 3)),
        }
    });
    Topology {
        half_edges,
        vertex_half_edge: vec![None; vertex_count],
        face_half_edge: half_edge.iter().copied().step_by(3).collect(),
        live_vertices: vertex_count,
        live_edges: edges.len(),
        live_faces: triangles.len(),
        revision: Revision::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;
    use std::collections::HashMap;

    /// Edges by definition: the edges of each smaller vertex in order of their first side.
    fn by_definition(triangles: &[[u32; 3]]) -> Vec<EdgeSides> {
        let mut sides: Vec<u32> = (0..3 * triangles.len() as u32).collect();
        let ends = |side: u32| side_ends(triangles, side);
        sides.sort_by_key(|&side| ends(side).into_iter().min());
        let mut edges = Vec::new();
        let mut number = HashMap::new();
        for side in sides {
            let [from, to] = ends(side);
            let edge = *number.entry([from.min(to), from.max(to)]).or_insert_with(|| {
                edges.push([EMPTY; 2]);
                edges.len() - 1
            });
            edges[edge][usize::from(from > to)] = side;
        }
        edges
    }

    /// Brings the vertices into another order.
    fn shuffle(count: usize, triangles: &mut [[u32; 3]]) {
        let mut random = SplitMix64::new(5);
        let mut keys: Vec<(u64, u32)> = (0..count as u32).map(|v| (random.bits(), v)).collect();
        keys.sort_unstable();
        triangles.as_flattened_mut().iter_mut().for_each(|v| *v = keys[*v as usize].1);
    }

    /// A double pyramid over many sides, whose tips are the vertices 0 and 1.
    fn double_pyramid(sides: u32) -> Vec<[u32; 3]> {
        let rim = |i: u32| 2 + i * 7 % sides;
        let at = |i: u32| [[0, rim(i), rim(i + 1)], [1, rim(i + 1), rim(i)]];
        (0..sides).flat_map(at).collect()
    }

    /// Vertex count and triangles of a square grid of `cells` x `cells` cells.
    fn grid(cells: u32) -> (usize, Vec<[u32; 3]>) {
        let at = |i: u32, j: u32| i * (cells + 1) + j;
        let cell = |i, j| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        };
        let triangles = (0..cells).flat_map(|i| (0..cells).flat_map(move |j| cell(i, j))).collect();
        ((cells as usize + 1).pow(2), triangles)
    }

    #[test]
    fn edges_are_those_of_the_definition_in_many_blocks_and_at_hubs() {
        let (count, mut triangles) = grid(200);
        assert_eq!(pair_sides(count, &triangles).unwrap(), by_definition(&triangles));
        shuffle(count, &mut triangles);
        assert_eq!(pair_sides(count, &triangles).unwrap(), by_definition(&triangles));
        for sides in [3, 16, 17, 100] {
            let triangles = double_pyramid(sides);
            assert_eq!(
                pair_sides(sides as usize + 2, &triangles).unwrap(),
                by_definition(&triangles)
            );
            Topology::from_triangles(sides as usize + 2, &triangles).unwrap().validate().unwrap();
        }
    }

    #[test]
    fn of_many_offences_that_at_the_smallest_vertex_is_told() {
        // Beyond the first block, twice; and at a hub.
        let mut triangles = double_pyramid(30_000);
        let [_, b, c] = triangles[0];
        triangles.push([b, c, 30_002]);
        let vertices = [b.min(c), b.max(c)];
        let expected = TopologyError::NonManifoldEdge { vertices, faces: 3 };
        assert_eq!(Topology::from_triangles(30_003, &triangles).unwrap_err(), expected);
        let late = triangles[50_000];
        triangles.push([late[1], late[2], 30_002]);
        assert!(late[1].min(late[2]) > vertices[0]);
        assert_eq!(Topology::from_triangles(30_003, &triangles).unwrap_err(), expected);
        triangles.push([0, b, 30_002]);
        let found = Topology::from_triangles(30_003, &triangles).unwrap_err();
        let at_hub = TopologyError::NonManifoldEdge { vertices: [0, b], faces: 3 };
        assert_eq!(found, at_hub);
    }

    #[test]
    fn of_many_pinched_vertices_the_smallest_is_told() {
        // Double pyramids that meet in one of their tips: two in vertex 20,000, and two in 5000.
        let mut triangles = Vec::new();
        for (first, tip) in [(0, 20_000), (100, 20_000), (200, 5000), (300, 5000)] {
            let pyramid = double_pyramid(10).into_iter();
            let name = |v: u32| if v == 0 { tip } else { first + v };
            triangles.extend(pyramid.map(|t| t.map(name)));
        }
        let found = Topology::from_triangles(20_001, &triangles).unwrap_err();
        assert_eq!(found, TopologyError::PinchedVertex { vertex: 5000 });
    }
}
