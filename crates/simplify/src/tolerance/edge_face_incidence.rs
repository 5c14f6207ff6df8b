//! The incidence between edges of one mesh and faces of another, in linked lists in both directions.

use mesh_core::{FaceId, Handle, as_u32};

/// Pairs of an edge and a face. All pairs of a face are removed at once.
pub(super) struct EdgeFaceIncidence {
    of_face: Vec<u32>,
    /// The first pair of each edge, where the list of the edge begins. Most edges have only this one. A place below the
    /// length of `first` is an index into `first`; higher places are indices into `others`.
    first: Vec<Pair>,
    others: Vec<Other>,
    /// The first free place in `others`. Free places are linked by `next_of_edge`.
    free: u32,
}

#[derive(Clone, Copy)]
struct Pair {
    /// [`NONE`] where there is no pair in this place.
    face: u32,
    /// The place of the next pair of the same face; `next_of_edge` is that of the same edge.
    next_of_face: u32,
    next_of_edge: u32,
}

/// A pair that is not the first of its edge.
#[derive(Clone, Copy)]
struct Other {
    edge: u32,
    pair: Pair,
}

const NONE: u32 = u32::MAX;

/// The number of entries by which `others` grows at least. Doubling would waste memory.
const MORE: usize = 1 << 14;

impl EdgeFaceIncidence {
    pub(super) fn new(faces: usize, edges: usize) -> Self {
        let nothing = Pair { face: NONE, next_of_face: NONE, next_of_edge: NONE };
        let (of_face, first) = (vec![NONE; faces], vec![nothing; edges]);
        Self { of_face, first, others: Vec::new(), free: NONE }
    }

    /// Adds a pair that is not in the lists yet.
    pub(super) fn add(&mut self, edge: u32, face: FaceId) {
        let edges = self.first.len();
        let first_of_face = &mut self.of_face[face.index()];
        let first = &mut self.first[edge as usize];
        let (face, next_of_face) = (face.get(), *first_of_face);
        if first.face == NONE {
            *first = Pair { face, next_of_face, ..*first };
            *first_of_face = edge;
            return;
        }
        let pair = Pair { face, next_of_face, next_of_edge: first.next_of_edge };
        let place = match self.free {
            NONE => {
                let place = edges + self.others.len();
                // A number that is cut off would be the place of another pair.
                assert!(place < NONE as usize, "more pairs of edges and faces than 32 bits number");
                as_u32(place)
            }
            place => place,
        };
        first.next_of_edge = place;
        *first_of_face = place;
        match self.others.get_mut(place as usize - edges) {
            Some(other) => {
                self.free = other.pair.next_of_edge;
                *other = Other { edge, pair };
            }
            None => {
                if self.others.len() == self.others.capacity() {
                    self.others.reserve_exact(MORE + self.others.len() / 8);
                }
                self.others.push(Other { edge, pair });
            }
        }
    }

    pub(super) fn of_face(&self, face: FaceId) -> impl Iterator<Item = u32> + '_ {
        let next = |&place: &u32| some(self.pair(place).next_of_face);
        core::iter::successors(some(self.of_face[face.index()]), next).map(|place| self.edge(place))
    }

    pub(super) fn of_edge(&self, edge: u32) -> impl Iterator<Item = FaceId> + '_ {
        let next = |&place: &u32| some(self.pair(place).next_of_edge);
        core::iter::successors(Some(edge), next)
            .filter_map(|place| some(self.pair(place).face))
            .map(|face| FaceId::from_index(face as usize))
    }

    /// Removes all pairs of a face.
    pub(super) fn clear(&mut self, face: FaceId) {
        let mut next = core::mem::replace(&mut self.of_face[face.index()], NONE);
        while next != NONE {
            let place = next;
            let Pair { next_of_face, next_of_edge, .. } = *self.pair(place);
            next = next_of_face;
            let edge = self.edge(place);
            if place == edge {
                // The first pair stays as the head of the list of its edge.
                self.pair_mut(place).face = NONE;
                continue;
            }
            // Few faces have the same edge, so a linear search is enough.
            let mut before = edge;
            while self.pair(before).next_of_edge != place {
                before = self.pair(before).next_of_edge;
            }
            self.pair_mut(before).next_of_edge = next_of_edge;
            self.pair_mut(place).next_of_edge = self.free;
            self.free = place;
        }
    }

    fn pair(&self, place: u32) -> &Pair {
        let place = place as usize;
        match self.first.get(place) {
            Some(pair) => pair,
            None => &self.others[place - self.first.len()].pair,
        }
    }

    fn pair_mut(&mut self, place: u32) -> &mut Pair {
        let place = place as usize;
        let edges = self.first.len();
        match self.first.get_mut(place) {
            Some(pair) => pair,
            None => &mut self.others[place - edges].pair,
        }
    }

    fn edge(&self, place: u32) -> u32 {
        match (place as usize).checked_sub(self.first.len()) {
            Some(other) => self.others[other].edge,
            None => place,
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
        let mut incidence = EdgeFaceIncidence::new(4, 3);
        let face = FaceId::from_index;
        for (edge, f) in [(0, 0), (0, 1), (0, 2), (1, 1), (2, 1), (2, 3)] {
            incidence.add(edge, face(f));
        }
        incidence.clear(face(1));
        let faces = |incidence: &EdgeFaceIncidence, t| {
            let mut faces: Vec<usize> = incidence.of_edge(t).map(Handle::index).collect();
            faces.sort_unstable();
            faces
        };
        assert_eq!([0, 1, 2].map(|t| faces(&incidence, t)), [vec![0, 2], vec![], vec![3]]);
        assert_eq!(incidence.of_face(face(1)).count(), 0);
        // Places that were freed are used again.
        incidence.add(1, face(2));
        incidence.add(0, face(3));
        assert_eq!(incidence.others.len(), 3);
        assert_eq!([0, 1, 2].map(|t| faces(&incidence, t)), [vec![0, 2, 3], vec![2], vec![3]]);
        let mut of_two: Vec<u32> = incidence.of_face(face(2)).collect();
        of_two.sort_unstable();
        assert_eq!(of_two, [0, 1]);
    }
}
