//! Triangles by their corners: small, without exterior half-edges, for collapses and nothing else.
//!
//! Corner `3 f + i` is the i-th of face f, and at the same time the side from there to the next corner.
//! A side knows the one across it, and the edge that it belongs to.
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

/// No vertex, corner or edge.
pub(super) const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Corner {
    /// The vertex; [`NONE`] where the face is gone.
    vertex: u32,
    /// The side across, seen from its other end; [`NONE`] at the rim.
    twin: u32,
    edge: u32,
}

/// The triangles of a part of a manifold.
#[derive(Clone, Debug)]
pub(super) struct Corners {
    corners: Vec<Corner>,
    /// A corner of each edge; [`NONE`] for those that are gone.
    of_edge: Vec<u32>,
    /// The corner of each vertex from which turning counter-clockwise meets all others.
    of_vertex: Vec<u32>,
    faces: usize,
}

/// The next corner of the same face, counter-clockwise.
#[inline]
pub(super) fn next(corner: u32) -> u32 {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

/// The corner before this one.
#[inline]
pub(super) fn previous(corner: u32) -> u32 {
    if corner.is_multiple_of(3) { corner + 2 } else { corner - 1 }
}

impl Corners {
    /// Those of triangles over so many vertices.
    pub(super) fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let of_vertex = vec![NONE; vertices];
        let corner = |&vertex: &u32| Corner { vertex, twin: NONE, edge: NONE };
        let corners: Vec<Corner> = triangles.iter().flatten().map(corner).collect();
        let of_edge = Vec::with_capacity(corners.len() / 2 + corners.len() / 16);
        let mut all = Self { corners, of_edge, of_vertex, faces: triangles.len() };
        all.pair(vertices);
        for corner in 0..all.corners.len() as u32 {
            let Corner { vertex, twin, .. } = all.corners[corner as usize];
            let slot = &mut all.of_vertex[vertex as usize];
            if twin == NONE || *slot == NONE {
                *slot = corner;
            }
        }
        all
    }

    /// Finds what lies across each side: sides wait in lists at that one of their ends which has fewer,
    /// so that no list is long.
    fn pair(&mut self, vertices: usize) {
        let mut counts = vec![0_u32; vertices];
        self.corners.iter().for_each(|corner| counts[corner.vertex as usize] += 1);
        let place = |v: u32| (counts[v as usize], v);
        let mut first = vec![NONE; vertices];
        let mut after = vec![NONE; self.corners.len()];
        for side in 0..self.corners.len() as u32 {
            let (from, to) = (self.vertex(side), self.target(side));
            let meeting = if place(from) < place(to) { from } else { to };
            let head = &mut first[meeting as usize];
            let (mut before, mut other) = (NONE, *head);
            while other != NONE && (self.vertex(other) != to || self.target(other) != from) {
                (before, other) = (other, after[other as usize]);
            }
            if other == NONE {
                after[side as usize] = *head;
                *head = side;
                let edge = self.of_edge.len() as u32;
                self.corners[side as usize].edge = edge;
                self.of_edge.push(side);
            } else {
                let rest = after[other as usize];
                if before == NONE {
                    *head = rest;
                } else {
                    after[before as usize] = rest;
                }
                let edge = self.corners[other as usize].edge;
                self.corners[other as usize].twin = side;
                self.corners[side as usize] = Corner { vertex: from, twin: other, edge };
            }
        }
    }

    /// The number of faces that are left.
    pub(super) fn faces(&self) -> usize {
        self.faces
    }

    /// The number of edges there were.
    pub(super) fn edge_capacity(&self) -> usize {
        self.of_edge.len()
    }

    /// A side of an edge; [`NONE`] when it is gone.
    #[inline]
    pub(super) fn of_edge(&self, edge: u32) -> u32 {
        self.of_edge[edge as usize]
    }

    /// The vertex of a corner; [`NONE`] when its face is gone.
    #[inline]
    pub(super) fn vertex(&self, corner: u32) -> u32 {
        self.corners[corner as usize].vertex
    }

    /// Where the side that starts at a corner ends.
    #[inline]
    pub(super) fn target(&self, corner: u32) -> u32 {
        self.vertex(next(corner))
    }

    #[inline]
    pub(super) fn twin(&self, corner: u32) -> u32 {
        self.corners[corner as usize].twin
    }

    #[inline]
    pub(super) fn edge(&self, corner: u32) -> u32 {
        self.corners[corner as usize].edge
    }

    /// The first corner at a vertex; [`NONE`] when it has no faces.
    #[inline]
    pub(super) fn first_at(&self, vertex: u32) -> u32 {
        self.of_vertex[vertex as usize]
    }

    /// The corner after this one counter-clockwise at the same vertex, before `first` comes again.
    #[inline]
    pub(super) fn turn(&self, corner: u32, first: u32) -> Option<u32> {
        let next = self.twin(previous(corner));
        (next != NONE && next != first).then_some(next)
    }

    /// Whether a vertex all of whose faces are here lies at the rim.
    #[inline]
    pub(super) fn is_at_rim(&self, vertex: u32) -> bool {
        let first = self.first_at(vertex);
        first == NONE || self.twin(first) == NONE
    }

    /// The triangles that are left, by the number of each.
    pub(super) fn triangles(&self) -> impl Iterator<Item = (usize, [u32; 3])> + '_ {
        let triangles = self.corners.as_chunks::<3>().0.iter().enumerate();
        triangles.filter(|(_, t)| t[0].vertex != NONE).map(|(i, t)| (i, t.map(|c| c.vertex)))
    }

    /// Merges the vertex at which `side` starts into the one where it ends. The caller has made sure
    /// that a manifold is left. `merged` hears of each pair of corners of which the first takes the place
    /// of the second's twin.
    pub(super) fn collapse(&mut self, side: u32, mut merged: impl FnMut(u32, u32)) {
        let (removed, kept) = (self.vertex(side), self.target(side));
        let at_rim = self.is_at_rim(removed) || self.is_at_rim(kept);
        let first = self.first_at(removed);
        let mut corner = first;
        loop {
            self.corners[corner as usize].vertex = kept;
            match self.turn(corner, first) {
                Some(next) => corner = next,
                None => break,
            }
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
            // Back to the side that has nothing across.
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

    /// Takes out the face of `side`, whose other sides are `stays` and `goes`: what is across them is
    /// then across each other. `from_apex` is the one that starts at the third corner. Returns a
    /// corner at the vertex that is left, if this face knows one.
    fn close(
        &mut self,
        side: u32,
        stays: u32,
        goes: u32,
        from_apex: u32,
        merged: &mut impl FnMut(u32, u32),
    ) -> u32 {
        let apex = self.vertex(from_apex);
        let [p, q] = [stays, goes].map(|side| self.twin(side));
        let (edge, gone) = (self.edge(stays), self.edge(goes));
        if p != NONE {
            self.corners[p as usize].twin = q;
        }
        if q != NONE {
            self.corners[q as usize].twin = p;
            self.corners[q as usize].edge = edge;
            merged(stays, q);
        }
        self.of_edge[edge as usize] = if p == NONE { q } else { p };
        self.of_edge[gone as usize] = NONE;
        if self.of_vertex[apex as usize] == from_apex {
            // What follows counter-clockwise at the apex.
            self.of_vertex[apex as usize] = self.twin(previous(from_apex));
        }
        for corner in [side, stays, goes] {
            self.corners[corner as usize].vertex = NONE;
        }
        self.faces -= 1;
        // Of the two that are left one starts at the apex, the other one at the vertex that stays.
        let leaving = if from_apex == goes { [q, p] } else { [p, q] };
        match leaving {
            [NONE, NONE] => NONE,
            [NONE, entering] => next(entering),
            [leaving, _] => leaving,
        }
    }
}
