//! Which edges of one mesh belong to which faces of another, in linked lists both ways.

use mesh_core::{FaceId, Handle};

/// Pairs of an edge and a face. A face gives all of its edges up at once.
pub(super) struct Covers {
    of_face: Vec<u32>,
    of_edge: Vec<u32>,
    pairs: Vec<Pair>,
    /// A list of pairs that are free again, by their edges' lists.
    free: u32,
}

#[derive(Clone, Copy)]
struct Pair {
    edge: u32,
    face: u32,
    /// The next one of the same face, and of the same edge.
    next_of_face: u32,
    next_of_edge: u32,
}

const NONE: u32 = u32::MAX;

/// Room is made for one pair more in so many: few more come.
const MORE: usize = 8;

impl Covers {
    pub(super) fn new(faces: usize, edges: usize) -> Self {
        let (of_face, of_edge) = (vec![NONE; faces], vec![NONE; edges]);
        // Most edges have one face. What grows is there twice for a moment, and its old place may stay a gap.
        let pairs = Vec::with_capacity(edges + edges / MORE);
        Self { of_face, of_edge, pairs, free: NONE }
    }

    /// Adds a pair that is not there yet.
    pub(super) fn add(&mut self, edge: u32, face: FaceId) {
        let (first_of_face, first_of_edge) =
            (&mut self.of_face[face.index()], &mut self.of_edge[edge as usize]);
        let face = face.index() as u32;
        let (next_of_face, next_of_edge) = (*first_of_face, *first_of_edge);
        let pair = Pair { edge, face, next_of_face, next_of_edge };
        let place = match self.free {
            NONE => {
                if self.pairs.len() == self.pairs.capacity() {
                    self.pairs.reserve_exact(self.pairs.len() / MORE + 1);
                }
                self.pairs.push(pair);
                self.pairs.len() as u32 - 1
            }
            place => {
                self.free = self.pairs[place as usize].next_of_edge;
                self.pairs[place as usize] = pair;
                place
            }
        };
        (*first_of_face, *first_of_edge) = (place, place);
    }

    pub(super) fn of_face(&self, face: FaceId) -> impl Iterator<Item = u32> + '_ {
        let following = |&i: &u32| some(self.pairs[i as usize].next_of_face);
        core::iter::successors(some(self.of_face[face.index()]), following)
            .map(|i| self.pairs[i as usize].edge)
    }

    pub(super) fn of_edge(&self, edge: u32) -> impl Iterator<Item = FaceId> + '_ {
        let following = |&i: &u32| some(self.pairs[i as usize].next_of_edge);
        core::iter::successors(some(self.of_edge[edge as usize]), following)
            .map(|i| FaceId::from_index(self.pairs[i as usize].face as usize))
    }

    /// Removes all pairs of a face.
    pub(super) fn clear(&mut self, face: FaceId) {
        let mut next = core::mem::replace(&mut self.of_face[face.index()], NONE);
        while next != NONE {
            let place = next;
            let Pair { edge, next_of_face, next_of_edge, .. } = self.pairs[place as usize];
            next = next_of_face;
            // Few faces have the same edge.
            let mut before = self.of_edge[edge as usize];
            if before == place {
                self.of_edge[edge as usize] = next_of_edge;
            } else {
                while self.pairs[before as usize].next_of_edge != place {
                    before = self.pairs[before as usize].next_of_edge;
                }
                self.pairs[before as usize].next_of_edge = next_of_edge;
            }
            self.pairs[place as usize].next_of_edge = self.free;
            self.free = place;
        }
    }
}

fn some(place: u32) -> Option<u32> {
    Some(place).filter(|&place| place != NONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_found_from_both_sides_until_the_face_gives_them_up() {
        let mut covers = Covers::new(4, 3);
        let face = FaceId::from_index;
        for (edge, f) in [(0, 0), (0, 1), (0, 2), (1, 1), (2, 1), (2, 3)] {
            covers.add(edge, face(f));
        }
        covers.clear(face(1));
        let faces = |covers: &Covers, t| {
            let mut faces: Vec<usize> = covers.of_edge(t).map(Handle::index).collect();
            faces.sort_unstable();
            faces
        };
        assert_eq!([0, 1, 2].map(|t| faces(&covers, t)), [vec![0, 2], vec![], vec![3]]);
        assert_eq!(covers.of_face(face(1)).count(), 0);
        // What was given up is used again.
        covers.add(1, face(2));
        covers.add(0, face(3));
        assert_eq!(covers.pairs.len(), 6);
        assert_eq!([0, 1, 2].map(|t| faces(&covers, t)), [vec![0, 2, 3], vec![2], vec![3]]);
        let mut of_two: Vec<u32> = covers.of_face(face(2)).collect();
        of_two.sort_unstable();
        assert_eq!(of_two, [0, 1]);
    }
}
