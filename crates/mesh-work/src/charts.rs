//! Charts that are merged because the wanted number of faces leaves no room for their borders.
//!
//! Seams divide the faces into *charts*. A vertex at which seams end, fork or cross stays where it is, so a chart with
//! n such nodes on its border keeps at least n - 2 faces. If the sum over all charts exceeds a share of the wanted
//! faces, collapses would have to happen where nothing holds the surface: the shape would pay for the texture. So the
//! smallest charts are merged with the neighbour that shares the longest border, until there is room.
//!
//! A *group* is a set of merged charts. Its *root* is its largest chart, whose attributes guide the collapses in the
//! whole group. Each face of the result takes the attributes of one chart of its group.

use core::cmp::Reverse;
use std::collections::VecDeque;

use mesh_core::{EdgeId, EdgeMap, FaceId, FaceMap, HalfEdgeId, HalfEdgeMap, TriMesh, as_u32};
use simplify::seam_nodes;

/// The largest share of the wanted faces that the borders of charts may need. The other faces are for the shape.
const SHARE: f64 = 0.2;

/// The share of the groups that is merged at once, so that the number of rounds is logarithmic.
const AT_ONCE: f64 = 0.25;

/// The charts of a mesh, and the groups that they were merged into.
#[derive(Clone, Debug)]
pub(crate) struct MergedCharts {
    /// The chart of each face.
    pub(crate) charts: FaceMap<u32>,
    /// The seams that are left.
    pub(crate) seams: EdgeMap<bool>,
    /// The number of charts.
    pub(crate) before: usize,
    /// The number of groups.
    pub(crate) after: usize,
    /// The root of the group of each chart.
    roots: Vec<u32>,
}

/// A mesh with charts. It shares the wanted faces with other meshes.
pub(crate) struct Charted<'a> {
    pub(crate) mesh: &'a TriMesh,
    pub(crate) seams: &'a EdgeMap<bool>,
    /// The number of times that the mesh is drawn.
    pub(crate) times: usize,
    /// The factor by which areas grow where it is drawn.
    pub(crate) growth: f64,
}

impl MergedCharts {
    /// Merges charts of meshes until the borders of all have room in this number of drawn faces. The smallest charts of
    /// all meshes are merged first. `None` for a mesh whose charts have room as they are.
    pub(crate) fn make_room(all: &[Charted<'_>], faces: usize) -> Vec<Option<Self>> {
        let mut all: Vec<Merging<'_>> = all.iter().map(Merging::new).collect();
        let room = SHARE * faces as f64;
        while all.iter().map(|one| one.part.times * one.needed).sum::<usize>() as f64 > room {
            let neighbours = all.iter_mut().zip(0..).map(|(one, i)| one.neighbours(i));
            let mut smallest: Vec<Neighbours> = neighbours.flatten().collect();
            smallest.sort_by(|a, b| a.area.total_cmp(&b.area));
            smallest.truncate((AT_ONCE * smallest.len() as f64).ceil() as usize);
            if smallest.is_empty() {
                break;
            }
            let mut is_changed = vec![false; all.len()];
            for Neighbours { part, small, other, .. } in smallest {
                all[part].groups.join(small, other);
                is_changed[part] = true;
            }
            all.iter_mut().zip(is_changed).filter(|(_, is)| *is).for_each(|(one, _)| one.update());
        }
        all.into_iter().map(Merging::finish).collect()
    }

    /// For each corner, the corner whose attributes guide the collapses: itself in the root of a group, and elsewhere
    /// the closest corner of the root, counted in edges.
    pub(crate) fn guides(&self, mesh: &TriMesh) -> HalfEdgeMap<HalfEdgeId> {
        let topology = mesh.topology();
        let mut guides: HalfEdgeMap<Option<HalfEdgeId>> = topology.half_edge_map(None);
        let mut queue = VecDeque::new();
        for face in topology.faces() {
            if self.roots[self.charts[face] as usize] == self.charts[face] {
                for h in topology.face_half_edges(face) {
                    guides[h] = Some(h);
                    queue.push_back(h);
                }
            }
        }
        while let Some(h) = queue.pop_front() {
            let guide = guides[h];
            // Around the vertex first, so that all corners of a group at a vertex have the same guide.
            let before = topology.next(topology.next(h));
            let clockwise = self.is_open(mesh, h).then(|| topology.next(h.twin()));
            let counterclockwise = self.is_open(mesh, before).then(|| before.twin());
            for at_vertex in [clockwise, counterclockwise].into_iter().flatten() {
                if guides[at_vertex].is_none() {
                    guides[at_vertex] = guide;
                    queue.push_front(at_vertex);
                }
            }
            for in_face in [topology.next(h), before] {
                if guides[in_face].is_none() {
                    guides[in_face] = guide;
                    queue.push_back(in_face);
                }
            }
        }
        let mut all = topology.half_edge_map(HalfEdgeId::new(0));
        for (h, guide) in guides.iter() {
            all[h] = guide.unwrap_or(h);
        }
        all
    }

    /// Whether the faces on both sides of a half-edge are in the same group, without a seam between them.
    fn is_open(&self, mesh: &TriMesh, h: HalfEdgeId) -> bool {
        !self.seams[h.edge()] && !mesh.topology().is_boundary_edge(h.edge())
    }
}

/// Two groups with a common border.
struct Neighbours {
    /// The mesh, by its place in the list.
    part: usize,
    /// The area of the smaller group, as it is drawn.
    area: f64,
    small: u32,
    other: u32,
}

/// The charts of a mesh while they are merged.
struct Merging<'a> {
    part: &'a Charted<'a>,
    charts: Charts,
    groups: Groups,
    /// The seams that are left.
    kept: EdgeMap<bool>,
    /// The number of faces that the seams need.
    needed: usize,
}

