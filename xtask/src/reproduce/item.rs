//! What a reproduction yields: items with numbers beside the printed ones, and figures.

use std::path::PathBuf;

use serde::Serialize;

use super::published::{Paper, Value};

/// A table or figure of a paper, reproduced.
#[derive(Debug, Serialize)]
pub(crate) struct Item {
    pub(crate) paper: String,
    /// The table or figure as the paper calls it.
    pub(crate) name: String,
    /// What was done, in a sentence or two.
    pub(crate) about: String,
    /// What is missing, if the item could not be computed for that.
    pub(crate) needs: Option<String>,
    pub(crate) rows: Vec<Row>,
    pub(crate) figures: Vec<Figure>,
    /// The public functions that did the work.
    pub(crate) functions: Vec<&'static str>,
    /// How to do the same to one's own mesh.
    pub(crate) command: &'static str,
}

/// A number of ours, beside the printed one where there is one.
#[derive(Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) quantity: String,
    pub(crate) ours: f64,
    pub(crate) printed: Option<f64>,
    pub(crate) verdict: Verdict,
}

/// How a number compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Verdict {
    /// Within the tolerance of the printed number.
    Exact,
    /// Farther from the printed number than that.
    Differs,
    /// The paper prints no such number.
    NotPublished,
    /// Not what this program computed when it was checked: the code has changed its result.
    Drifted,
}

/// A picture, written beside the page and shown on it.
#[derive(Debug, Serialize)]
pub(crate) struct Figure {
    pub(crate) caption: String,
    pub(crate) file: PathBuf,
    /// The drawn mesh, to be opened elsewhere.
    pub(crate) mesh: PathBuf,
}

impl Row {
    /// Compares a number with what the paper prints.
    pub(crate) fn new(paper: &Paper, item: &str, quantity: &str, ours: f64) -> Self {
        let value = paper.value(item, quantity);
        Self {
            quantity: quantity.to_owned(),
            ours,
            printed: value.and_then(|v| v.printed),
            verdict: value.map_or(Verdict::NotPublished, |v| Verdict::of(v, ours)),
        }
    }

    /// How far ours is from the printed number.
    pub(crate) fn difference(&self) -> Option<f64> {
        self.printed.map(|printed| self.ours - printed)
    }
}

impl Verdict {
    fn of(value: &Value, ours: f64) -> Self {
        let near = |target: f64, tolerance: f64| (ours - target).abs() <= tolerance;
        match (value.reference, value.printed) {
            (Some(reference), _) if !near(reference.value, reference.tolerance) => Self::Drifted,
            (_, None) => Self::NotPublished,
            (_, Some(printed)) if near(printed, value.tolerance) => Self::Exact,
            _ => Self::Differs,
        }
    }

    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Differs => "differs",
            Self::NotPublished => "not published",
            Self::Drifted => "drifted",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::published::{Reference, Value};
    use super::Verdict;

    #[test]
    fn a_changed_result_is_noticed_before_it_leaves_the_printed_digits() {
        let value = Value {
            item: String::new(),
            quantity: String::new(),
            printed: Some(0.2342743546),
            tolerance: 2e-7,
            reference: Some(Reference { value: 0.2342743622, tolerance: 1e-9 }),
        };
        assert_eq!(Verdict::of(&value, 0.2342743622), Verdict::Exact);
        assert_eq!(Verdict::of(&value, 0.2342743546), Verdict::Drifted);
        let printed_only = Value { reference: None, ..value };
        assert_eq!(Verdict::of(&printed_only, 0.2342743546), Verdict::Exact);
        assert_eq!(Verdict::of(&printed_only, 0.2342), Verdict::Differs);
    }
}
