//! The numbers that the papers print and the claims they make, one data file per paper.
//!
//! They are only compared with; nothing is computed from them.

use serde::Deserialize;

use super::outcome::Outcome;
use xtask_common::Failure;

const FILES: [&str; 5] = [
    include_str!("../published/dhkl01.toml"),
    include_str!("../published/bar06.toml"),
    include_str!("../published/sn10.toml"),
    include_str!("../published/kkl02.toml"),
    include_str!("../published/pkh00.toml"),
];

/// A paper, the numbers it prints and the claims it makes.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Paper {
    /// The short name used throughout the project, like `DHKL01`.
    pub(crate) short: String,
    pub(crate) title: String,
    pub(crate) authors: String,
    /// Where and when it appeared.
    pub(crate) source: String,
    /// What the paper does, and what came of reproducing it, in a few sentences.
    pub(crate) about: String,
    /// The real models that take part.
    #[serde(default, rename = "model")]
    pub(crate) models: Vec<ModelSource>,
    #[serde(default, rename = "value")]
    pub(crate) values: Vec<Value>,
    #[serde(default, rename = "claim")]
    pub(crate) claims: Vec<Claim>,
}

/// A real model and where it came from.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModelSource {
    pub(crate) file: String,
    /// Which of the paper's models it is or stands for.
    pub(crate) role: String,
    pub(crate) from: String,
}

/// A printed number.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Value {
    /// The table or figure.
    pub(crate) item: String,
    /// Which number of it.
    pub(crate) quantity: String,
    /// Where the paper has it: page, section or figure.
    #[serde(rename = "where")]
    pub(crate) place: Option<String>,
    /// As printed; absent for a number that is only watched.
    pub(crate) printed: Option<f64>,
    /// How far a result may be from the printed number to count as exact.
    #[serde(default)]
    pub(crate) tolerance: f64,
    /// Whether the program sets the number itself, such as a radius or a target face count. It is shown
    /// and not counted as a result.
    #[serde(default)]
    pub(crate) setup: bool,
    /// Whether ours is of other data than the printed one, or another quantity, such as a median over
    /// faces for the number of a single face. Then it is never exact, and it agrees if the printed
    /// number lies in our range ([`super::item::Number::range`]).
    #[serde(default, rename = "other-data")]
    pub(crate) other_data: bool,
    /// The known reason why ours differs from the printed number; if no number is printed, why it
    /// differs from the result of the independent program.
    pub(crate) differs: Option<String>,
    /// The model that the number needs: a file of the models' folder, or in words one that is not
    /// available.
    pub(crate) needs: Option<String>,
    /// What an independent program gave, where that is known.
    pub(crate) reference: Option<Reference>,
}

impl Value {
    /// What an independent program gave.
    pub(crate) fn reference_value(&self) -> Option<f64> {
        self.reference.map(|reference| reference.value)
    }

    /// Why an independent program gave something else. Beside a printed number, which has a reason
    /// of its own, both programs have to agree.
    pub(crate) fn differs_from_reference(&self) -> Option<&str> {
        self.differs.as_deref().filter(|_| self.printed.is_none())
    }
}

/// The result of an independent implementation.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Reference {
    pub(crate) value: f64,
    pub(crate) tolerance: f64,
}

/// Something that the paper says without giving a number.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Claim {
    /// The table or figure it is checked with.
    pub(crate) item: String,
    pub(crate) name: String,
    #[serde(rename = "where")]
    pub(crate) place: Option<String>,
    /// The claim, word for word.
    pub(crate) quote: String,
    /// What the quotation leaves out, in our words.
    pub(crate) says: Option<String>,
    /// The outcome on record; without one the claim is judged anew in every run.
    pub(crate) outcome: Option<Outcome>,
    /// As for [`Value::needs`].
    pub(crate) needs: Option<String>,
}

/// All papers.
pub(crate) fn papers() -> Result<Vec<Paper>, Failure> {
    FILES.iter().map(|text| toml::from_str(text).map_err(Failure::numbers)).collect()
}

impl Paper {
    /// What is known of a number.
    pub(crate) fn value(&self, item: &str, quantity: &str) -> Option<&Value> {
        self.values.iter().find(|v| v.item == item && v.quantity == quantity)
    }

    /// A claim by its name.
    pub(crate) fn claim(&self, item: &str, name: &str) -> Option<&Claim> {
        self.claims.iter().find(|c| c.item == item && c.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::super::steps_of;
    use super::papers;

    #[test]
    fn every_printed_number_is_there_once_and_can_be_compared() {
        for paper in papers().unwrap() {
            for value in &paper.values {
                let same = |v: &&super::Value| v.item == value.item && v.quantity == value.quantity;
                assert_eq!(paper.values.iter().filter(same).count(), 1, "{value:?}");
                assert!(value.printed.is_some() || value.reference.is_some(), "{value:?}");
                assert!(value.printed.is_none() || value.place.is_some(), "where is {value:?}?");
            }
        }
    }

    #[test]
    fn every_number_and_claim_belongs_to_an_item() {
        for paper in papers().unwrap() {
            let exists = |item: &str| steps_of(&paper.short).iter().any(|step| step.name == item);
            for value in &paper.values {
                assert!(exists(&value.item), "{}: {value:?}", paper.short);
            }
            for claim in &paper.claims {
                assert!(exists(&claim.item), "{}: {claim:?}", paper.short);
            }
        }
    }
}