impl<'a> Merging<'a> {
    fn new(part: &'a Charted<'a>) -> Self {
        let charts = Charts::new(part.mesh, part.seams);
        let mut groups = Groups::new(charts.areas.clone());
        let kept = part.seams.clone();
        let needed = charts.faces_needed(part.mesh, &kept, &mut groups);
        Self { part, charts, groups, kept, needed }
    }

    /// Each group that has neighbours, with the one that shares the longest border.
    fn neighbours(&mut self, part: usize) -> Vec<Neighbours> {
        let all = self.charts.neighbours(self.part.mesh, &self.kept, &mut self.groups);
        let found = |(small, other): (u32, u32)| {
            let area = self.part.growth * self.groups.areas[small as usize];
            Neighbours { part, area, small, other }
        };
        all.into_iter().map(found).collect()
    }

    /// Drops the seams inside groups.
    fn update(&mut self) {
        let Charted { mesh, seams, .. } = *self.part;
        self.kept = self.charts.borders(mesh, seams, &mut self.groups);
        self.needed = self.charts.faces_needed(mesh, &self.kept, &mut self.groups);
    }

    fn finish(self) -> Option<MergedCharts> {
        let Self { charts, mut groups, kept: seams, .. } = self;
        let before = charts.areas.len();
        let roots: Vec<u32> = (0..as_u32(before)).map(|chart| groups.root(chart)).collect();
        let after = roots.iter().zip(0..).filter(|&(&root, chart)| root == chart).count();
        let merged = MergedCharts { charts: charts.of_face, seams, before, after, roots };
        (after < before).then_some(merged)
    }
}

/// The charts of a mesh.
struct Charts {
    of_face: FaceMap<u32>,
    areas: Vec<f64>,
}

impl Charts {
    /// Floods the faces between seams.
    fn new(mesh: &TriMesh, seams: &EdgeMap<bool>) -> Self {
        let topology = mesh.topology();
        let mut of_face = topology.face_map(u32::MAX);
        let mut areas = Vec::new();
        let mut open: Vec<FaceId> = Vec::new();
        for start in topology.faces() {
            if of_face[start] != u32::MAX {
                continue;
            }
            let chart = as_u32(areas.len());
            let mut area = 0.0;
            of_face[start] = chart;
            open.push(start);
            while let Some(face) = open.pop() {
                area += 0.5 * mesh.face_cross(face).length();
                for h in topology.face_half_edges(face).into_iter().filter(|h| !seams[h.edge()]) {
                    if let Some(next) = topology.face(h.twin())
                        && of_face[next] == u32::MAX
                    {
                        of_face[next] = chart;
                        open.push(next);
                    }
                }
            }
            areas.push(area);
        }
        Self { of_face, areas }
    }

