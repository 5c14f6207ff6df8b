//! Tables of records: geometric means as ratios to one of the tools, and sums of defects.

use std::fmt::Write as _;

use super::drivers::{ABSENT, DRIVERS, Driver};
use super::record::{Outcome, Record};
use crate::figures::{distinct, geometric_mean, told};

/// A column of a table of ratios.
#[derive(Clone, Debug)]
enum Column {
    Time,
    /// The time to one target.
    TimeTo(String),
    Mean,
    Rms,
    Max,
    Normals,
    /// The largest memory of a job; no ratio.
    Bytes,
}

impl Column {
    fn title(&self) -> String {
        match self {
            Self::Time => "time".into(),
            Self::TimeTo(target) => format!("to {target}"),
            Self::Mean => "mean distance".into(),
            Self::Rms => "RMS distance".into(),
            Self::Max => "largest distance".into(),
            Self::Normals => "normals".into(),
            Self::Bytes => "bytes per input face".into(),
        }
    }

    fn cell(&self, rows: &[&Record], name: &str, base: &str) -> String {
        let of = |index: usize| mean(&ratios(rows, name, base), index);
        let value = match self {
            Self::Bytes => {
                let bytes = most_bytes(rows, name);
                return if bytes.is_nan() { String::new() } else { format!("{bytes:.0}") };
            }
            _ if name == base => return "1".into(),
            Self::Time => of(0),
            Self::TimeTo(target) => {
                let rows: Vec<&Record> =
                    rows.iter().filter(|row| row.target == *target).copied().collect();
                mean(&ratios(&rows, name, base), 0)
            }
            Self::Mean => of(1),
            Self::Rms => of(2),
            Self::Max => of(3),
            Self::Normals => of(4),
        };
        let digits = match self {
            // Two digits that count.
            Self::Time | Self::TimeTo(_) if value < 0.1 => 3,
            Self::Mean if value < 1.0 => 3,
            _ => 2,
        };
        told(value, digits)
    }
}

/// The table of all columns, as in the book.
pub(super) fn full(rows: &[Record], base: &str) -> String {
    let mut columns = vec![Column::Time];
    let targets = distinct(rows, |row| &*row.target);
    if targets.len() > 1 {
        columns.extend(targets.iter().map(|target| Column::TimeTo((*target).to_owned())));
    }
    columns.extend([Column::Mean, Column::Rms, Column::Max, Column::Normals, Column::Bytes]);
    of_columns(rows, base, &columns)
}

/// The table of time and distances, as in the README.
pub(super) fn short(rows: &[Record], base: &str) -> String {
    of_columns(rows, base, &[Column::Time, Column::Mean, Column::Rms, Column::Max])
}

/// The table of distances and normals alone, for records whose times mean nothing.
pub(super) fn distances(rows: &[Record], base: &str) -> String {
    of_columns(rows, base, &[Column::Mean, Column::Rms, Column::Max, Column::Normals])
}

fn of_columns(rows: &[Record], base: &str, columns: &[Column]) -> String {
    let titles: Vec<String> = columns.iter().map(Column::title).collect();
    let all: Vec<&Record> = rows.iter().collect();
    let mut text = format!("| | {} |\n|---|{}\n", titles.join(" | "), "---|".repeat(columns.len()));
    for name in distinct(rows, |row| &*row.name) {
        let _ = write!(text, "| {} |", label(rows, name));
        for column in columns {
            match column.cell(&all, name, base) {
                cell if cell.is_empty() => text.push_str(" |"),
                cell => drop(write!(text, " {cell} |")),
            }
        }
        text.push('\n');
    }
    text
}

