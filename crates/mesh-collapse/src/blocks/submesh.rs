//! A block as a separate mesh, for the greedy loop.

use glam::DVec3;
use mesh_core::{FaceId, HalfEdgeId, TriMesh, VertexId, as_u32};

use crate::blocks::partition::Partition;
use crate::geometry::quadric::Quadric;
use crate::record::log::LogEntry;

/// A block with all faces that have a corner in it, as a separate mesh with maps to the whole mesh.
///
/// Vertices of other blocks are included only as corners of the faces. If the faces at such a vertex form several fans,
/// the vertex is split, so that the submesh is a manifold.
pub(super) struct Submesh {
    pub(super) mesh: TriMesh,
    /// For each vertex, whether all faces around it have all corners in the block. Only edges between two such vertices
    /// may collapse: then the block contains all faces of both ends and their neighbours that matter, and no other
    /// block changes them.
    pub(super) is_free: Vec<bool>,
    /// The vertices of the block, as handles of the mesh; they come first.
    own: Vec<u32>,
    /// The half-edge of the mesh for each half-edge.
    half_edges: Vec<HalfEdgeId>,
}

/// A corner at a vertex of another block, with the next and the previous corner of its triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Outer {
    vertex: u32,
    following: u32,
    preceding: u32,
    /// Three times the number of the triangle, plus the position in it.
    corner: u32,
}

impl Submesh {
    pub(super) fn new(mesh: &TriMesh, partition: &Partition, block: usize) -> Self {
        let topology = mesh.topology();
        let lists = [partition.mixed(block), partition.inner(block)];
        let faces: Vec<FaceId> = lists.into_iter().flatten().map(|&f| FaceId::new(f)).collect();
        let own = partition.vertices(block).to_vec();
        let first = as_u32(partition.first(block));
        let mut is_free = vec![true; own.len()];
        let mut triangles = Vec::with_capacity(faces.len());
        let mut outer = Vec::new();
        for &face in &faces {
            let corners = topology.face_vertices(face).map(VertexId::get);
            // For vertices before the block, the difference wraps to a very large number.
            let numbers = corners.map(|v| partition.rank(v).wrapping_sub(first));
            let is_own = numbers.map(|number| (number as usize) < own.len());
            for i in 0..3 {
                let [following, preceding] = [(i + 1) % 3, (i + 2) % 3].map(|i| corners[i]);
                match is_own[i] {
                    true => is_free[numbers[i] as usize] &= is_own == [true; 3],
                    false => {
                        let corner = as_u32(3 * triangles.len() + i);
                        outer.push(Outer { vertex: corners[i], following, preceding, corner });
                    }
                }
            }
            triangles.push(numbers);
        }
        let mut positions: Vec<DVec3> =
            own.iter().map(|&v| mesh.position(VertexId::new(v))).collect();
        for fan in fans(outer) {
            for outer in &fan {
                triangles[outer.corner as usize / 3][outer.corner as usize % 3] =
                    as_u32(positions.len());
            }
            positions.extend(fan.first().map(|outer| mesh.position(VertexId::new(outer.vertex))));
        }
        is_free.resize(positions.len(), false);
        #[expect(clippy::expect_used, reason = "faces of a manifold whose fans have been parted")]
        let submesh = TriMesh::from_triangles(&positions, &triangles).expect("a manifold");
        let mut half_edges = vec![HalfEdgeId::new(0); submesh.topology().half_edge_capacity()];
        for (here, &there) in submesh.topology().faces().zip(&faces) {
            let sides = submesh.topology().face_half_edges(here);
            for (here, there) in sides.into_iter().zip(topology.face_half_edges(there)) {
                half_edges[here.index()] = there;
                half_edges[here.twin().index()] = there.twin();
            }
        }
        Self { mesh: submesh, is_free, own, half_edges }
    }

    /// Selects the quadrics of the vertices of the submesh; empty if the mesh has none.
    pub(super) fn quadrics(&self, of_mesh: &[Quadric]) -> Vec<Quadric> {
        if of_mesh.is_empty() {
            return Vec::new();
        }
        let mut quadrics: Vec<Quadric> = self.own.iter().map(|&v| of_mesh[v as usize]).collect();
        quadrics.resize(self.is_free.len(), Quadric::default());
        quadrics
    }

    /// Translates a collapse of the submesh into one of the mesh.
    pub(super) fn of_mesh(&self, entry: &LogEntry) -> LogEntry {
        let vertex = |v: VertexId| VertexId::new(self.own[v.index()]);
        LogEntry {
            half_edge: self.half_edges[entry.half_edge.index()],
            removed: vertex(entry.removed),
            kept: vertex(entry.kept),
            ..*entry
        }
    }
}

