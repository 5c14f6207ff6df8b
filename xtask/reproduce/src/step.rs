//! One item of a paper, and what computes it.

use std::time::Instant;

use super::item::Item;
use super::run::Run;
use xtask_common::Failure;

/// One item of a paper: its name there, and what computes it.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub(super) name: &'static str,
    pub(super) compute: fn(&Run<'_>, &mut Item) -> Result<(), Failure>,
}

impl Step {
    /// Computes the item; a failure is kept in it.
    pub(super) fn item(&self, paper: &str, run: &Run<'_>) -> Item {
        let mut item = Item { paper: paper.into(), name: self.name.into(), ..Item::default() };
        let start = Instant::now();
        if let Err(failure) = (self.compute)(run, &mut item) {
            item.failure = Some(failure.to_string());
        }
        item.took = start.elapsed();
        item
    }
}
