//! `cargo xtask reproduce`: the papers' tables and figures, with the printed numbers beside ours.

mod dhkl01;
mod item;
mod page;
mod published;

use std::fs::File;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};

use crate::failure::Failure;
use item::{Item, Row, Verdict};
use published::Paper;

/// What to reproduce, and where to put it.
#[derive(Debug, clap::Args)]
pub(crate) struct Reproduce {
    /// The papers to reproduce, like DHKL01; all of them by default
    #[arg(value_name = "PAPER")]
    papers: Vec<String>,
    /// Fail when a number is not what it should be
    #[arg(long)]
    check: bool,
    /// The folder for the page, the pictures, the meshes and the numbers
    #[arg(long, value_name = "DIR", default_value = "target/reproduce")]
    out: PathBuf,
}

/// Reproduces, prints a summary, and writes the page.
pub(crate) fn run(options: &Reproduce) -> Result<(), Failure> {
    let papers = selected(&options.papers)?;
    std::fs::create_dir_all(&options.out).map_err(Failure::writing(&options.out))?;
    let items = reproduce(&papers, &options.out)?;
    write_numbers(&items, &options.out)?;
    page::write(&papers, &items, &options.out)?;
    print_summary(&items);
    println!("\nThe page with pictures: {}", options.out.join("index.html").display());
    let wrong = rows(&items)
        .filter(|row| row.verdict != Verdict::Exact && row.verdict != Verdict::NotPublished);
    match wrong.count() {
        drift if options.check && drift > 0 => Err(Failure::Drift(drift)),
        _ => Ok(()),
    }
}

fn selected(names: &[String]) -> Result<Vec<Paper>, Failure> {
    let papers = published::papers()?;
    let known: Vec<String> = papers.iter().map(|p| p.short.clone()).collect();
    let is_known = |name: &&String| known.iter().any(|k| k.eq_ignore_ascii_case(name));
    if let Some(unknown) = names.iter().find(|name| !is_known(name)) {
        let message = format!("there is no paper {unknown}; known are {}", known.join(", "));
        return Err(Failure::Usage(message));
    }
    let wanted = |paper: &Paper| {
        names.is_empty() || names.iter().any(|name| paper.short.eq_ignore_ascii_case(name))
    };
    Ok(papers.into_iter().filter(wanted).collect())
}

fn reproduce(papers: &[Paper], out: &Path) -> Result<Vec<Item>, Failure> {
    let steps: Vec<(&Paper, Step)> = papers
        .iter()
        .flat_map(|paper| steps_of(&paper.short).iter().map(move |&step| (paper, step)))
        .collect();
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len}  {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(steps.len() as u64).with_style(style);
    let mut items = Vec::with_capacity(steps.len());
    for (paper, (name, step)) in steps {
        bar.set_message(format!("{}, {name}", paper.short));
        items.push(step(paper, out)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(items)
}

/// The name of an item and the function that computes it.
type Step = (&'static str, fn(&Paper, &Path) -> Result<Item, Failure>);

fn steps_of(paper: &str) -> &'static [Step] {
    match paper {
        "DHKL01" => &dhkl01::STEPS,
        _ => &[],
    }
}

fn rows(items: &[Item]) -> impl Iterator<Item = &Row> {
    items.iter().flat_map(|item| &item.rows)
}

/// `results.json` with everything, `results.csv` with the numbers.
fn write_numbers(items: &[Item], out: &Path) -> Result<(), Failure> {
    let path = out.join("results.json");
    let file = File::create(&path).map_err(Failure::writing(&path))?;
    serde_json::to_writer_pretty(file, items).map_err(|e| Failure::writing(&path)(e.into()))?;

    let path = out.join("results.csv");
    let failed = |e: csv::Error| Failure::writing(&path)(e.into());
    let mut table = csv::Writer::from_path(&path).map_err(failed)?;
    table
        .write_record(["paper", "item", "quantity", "printed", "ours", "verdict"])
        .map_err(failed)?;
    for item in items {
        for row in &item.rows {
            let printed = row.printed.map(|p| p.to_string()).unwrap_or_default();
            let ours = row.ours.to_string();
            let fields =
                [&item.paper, &item.name, &row.quantity, &printed, &ours, row.verdict.label()];
            table.write_record(fields).map_err(failed)?;
        }
    }
    table.flush().map_err(Failure::writing(&path))
}

fn print_summary(items: &[Item]) {
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(["paper", "item", "quantity", "printed", "ours", "difference", "verdict"]);
    for item in items {
        if let Some(needs) = &item.needs {
            table.add_row([&item.paper, &item.name, needs]);
        }
        for row in &item.rows {
            table.add_row([
                item.paper.clone(),
                item.name.clone(),
                row.quantity.clone(),
                row.printed.map(|p| format!("{p:.10}")).unwrap_or_default(),
                format!("{:.10}", row.ours),
                row.difference().map(|d| format!("{d:+.1e}")).unwrap_or_default(),
                row.verdict.label().to_owned(),
            ]);
        }
    }
    println!("{table}");
}
