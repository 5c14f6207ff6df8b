//! The results as files for programs: all results together, and the results of every item, as JSON and CSV.

use std::fs::File;
use std::path::Path;

use super::item::Item;
use super::row::Content;
use xtask_common::Failure;

/// Writes `results.json` and `results.csv`, and the same for every item.
pub(super) fn write(items: &[Item], out: &Path) -> Result<(), Failure> {
    write_json(items, &out.join("results.json"))?;
    write_csv(items, &out.join("results.csv"))?;
    for item in items {
        let name = out.join(item.file_name());
        write_json(item, &name.with_extension("json"))?;
        write_csv(std::slice::from_ref(item), &name.with_extension("csv"))?;
    }
    Ok(())
}

fn write_json(what: &(impl serde::Serialize + ?Sized), path: &Path) -> Result<(), Failure> {
    let file = File::create(path).map_err(Failure::writing(path))?;
    serde_json::to_writer_pretty(file, what).map_err(|e| Failure::writing(path)(e))
}

fn write_csv(items: &[Item], path: &Path) -> Result<(), Failure> {
    let failed = |e: csv::Error| Failure::writing(path)(e);
    let mut table = csv::Writer::from_path(path).map_err(failed)?;
    let header =
        ["paper", "item", "quantity", "where", "printed", "ours", "reference", "verdict", "remark"];
    table.write_record(header).map_err(failed)?;
    for item in items {
        for row in &item.rows {
            let [printed, ours, reference] = match &row.content {
                Content::Number { printed, ours, reference } => {
                    [printed, ours, reference].map(|x| x.map(|x| x.to_string()).unwrap_or_default())
                }
                Content::Claim { quote, how, .. } => [quote.clone(), how.clone(), String::new()],
            };
            let place = row.place.clone().unwrap_or_default();
            let (verdict, remark) = (row.verdict.label(), row.verdict.remark());
            let fields = [
                &*item.paper,
                &item.name,
                &row.quantity,
                &place,
                &printed,
                &ours,
                &reference,
                verdict,
                remark,
            ];
            table.write_record(fields).map_err(failed)?;
        }
    }
    table.flush().map_err(Failure::writing(path))
}

impl Item {
    /// A name for its files and for links to it, like `dhkl01-table-1`.
    pub(super) fn file_name(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { ' ' };
        let words: String = format!("{} {}", self.paper, self.name).chars().map(plain).collect();
        words.split_whitespace().collect::<Vec<_>>().join("-")
    }
}
