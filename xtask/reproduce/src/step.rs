//! One item of a paper, and what computes it.

use std::time::Instant;

use super::item::Item;
use super::run::Run;
use xtask_common::Failure;

/// One item of a paper: its name there, and what computes it.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub(super) name: &'static str,
    /// Names of the data sets that it works on, for the command line.
    pub(super) data: &'static [&'static str],
    pub(super) compute: fn(&Run<'_>, &mut Item) -> Result<(), Failure>,
}

impl Step {
    /// Whether the command line asks for it: by paper, data set, name, or name of its files.
    pub(super) fn is_asked_for(&self, paper: &str, word: &str) -> bool {
        let same = |name: &str| name.eq_ignore_ascii_case(word);
        same(paper)
            || self.data.iter().any(|data| same(data))
            || same(&self.named_item(paper).file_name())
            || same(self.name)
            || same(&format!("{paper} {}", self.name))
    }

    /// The item before anything is computed.
    pub(super) fn named_item(&self, paper: &str) -> Item {
        Item { paper: paper.into(), name: self.name.into(), ..Item::default() }
    }

    /// Computes the item; a failure is kept in it.
    pub(super) fn item(&self, paper: &str, run: &Run<'_>) -> Item {
        let mut item = self.named_item(paper);
        let start = Instant::now();
        if let Err(failure) = (self.compute)(run, &mut item) {
            item.failure = Some(failure.to_string());
        }
        item.took = start.elapsed();
        item
    }
}
