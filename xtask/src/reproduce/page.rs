//! The page of a reproduction: one self-contained HTML file.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::item::{Figure, Item, Row, Verdict};
use super::published::Paper;
use crate::failure::Failure;

const STYLE: &str = "
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; } h2 { margin-top: 3rem; border-bottom: 1px solid #ddd; } h3 { margin-top: 2rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .9rem; text-align: right; border-bottom: 1px solid #eee; }
th:first-child, td:first-child, td:last-child, th:last-child { text-align: left; }
.exact { color: #176d2f; } .differs, .drifted { color: #b3261e; font-weight: 600; } .not-published { color: #666; }
.figures { display: flex; flex-wrap: wrap; gap: 1rem; }
figure { margin: 0; width: 22rem; } figure img { width: 100%; border: 1px solid #eee; } figcaption { color: #555; font-size: .9rem; }
code { background: #f4f4f2; padding: .1rem .3rem; border-radius: .2rem; }
";

/// Writes the page to `folder/index.html`, with the pictures of the items inlined.
pub(super) fn write(papers: &[Paper], items: &[Item], folder: &Path) -> Result<(), Failure> {
    let path = folder.join("index.html");
    let text = page(papers, items, folder)?.into_string();
    std::fs::write(&path, text).map_err(Failure::writing(&path))
}

fn page(papers: &[Paper], items: &[Item], folder: &Path) -> Result<Markup, Failure> {
    let sections: Vec<Markup> =
        papers.iter().map(|paper| section(paper, items, folder)).collect::<Result<_, _>>()?;
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "curvmesh: reproduction" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "What the papers print, and what curvmesh computes" }
                p {
                    "Every number is computed anew by " code { "cargo xtask reproduce" }
                    ". " span.exact { "exact" } " means within the stated tolerance of the printed number."
                }
                @for section in &sections { (section) }
            }
        }
    })
}

fn section(paper: &Paper, items: &[Item], folder: &Path) -> Result<Markup, Failure> {
    let blocks: Vec<Markup> = items
        .iter()
        .filter(|item| item.paper == paper.short)
        .map(|item| block(item, folder))
        .collect::<Result<_, _>>()?;
    Ok(html! {
        @if !blocks.is_empty() {
            h2 { (paper.short) ": " (paper.title) }
            @for block in &blocks { (block) }
        }
    })
}

fn block(item: &Item, folder: &Path) -> Result<Markup, Failure> {
    let figures: Vec<Markup> =
        item.figures.iter().map(|f| figure(f, folder)).collect::<Result<_, _>>()?;
    Ok(html! {
        h3 { (item.name) }
        p { (item.about) }
        @if let Some(needs) = &item.needs { p { em { (needs) } } }
        @if !item.rows.is_empty() {
            table {
                tr { th { "quantity" } th { "printed" } th { "ours" } th { "difference" } th { "verdict" } }
                @for row in &item.rows { (table_row(row)) }
            }
        }
        div.figures { @for figure in &figures { (figure) } }
        p {
            "Computed by "
            @for (i, function) in item.functions.iter().enumerate() {
                @if i > 0 { ", " }
                code { (function) }
            }
            ". On your own mesh: " code { (item.command) }
        }
    })
}

fn table_row(row: &Row) -> Markup {
    let class = match row.verdict {
        Verdict::Exact => "exact",
        Verdict::Differs => "differs",
        Verdict::Drifted => "drifted",
        Verdict::NotPublished => "not-published",
    };
    html! {
        tr {
            td { (row.quantity) }
            td { @if let Some(printed) = row.printed { (format!("{printed:.10}")) } }
            td { (format!("{:.10}", row.ours)) }
            td { @if let Some(difference) = row.difference() { (format!("{difference:+.1e}")) } }
            td class=(class) { (row.verdict.label()) }
        }
    }
}

fn figure(figure: &Figure, folder: &Path) -> Result<Markup, Failure> {
    let path = folder.join(&figure.file);
    let bytes = std::fs::read(&path).map_err(Failure::writing(&path))?;
    let source = format!("data:image/png;base64,{}", BASE64.encode(bytes));
    let mesh = figure.mesh.to_string_lossy();
    Ok(html! {
        figure {
            img src=(source) alt=(figure.caption);
            figcaption { (figure.caption) " (" a href=(mesh) { (mesh) } ")" }
        }
    })
}
