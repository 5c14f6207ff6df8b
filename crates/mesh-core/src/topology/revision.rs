//! Ties the token of a check to one mesh in one state.
//!
//! A token of a check must not be applied to another mesh, or to the same mesh after an edit. So every mesh has its own
//! number and counts its edits, and a token stores both.
//!
//! A copy of a mesh *is* the same state as the original until one of the two is edited: a check of either is valid for
//! both, so tokens may be applied to either. With its first edit the copy takes its own number, and from then on they
//! are two meshes.

use core::sync::atomic::{AtomicU64, Ordering};

/// How often a mesh was edited.
#[derive(Debug)]
pub(crate) struct Revision {
    state: State,
    /// Whether the number of the mesh is that of the original.
    is_copy: bool,
}

/// A state of a mesh. Within one run of a program, different states are never equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct State {
    mesh: u64,
    edits: u64,
}

impl Revision {
    /// The state of a new mesh.
    pub(crate) fn new() -> Self {
        Self { state: State { mesh: new_number(), edits: 0 }, is_copy: false }
    }

    /// The present state.
    pub(crate) fn state(&self) -> State {
        self.state
    }

    /// Counts an edit.
    pub(crate) fn advance(&mut self) {
        if self.is_copy {
            *self = Self::new();
        }
        self.state.edits += 1;
    }
}

impl Clone for Revision {
    fn clone(&self) -> Self {
        Self { state: self.state, is_copy: true }
    }
}

fn new_number() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_equal_only_where_the_meshes_are() {
        let (mut first, mut second) = (Revision::new(), Revision::new());
        assert_ne!(first.state(), second.state());
        let mut copy = first.clone();
        let mut copy_of_copy = copy.clone();
        assert_eq!(first.state(), copy_of_copy.state());
        for revision in [&mut first, &mut second, &mut copy, &mut copy_of_copy] {
            revision.advance();
        }
        let states = [first.state(), second.state(), copy.state(), copy_of_copy.state()];
        for (i, state) in states.iter().enumerate() {
            assert!(!states[..i].contains(state));
        }
    }
}
