//! One item on the page.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{Markup, PreEscaped, html};

use super::super::item::{Figure, Item, Table};
use super::super::numbers::{difference, pair, reference};
use super::super::row::{Content, Row};
use super::source;
use xtask_common::Failure;

/// So many numbers that the paper does not print are shown at once; more, only when asked for.
const FEW: usize = 6;
/// Tables with more columns are set closer.
const DENSE: usize = 5;

pub(super) fn article(item: &Item, folder: &Path) -> Result<Markup, Failure> {
    let figures: Vec<Markup> =
        item.figures.iter().map(|row| side_by_side(row, folder)).collect::<Result<_, _>>()?;
    let is_claim = |row: &&Row| matches!(row.content, Content::Claim { .. });
    let (claims, numbers): (Vec<&Row>, Vec<&Row>) = item.rows.iter().partition(is_claim);
    let in_sight = |row: &&&Row| row.is_compared() || !row.verdict.is_expected();
    let (shown, rest): (Vec<&Row>, Vec<&Row>) = numbers.iter().copied().partition(|r| in_sight(&r));
    Ok(html! {
        article id=(item.file_name()) {
            h3 { (item.name) }
            @if let Some(failure) = &item.failure { p.failure { "Could not be computed: " (failure) } }
            @if !item.about.is_empty() { p { (item.about) } }
            @if let Some(text) = &item.stand_in { p.note { (text) } }
            @if !item.missing_models.is_empty() {
                p.note { "Not here: " (item.missing_models.join(", ")) ". Name a folder that has it with "
                    code { "--models DIR" } " or " code { "CURVMESH_MODELS" } "." }
            }
            @if !claims.is_empty() { ul.claims { @for row in &claims { (claim(row)) } } }
            @if !shown.is_empty() { (number_table(&shown)) }
            @for figures in &figures { (figures) }
            @for plot in &item.plots {
                figure.plot { (PreEscaped(&plot.svg)) figcaption { (plot.caption) } }
            }
            @for table in &item.tables { (plain_table(table)) }
            @if !rest.is_empty() {
                details open[rest.len() <= FEW] {
                    summary { (rest.len()) " numbers that the paper does not print, as they are watched" }
                    (number_table(&rest))
                }
            }
            (how_to(item, folder))
        }
    })
}

fn claim(row: &Row) -> Markup {
    let Content::Claim { quote, says, outcome, how } = &row.content else { return html! {} };
    let label = match outcome {
        Some(outcome) if row.verdict.is_expected() => outcome.to_string(),
        _ => row.verdict.to_string(),
    };
    html! {
        li {
            q { (quote) } " "
            @if let Some(says) = says { (says) " " }
            @if let Some(place) = &row.place { span.place { "(" (place) ")" } }
            span.how { span class={ "v " (class(row)) } { (label) } @if !how.is_empty() { ": " (how) } }
        }
    }
}

/// The class of a row's verdict.
fn class(row: &Row) -> String {
    row.verdict.label().replace(' ', "-")
}

fn number_table(rows: &[&Row]) -> Markup {
    let has_printed = rows.iter().any(|row| row.is_published());
    let has_reference = rows.iter().any(|row| row.reference().is_some());
    html! {
        div.scroll tabindex="0" role="group" aria-label="Numbers" { table.cards.numbers {
            tr {
                th { "quantity" }
                @if has_printed { th.place { "where" } th { "published" } }
                th { "ours" }
                @if has_printed { th { "difference" } }
                @if has_reference { th { "independent program" } }
                th.verdict { "verdict" }
            }
            @for row in rows {
                @let [printed, ours] = pair(row);
                tr {
                    td { (row.quantity) }
                    @if has_printed {
                        td.place data-label="where" { @if let Some(place) = &row.place { (place) } }
                        td data-label="published" { (printed) }
                    }
                    td data-label="ours" { (ours) }
                    @if has_printed { td data-label="difference" { (difference(row)) } }
                    @if has_reference { td data-label="independent program" { (reference(row)) } }
                    td.verdict data-label="verdict" {
                        span class={ "v " (class(row)) } { (row.verdict.label()) }
                        @if !row.verdict.remark().is_empty() { ": " (row.verdict.remark()) }
                    }
                }
            }
        } }
    }
}

fn plain_table(table: &Table) -> Markup {
    html! {
        p.caption { (table.caption) }
        div.scroll tabindex="0" role="group" aria-label=(table.caption) { table.cards.dense[table.header.len() > DENSE] {
            tr { @for (i, name) in table.header.iter().enumerate() { th.word[is_words(table, i)] { (name) } } }
            @for line in &table.lines {
                tr {
                    @for (i, cell) in line.iter().enumerate() {
                        td.word[is_words(table, i)] data-label=[label(table, i)] { (cell) }
                    }
                }
            }
        } }
    }
}

/// The head of a column beside its cells where rows are cards; the first cell is the head of its card.
fn label(table: &Table, column: usize) -> Option<&str> {
    table.header.get(column).map(String::as_str).filter(|_| column > 0)
}

/// Whether a column holds words, not numbers.
fn is_words(table: &Table, column: usize) -> bool {
    let mut cells = table.lines.iter().filter_map(|line| line.get(column));
    cells.any(|cell| cell.starts_with(char::is_alphabetic))
}

fn side_by_side(figures: &[Figure], folder: &Path) -> Result<Markup, Failure> {
    let figures: Vec<Markup> =
        figures.iter().map(|f| figure(f, folder)).collect::<Result<_, _>>()?;
    Ok(html! { div class={ "row n" (figures.len()) } { @for figure in &figures { (figure) } } })
}

fn figure(figure: &Figure, folder: &Path) -> Result<Markup, Failure> {
    let path = folder.join(&figure.file);
    let bytes = std::fs::read(&path).map_err(Failure::writing(&path))?;
    let source = format!("data:image/png;base64,{}", BASE64.encode(bytes));
    Ok(html! {
        figure {
            button.turn type="button" data-view=(figure.turning.display())
                aria-label={ "Turn the model: " (figure.caption) } {
                img src=(source) alt=(figure.caption);
            }
            figcaption {
                (figure.caption)
                " " a href=(figure.turning.display()) { "turn" }
                @for mesh in &figure.meshes {
                    @let kind = mesh.extension().unwrap_or_default().to_string_lossy().to_uppercase();
                    " " a href=(mesh.to_string_lossy()) { (kind) }
                }
            }
        }
    })
}

/// The functions that did the work, and how to do it to one's own mesh.
fn how_to(item: &Item, folder: &Path) -> Markup {
    html! {
        div.how-to {
            @if !item.functions.is_empty() {
                p {
                    "Computed by "
                    @for (i, function) in item.functions.iter().enumerate() {
                        @if i > 0 { ", " }
                        @match source::link(function, folder) {
                            Some(link) => a href=(link) { code { (function) } },
                            None => code { (function) },
                        }
                    }
                    " in " (format!("{:.1}", item.took.as_secs_f64())) " s."
                }
            }
            @if !item.commands.is_empty() {
                p {
                    "On your own mesh: "
                    @for (i, command) in item.commands.iter().enumerate() {
                        @if i > 0 { ", " }
                        code { (command) }
                    }
                }
            }
            p {
                "These numbers as " a href={ (item.file_name()) ".csv" } { "CSV" } " and "
                a href={ (item.file_name()) ".json" } { "JSON" } "."
            }
        }
    }
}
