//! Whether triangles form an oriented 2-manifold, counted from scratch.

use std::collections::HashMap;

/// Counts of the defects of triangles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) edges: usize,
    /// Edges of one triangle.
    pub(super) boundary: usize,
    /// Edges of more than two triangles.
    pub(super) non_manifold: usize,
    /// Edges of two triangles that run along them in the same direction.
    pub(super) inconsistent: usize,
    /// Triangles that use a vertex twice; they are left out of the counts above.
    pub(super) degenerate: usize,
    /// Vertices whose triangles are not all connected through edges at the vertex.
    pub(super) pinched: usize,
}

impl Counts {
    pub(super) fn of(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let mut counts = Self::default();
        // For each edge, the number of triangles along it, and the number of those that run from the smaller vertex to
        // the larger.
        let mut edges: HashMap<[u32; 2], [usize; 2]> = HashMap::with_capacity(2 * triangles.len());
        let is_degenerate = |[a, b, c]: [u32; 3]| a == b || b == c || c == a;
        for &[a, b, c] in triangles.iter().filter(|&&triangle| !is_degenerate(triangle)) {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let [all, up] = edges.entry([from.min(to), from.max(to)]).or_default();
                *all += 1;
                *up += usize::from(from < to);
            }
        }
        counts.degenerate = triangles.iter().filter(|&&triangle| is_degenerate(triangle)).count();
        counts.edges = edges.len();
        counts.boundary = edges.values().filter(|[all, _]| *all == 1).count();
        counts.non_manifold = edges.values().filter(|[all, _]| *all > 2).count();
        counts.inconsistent = edges.values().filter(|[all, up]| *all == 2 && *up != 1).count();
        counts.pinched = pinched(triangles, vertices, is_degenerate);
        counts
    }

    /// The reason why the triangles are not an oriented 2-manifold.
    pub(super) fn defect(&self) -> Option<String> {
        let counts = [
            (self.degenerate, "triangles that use a vertex twice"),
            (self.non_manifold, "edges of more than two triangles"),
            (self.inconsistent, "edges whose triangles disagree on what is outside"),
            (self.pinched, "pinched vertices"),
        ];
        let found = counts.into_iter().find(|(count, _)| *count > 0);
        found.map(|(count, what)| format!("{count} {what}"))
    }
}

/// The number of vertices whose triangles are not connected through edges at the vertex.
fn pinched(
    triangles: &[[u32; 3]],
    vertices: usize,
    is_degenerate: impl Fn([u32; 3]) -> bool,
) -> usize {
    // The edges opposite to each vertex; the edges of one fan form one connected component.
    let mut links: Vec<Vec<[u32; 2]>> = vec![Vec::new(); vertices];
    for &[a, b, c] in triangles.iter().filter(|&&triangle| !is_degenerate(triangle)) {
        for (vertex, link) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
            if let Some(links) = links.get_mut(vertex as usize) {
                links.push(link);
            }
        }
    }
    links.iter().filter(|link| pieces(link) > 1).count()
}

/// The number of connected components of a graph.
fn pieces(edges: &[[u32; 2]]) -> usize {
    let mut parent: HashMap<u32, u32> = HashMap::with_capacity(edges.len());
    let mut pieces = 0;
    for &[a, b] in edges {
        let [a, b] = [a, b].map(|vertex| {
            pieces += usize::from(!parent.contains_key(&vertex));
            root(&mut parent, vertex)
        });
        if a != b {
            parent.insert(a, b);
            pieces -= 1;
        }
    }
    pieces
}

fn root(parent: &mut HashMap<u32, u32>, mut vertex: u32) -> u32 {
    loop {
        let above = *parent.entry(vertex).or_insert(vertex);
        if above == vertex {
            return vertex;
        }
        // Path halving.
        let next = parent.get(&above).copied().unwrap_or(above);
        parent.insert(vertex, next);
        vertex = next;
    }
}

#[cfg(test)]
mod tests {
    use super::Counts;

    #[test]
    fn defects_are_counted() {
        let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let closed = Counts::of(&tetrahedron, 4);
        assert_eq!(closed, Counts { edges: 6, ..Counts::default() });
        assert_eq!(closed.defect(), None);

        let open = Counts::of(&tetrahedron[..3], 4);
        assert_eq!(open, Counts { edges: 6, boundary: 3, ..Counts::default() });

        let fan = Counts::of(&[[0, 1, 2], [1, 0, 3], [0, 1, 4], [5, 5, 6]], 7);
        assert_eq!((fan.non_manifold, fan.degenerate, fan.pinched), (1, 1, 0));

        let twisted = Counts::of(&[[0, 1, 2], [0, 1, 3]], 4);
        assert_eq!((twisted.inconsistent, twisted.non_manifold), (1, 0));

        let hourglass = Counts::of(&[[0, 1, 2], [0, 3, 4]], 5);
        assert_eq!((hourglass.pinched, hourglass.boundary), (1, 6));
        assert_eq!(hourglass.defect().as_deref(), Some("1 pinched vertices"));
    }
}
