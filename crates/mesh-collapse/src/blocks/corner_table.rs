//! A compact corner table without exterior half-edges, for collapses only.
//!
//! Corner `4 f + i` is the i-th corner of face f, and also the side from there to the next corner. Every fourth entry
//! is unused, so that a face fits into a cache line. Each side stores the opposite side across the edge, and the edge.
//!
//! ```text
//!            c                    p: across (b, c)    q: across (c, a)
//!         q / \ p                 r: across (d, b)    s: across (a, d)
//!          /   \
//!         a--h--b                 a goes, b stays: of the edges (b, c) and (c, a) the first
//!          \   /                  stays, and of (d, b) and (a, d) too, as in `mesh_core`
//!         s \ / r
//!            d
//! ```

use mesh_core::as_u32;

/// No vertex, corner or edge.
pub(super) const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Corner {
    /// The vertex; [`NONE`] where the face is gone.
    vertex: u32,
    /// The opposite side of the same edge; [`NONE`] at the rim.
    twin: u32,
}

impl Corner {
    #[inline]
    fn new(vertex: u32) -> Self {
        Self { vertex, twin: NONE }
    }
}

/// The corners of a face, and an unused one.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Face([Corner; STRIDE]);

/// The distance between the first corners of consecutive faces.
pub(super) const STRIDE: usize = 4;

/// The triangles of a part of a manifold.
#[derive(Clone, Debug)]
pub(super) struct CornerTable {
    faces: Vec<Face>,
    /// The edge of each side.
    edges: Vec<u32>,
    /// A corner of each edge; [`NONE`] for removed edges.
    of_edge: Vec<u32>,
    /// A corner of each vertex from which counter-clockwise turns reach all other corners of the vertex.
    of_vertex: Vec<u32>,
    left: usize,
}

/// The next corner of the same face, counter-clockwise.
#[inline]
pub(super) fn next(corner: u32) -> u32 {
    if corner % 4 == 2 { corner - 2 } else { corner + 1 }
}

/// The corner before this one.
#[inline]
pub(super) fn previous(corner: u32) -> u32 {
    if corner.is_multiple_of(4) { corner + 2 } else { corner - 1 }
}

