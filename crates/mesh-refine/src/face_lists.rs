//! Lists of numbers that belong to faces, as linked lists: moving a number to another face allocates no memory.

use mesh_core::FaceId;

/// A list of numbers for each face. Each number is in at most one list.
pub struct FaceLists {
    first: Vec<u32>,
    following: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl FaceLists {
    /// Empty lists for this many faces, with capacity for this many numbers.
    pub fn new(faces: usize, numbers: usize) -> Self {
        Self { first: vec![NONE; faces], following: Vec::with_capacity(numbers) }
    }

    /// Puts a number at the head of the list of a face. It must not be in another list.
    pub fn push(&mut self, face: FaceId, number: u32) {
        if self.following.len() <= number as usize {
            self.following.resize(number as usize + 1, NONE);
        }
        let slot = &mut self.first[face.index()];
        self.following[number as usize] = *slot;
        *slot = number;
    }

    /// Empties the list of a face.
    pub fn clear(&mut self, face: FaceId) {
        self.first[face.index()] = NONE;
    }

    /// Empties all lists, and keeps their memory.
    pub fn clear_all(&mut self) {
        self.first.fill(NONE);
        self.following.clear();
    }

    /// The numbers of a face, the last one added first.
    pub fn of_face(&self, face: FaceId) -> impl Iterator<Item = u32> + '_ {
        let start = Some(self.first[face.index()]).filter(|&i| i != NONE);
        let following = |&i: &u32| Some(self.following[i as usize]).filter(|&i| i != NONE);
        core::iter::successors(start, following)
    }
}
