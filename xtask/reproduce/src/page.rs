//! The page of a reproduction: one self-contained HTML file.

mod item;
mod source;

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::item::Item;
use super::published::Paper;
use super::summary::Counts;
use xtask_common::Failure;

const STYLE: &str = include_str!("page/style.css");

/// Opens the turning models.
const SCRIPT: &str = include_str!("page/turning.js");

/// Writes the page to `folder/index.html`, with the pictures of the items inlined. The models turn
/// on pages beside it, which are loaded when asked for; or, embedded, on pages in it.
pub(super) fn write(
    papers: &[Paper],
    items: &[Item],
    folder: &Path,
    embed: bool,
) -> Result<(), Failure> {
    let path = folder.join("index.html");
    let models = if embed {
        embedded(items, folder)?
    } else {
        html! {}
    };
    let text = page(papers, items, folder, &models)?.into_string();
    std::fs::write(&path, text).map_err(Failure::writing(&path))
}

/// The pages of the turning models, as data that does nothing until it is asked for.
fn embedded(items: &[Item], folder: &Path) -> Result<Markup, Failure> {
    let mut models = Vec::new();
    for figure in items.iter().flat_map(|item| item.figures.iter().flatten()) {
        let path = folder.join(&figure.turning);
        let bytes = std::fs::read(&path).map_err(Failure::writing(&path))?;
        models.push((figure.turning.display().to_string(), BASE64.encode(bytes)));
    }
    Ok(html! {
        @for (name, data) in &models { script type="text/plain" id=(name) { (PreEscaped(data)) } }
    })
}

fn page(
    papers: &[Paper],
    items: &[Item],
    folder: &Path,
    models: &Markup,
) -> Result<Markup, Failure> {
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
                div.layout {
                    (contents(papers, items))
                    main {
                        (summary(papers, items))
                        @for section in &sections { (section) }
                        footer {
                            "Made by " code { "cargo xtask reproduce" } ". The numbers of this page, as "
                            a href="results.csv" { "CSV" } " and " a href="results.json" { "JSON" } "."
                        }
                    }
                }
                dialog #turning aria-label="Turning model" {
                    form method="dialog" { button { "Close" } }
                    iframe title="Turning model" {}
                }
                (models)
                script { (PreEscaped(SCRIPT)) }
            }
        }
    })
}

fn items_of<'a>(paper: &'a Paper, items: &'a [Item]) -> impl Iterator<Item = &'a Item> {
    items.iter().filter(|item| item.paper == paper.short)
}

/// The table of contents: every item with a dot that tells its verdict.
fn contents(papers: &[Paper], items: &[Item]) -> Markup {
    html! {
        nav {
            a href="#summary" { strong { "Summary" } }
            @for paper in papers {
                ol {
                    li.paper { a href={ "#" (paper.short) } { (paper.short) } }
                    @for item in items_of(paper, items) {
                        li {
                            span class={ "dot " (worst_class(item)) } {}
                            a href={ "#" (item.file_name()) } { (item.name) }
                        }
                    }
                }
            }
        }
    }
}

/// The verdict of an item as a whole: the least favourable one of its rows.
fn worst_class(item: &Item) -> &'static str {
    let counts = Counts::of(&item.rows);
    match counts {
        _ if item.failure.is_some() || counts.drifted > 0 => "drifted",
        _ if counts.differs > 0 => "differs",
        _ if counts.agrees > 0 => "agrees",
        _ if counts.exact > 0 => "exact",
        _ if counts.needs_model > 0 => "needs-a-model",
        _ => "not-published",
    }
}

fn summary(papers: &[Paper], items: &[Item]) -> Markup {
    let all = Counts::of(items.iter().flat_map(|item| &item.rows));
    let failed = items.iter().filter(|item| item.failure.is_some()).count();
    html! {
        header id="summary" {
            h1 { "What the papers print, and what curvmesh computes" }
            p.lead {
                "Tables, figures and claims of the papers that curvmesh implements, computed "
                "by one command and compared with the printed numbers. Numbers that the papers do not print "
                "are compared with the record of an earlier run, so that a change is noticed."
            }
            p { (opening(all, failed)) }
            div.tiles {
                (tile(all.exact, "exact", "the same quantity of the same data, within the tolerance of the printed number"))
                (tile(all.agrees, "agree", "the printed number lies in the range of our results, or the claim holds"))
                (tile(all.differs, "differ", "the number differs, or the claim holds in part or not at all; the reason is beside it"))
                (tile(all.needs_model, "need a model", "the model is not here or not public"))
                (tile(all.not_published, "not published", "recorded and watched"))
                @if all.skipped > 0 { (tile(all.skipped, "skipped", "left out of a quick run")) }
                @if all.drifted > 0 { (tile(all.drifted, "drifted", "not what is on record")) }
                @if failed > 0 { (tile(failed, "failed", "items that could not be computed")) }
            }
            div.scroll tabindex="0" role="group" aria-label="Papers" { table.cards {
                tr { th { "paper" } th { "items" } th { "exact" } th { "agree" } th { "differ" } th { "need a model" } th { "not published" } }
                @for paper in papers {
                    @let counts = Counts::of(items_of(paper, items).flat_map(|item| &item.rows));
                    tr {
                        td { a href={ "#" (paper.short) } { (paper.short) } " " (paper.title) }
                        td data-label="items" { (items_of(paper, items).count()) }
                        td data-label="exact" { (counts.exact) }
                        td data-label="agree" { (counts.agrees) }
                        td data-label="differ" { (counts.differs) }
                        td data-label="need a model" { (counts.needs_model) }
                        td data-label="not published" { (counts.not_published) }
                    }
                }
            } }
        }
    }
}

/// The result in words. Numbers that the program sets itself are not counted.
fn opening(all: Counts, failed: usize) -> String {
    let mut text = format!(
        "{} numbers are exact: the same quantity of the same data, within the tolerance of the printed one. \
         {} numbers and claims agree, by the rule beside each. {} differ, with the reason beside each: \
         among them {} claims that hold in part and {} that fail.",
        all.exact, all.agrees, all.differs, all.in_part, all.fails
    );
    if all.needs_model > 0 {
        text += &format!(" {} need a model that is not here or not public.", all.needs_model);
    }
    if all.drifted + failed > 0 {
        text += &format!(" {} have changed since the record; {failed} items failed.", all.drifted);
    }
    text + " Radii, point counts and target face counts that the program sets itself are shown and not counted."
}

fn tile(count: usize, name: &str, meaning: &str) -> Markup {
    html! { div.tile title=(meaning) { b { (count) } span { (name) } } }
}

fn section(paper: &Paper, items: &[Item], folder: &Path) -> Result<Markup, Failure> {
    let blocks: Vec<Markup> =
        items_of(paper, items).map(|item| item::article(item, folder)).collect::<Result<_, _>>()?;
    Ok(html! {
        section.paper id=(paper.short) {
            h2 { (paper.title) }
            p.source { (paper.authors) ". " (paper.source) }
            p { (paper.about) }
            @for block in &blocks { (block) }
            @if !paper.models.is_empty() { (models(paper)) }
        }
    })
}

fn models(paper: &Paper) -> Markup {
    html! {
        details {
            summary { "Where the real models come from" }
            div.scroll tabindex="0" role="group" aria-label="Models" { table {
                tr { th { "file" } th.verdict { "part it plays" } th.verdict { "source" } }
                @for model in &paper.models {
                    tr { td { code { (model.file) } } td.verdict { (model.role) } td.verdict { (model.from) } }
                }
            } }
        }
    }
}
