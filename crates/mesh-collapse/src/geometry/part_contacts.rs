//! Contacts between the parts of an assembly: vertices of different parts at equal positions.
//!
//! Parts that touched before a run cannot stay in exact contact if only one of them has been simplified so far: a chord
//! of one cuts the corners of the other. So the vertices that met at the start decide what counts as touching:
//!
//! - A *shared point* is a vertex at the position of a vertex of another part. While both keep equal positions, their
//!   faces count as neighbours with a common vertex.
//! - Shared points that are joined by an edge in both parts form a *contact*: a seam, or a wall that exists twice. Two
//!   faces of different parts at one contact may touch or overlap, provided that all edges that meet the other face
//!   start at the contact.
//!
//! In a collapse, the remaining vertex inherits the membership of the removed one.

use std::collections::HashMap;

use glam::DVec3;
use mesh_core::crossing::{Triangle, segment_meets_triangle};
use mesh_core::{TriMesh, VertexId, triangles_cross};

/// The shared points of a mesh, their contacts, and the part of each vertex.
#[derive(Clone, Debug)]
pub(crate) struct Contacts {
    /// The part of each vertex, by index.
    part: Vec<u32>,
    /// For each vertex, [`NONE`] or a number of a contact; several numbers may mean the same contact.
    number: Vec<u32>,
    /// A forest: numbers with the same root are one contact.
    parent: Vec<u32>,
    /// For a root, whether the contact has edges, and is not just a point.
    is_line: Vec<bool>,
}

const NONE: u32 = u32::MAX;

impl Contacts {
    /// The contacts of the current mesh; `None` if no parts touch at vertices.
    pub(crate) fn new(mesh: &TriMesh) -> Option<Self> {
        let topology = mesh.topology();
        // After sorting by position, vertices with equal positions are consecutive.
        let mut order: Vec<VertexId> =
            topology.vertices().filter(|&v| !topology.is_isolated_vertex(v)).collect();
        // Adding zero turns -0 into 0.
        let key = |v: VertexId| (mesh.position(v) + DVec3::ZERO).to_array().map(f64::to_bits);
        order.sort_unstable_by_key(|&v| (key(v), v));
        let same_place = |a: &VertexId, b: &VertexId| key(*a) == key(*b);
        if order.chunk_by(same_place).all(|group| group.len() == 1) {
            return None;
        }
        let components = topology.components().of_vertex;
        let part: Vec<u32> =
            components.as_slice().iter().map(|part| part.unwrap_or(NONE)).collect();
        let mut number = vec![NONE; topology.vertex_capacity()];
        let mut groups = 0;
        for group in order.chunk_by(same_place) {
            if group.iter().any(|v| part[v.index()] != part[group[0].index()]) {
                group.iter().for_each(|v| number[v.index()] = groups);
                groups += 1;
            }
        }
        if groups == 0 {
            return None;
        }
        let parent = (0..groups).collect();
        let mut contacts = Self { part, number, parent, is_line: vec![false; groups as usize] };
        contacts.join_lines(mesh);
        Some(contacts)
    }

    /// Joins shared points that are connected by an edge in two parts.
    fn join_lines(&mut self, mesh: &TriMesh) {
        let topology = mesh.topology();
        let mut first: HashMap<[u32; 2], u32> = HashMap::new();
        for e in topology.edges() {
            let ends = topology.edge_vertices(e);
            let mut numbers = ends.map(|v| self.number[v.index()]);
            numbers.sort_unstable();
            if numbers.contains(&NONE) || numbers[0] == numbers[1] {
                continue;
            }
            let part = self.part[ends[0].index()];
            if *first.entry(numbers).or_insert(part) != part {
                let root = self.join(numbers);
                self.is_line[root as usize] = true;
            }
        }
        // Parents have smaller numbers, so one pass replaces every parent by its root.
        for number in 0..self.parent.len() {
            self.parent[number] = self.parent[self.parent[number] as usize];
        }
    }

    fn root(&self, mut number: u32) -> u32 {
        while self.parent[number as usize] != number {
            number = self.parent[number as usize];
        }
        number
    }

    /// Merges two contacts under the smaller root.
    fn join(&mut self, numbers: [u32; 2]) -> u32 {
        let [a, b] = numbers.map(|number| self.root(number));
        let (root, other) = (a.min(b), a.max(b));
        self.is_line[root as usize] |= self.is_line[other as usize];
        // Shortens the path to the root for later queries.
        for number in [numbers[0], numbers[1], other] {
            self.parent[number as usize] = root;
        }
        root
    }

