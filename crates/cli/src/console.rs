//! What goes to stdout, and what goes to stderr.

use std::io::{ErrorKind, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;

/// Where messages and results go.
#[derive(Debug)]
pub(crate) struct Console {
    json: bool,
    quiet: bool,
}

impl Console {
    pub(crate) fn new(common: &Common) -> Self {
        Self { json: common.json, quiet: common.quiet }
    }

    /// Something for people to know.
    pub(crate) fn message(&self, text: impl std::fmt::Display) {
        if !self.quiet {
            eprintln!("{text}");
        }
    }

    /// The outcome: the JSON object on stdout if asked for, and the text otherwise.
    pub(crate) fn result(
        &self,
        json: &impl Serialize,
        text: impl std::fmt::Display,
    ) -> Result<(), Failure> {
        let mut stdout = std::io::stdout().lock();
        let written = if self.json {
            writeln!(stdout, "{}", serde_json::to_string(json).map_err(Failure::json)?)
        } else {
            writeln!(stdout, "{text}")
        };
        match written {
            // Whoever reads this has read enough.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            other => other.map_err(Failure::Stdout),
        }
    }

    /// A progress bar of so many steps; hidden when stderr is no terminal.
    pub(crate) fn progress(&self, steps: u64, what: &'static str) -> ProgressBar {
        let style = ProgressStyle::with_template("{msg} {bar:30} {percent}% {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::with_draw_target(Some(steps), self.target())
            .with_style(style)
            .with_message(what)
    }

    /// A sign of life for work whose length is unknown; hidden when stderr is no terminal.
    pub(crate) fn spinner(&self, what: &'static str) -> ProgressBar {
        let spinner = ProgressBar::with_draw_target(None, self.target()).with_message(what);
        spinner.enable_steady_tick(Duration::from_millis(100));
        spinner
    }

    fn target(&self) -> ProgressDrawTarget {
        if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() }
    }
}
