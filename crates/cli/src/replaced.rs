//! Content of the input that the results of a command replace.

use std::path::Path;

use mesh_io::{Lost, ScalarValues, Scalars};

use crate::console::Console;
use crate::text::printable;

/// Colours and numbers of the input that results took the place of.
#[derive(Debug, Default)]
pub(crate) struct Replaced {
    colors: u64,
    names: Vec<String>,
}

impl Replaced {
    /// Removes colours that have to make room.
    pub(crate) fn take(&mut self, colors: &mut Option<Vec<[f32; 4]>>) {
        self.colors += colors.take().map_or(0, |colors| colors.len() as u64);
    }

    /// Sets the numbers of this name.
    pub(crate) fn set(
        &mut self,
        all: &mut Vec<Scalars>,
        name: &str,
        values: impl Into<ScalarValues>,
    ) {
        let before = all.len();
        all.retain(|scalars| scalars.name != name);
        if all.len() < before {
            self.names.push(name.to_owned());
        }
        all.push(Scalars::new(name, values));
    }

    /// Reports what was replaced.
    pub(crate) fn tell(self, input: &Path, console: &Console) {
        let name = printable(input.display());
        let lose = |what: &str, count| {
            let lost = Lost::some(what, count, "the results of this command take their place");
            console.message(format_args!("{name}: lost {lost}"));
            console.lose(&name, console.command(), &lost);
        };
        if self.colors > 0 {
            lose("colours", self.colors);
        }
        if !self.names.is_empty() {
            lose(&format!("numbers {}", self.names.join(", ")), self.names.len() as u64);
        }
    }
}
