//! What this program computed when its results were last looked at: guards against drift where
//! the papers print nothing.
//!
//! One CSV file per paper, written by `cargo xtask reproduce --record` and read at compile time,
//! so that a change shows in the history.

use std::collections::BTreeMap;
use std::path::Path;

use super::item::Item;
use xtask_common::Failure;

const FILES: [(&str, &str); 5] = [
    ("DHKL01", include_str!("../recorded/dhkl01.csv")),
    ("BAR06", include_str!("../recorded/bar06.csv")),
    ("SN10", include_str!("../recorded/sn10.csv")),
    ("KKL02", include_str!("../recorded/kkl02.csv")),
    ("PKH00", include_str!("../recorded/pkh00.csv")),
];

/// Values by paper, item and quantity.
#[derive(Clone, Debug, Default)]
pub(crate) struct Recorded(BTreeMap<[String; 3], f64>);

impl Recorded {
    /// The values of the data files.
    pub(crate) fn read() -> Result<Self, Failure> {
        let mut values = BTreeMap::new();
        for (paper, text) in FILES {
            for line in csv::Reader::from_reader(text.as_bytes()).deserialize() {
                let (item, quantity, value): (String, String, f64) =
                    line.map_err(Failure::numbers)?;
                values.insert([paper.to_owned(), item, quantity], value);
            }
        }
        Ok(Self(values))
    }

    pub(crate) fn value(&self, paper: &str, item: &str, quantity: &str) -> Option<f64> {
        self.0.get(&[paper, item, quantity].map(str::to_owned)).copied()
    }

    /// Takes over what the items computed; what they left out stays as it was, unless nothing was
    /// missing.
    fn update(&mut self, items: &[Item]) {
        for item in items.iter().filter(|item| item.failure.is_none()) {
            if item.missing_models.is_empty() {
                self.0.retain(|[paper, name, _], _| (paper, name) != (&item.paper, &item.name));
            }
            for number in &item.numbers {
                let key = [&item.paper, &item.name, &number.quantity].map(String::clone);
                self.0.insert(key, number.value);
            }
        }
    }

    /// Writes the data files anew, with what the items computed.
    pub(crate) fn record(mut self, items: &[Item]) -> Result<Self, Failure> {
        self.update(items);
        for (paper, _) in FILES {
            let name = format!("{}.csv", paper.to_lowercase());
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("recorded").join(name);
            let failed = |e: csv::Error| Failure::writing(&path)(e);
            let mut table = csv::Writer::from_path(&path).map_err(failed)?;
            table.write_record(["item", "quantity", "value"]).map_err(failed)?;
            for ([_, item, quantity], value) in self.0.iter().filter(|(key, _)| key[0] == paper) {
                table.write_record([item, quantity, &value.to_string()]).map_err(failed)?;
            }
            table.flush().map_err(Failure::writing(&path))?;
        }
        Ok(self)
    }

    /// The same with one value replaced, to see whether that is noticed.
    #[cfg(test)]
    pub(crate) fn with(mut self, paper: &str, item: &str, quantity: &str, value: f64) -> Self {
        self.0.insert([paper, item, quantity].map(str::to_owned), value);
        self
    }
}
