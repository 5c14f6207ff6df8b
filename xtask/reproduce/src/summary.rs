//! The summary on the terminal.

use comfy_table::{ContentArrangement, Table, presets};

use super::item::Item;
use super::numbers::{difference, pair, reference};
use super::outcome::Outcome;
use super::published::Paper;
use super::row::{Content, Row, Verdict};

/// How many rows have which verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) exact: usize,
    pub(super) agrees: usize,
    /// Numbers that the program sets itself.
    pub(super) setup: usize,
    pub(super) differs: usize,
    /// Claims among them that hold in part, and that fail.
    pub(super) in_part: usize,
    pub(super) fails: usize,
    pub(super) needs_model: usize,
    pub(super) not_published: usize,
    pub(super) skipped: usize,
    pub(super) drifted: usize,
}

impl Counts {
    pub(super) fn of<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Self {
        let mut counts = Self::default();
        for row in rows {
            if let (Verdict::Differs(_), Content::Claim { outcome: Some(outcome), .. }) =
                (&row.verdict, &row.content)
            {
                counts.in_part += usize::from(*outcome == Outcome::InPart);
                counts.fails += usize::from(*outcome == Outcome::Fails);
            }
            *match row.verdict {
                Verdict::Exact => &mut counts.exact,
                Verdict::Agrees(_) => &mut counts.agrees,
                Verdict::Setup => &mut counts.setup,
                Verdict::Differs(_) => &mut counts.differs,
                Verdict::NeedsModel(_) => &mut counts.needs_model,
                Verdict::NotPublished => &mut counts.not_published,
                Verdict::Skipped => &mut counts.skipped,
                Verdict::Drifted(_) => &mut counts.drifted,
            } += 1;
        }
        counts
    }
}

/// Everything that is published, item by item; of the rest, what is not as it should be.
pub(super) fn text(papers: &[Paper], items: &[Item]) -> String {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_BORDERS_ONLY);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    // Claims are sentences: wide lines would not be read. Without a terminal there is no width.
    table.set_width(table.width().unwrap_or(150).min(150));
    table.set_header(["item", "published", "ours", "difference", "verdict"]);
    for item in papers.iter().flat_map(|p| items.iter().filter(|i| i.paper == p.short)) {
        item_lines(item, &mut table);
    }
    format!("{table}\n{}\n", totals(items))
}

fn item_lines(item: &Item, table: &mut Table) {
    if let Some(failure) = &item.failure {
        table.add_row([format!("{} {}", item.paper, item.name), failure.clone()]);
    }
    let shown = |row: &&Row| row.is_compared() || !row.verdict.is_expected();
    for row in item.rows.iter().filter(shown) {
        let name = format!("{} {}: {}", item.paper, item.name, row.quantity);
        let [mut printed, mut ours] = pair(row);
        if row.reference().is_some() && !row.is_published() {
            printed = format!("not; another program: {}", reference(row));
        }
        if let Content::Claim { quote, says, how, .. } = &row.content {
            printed = format!("“{quote}”");
            if let Some(says) = says {
                printed += &format!(" {says}");
            }
            ours.clone_from(how);
        }
        table.add_row([name, printed, ours, difference(row), row.verdict.to_string()]);
    }
    let unpublished = item.rows.iter().filter(|row| !shown(row)).count();
    if unpublished > 0 {
        let text = format!("{unpublished} more, as on record");
        let name = format!("{} {}", item.paper, item.name);
        table.add_row([name, String::new(), text, String::new(), "not published".into()]);
    }
}

fn totals(items: &[Item]) -> String {
    let counts = Counts::of(items.iter().flat_map(|item| &item.rows));
    let mut text = format!(
        "{} exact, {} agree, {} differ, {} need a model; not counted: {} set by the program, {} not published",
        counts.exact,
        counts.agrees,
        counts.differs,
        counts.needs_model,
        counts.setup,
        counts.not_published
    );
    if counts.skipped > 0 {
        text += &format!(", {} skipped", counts.skipped);
    }
    if counts.drifted > 0 {
        text += &format!(", {} DRIFTED", counts.drifted);
    }
    text
}
