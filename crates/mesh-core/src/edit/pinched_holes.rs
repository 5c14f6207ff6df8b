//! Holes that meet in a vertex, for [hole filling](super::fill).
//!
//! For example, two missing faces of an octahedron that share a vertex leave two fans of faces there. Building the mesh
//! cuts the vertex into a copy for each fan, and the boundary becomes one loop of six edges around both holes. Filled
//! as one, the octahedron has four faces too many and a neck between two copies of the vertex. Here the copies are
//! joined again, so that the boundary becomes two loops of three edges. Once one of the two is filled, the fans are
//! joined by its faces, and the surface is a manifold at the vertex.
//!
//! 1. A loop that passes through copies of a vertex is divided there, innermost part first.
//! 2. Copies in two loops are joined if that makes more loops that can be filled, each of which passes through a vertex
//!    once: three missing faces around a face that is left are two loops (around the face, and around all), and become
//!    three. The loop around a single face cannot be filled.
//!
//! Of more than two fans, the boundary leads from one to the next counter-clockwise around the vertex.
//!
//! Copies are vertices at equal positions on the boundary. They stay apart where two of them have a neighbour at the
//! same position: the surface was cut along an edge there, or has a crack.

use glam::DVec3;

use crate::build::position_key;
use crate::index::as_u32;
use crate::mesh::TriMesh;
use crate::topology::disjoint_sets::DisjointSets;
use crate::topology::half_edges::Topology;
use crate::topology::handle::{HalfEdgeId, VertexId};

/// The groups of boundary vertices at one position that no two edges at one place keep apart, each counter-clockwise
/// around the sum of the normals of its faces.
pub(super) fn boundary_copies(mesh: &TriMesh) -> Vec<Vec<VertexId>> {
    let topology = mesh.topology();
    let key = |v: VertexId| position_key(mesh.position(v));
    let mut places: Vec<([u64; 3], VertexId)> = topology
        .vertices()
        .filter(|&v| topology.half_edge_of_vertex(v).is_some_and(|h| topology.is_exterior(h)))
        .map(|v| (key(v), v))
        .collect();
    places.sort_unstable();
    let mut around = Vec::new();
    let are_apart = |group: &&[([u64; 3], VertexId)]| {
        around.clear();
        around.push(group[0].0);
        around.extend(group.iter().flat_map(|&(_, v)| topology.one_ring(v)).map(key));
        around.sort_unstable();
        around.windows(2).all(|pair| pair[0] != pair[1])
    };
    let groups = places.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1);
    let groups = groups.filter(are_apart);
    groups
        .map(|group| counter_clockwise(mesh, group.iter().map(|place| place.1).collect()))
        .collect()
}

/// Copies of a vertex by the direction in which the boundary leaves them: there their faces end, counter-clockwise.
fn counter_clockwise(mesh: &TriMesh, mut copies: Vec<VertexId>) -> Vec<VertexId> {
    if copies.len() > 2 {
        let topology = mesh.topology();
        let faces = copies.iter().flat_map(|&copy| topology.faces_of_vertex(copy));
        let normal: DVec3 = faces.map(|face| mesh.face_normal(face)).sum();
        let (across, along) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
        let direction = |copy: VertexId| {
            let away = topology
                .one_ring(copy)
                .next()
                .map_or(DVec3::ZERO, |v| mesh.position(v) - mesh.position(copy));
            away.dot(along).atan2(away.dot(across))
        };
        copies.sort_by(|&a, &b| direction(a).total_cmp(&direction(b)));
    }
    copies
}