/// The other programs beside one tool: ratios to it, in how many cells it is closer, and what went wrong.
pub(super) fn compare(rows: &[Record], base: &str) -> String {
    let all: Vec<&Record> = rows.iter().collect();
    let base_title = label(rows, base);
    let mut text = format!(
        "| | version | time | mean distance | largest distance | {base_title} has the lower mean | the lower largest | \
         failed | other number of faces | runs with new defects |\n|---|{}\n",
        "---|".repeat(9)
    );
    for name in distinct(rows, |row| &*row.name) {
        let own = || rows.iter().filter(|row| row.name == name);
        if name != base && own().any(Record::is_ours) {
            continue;
        }
        let ratios = ratios(&all, name, base);
        let closer = |index: usize| {
            let count = ratios.iter().filter(|ratio| ratio[index] > 1.0).count();
            if name == base { String::new() } else { format!("{count} of {}", ratios.len()) }
        };
        let cell = |column: Column| column.cell(&all, name, base);
        let defective = own().filter(|row| row.has_new_defects()).count();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {defective} of {} |",
            label(rows, name),
            own().find_map(|row| row.version.as_deref()).unwrap_or("–"),
            cell(Column::Time),
            cell(Column::Mean),
            cell(Column::Max),
            closer(1),
            closer(3),
            own().filter(|row| row.outcome.is_none()).count(),
            own().filter(|row| row.has_missed()).count(),
            own().count(),
        );
    }
    text
}

/// The other programs with method and version; those that are not in the record, with the reason.
pub(super) fn tools(rows: &[Record]) -> String {
    let mut text = String::from("| program | method | version |\n|---|---|---|\n");
    for Driver { name, title, method, .. } in &DRIVERS {
        let row = rows.iter().find(|row| row.name == *name);
        let version = row.map_or("not in this record", |row| row.version.as_deref().unwrap_or("–"));
        let _ = writeln!(text, "| {title} | {method} | {version} |");
    }
    for (name, reason) in ABSENT {
        let _ = writeln!(text, "| {name} | – | not had: {reason} |");
    }
    text
}

/// In how many cells a tool is lower than each other program that is not ours, by the mean distance and by the largest.
pub(super) fn wins(rows: &[Record]) -> String {
    let mut text = String::from("| | cells | lowest mean | lowest largest |\n|---|---|---|---|\n");
    for name in distinct(rows, |row| &*row.name) {
        let own = rows.iter().filter(|row| row.name == name);
        let cells = own.clone().count();
        let share = |index: usize| {
            let is_lowest = |row: &&Record| {
                let other = lowest_of_others(rows, row, index);
                let pair = row.values().zip(other);
                row.is_comparable() && pair.is_some_and(|(own, (value, _))| own[index] <= value)
            };
            let count = own.clone().filter(is_lowest).count();
            format!("{:.0} %", 100.0 * count as f64 / cells as f64)
        };
        let _ = writeln!(text, "| {} | {cells} | {} | {} |", label(rows, name), share(1), share(3));
    }
    text
}

