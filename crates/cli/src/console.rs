//! Output to stdout and stderr.

use std::borrow::Cow;
use std::collections::HashSet;
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mesh_io::{Lost, Model};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::args::{Common, is_standard};
use crate::failure::{Described, Failure};
use crate::given::Given;
use crate::inventory::Inventory;
use crate::text::{printable_json, printable_lines};

/// The name of this program in its reports.
const TOOL: &str = "curvmesh";

/// The destination of messages and results.
#[derive(Clone, Debug, Default)]
pub(crate) struct Console {
    json: bool,
    quiet: bool,
    /// Whether a mesh is written to stdout.
    holds_mesh: bool,
    command: String,
    /// The options of the run, for its reports.
    options: Map<String, Value>,
    /// The progress bar over many files; messages are printed above it.
    files: Option<ProgressBar>,
    /// Changes of a run that were not asked for.
    losses: Arc<Mutex<Losses>>,
}

/// Repairs, and content lost between the input and the output of a command.
#[derive(Debug, Default)]
struct Losses {
    repairs: Vec<Repaired>,
    lost: Vec<LostPart>,
    /// The same parts: a file can lose any number of them.
    known: HashSet<LostPart>,
    /// The largest rounding of the outputs.
    rounding: f64,
    stayed: Vec<Stayed>,
    /// The content of the first input.
    input: Option<Inventory>,
    /// Whether anything was written.
    has_output: bool,
}

/// A part of the content that is lost, and its place.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
struct LostPart {
    file: String,
    /// `reading`, `writing`, or the command itself.
    by: String,
    #[serde(flatten)]
    lost: Lost,
}

/// Data of an output that are not in the form that was asked for.
#[derive(Clone, Debug, Serialize)]
struct Stayed {
    file: String,
    what: String,
}

/// A repair of an input.
#[derive(Clone, Debug, Serialize)]
struct Repaired {
    file: String,
    what: &'static str,
    count: usize,
}

/// The first and last fields of every JSON object that this program prints.
#[derive(Serialize)]
struct Signed<'a, T> {
    tool: &'static str,
    version: &'static str,
    #[serde(flatten)]
    content: T,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    repairs: &'a [Repaired],
    #[serde(skip_serializing_if = "Option::is_none")]
    lost: Option<&'a [LostPart]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rounding: Option<f64>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    stayed: &'a [Stayed],
    #[serde(skip_serializing_if = "Map::is_empty")]
    options: &'a Map<String, Value>,
}

/// A failed run or file.
#[derive(Serialize)]
struct Failed<'a> {
    command: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    input: Option<&'a str>,
    error: Described,
}

impl Console {
    pub(crate) fn new(common: &Common, command: &str, given: &Given) -> Self {
        Self {
            json: common.json,
            quiet: common.quiet,
            command: command.to_owned(),
            options: given.options().clone(),
            ..Self::default()
        }
    }

    /// The console for failures of the command line itself.
    pub(crate) fn without_command(json: bool) -> Self {
        Self { json, ..Self::default() }
    }

    /// The console for each of many files, whose own progress is not shown.
    pub(crate) fn below(&self, files: &ProgressBar) -> Self {
        Self {
            command: self.command.clone(),
            options: self.options.clone(),
            files: Some(files.clone()),
            losses: Arc::default(),
            ..*self
        }
    }