/// Per place where a loop with all copies of a vertex is divided, the copies in the order in which the loop passes
/// through them.
fn divisions(topology: &Topology, groups: &[Vec<VertexId>]) -> Vec<Vec<VertexId>> {
    const NONE: u32 = u32::MAX;
    let mut group_of = vec![NONE; topology.vertex_capacity()];
    for (group, i) in groups.iter().zip(0..) {
        group.iter().for_each(|v| group_of[v.index()] = i);
    }
    // Per group, where on the path its vertex is, and the number of its list of copies.
    let mut on_path = vec![NONE; groups.len()];
    let mut list_of = vec![NONE; groups.len()];
    let mut joined: Vec<Vec<VertexId>> = Vec::new();
    // The groups of the loop so far, without the parts that were divided off.
    let mut path: Vec<(u32, VertexId)> = Vec::new();
    for boundary in topology.boundaries() {
        for vertex in boundary.map(|h| topology.origin(h)) {
            let group = group_of[vertex.index()];
            if group == NONE {
                continue;
            }
            let earlier = on_path[group as usize];
            if earlier == NONE {
                on_path[group as usize] = as_u32(path.len());
                path.push((group, vertex));
                continue;
            }
            let inner = path.drain(earlier as usize + 1..);
            inner.for_each(|(other, _)| forget(&mut on_path, &mut list_of, other));
            let list = &mut list_of[group as usize];
            if *list == NONE {
                *list = as_u32(joined.len());
                joined.push(vec![path[earlier as usize].1]);
            }
            joined[*list as usize].push(vertex);
        }
        path.drain(..).for_each(|(group, _)| forget(&mut on_path, &mut list_of, group));
    }
    joined.retain(|copies| copies.len() == groups[group_of[copies[0].index()] as usize].len());
    joined
}

/// What follows on the boundary has nothing to do with a group's vertex so far.
fn forget(on_path: &mut [u32], list_of: &mut [u32], group: u32) {
    on_path[group as usize] = u32::MAX;
    list_of[group as usize] = u32::MAX;
}

impl Topology {
    /// Joins copies of vertices where holes meet. Returns the copies of each, of which the first is the vertex now. The
    /// surface is a manifold again after [`cut_open_fans`](Self::cut_open_fans).
    pub(crate) fn join_pinched_holes(
        &mut self,
        mut groups: Vec<Vec<VertexId>>,
    ) -> Vec<Vec<VertexId>> {
        let mut joined = divisions(self, &groups);
        let mut is_joined = vec![false; self.vertex_capacity()];
        for copies in &joined {
            self.join_copies(copies);
            copies.iter().for_each(|v| is_joined[v.index()] = true);
        }
        groups.retain(|group| group.iter().all(|v| !is_joined[v.index()]));
        joined.extend(self.join_between_loops(&groups));
        joined
    }

    /// Makes the surface a manifold again where faces do not join the fans at copies that were joined.
    pub(crate) fn cut_open_fans(&mut self, joined: &[Vec<VertexId>]) {
        joined.iter().for_each(|copies| self.cut_fans_at(copies));
    }

    /// Makes copies of a boundary vertex one vertex, the first one: the boundary that arrives at a copy goes on where
    /// it left the copy before it. The vertex has several fans of faces then.
    fn join_copies(&mut self, copies: &[VertexId]) {
        self.revision.advance();
        let leaving: Vec<HalfEdgeId> =
            copies.iter().filter_map(|&copy| self.half_edge_of_vertex(copy)).collect();
        let arriving: Vec<HalfEdgeId> = leaving.iter().map(|&h| self.previous(h)).collect();
        for &copy in &copies[1..] {
            let around: Vec<HalfEdgeId> = self.outgoing(copy).collect();
            for h in around {
                self.half_edges[h.twin().index()].target = copies[0];
            }
            self.vertex_half_edge[copy.index()] = Some(HalfEdgeId::REMOVED);
            self.live_vertices -= 1;
        }
        let before = leaving.iter().cycle().skip(leaving.len() - 1);
        for (&half_edge, &next) in arriving.iter().zip(before) {
            self.link(half_edge, next);
        }
    }

