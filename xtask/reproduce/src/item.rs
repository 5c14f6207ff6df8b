//! What a reproduction yields: items with numbers, claims, tables, plots and pictures.
//!
//! An item only says what was computed. What the papers print is not known here: the comparison
//! comes later, in `verdict`.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;

use super::outcome::Outcome;
use super::row::Row;
use xtask_common::plot::Plot;

/// A table or figure of a paper, reproduced.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Item {
    pub(crate) paper: String,
    /// The table or figure as the paper calls it.
    pub(crate) name: String,
    /// What was done, and what came out, in a few sentences.
    pub(crate) about: String,
    /// What takes the place of the paper's own data.
    pub(crate) stand_in: Option<String>,
    /// The public functions that did the work.
    pub(crate) functions: Vec<&'static str>,
    /// How to do the same to one's own mesh.
    pub(crate) commands: Vec<&'static str>,
    /// Models that were asked for and not there.
    pub(crate) missing_models: Vec<String>,
    #[serde(skip)]
    pub(crate) numbers: Vec<Number>,
    #[serde(skip)]
    pub(crate) claims: Vec<ClaimResult>,
    pub(crate) tables: Vec<Table>,
    #[serde(skip)]
    pub(crate) plots: Vec<PlotFigure>,
    /// Rows of pictures to be seen side by side.
    pub(crate) figures: Vec<Vec<Figure>>,
    /// The numbers and claims with their verdicts; filled by `verdict`.
    pub(crate) rows: Vec<Row>,
    /// What went wrong, if the item could not be finished.
    pub(crate) failure: Option<String>,
    #[serde(skip)]
    pub(crate) took: Duration,
}

/// A number that was computed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Number {
    pub(crate) quantity: String,
    pub(crate) value: f64,
    /// The relative difference from the recorded value below which it is the same result.
    pub(crate) leeway: f64,
    /// For a median: the 5th and the 95th percentile.
    pub(crate) range: Option<[f64; 2]>,
}

/// What became of a claim of the paper.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClaimResult {
    /// The claim's name in the data file.
    pub(crate) name: String,
    pub(crate) outcome: Outcome,
    /// By how much, in plain words with numbers.
    pub(crate) how: String,
}

/// Numbers to be read beside each other. They are shown only: what is to be checked is given as
/// [`Item::number`] too.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Table {
    pub(crate) caption: String,
    pub(crate) header: Vec<String>,
    pub(crate) lines: Vec<Vec<String>>,
}

/// A plot, as SVG.
#[derive(Debug)]
pub(crate) struct PlotFigure {
    pub(crate) caption: String,
    pub(crate) svg: String,
}

/// A picture, written beside the page and shown on it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Figure {
    pub(crate) caption: String,
    pub(crate) file: PathBuf,
    /// The drawn mesh, to be opened elsewhere.
    pub(crate) meshes: Vec<PathBuf>,
    /// The page on which it turns.
    pub(crate) turning: PathBuf,
}

/// The leeway of a number that is the same on every machine but for rounding.
const ROUNDING: f64 = 1e-6;

impl Item {
    /// Says what was done.
    pub(crate) fn about(&mut self, text: impl Into<String>) {
        self.about = text.into();
    }

    /// Names what takes the place of the paper's own data.
    pub(crate) fn stand_in(&mut self, text: impl Into<String>) {
        self.stand_in = Some(text.into());
    }

    /// Names the public functions that did the work, and commands that do it to one's own mesh.
    pub(crate) fn how(&mut self, functions: &[&'static str], commands: &[&'static str]) {
        self.functions = functions.to_vec();
        self.commands = commands.to_vec();
    }

    /// Adds a number that is the same everywhere but for rounding.
    pub(crate) fn number(&mut self, quantity: impl Into<String>, value: f64) {
        self.number_within(quantity, value, ROUNDING);
    }

    /// Adds a number that may be off by a share of itself and still be the same result: one that
    /// comes from samples, or from long chains of decisions.
    pub(crate) fn number_within(&mut self, quantity: impl Into<String>, value: f64, leeway: f64) {
        self.numbers.push(Number { quantity: quantity.into(), value, leeway, range: None });
    }

    /// Adds a median with the 5th and the 95th percentile.
    pub(crate) fn median(&mut self, quantity: impl Into<String>, [low, median, high]: [f64; 3]) {
        let (quantity, range) = (quantity.into(), Some([low, high]));
        self.numbers.push(Number { quantity, value: median, leeway: ROUNDING, range });
    }

    /// Says whether a claim of the data file holds, and by how much.
    pub(crate) fn claim(&mut self, name: &str, outcome: Outcome, how: impl Into<String>) {
        self.claims.push(ClaimResult { name: name.into(), outcome, how: how.into() });
    }

    /// Adds a table to be shown.
    pub(crate) fn table<C: Into<String>>(
        &mut self,
        caption: impl Into<String>,
        header: impl IntoIterator<Item = C>,
        lines: Vec<Vec<String>>,
    ) {
        let header = header.into_iter().map(Into::into).collect();
        self.tables.push(Table { caption: caption.into(), header, lines });
    }

    /// Adds a plot.
    pub(crate) fn plot(&mut self, plot: &Plot, caption: impl Into<String>) {
        self.plots.push(PlotFigure { caption: caption.into(), svg: plot.svg() });
    }

    /// Adds pictures that belong side by side.
    pub(crate) fn side_by_side(&mut self, figures: impl IntoIterator<Item = Figure>) {
        self.figures.push(figures.into_iter().collect());
    }
}
