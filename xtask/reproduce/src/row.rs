//! A number or claim with its verdict, as the page and the tables show it.

use serde::Serialize;

use super::outcome::Outcome;

/// A number or claim, beside what the paper prints.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) quantity: String,
    /// Where the paper prints it.
    pub(crate) place: Option<String>,
    pub(crate) content: Content,
    pub(crate) verdict: Verdict,
}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Content {
    Number {
        printed: Option<f64>,
        ours: Option<f64>,
        /// What an independent program gave.
        reference: Option<f64>,
    },
    Claim {
        /// The paper's words.
        quote: String,
        /// What they leave out, in our words.
        says: Option<String>,
        outcome: Option<Outcome>,
        how: String,
    },
}

/// How something compares.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Verdict {
    /// The same quantity of the same data, within the tolerance of the printed number.
    Exact,
    /// The printed number lies in the range of our results, as the rule says; or the claim holds.
    Agrees(String),
    /// A number that the program sets itself: shown, and no result.
    Setup,
    /// Neither, and why.
    Differs(String),
    /// The paper prints no such number.
    NotPublished,
    /// Cannot be computed without this.
    NeedsModel(String),
    /// Left out of a quick run.
    Skipped,
    /// Not what this program computed when it was checked: the code has changed its result.
    Drifted(String),
}

impl Row {
    /// How far ours is from the printed number.
    pub(crate) fn difference(&self) -> Option<f64> {
        match self.content {
            Content::Number { printed: Some(printed), ours: Some(ours), .. } => {
                Some(ours - printed)
            }
            _ => None,
        }
    }

    /// What an independent program gave.
    pub(crate) fn reference(&self) -> Option<f64> {
        match self.content {
            Content::Number { reference, .. } => reference,
            Content::Claim { .. } => None,
        }
    }

    /// Whether there is something to compare it with besides what is on record.
    pub(crate) fn is_compared(&self) -> bool {
        self.is_published() || self.reference().is_some()
    }

    pub(crate) fn is_published(&self) -> bool {
        match self.content {
            Content::Number { printed, .. } => printed.is_some(),
            Content::Claim { .. } => true,
        }
    }
}

impl Verdict {
    /// Whether nothing is to be done about it.
    pub(crate) fn is_expected(&self) -> bool {
        !matches!(self, Self::Drifted(_))
    }

    /// The verdict in a word or two.
    pub(crate) fn label(&self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Agrees(_) => "agrees",
            Self::Setup => "setup",
            Self::Differs(_) => "differs",
            Self::NotPublished => "not published",
            Self::NeedsModel(_) => "needs a model",
            Self::Skipped => "skipped",
            Self::Drifted(_) => "drifted",
        }
    }

    /// The rule, the reason or the missing model.
    pub(crate) fn remark(&self) -> &str {
        match self {
            Self::Agrees(text)
            | Self::Differs(text)
            | Self::NeedsModel(text)
            | Self::Drifted(text) => text,
            _ => "",
        }
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.remark() {
            "" => f.write_str(self.label()),
            remark => write!(f, "{}: {remark}", self.label()),
        }
    }
}