    /// Gives each fan of faces at a joined vertex a copy of its own again, unless new faces joined the fans.
    fn cut_fans_at(&mut self, copies: &[VertexId]) {
        self.revision.advance();
        let mut around: Vec<HalfEdgeId> = self.outgoing(copies[0]).collect();
        let Some(first) = around.iter().position(|&h| self.is_exterior(h)) else { return };
        around.rotate_left(first);
        let fans: Vec<&[HalfEdgeId]> = around.chunk_by(|_, &h| !self.is_exterior(h)).collect();
        // Clockwise around the vertex, the fans are in the order opposite to the order along the boundary.
        let clockwise = copies[..1].iter().chain(copies[1..].iter().rev());
        for (fan, &copy) in fans.into_iter().zip(clockwise) {
            for h in fan {
                self.half_edges[h.twin().index()].target = copy;
            }
            if !self.contains_vertex(copy) {
                self.live_vertices += 1;
            }
            self.vertex_half_edge[copy.index()] = Some(fan[0]);
            self.link(fan[fan.len() - 1].twin(), fan[0]);
        }
    }

    /// Joins copies in different loops where that makes more loops that can be filled.
    fn join_between_loops(&mut self, groups: &[Vec<VertexId>]) -> Vec<Vec<VertexId>> {
        let mut loop_of = vec![0; self.vertex_capacity()];
        let starts = self.boundary_loops();
        for (&start, i) in starts.iter().zip(0..) {
            self.boundary_loop(start).for_each(|h| loop_of[self.origin(h).index()] = i);
        }
        let mut clusters = DisjointSets::new(starts.len());
        for (a, b) in groups.iter().flat_map(|group| group.iter().zip(&group[1..])) {
            clusters.union(loop_of[a.index()], loop_of[b.index()]);
        }
        let mut members: Vec<(u32, u32)> =
            (0..as_u32(starts.len())).map(|i| (clusters.find(i), i)).collect();
        members.sort_unstable();
        let mut by_cluster: Vec<(u32, &Vec<VertexId>)> =
            groups.iter().map(|group| (clusters.find(loop_of[group[0].index()]), group)).collect();
        by_cluster.sort_by_key(|entry| entry.0);
        let mut joined = Vec::new();
        for cluster in by_cluster.chunk_by(|a, b| a.0 == b.0) {
            let (from, to) = (
                members.partition_point(|member| member.0 < cluster[0].0),
                members.partition_point(|member| member.0 <= cluster[0].0),
            );
            let loops = &members[from..to];
            let sides: Vec<HalfEdgeId> =
                loops.iter().flat_map(|&(_, i)| self.boundary_loop(starts[i as usize])).collect();
            let is_fillable = |&&(_, i): &&(u32, u32)| !self.is_around_face(starts[i as usize]);
            let fillable = loops.iter().filter(is_fillable).count();
            cluster.iter().for_each(|(_, group)| self.join_copies(group));
            if self.simple_loops(&sides).is_some_and(|count| count > fillable) {
                joined.extend(cluster.iter().map(|(_, group)| (*group).clone()));
            } else {
                cluster.iter().for_each(|(_, group)| self.cut_fans_at(group));
            }
        }
        joined
    }

    /// Whether a boundary loop is the outline of a single face.
    pub(super) fn is_around_face(&self, exterior: HalfEdgeId) -> bool {
        let face = self.face(exterior.twin());
        let mut sides = self.boundary_loop(exterior);
        sides.by_ref().take(3).all(|h| self.face(h.twin()) == face) && sides.next().is_none()
    }

    /// The number of loops that half-edges form, if none of them passes through a vertex twice.
    fn simple_loops(&self, sides: &[HalfEdgeId]) -> Option<usize> {
        let mut sorted = sides.to_vec();
        sorted.sort_unstable();
        let place = |h: HalfEdgeId| sorted.partition_point(|&other| other < h);
        let mut loop_of = vec![0; sides.len()];
        let mut loops = 0;
        for &side in sides {
            if loop_of[place(side)] > 0 {
                continue;
            }
            loops += 1;
            self.boundary_loop(side).for_each(|h| loop_of[place(h)] = loops);
        }
        let mut visits: Vec<(VertexId, usize)> =
            sides.iter().map(|&h| (self.origin(h), loop_of[place(h)])).collect();
        visits.sort_unstable();
        visits.windows(2).all(|pair| pair[0] != pair[1]).then_some(loops)
    }
}