/// The lowest value of the other programs that are not ours, in the cell of a row, and the name of the program.
fn lowest_of_others(rows: &[Record], own: &Record, index: usize) -> Option<(f64, String)> {
    let others = rows.iter().filter(|row| !row.is_ours() && row.is_comparable());
    let others = others.filter(|row| row.name != own.name);
    let others = others.filter(|row| (&row.mesh, &row.target) == (&own.mesh, &own.target));
    let values = others.filter_map(|row| Some((row.values()?[index], label(rows, &row.name))));
    values.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The cells in which a tool of ours is worst: its mean distance and its largest one over the lowest of the other
/// programs. The larger of the two ratios counts.
pub(super) fn worst(rows: &[Record], name: &str) -> String {
    const CELLS: usize = 10;
    let best = |own: &Record, index: usize| {
        let (value, by) = lowest_of_others(rows, own, index)?;
        Some((own.values()?[index].max(1e-12) / value.max(1e-12), by))
    };
    let own = rows.iter().filter(|row| row.name == name && row.is_comparable());
    let cells = own.filter_map(|row| Some((row, best(row, 1)?, best(row, 3)?)));
    let mut cells: Vec<_> = cells.collect();
    cells.sort_by(|(_, a, b), (_, c, d)| c.0.max(d.0).total_cmp(&a.0.max(b.0)));
    let mut text = String::from(
        "| mesh | faces | mean distance / lowest of the others | by | largest distance / lowest of the others | by |\n\
         |---|---|---|---|---|---|\n",
    );
    for (row, (mean, mean_by), (max, max_by)) in cells.into_iter().take(CELLS) {
        let Record { mesh, target, .. } = row;
        let _ =
            writeln!(text, "| `{mesh}` | {target} | {mean:.2} | {mean_by} | {max:.2} | {max_by} |");
    }
    text
}

/// The defects that the inputs did not have, summed over all jobs, and what else tells whether a result is sound.
pub(super) fn validity(rows: &[Record]) -> String {
    let mut text = String::new();
    for name in distinct(rows, |row| &*row.name) {
        let own = || rows.iter().filter(|row| row.name == name);
        let outcomes: Vec<&Outcome> = own().filter_map(|row| row.outcome.as_ref()).collect();
        let failed = own().filter(|row| row.outcome.is_none()).count();
        let missed = own().filter(|row| row.has_missed()).count();
        let mut sums = outcomes.iter().map(|outcome| outcome.validity.new_defects());
        let mut sum = sums.next().unwrap_or_default();
        for counts in sums {
            sum.iter_mut().zip(counts).for_each(|(total, (_, count))| total.1 += count);
        }
        if text.is_empty() {
            let titles: Vec<&str> = sum.iter().map(|(title, _)| *title).collect();
            let _ = writeln!(
                text,
                "| | runs | failed | other number of faces | {} | area | volume | normals |\n|---|{}",
                titles.join(" | "),
                "---|".repeat(titles.len() + 6)
            );
        }
        let average = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        let area = average(outcomes.iter().map(|o| 100.0 * o.validity.area.abs()).collect());
        let volumes = outcomes.iter().filter_map(|o| Some(100.0 * o.validity.volume?.abs()));
        let normals = average(outcomes.iter().map(|o| o.errors.normals).collect());
        let counts: Vec<String> = sum.iter().map(|(_, count)| count.to_string()).collect();
        let _ = writeln!(
            text,
            "| {} | {} | {failed} | {missed} | {} | {} % | {} % | {}° |",
            label(rows, name),
            own().count(),
            counts.join(" | "),
            told(area, 2),
            told(average(volumes.collect()), 2),
            told(normals, 2),
        );
    }
    text
}

/// Everything about a run, for the terminal: ratios over all targets and for each of them, and defects.
pub(super) fn report(rows: &[Record], base: &str) -> String {
    let mut text = String::new();
    let all = distinct(rows, |row| &*row.target);
    let mut groups = vec![all.clone()];
    if all.len() > 1 {
        groups.extend(all.iter().map(|target| vec![*target]));
    }
    for targets in groups {
        let _ = writeln!(text, "\n{}; ratios to {base}\n", targets.join(", "));
        text.push_str(
            "| tool | runs | time | mean | rms | max | normals | faces | worst mean | most bytes a face |\n\
             |---|---|---|---|---|---|---|---|---|---|\n",
        );
        let of: Vec<&Record> = rows.iter().filter(|r| targets.contains(&&*r.target)).collect();
        for name in distinct(rows, |row| &*row.name) {
            line(&mut text, &of, name, base);
        }
    }
    let _ = write!(text, "\nDefects that the inputs did not have\n\n{}", validity(rows));
    text
}

fn line(text: &mut String, rows: &[&Record], name: &str, base: &str) {
    let ratios = ratios(rows, name, base);
    let worst = ratios.iter().map(|r| r[1]).fold(f64::NAN, f64::max);
    let _ = writeln!(
        text,
        "| {name} | {} of {} | {} | {} | {} |",
        ratios.len(),
        rows.iter().filter(|row| row.name == name).count(),
        core::array::from_fn::<_, 6, _>(|i| told(mean(&ratios, i), 3)).join(" | "),
        told(worst, 2),
        told(most_bytes(rows, name), 0),
    );
}

/// The tools that others are ratios to, the first that is there.
pub(super) const USUAL_BASES: [&str; 2] = ["cgal-lt", "meshlab"];

/// The tool that the others are ratios to.
pub(super) fn usual_base(rows: &[Record]) -> Option<&str> {
    let names = distinct(rows, |row| &*row.name);
    let preferred = USUAL_BASES.into_iter().find(|name| names.contains(name));
    preferred.or_else(|| names.first().copied())
}

/// The ratios of the values of a tool to the values of another one, for each job that both did.
fn ratios(rows: &[&Record], name: &str, base: &str) -> Vec<[f64; 6]> {
    let own = rows.iter().filter(|row| row.name == name && row.is_comparable());
    own.filter_map(|row| {
        let same = |other: &&&Record| {
            other.name == base && (&other.mesh, &other.target) == (&row.mesh, &row.target)
        };
        let other = rows.iter().find(same).filter(|other| other.is_comparable())?;
        let (ours, theirs) = (row.values()?, other.values()?);
        Some(core::array::from_fn(|i| ours[i].max(1e-12) / theirs[i].max(1e-12)))
    })
    .collect()
}

/// The geometric mean of a value.
fn mean(ratios: &[[f64; 6]], index: usize) -> f64 {
    geometric_mean(ratios.iter().map(|r| r[index]))
}

fn most_bytes(rows: &[&Record], name: &str) -> f64 {
    let own = rows.iter().filter(|row| row.name == name);
    own.filter_map(|row| row.bytes_per_face()).fold(f64::NAN, f64::max)
}

/// The name of a tool in a page.
fn label(rows: &[Record], name: &str) -> String {
    if rows.iter().any(|row| row.name == name && row.is_ours()) {
        return format!("`{name}`");
    }
    Driver::of_name(name).map_or(name, |driver| driver.title).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::record::tests::record;

    #[test]
    fn ratios_are_geometric_means_over_equal_counts() {
        let rows = [record("fast", 100, 1.0, 3.0), record("cgal-lt", 101, 4.0, 2.0)];
        let text = report(&rows, "cgal-lt");
        assert!(text.contains("| fast | 1 of 1 | 0.250 | 1.500 |"), "{text}");
        let missed = [record("fast", 120, 1.0, 3.0), record("cgal-lt", 101, 4.0, 2.0)];
        let text = report(&missed, "cgal-lt");
        assert!(text.contains("| fast | 0 of 1 |"), "{text}");
    }

    #[test]
    fn tables_have_the_form_of_the_pages() {
        let mut other = record("fast", 100, 2.0, 3.0);
        other.target = "2 %".into();
        let mut base = record("cgal-lt", 101, 4.0, 2.0);
        base.target = "2 %".into();
        base.outcome.as_mut().unwrap().memory = None;
        let rows = [record("fast", 100, 0.2, 1.0), record("cgal-lt", 100, 4.0, 2.0), other, base];
        assert_eq!(
            short(&rows, "cgal-lt"),
            "| | time | mean distance | RMS distance | largest distance |\n|---|---|---|---|---|\n\
             | `fast` | 0.16 | 0.866 | 0.87 | 0.87 |\n| CGAL Lindstrom-Turk | 1 | 1 | 1 | 1 |\n"
        );
        let text = full(&rows, "cgal-lt");
        assert!(text.starts_with("| | time | to 10 % | to 2 % | mean distance |"), "{text}");
        assert!(text.contains("| `fast` | 0.16 | 0.050 | 0.50 | 0.866 |"), "{text}");
        assert!(text.contains("| 1.00 | 5 |\n"), "{text}");
    }

    #[test]
    fn the_worst_cells_come_first() {
        let cell = |mesh: &str, name: &str, mean: f64| Record {
            mesh: mesh.into(),
            ..record(name, 100, 1.0, mean)
        };
        let rows = [
            cell("a", "default", 2.0),
            cell("a", "meshlab", 4.0),
            cell("a", "open3d", 8.0),
            cell("b", "default", 3.0),
            cell("b", "meshlab", 4.0),
            cell("b", "open3d", 2.0),
            cell("b", "fast", 1.0),
        ];
        let text = worst(&rows, "default");
        let lines: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(
            lines,
            [
                "| `b` | 10 % | 1.50 | Open3D | 1.50 | Open3D |",
                "| `a` | 10 % | 0.50 | MeshLab | 0.50 | MeshLab |",
            ]
        );
    }

    #[test]
    fn wins_are_over_all_programs_that_are_not_ours() {
        let cell = |mesh: &str, name: &str, mean: f64| Record {
            mesh: mesh.into(),
            ..record(name, 100, 1.0, mean)
        };
        let rows = [
            cell("a", "default", 2.0),
            cell("a", "meshlab", 4.0),
            cell("a", "open3d", 8.0),
            cell("b", "default", 3.0),
            cell("b", "fast", 1.0),
            cell("b", "meshlab", 4.0),
            cell("b", "open3d", 2.0),
        ];
        let text = wins(&rows);
        let lines: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(
            lines,
            [
                "| `default` | 2 | 50 % | 50 % |",
                "| MeshLab | 2 | 50 % | 50 % |",
                "| Open3D | 2 | 50 % | 50 % |",
                "| `fast` | 1 | 100 % | 100 % |",
            ]
        );
    }

    #[test]
    fn what_is_not_in_the_record_is_said() {
        let text = tools(&[record("meshlab", 100, 1.0, 3.0)]);
        assert!(text.contains("| MeshLab | default | 1.0 |"), "{text}");
        assert!(text.contains("| Open3D | default | not in this record |"), "{text}");
        assert!(text.contains("| trimesh | – | not had: it calls fast-simplification |"), "{text}");
    }

    #[test]
    fn others_are_compared_with_one_tool() {
        let mut sound = record("default", 100, 1.0, 3.0);
        let outcome = sound.outcome.as_mut().unwrap();
        outcome.validity.output = outcome.validity.input;
        let rows = [
            sound,
            record("fast", 100, 0.5, 4.0),
            record("meshlab", 100, 2.0, 6.0),
            Record { outcome: None, ..record("open3d", 100, 2.0, 6.0) },
        ];
        let text = compare(&rows, "default");
        let lines: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(
            lines,
            [
                "| `default` | 1.0 | 1 | 1 | 1 |  |  | 0 | 0 | 0 of 1 |",
                "| MeshLab | 1.0 | 2.00 | 2.00 | 2.00 | 1 of 1 | 1 of 1 | 0 | 0 | 1 of 1 |",
                "| Open3D | 1.0 | – | – | – | 0 of 0 | 0 of 0 | 1 | 0 | 0 of 1 |",
            ]
        );
    }

    #[test]
    fn defects_are_sums_of_what_the_inputs_did_not_have() {
        let mut failed = record("fast", 100, 1.0, 3.0);
        failed.outcome = None;
        let rows = [record("fast", 100, 1.0, 3.0), record("fast", 103, 1.0, 3.0), failed];
        let text = validity(&rows);
        let line = text.lines().last().unwrap();
        assert_eq!(
            line,
            "| `fast` | 3 | 1 | 1 | 0 | 6 | 0 | 0 | 0 | 2 | 0 | 25.00 % | 50.00 % | 1.00° |"
        );
        let cells = |line: &str| line.matches('|').count();
        assert!(text.lines().all(|other| cells(other) == cells(line)), "{text}");
    }
}