/// Groups corners into fans: corners at one vertex whose triangles follow each other around it.
fn fans(mut corners: Vec<Outer>) -> Vec<Vec<Outer>> {
    corners.sort_unstable();
    let find = |vertex: u32, following: u32| {
        corners.binary_search_by_key(&(vertex, following), |c| (c.vertex, c.following)).ok()
    };
    let next: Vec<Option<usize>> = corners.iter().map(|c| find(c.vertex, c.preceding)).collect();
    let mut has_one_before = vec![false; corners.len()];
    next.iter().flatten().for_each(|&i| has_one_before[i] = true);
    let mut is_met = vec![false; corners.len()];
    // First the open fans, then the closed ones.
    let begins = (0..corners.len()).filter(|&i| !has_one_before[i]);
    let mut fans = Vec::new();
    for start in begins.chain(0..corners.len()) {
        let mut fan = Vec::new();
        let mut turn = Some(start);
        while let Some(i) = turn.filter(|&i| !is_met[i]) {
            is_met[i] = true;
            fan.push(corners[i]);
            turn = next[i];
        }
        if !fan.is_empty() {
            fans.push(fan);
        }
    }
    fans
}

#[cfg(test)]
mod tests {
    use core::ops::ControlFlow;

    use super::*;
    use crate::blocks::flat_mesh::FlatMesh;
    use crate::cost::Hybrid;
    use crate::engine::edge_collapse::collapse_edges_from;
    use crate::engine::start::Start;
    use crate::placement::Optimal;
    use crate::policies::Policies;
    use crate::record::target::Target;
    use mesh_shapes::{Irregular, Wave};

    /// An open mesh with many holes, so that the borders of its blocks touch themselves.
    fn sieve() -> TriMesh {
        let wave = Wave { amplitude: 0.15, wavelength: 1.1, half_width: 1.0 };
        let soup = wave.irregular_mesh(90, Irregular { jitter: 0.2, seed: 4 }).unwrap();
        let mut mesh = TriMesh::from_soup(&soup).unwrap();
        for f in (0..mesh.topology().face_count()).filter(|f| f % 7 == 0) {
            let face = FaceId::new(f as u32);
            if let Ok(legal) = mesh.topology().check_remove_face(face) {
                mesh.remove_face(legal);
            }
        }
        mesh
    }

    /// Every block is a mesh whose elements map to the whole mesh. Its legal collapses are legal there as well,
    /// whatever happens in other blocks.
    #[test]
    fn excerpts_are_manifolds_whose_collapses_are_those_of_the_mesh() {
        let mut mesh = sieve();
        mesh.topology().validate().unwrap();
        let (mut parted, mut collapses) = (0, 0);
        for pass in 0..2 {
            let partition = FlatMesh::new(&mesh).partition(pass);
            assert!(partition.blocks() > 1);
            let mut entries = Vec::new();
            for block in 0..partition.blocks() {
                let mut submesh = Submesh::new(&mesh, &partition, block);
                submesh.mesh.topology().validate().unwrap();
                for h in submesh.mesh.topology().half_edges() {
                    let there = submesh.half_edges[h.index()];
                    let [here, there] = [
                        (submesh.mesh.topology(), &submesh.mesh, h),
                        (mesh.topology(), &mesh, there),
                    ]
                    .map(|(t, mesh, h)| [t.origin(h), t.target(h)].map(|v| mesh.position(v)));
                    assert_eq!(here, there);
                }
                let own = submesh.own.len();
                for v in submesh.mesh.topology().vertices().take(own) {
                    let there = VertexId::new(submesh.own[v.index()]);
                    assert_eq!(submesh.mesh.topology().valence(v), mesh.topology().valence(there));
                }
                let mut outer: Vec<_> = submesh.mesh.positions()[own..].to_vec();
                outer.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
                parted += outer.windows(2).filter(|pair| pair[0] == pair[1]).count();
                let is_free = Some(core::mem::take(&mut submesh.is_free));
                let start = Start { is_free, ..Start::default() };
                let policies = Policies::new(Hybrid::default(), Optimal::default());
                let (protect, limits) = (Default::default(), Target::default());
                let run = collapse_edges_from(
                    &mut submesh.mesh,
                    policies,
                    start,
                    &protect,
                    &limits,
                    &mut |_| ControlFlow::Continue(()),
                );
                entries.extend(run.log.entries().iter().map(|entry| submesh.of_mesh(entry)));
            }
            for entry in entries {
                let legal = mesh.topology().check_collapse(entry.half_edge).unwrap();
                assert_eq!([legal.removed(), legal.kept()], [entry.removed, entry.kept]);
                mesh.collapse(legal, entry.position);
                collapses += 1;
            }
            mesh.topology().validate().unwrap();
        }
        assert!(parted > 0 && collapses > 2000, "{parted} {collapses}");
    }
}
