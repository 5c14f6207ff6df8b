//! The numbers that the papers print, one data file per paper.
//!
//! They are only compared with; nothing is computed from them.

use serde::Deserialize;

use crate::failure::Failure;

const FILES: [&str; 1] = [include_str!("../../published/dhkl01.toml")];

/// A paper and the numbers it prints.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Paper {
    /// The short name used throughout the project, like `DHKL01`.
    pub(crate) short: String,
    pub(crate) title: String,
    #[serde(rename = "value")]
    pub(crate) values: Vec<Value>,
}

/// A printed number.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Value {
    /// The table or figure.
    pub(crate) item: String,
    /// Which number of it.
    pub(crate) quantity: String,
    /// As printed; absent for a number that is only watched.
    pub(crate) printed: Option<f64>,
    /// How far a result may be from the printed number to count as exact.
    #[serde(default)]
    pub(crate) tolerance: f64,
    /// What independent code gave, where it gives more digits than the paper prints.
    pub(crate) reference: Option<Reference>,
}

/// The result of an independent implementation.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Reference {
    pub(crate) value: f64,
    pub(crate) tolerance: f64,
}

/// All papers.
pub(crate) fn papers() -> Result<Vec<Paper>, Failure> {
    FILES.iter().map(|text| toml::from_str(text).map_err(Failure::published)).collect()
}

impl Paper {
    /// The printed number, if the paper prints one.
    pub(crate) fn value(&self, item: &str, quantity: &str) -> Option<&Value> {
        self.values.iter().find(|v| v.item == item && v.quantity == quantity)
    }
}

#[cfg(test)]
mod tests {
    use super::papers;

    #[test]
    fn every_printed_number_is_there_once() {
        for paper in papers().unwrap() {
            for value in &paper.values {
                let same = |v: &&super::Value| v.item == value.item && v.quantity == value.quantity;
                assert_eq!(paper.values.iter().filter(same).count(), 1, "{value:?}");
                assert!(value.printed.is_none() || value.tolerance > 0.0, "{value:?}");
                assert!(value.printed.is_some() || value.reference.is_some(), "{value:?}");
            }
        }
    }
}
