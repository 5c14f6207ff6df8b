//! A summary: a line for each file, a column for each command, and all faults.

use std::collections::BTreeMap;

use comfy_table::{CellAlignment, Table, presets};

use super::record::Record;

/// The outcomes of the runs of one cell.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    done: usize,
    unreadable: usize,
    refused: usize,
    faults: usize,
}

impl Tally {
    fn add(&mut self, record: &Record) {
        *match (&record.fault, record.exit) {
            (Some(_), _) => &mut self.faults,
            (None, Some(3)) => &mut self.unreadable,
            (None, Some(4)) => &mut self.refused,
            (None, _) => &mut self.done,
        } += 1;
    }

    fn text(self) -> String {
        let Self { done, unreadable, refused, faults } = self;
        let parts = [(done, ""), (refused, "r"), (unreadable, "u"), (faults, " FAULT")];
        let shown = parts.iter().filter(|(count, _)| *count > 0);
        shown.map(|(count, what)| format!("{count}{what}")).collect::<Vec<_>>().join(" ")
    }
}

/// The table, the slowest and largest runs, and the faults.
pub(super) fn text(records: &[Record]) -> String {
    let mut commands: Vec<&str> = Vec::new();
    let mut cells: BTreeMap<(&str, &str), Tally> = BTreeMap::new();
    let mut rows: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    let mut totals: BTreeMap<&str, Tally> = BTreeMap::new();
    for record in records {
        if !commands.contains(&record.command.as_str()) {
            commands.push(&record.command);
        }
        cells.entry((&record.file, &record.command)).or_default().add(record);
        totals.entry(&record.command).or_default().add(record);
        let (seconds, peak) = rows.entry(&record.file).or_default();
        (*seconds, *peak) = (seconds.max(record.seconds), peak.max(record.peak_mib));
    }
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN);
    let header = ["file"].into_iter().chain(commands.iter().copied());
    table.set_header(header.chain(["slowest, s", "most memory, MiB"]));
    for (file, (seconds, peak)) in &rows {
        let cell =
            |command: &&str| cells.get(&(*file, *command)).map_or_else(String::new, |t| t.text());
        let row = [(*file).to_owned()].into_iter().chain(commands.iter().map(cell));
        table.add_row(row.chain([format!("{seconds:.1}"), format!("{peak:.0}")]));
    }
    let cell = |command: &&str| totals.get(command).map_or_else(String::new, |tally| tally.text());
    let all = rows.values().fold((0.0_f64, 0.0_f64), |(s, p), row| (s.max(row.0), p.max(row.1)));
    let row = ["all".to_owned()].into_iter().chain(commands.iter().map(cell));
    table.add_row(row.chain([format!("{:.1}", all.0), format!("{:.0}", all.1)]));
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let faults: Vec<&Record> = records.iter().filter(|record| record.fault.is_some()).collect();
    let mut text = format!(
        "{table}\n\nr: the mesh was refused (exit 4), u: the file was refused (exit 3)\n\
         {} runs on {} files, {} faults\n",
        records.len(),
        rows.len(),
        faults.len()
    );
    for Record { file, job, fault, .. } in faults {
        text += &format!("{file}: {job}: {}\n", fault.as_deref().unwrap_or_default());
    }
    text
}
