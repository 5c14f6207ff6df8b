//! What a reader passes over, in words.

use crate::text::brief;
use std::collections::HashSet;

/// Notes about a file: each of them once, printable, and not more than anyone reads.
#[derive(Default)]
pub(crate) struct Notes {
    notes: Vec<String>,
    seen: HashSet<String>,
    left_out: u64,
}

/// So many notes are kept; of the others only their number.
const MOST: usize = 100;

impl Notes {
    pub(crate) fn add(&mut self, note: impl AsRef<str>) {
        let note = brief(note.as_ref());
        if self.seen.contains(note.as_ref()) {
            return;
        }
        if self.notes.len() == MOST {
            self.left_out += 1;
            return;
        }
        self.seen.insert(note.clone().into_owned());
        self.notes.push(note.into_owned());
    }

    pub(crate) fn finish(mut self) -> Vec<String> {
        if self.left_out > 0 {
            self.notes.push(format!("{} more notes are left out", self.left_out));
        }
        self.notes
    }
}