    /// The console for an output. If the mesh is written to stdout, results for people go to stderr.
    pub(crate) fn beside(&self, output: Option<&Path>) -> Result<Cow<'_, Self>, Failure> {
        if !output.is_some_and(is_standard) {
            return Ok(Cow::Borrowed(self));
        }
        if self.json {
            let message = "both the mesh and the report of --json would go to the standard \
                           output; write one of them to a file";
            return Err(Failure::usage(message));
        }
        let command = self.command.clone();
        Ok(Cow::Owned(Self { command, holds_mesh: true, quiet: self.quiet, ..Self::default() }))
    }

    /// Whether results are JSON objects.
    pub(crate) fn is_json(&self) -> bool {
        self.json
    }

    /// The name of the command.
    pub(crate) fn command(&self) -> &str {
        &self.command
    }

    /// Prints a message, unless quiet.
    pub(crate) fn message(&self, text: impl Display) {
        if !self.quiet {
            self.error(text);
        }
    }

    /// Prints a message even if quiet.
    pub(crate) fn error(&self, text: impl Display) {
        // The message is lost if nobody reads it, or if its disk is full.
        let say = || drop(writeln!(std::io::stderr(), "{}", printable_lines(text)));
        match &self.files {
            Some(bar) => bar.suspend(say),
            None => say(),
        }
    }

    fn losses(&self) -> MutexGuard<'_, Losses> {
        self.losses.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records a loss for the report. `by` is `reading`, `writing` or the command.
    pub(crate) fn lose(&self, file: &str, by: &str, lost: &Lost) {
        let part = LostPart { file: file.to_owned(), by: by.to_owned(), lost: lost.clone() };
        let mut losses = self.losses();
        if losses.known.insert(part.clone()) {
            losses.lost.push(part);
        }
    }

    /// Records the rounding of an output for the report.
    pub(crate) fn rounded(&self, rounding: f64) {
        let mut losses = self.losses();
        losses.rounding = losses.rounding.max(rounding);
    }

    /// Records data of an output that are not in the form that was asked for.
    pub(crate) fn stays(&self, file: &str, what: &str) {
        let (file, what) = (file.to_owned(), what.to_owned());
        self.losses().stayed.push(Stayed { file, what });
    }

    /// Records the repairs of an input for the report.
    pub(crate) fn repaired(
        &self,
        file: &str,
        repairs: impl Iterator<Item = (&'static str, usize)>,
    ) {
        let repairs = repairs.map(|(what, count)| Repaired { file: file.to_owned(), what, count });
        self.losses().repairs.extend(repairs);
    }

    /// Records the content of the first input.
    pub(crate) fn note_input(&self, model: &Model) {
        self.losses().input.get_or_insert_with(|| Inventory::of(model));
    }

    /// Reports the kinds of content of the first input that are not in the output.
    pub(crate) fn compare_with_input(&self, model: &Model) {
        let missing = match &self.losses().input {
            Some(input) => input.missing_in(&Inventory::of(model)),
            None => Vec::new(),
        };
        for lost in missing {
            self.message(format_args!("lost {lost}"));
            self.lose("", &self.command, &lost);
        }
    }

    /// Records that there is an output, so that the report lists losses, even if there are none.
    pub(crate) fn wrote(&self) {
        self.losses().has_output = true;
    }

    /// A JSON object with the common fields.
    pub(crate) fn signed(&self, content: impl Serialize) -> Result<String, Failure> {
        let version = env!("CARGO_PKG_VERSION");
        let losses = self.losses();
        let lost = losses.has_output.then_some(losses.lost.as_slice());
        let (repairs, options) = (losses.repairs.as_slice(), &self.options);
        let rounding = (losses.rounding > 0.0).then_some(losses.rounding);
        let stayed = losses.stayed.as_slice();
        let signed =
            Signed { tool: TOOL, version, content, repairs, lost, rounding, stayed, options };
        let json = serde_json::to_string(&signed).map_err(Failure::json)?;
        Ok(printable_json(&json))
    }

    /// The JSON object of a failure.
    pub(crate) fn failed(&self, input: Option<&str>, failure: &Failure) -> Result<String, Failure> {
        self.signed(Failed { command: &self.command, input, error: failure.described() })
    }

    /// Prints a result: text for people, or a line of JSON.
    pub(crate) fn print(&self, text: impl Display) -> Result<(), Failure> {
        if self.holds_mesh {
            self.message(text);
            return Ok(());
        }
        // JSON is escaped already, and lines of text are our own.
        let text = printable_lines(text);
        let mut stdout = std::io::stdout().lock();
        match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
            // The reader of the pipe has closed it.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            other => other.map_err(Failure::Stdout),
        }
    }

    /// A progress bar of `steps` steps; hidden when stderr is no terminal.
    pub(crate) fn progress(&self, steps: u64, what: &'static str) -> ProgressBar {
        let style = ProgressStyle::with_template("{msg} {bar:30} {percent}% {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::with_draw_target(Some(steps), self.target())
            .with_style(style)
            .with_message(what)
    }

    /// A progress bar over the steps of a pass, with the remaining time of the step.
    pub(crate) fn progress_of_passes(&self) -> ProgressBar {
        let style =
            ProgressStyle::with_template("{msg} {bar:30} {pos} of {len} {elapsed}, {eta} left")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::with_draw_target(Some(0), self.target()).with_style(style)
    }

    /// A progress bar over files.
    pub(crate) fn progress_of_files(&self, files: u64) -> ProgressBar {
        let style = ProgressStyle::with_template("{bar:30} {pos} of {len} files {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::with_draw_target(Some(files), self.target()).with_style(style)
    }

    /// A spinner for work of unknown length; hidden when stderr is no terminal.
    pub(crate) fn spinner(&self, what: &'static str) -> ProgressBar {
        let spinner = ProgressBar::with_draw_target(None, self.target()).with_message(what);
        spinner.enable_steady_tick(Duration::from_millis(100));
        spinner
    }

    fn target(&self) -> ProgressDrawTarget {
        if self.quiet || self.files.is_some() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        }
    }
}
