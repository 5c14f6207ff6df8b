//! The messages of a reader: notes for people, and lost content.

use crate::lost::Lost;
use crate::model::Model;
use crate::text::brief;
use std::collections::HashSet;

/// Notes about a file: unique, printable, and limited in number.
#[derive(Default)]
pub(crate) struct Notes {
    notes: Vec<String>,
    lost: Vec<Lost>,
    seen: HashSet<String>,
    left_out: u64,
}

/// This many notes are kept. Further ones are only counted.
const MOST: usize = 100;

impl Notes {
    pub(crate) fn add(&mut self, note: impl AsRef<str>) {
        self.is_new(note.as_ref());
    }

    /// Adds a note, unless it is present already or there are too many. Returns whether it is new.
    fn is_new(&mut self, note: &str) -> bool {
        let note = brief(note);
        if self.seen.contains(note.as_ref()) {
            return false;
        }
        if self.notes.len() == MOST {
            self.left_out += 1;
            return false;
        }
        self.seen.insert(note.clone().into_owned());
        self.notes.push(note.into_owned());
        true
    }

    /// Records content that is not in the model.
    pub(crate) fn lose(&mut self, lost: Lost) {
        if self.is_new(&format!("lost {lost}")) {
            self.lost.push(lost);
        }
    }

    /// Records content that is not in the model, if there is any.
    pub(crate) fn lose_some(&mut self, what: impl AsRef<str>, count: u64, why: impl AsRef<str>) {
        if count > 0 {
            self.lose(Lost::some(what, count, why));
        }
    }

    /// The notes and the losses.
    pub(crate) fn finish(mut self) -> (Vec<String>, Vec<Lost>) {
        if self.left_out > 0 {
            self.notes.push(format!("{} more notes are left out", self.left_out));
        }
        (self.notes, self.lost)
    }

    /// Puts the notes and the losses into the model.
    pub(crate) fn store(self, model: &mut Model) {
        (model.notes, model.lost) = self.finish();
    }
}