    /// Updates the contacts after a collapse.
    pub(crate) fn collapsed(&mut self, removed: VertexId, kept: VertexId) {
        let numbers = [removed, kept].map(|v| self.number[v.index()]);
        match numbers {
            [NONE, _] => {}
            [from, NONE] => self.number[kept.index()] = from,
            _ => {
                self.join(numbers);
            }
        }
    }

    /// The end of an edge that represents both ends after they have merged.
    pub(crate) fn merged(&self, removed: VertexId, kept: VertexId) -> VertexId {
        if self.number_of(kept).is_none() && self.number_of(removed).is_some() {
            removed
        } else {
            kept
        }
    }

    fn number_of(&self, v: VertexId) -> Option<u32> {
        self.number.get(v.index()).copied().filter(|&number| number != NONE)
    }

    /// The contact of a vertex, unless it is a single point.
    fn line(&self, v: VertexId) -> Option<u32> {
        self.number_of(v)
            .map(|number| self.root(number))
            .filter(|&root| self.is_line[root as usize])
    }

    /// Whether two triangles that cross, judged by their vertices, are only in contact.
    pub(crate) fn only_touch(&self, first: Triangle, second: Triangle) -> bool {
        let part = |of: Triangle| self.part.get(of.0[0].index()).copied().unwrap_or(NONE);
        if part(first) == part(second) {
            return false;
        }
        self.touch_at_points(first, second) || self.touch_at_contact(first, second)
    }

    /// Whether they do not cross if shared points at equal positions count as one vertex.
    fn touch_at_points(&self, first: Triangle, second: Triangle) -> bool {
        let mut joined = second;
        for (v, at) in joined.0.iter_mut().zip(second.1) {
            let is_same = |&(w, place): &(VertexId, DVec3)| {
                place == at && self.number_of(w).is_some() && self.number_of(*v).is_some()
            };
            if let Some((w, _)) = first.0.into_iter().zip(first.1).find(is_same) {
                *v = w;
            }
        }
        joined.0 != second.0 && !triangles_cross(first, joined)
    }

    /// Whether they belong to one contact, and each edge of either that meets the other starts at the contact.
    fn touch_at_contact(&self, first: Triangle, second: Triangle) -> bool {
        let lines = |of: Triangle| of.0.map(|v| self.line(v));
        let (a, b) = (lines(first), lines(second));
        let Some(contact) = a.into_iter().flatten().find(|line| b.contains(&Some(*line))) else {
            return false;
        };
        let stays_off = |of: Triangle, lines: [Option<u32>; 3], other: Triangle| {
            (0..3).all(|i| {
                let ends = [i, (i + 1) % 3];
                ends.iter().any(|&k| lines[k] == Some(contact))
                    || !segment_meets_triangle(ends.map(|k| of.1[k]), other.1)
            })
        };
        stays_off(first, a, second) && stays_off(second, b, first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge of one triangle that is away from the contact passes through the other triangle. In either order of the
    /// arguments, this is more than a contact.
    #[test]
    fn triangles_at_a_contact_touch_when_the_edges_of_neither_meet_the_other() {
        // Two parts with two faces each. One edge of each part has the same end positions.
        let (p, q) = ([0.0, 0.0, 0.0], [0.0, 3.0, 0.0]);
        let first = [p, q, [-1.0, 1.0, 1.0], [-1.0, 0.0, 1.0]];
        let second = [p, q, [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let mesh = TriMesh::from_triangles(&[first, second].concat(), &triangles).unwrap();
        let contacts = Contacts::new(&mesh).unwrap();
        let triangle = |vertices: [u32; 3], places: [[f64; 3]; 3]| {
            (vertices.map(VertexId::new), places.map(DVec3::from))
        };
        let flat = triangle([0, 2, 3], [p, [4.0, -2.0, 0.0], [4.0, 2.0, 0.0]]);
        let through = |z: f64| {
            triangle([4, 6, 7], [[0.0, 0.0, 3.0], [1.0, 0.0, z + 1.0], [1.0, 0.0, z - 1.0]])
        };
        for (z, touches) in [(0.0, false), (2.0, true)] {
            assert_eq!(contacts.touch_at_contact(flat, through(z)), touches, "{z}");
            assert_eq!(contacts.touch_at_contact(through(z), flat), touches, "{z}");
        }
        // A single shared point is not a contact.
        let none = triangle([0, 2, 3].map(|v| v % 2 + 2), flat.1.map(|p| p.to_array()));
        assert!(!contacts.touch_at_contact(none, through(2.0)));
    }
}