impl CornerTable {
    /// The table of triangles over `vertices` vertices.
    pub(super) fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut all = Self::unpaired(vertices, triangles);
        all.pair(vertices, triangles);
        all.find_first();
        all
    }

    /// The table of triangles whose sides have known half-edges. The two half-edges of an edge are an even number and
    /// the next one, all below `capacity`.
    pub(super) fn of_half_edges(
        vertices: usize,
        triangles: &[[u32; 3]],
        half_edges: &[[u32; 3]],
        capacity: usize,
    ) -> Self {
        let mut all = Self::unpaired(vertices, triangles);
        let mut side_of = vec![NONE; capacity];
        for (face, half_edges) in half_edges.iter().enumerate() {
            for (side, &half_edge) in (STRIDE * face..).zip(half_edges) {
                side_of[half_edge as usize] = as_u32(side);
            }
        }
        for (face, half_edges) in half_edges.iter().enumerate() {
            for (side, &half_edge) in (STRIDE * face..).zip(half_edges) {
                let twin = side_of[half_edge as usize ^ 1];
                all.corner_mut(as_u32(side)).twin = twin;
                // Edges are numbered in the order of their first side.
                all.edges[side] = if twin == NONE || twin as usize > side {
                    all.of_edge.push(as_u32(side));
                    as_u32(all.of_edge.len()) - 1
                } else {
                    all.edges[twin as usize]
                };
            }
        }
        all.find_first();
        all
    }

    /// A table without any opposite sides.
    fn unpaired(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let face = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [Corner::new(a), Corner::new(b), Corner::new(c)];
            Face([a, b, c, Corner::new(NONE)])
        };
        Self {
            faces: triangles.iter().map(face).collect(),
            edges: vec![NONE; STRIDE * triangles.len()],
            of_edge: Vec::with_capacity(3 * triangles.len() / 2 + triangles.len() / 16 + 3),
            of_vertex: vec![NONE; vertices],
            left: triangles.len(),
        }
    }

    /// Finds the first corner at each vertex.
    fn find_first(&mut self) {
        for (face, Face(corners)) in self.faces.iter().enumerate() {
            for (i, &Corner { vertex, twin }) in corners[..3].iter().enumerate() {
                let slot = &mut self.of_vertex[vertex as usize];
                if twin == NONE || *slot == NONE {
                    *slot = as_u32(STRIDE * face + i);
                }
            }
        }
    }

    /// Finds the opposite side of each side. Sides wait in a list at the end that has fewer of them, so that no list is
    /// long.
    fn pair(&mut self, vertices: usize, triangles: &[[u32; 3]]) {
        /// A waiting side: its other end, and the next side in the list.
        #[derive(Clone, Copy)]
        struct BucketQueue {
            elsewhere: u32,
            after: u32,
        }
        let mut counts = vec![0_u32; vertices];
        triangles.as_flattened().iter().for_each(|&v| counts[v as usize] += 1);
        let mut first = vec![NONE; vertices];
        let mut queue =
            vec![BucketQueue { elsewhere: NONE, after: NONE }; STRIDE * triangles.len()];
        for (face, &[a, b, c]) in triangles.iter().enumerate() {
            for (side, (from, to)) in (STRIDE * face..).zip([(a, b), (b, c), (c, a)]) {
                let [at_from, at_to] = [counts[from as usize], counts[to as usize]];
                let is_from = at_from < at_to || (at_from == at_to && from < to);
                let (here, elsewhere) = if is_from { (from, to) } else { (to, from) };
                let head = first[here as usize];
                let (mut before, mut other) = (NONE, head);
                while other != NONE && queue[other as usize].elsewhere != elsewhere {
                    (before, other) = (other, queue[other as usize].after);
                }
                if other == NONE {
                    queue[side] = BucketQueue { elsewhere, after: head };
                    first[here as usize] = as_u32(side);
                    self.edges[side] = as_u32(self.of_edge.len());
                    self.of_edge.push(as_u32(side));
                } else {
                    let rest = queue[other as usize].after;
                    match before {
                        NONE => first[here as usize] = rest,
                        _ => queue[before as usize].after = rest,
                    }
                    self.edges[side] = self.edges[other as usize];
                    self.corner_mut(other).twin = as_u32(side);
                    self.corner_mut(as_u32(side)).twin = other;
                }
            }
        }
    }

    #[inline]
    fn corner(&self, corner: u32) -> &Corner {
        &self.faces[corner as usize / STRIDE].0[corner as usize % STRIDE]
    }

    #[inline]
    fn corner_mut(&mut self, corner: u32) -> &mut Corner {
        &mut self.faces[corner as usize / STRIDE].0[corner as usize % STRIDE]
    }

    /// The number of remaining faces.
    pub(super) fn faces(&self) -> usize {
        self.left
    }

    /// The original number of edges.
    pub(super) fn edge_capacity(&self) -> usize {
        self.of_edge.len()
    }

    /// A side of an edge; [`NONE`] for a removed edge.
    #[inline]
    pub(super) fn of_edge(&self, edge: u32) -> u32 {
        self.of_edge[edge as usize]
    }

    /// The vertex of a corner; [`NONE`] for a removed face.
    #[inline]
    pub(super) fn vertex(&self, corner: u32) -> u32 {
        self.corner(corner).vertex
    }

    /// The end of the side that starts at a corner.
    #[inline]
    pub(super) fn target(&self, corner: u32) -> u32 {
        self.vertex(next(corner))
    }

    /// The vertex opposite to a side; [`NONE`] for [`NONE`].
    #[inline]
    pub(super) fn apex(&self, side: u32) -> u32 {
        if side == NONE { NONE } else { self.vertex(previous(side)) }
    }

    #[inline]
    pub(super) fn twin(&self, corner: u32) -> u32 {
        self.corner(corner).twin
    }

    #[inline]
    pub(super) fn edge(&self, corner: u32) -> u32 {
        self.edges[corner as usize]
    }

    /// The first corner at a vertex; [`NONE`] if it has no faces.
    #[inline]
    pub(super) fn first_at(&self, vertex: u32) -> u32 {
        self.of_vertex[vertex as usize]
    }

    /// The next corner counter-clockwise at the same vertex, until `first` is reached again.
    #[inline]
    pub(super) fn turn(&self, corner: u32, first: u32) -> Option<u32> {
        let next = self.twin(previous(corner));
        (next != NONE && next != first).then_some(next)
    }

    /// The remaining triangles, with their indices.
    pub(super) fn triangles(&self) -> impl Iterator<Item = (usize, [u32; 3])> + '_ {
        let faces = self.faces.iter().enumerate();
        let triangles = faces.map(|(i, &Face([a, b, c, _]))| (i, [a.vertex, b.vertex, c.vertex]));
        triangles.filter(|(_, t)| t[0] != NONE)
    }

    /// Merges the start vertex of `side` into its end vertex. `fan` are the corners at the start vertex, except those
    /// of vanishing faces; `at_rim` tells whether one of the two vertices lies at the rim. The caller must ensure that
    /// the result is a manifold. `merged` receives pairs of corners; the first one takes the place of the twin of the
    /// second.
    #[inline]
    pub(super) fn collapse(
        &mut self,
        side: u32,
        fan: &[u32],
        at_rim: bool,
        mut merged: impl FnMut(u32, u32),
    ) {
        let (removed, kept) = (self.vertex(side), self.target(side));
        for &corner in fan {
            self.corner_mut(corner).vertex = kept;
        }
        let twin = self.twin(side);
        let edge = self.edge(side);
        self.of_edge[edge as usize] = NONE;
        let (bc, ca) = (next(side), previous(side));
        let mut start = self.close(side, bc, ca, ca, &mut merged);
        if twin != NONE {
            let (ad, db) = (next(twin), previous(twin));
            let other = self.close(twin, db, ad, db, &mut merged);
            if start == NONE {
                start = other;
            }
        }
        if at_rim {
            // Turn back to the side without an opposite side.
            let found = start;
            while start != NONE && self.twin(start) != NONE {
                start = next(self.twin(start));
                if start == found {
                    break;
                }
            }
        }
        self.of_vertex[kept as usize] = start;
        self.of_vertex[removed as usize] = NONE;
    }

    /// Removes the face of `side`; `stays` and `goes` are its other sides. Their opposite sides become opposite to each
    /// other. `from_apex` is the side that starts at the third corner. Returns a corner at the remaining vertex, if
    /// this face determines one.
    #[inline]
    fn close(
        &mut self,
        side: u32,
        stays: u32,
        goes: u32,
        from_apex: u32,
        merged: &mut impl FnMut(u32, u32),
    ) -> u32 {
        let apex = self.vertex(from_apex);
        let (p, q) = (self.twin(stays), self.twin(goes));
        let (edge, gone) = (self.edge(stays), self.edge(goes));
        if p != NONE {
            self.corner_mut(p).twin = q;
        }
        if q != NONE {
            self.corner_mut(q).twin = p;
            self.edges[q as usize] = edge;
            merged(stays, q);
        }
        self.of_edge[edge as usize] = if p == NONE { q } else { p };
        self.of_edge[gone as usize] = NONE;
        if self.of_vertex[apex as usize] == from_apex {
            // The next corner counter-clockwise at the apex.
            self.of_vertex[apex as usize] = self.twin(previous(from_apex));
        }
        for corner in [side, stays, goes] {
            self.corner_mut(corner).vertex = NONE;
        }
        self.left -= 1;
        // One of the two remaining sides starts at the apex, the other one at the remaining vertex.
        let leaving = if from_apex == goes { [q, p] } else { [p, q] };
        match leaving {
            [NONE, NONE] => NONE,
            [NONE, entering] => next(entering),
            [leaving, _] => leaving,
        }
    }
}
