//! Connectivity through edges of triangles that need not be manifold: components and fans.

use crate::index::as_u32;
use crate::topology::disjoint_sets::DisjointSets;
use crate::topology::pairing::next;

/// Triangles that are connected edge by edge. Side i runs from corner i to the next corner of its triangle;
/// both belong to triangle i / 3.
#[derive(Clone, Debug)]
pub struct EdgeConnectivity<'t> {
    triangles: &'t [[u32; 3]],
    /// Vertices that are connected through edges.
    pub vertices: DisjointSets,
    /// Triangles that are connected through edges.
    pub faces: DisjointSets,
    /// Corners that are connected through the edges at their vertex: a set is a fan of faces.
    pub corners: DisjointSets,
}

impl<'t> EdgeConnectivity<'t> {
    /// Triangles over a number of vertices, not connected yet.
    #[must_use]
    pub fn new(vertices: usize, triangles: &'t [[u32; 3]]) -> Self {
        Self {
            triangles,
            vertices: DisjointSets::new(vertices),
            faces: DisjointSets::new(triangles.len()),
            corners: DisjointSets::new(3 * triangles.len()),
        }
    }

    /// The vertex of a corner.
    fn vertex(&self, corner: u32) -> u32 {
        self.triangles[corner as usize / 3][corner as usize % 3]
    }

    /// Connects vertices, faces and corners that meet at an edge, given by all its sides. Returns its ends.
    ///
    /// # Panics
    /// No side is given, or one is out of range.
    pub fn connect(&mut self, mut sides: impl Iterator<Item = u32>) -> [u32; 2] {
        #[expect(clippy::expect_used, reason = "documented panic")]
        let first = sides.next().expect("an edge with a side");
        let [from, to] = [self.vertex(first), self.vertex(next(first))];
        self.vertices.union(from, to);
        for side in sides {
            self.faces.union(first / 3, side / 3);
            let is_parallel = self.vertex(side) == from;
            let [at_from, at_to] =
                if is_parallel { [side, next(side)] } else { [next(side), side] };
            self.corners.union(first, at_from);
            self.corners.union(next(first), at_to);
        }
        [from, to]
    }

    /// The number of fans at each vertex: 0 without faces, 1 where all faces are connected through edges at it.
    #[must_use]
    pub fn fans(&mut self, vertices: usize) -> Vec<u32> {
        let mut fans = vec![0_u32; vertices];
        for corner in 0..3 * as_u32(self.triangles.len()) {
            let v = self.vertex(corner) as usize;
            if v < vertices && self.corners.find(corner) == corner {
                fans[v] += 1;
            }
        }
        fans
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_faces_at_an_edge_and_one_at_a_vertex() {
        let triangles = [[0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 5, 6]];
        let mut edges = EdgeConnectivity::new(7, &triangles);
        assert_eq!(edges.connect([0, 3, 6].into_iter()), [0, 1]);
        for side in [1, 2, 4, 5, 7, 8, 9, 10, 11] {
            edges.connect([side].into_iter());
        }
        assert_eq!(edges.fans(7), [1, 1, 2, 1, 1, 1, 1]);
        assert_eq!(edges.vertices.count_sets(0..7), 1);
        assert_eq!(edges.faces.count_sets(0..4), 2);
        assert_eq!(edges.fans(2), [1, 1]);
    }
}