    /// The charts on both sides of an edge, if there are two faces.
    fn sides(&self, mesh: &TriMesh, edge: EdgeId) -> Option<[u32; 2]> {
        match mesh.topology().edge_faces(edge) {
            [Some(left), Some(right)] => Some([left, right].map(|face| self.of_face[face])),
            _ => None,
        }
    }

    /// The seams without the borders between charts of one group. A seam inside a chart stays.
    fn borders(&self, mesh: &TriMesh, seams: &EdgeMap<bool>, groups: &mut Groups) -> EdgeMap<bool> {
        let mut kept = seams.clone();
        for edge in mesh.topology().edges().filter(|&edge| seams[edge]) {
            if let Some([a, b]) = self.sides(mesh, edge) {
                kept[edge] = a == b || groups.root(a) != groups.root(b);
            }
        }
        kept
    }

    /// The smallest number of faces between these seams: two less than the number of nodes on the border of each group.
    fn faces_needed(&self, mesh: &TriMesh, kept: &EdgeMap<bool>, groups: &mut Groups) -> usize {
        let topology = mesh.topology();
        let nodes = seam_nodes(topology, kept);
        let mut around = vec![0_usize; self.areas.len()];
        for h in topology.half_edges() {
            // One corner for each sector between two seams.
            if nodes[topology.origin(h)]
                && (kept[h.edge()] || topology.is_boundary_edge(h.edge()))
                && let Some(face) = topology.face(h)
            {
                around[groups.root(self.of_face[face]) as usize] += 1;
            }
        }
        around.into_iter().map(|nodes| nodes.saturating_sub(2)).sum()
    }

    /// Each group that has neighbours, with the one that shares the longest border, by the number of the group.
    fn neighbours(
        &self,
        mesh: &TriMesh,
        kept: &EdgeMap<bool>,
        groups: &mut Groups,
    ) -> Vec<(u32, u32)> {
        // The length of the common border of each pair of neighbours, from both sides.
        let mut borders: Vec<(u32, u32, f64)> = Vec::new();
        for edge in mesh.topology().edges().filter(|&edge| kept[edge]) {
            if let Some(sides) = self.sides(mesh, edge) {
                let [a, b] = sides.map(|chart| groups.root(chart));
                let [p, q] = mesh.segment(edge);
                if a != b {
                    borders.extend([(a, b, p.distance(q)), (b, a, p.distance(q))]);
                }
            }
        }
        borders.sort_unstable_by(|(a, b, m), (c, d, n)| (a, b).cmp(&(c, d)).then(m.total_cmp(n)));
        borders.dedup_by(|next, sum| {
            let is_same = (next.0, next.1) == (sum.0, sum.1);
            if is_same {
                sum.2 += next.2;
            }
            is_same
        });
        borders
            .sort_unstable_by(|(a, b, m), (c, d, n)| a.cmp(c).then(n.total_cmp(m)).then(b.cmp(d)));
        borders.dedup_by_key(|&mut (group, ..)| group);
        borders.into_iter().map(|(group, neighbour, _)| (group, neighbour)).collect()
    }
}

/// Groups of charts, as a forest.
struct Groups {
    parents: Vec<u32>,
    /// The area of each chart, and at a root the area of its group.
    areas: Vec<f64>,
    /// The area of the chart itself.
    own: Vec<f64>,
}

impl Groups {
    fn new(areas: Vec<f64>) -> Self {
        Self { parents: (0..as_u32(areas.len())).collect(), own: areas.clone(), areas }
    }

    /// The largest chart of the group of a chart.
    fn root(&mut self, mut chart: u32) -> u32 {
        while self.parents[chart as usize] != chart {
            let parent = self.parents[chart as usize];
            self.parents[chart as usize] = self.parents[parent as usize];
            chart = parent;
        }
        chart
    }

    fn join(&mut self, a: u32, b: u32) {
        let mut pair = [a, b].map(|chart| self.root(chart));
        if pair[0] == pair[1] {
            return;
        }
        // For charts of equal area the number decides.
        pair.sort_by(|&p, &q| {
            self.own[q as usize].total_cmp(&self.own[p as usize]).then(Reverse(q).cmp(&Reverse(p)))
        });
        let [root, other] = pair;
        self.parents[other as usize] = root;
        self.areas[root as usize] += self.areas[other as usize];
    }
}
