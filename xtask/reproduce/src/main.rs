//! `cargo xtask reproduce`: the papers' tables and figures, with the printed numbers beside ours.
//!
//! This is a program, so unlike the libraries it prints.
//!
//! A paper is a list of [`Step`]s, in a module of its own. Each step computes an [`Item`]: it says
//! what was done ([`Item::about`], [`Item::how`]), adds numbers ([`Item::number`]), says whether
//! claims hold ([`Item::claim`]), and adds tables, plots and pictures ([`Run::draw`]). It knows
//! nothing of what is printed: that is in `published/*.toml`, together with the claims, and what the
//! program computed before is in `recorded/*.csv`. [`verdict`] compares them; every printed number
//! and every claim whose item did not compute it gets a row too. [`page`] shows all.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod bar06;
#[cfg(test)]
mod commands;
mod dhkl01;
mod files;
mod flips;
mod item;
mod kkl02;
mod numbers;
mod outcome;
mod page;
mod pkh00;
mod published;
mod recorded;
mod row;
mod run;
mod sn10;
mod step;
mod summary;
mod verdict;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use rayon::prelude::*;
use xtask_common::{Failure, exit_code, progress_bar};

use item::Item;
use published::Paper;
use recorded::Recorded;
use run::Run;
use step::Step;
use verdict::Judge;

/// What to reproduce, and where to put it.
#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask reproduce",
    about = "Computes the papers' tables and figures and compares them with the printed numbers"
)]
struct Reproduce {
    /// What to reproduce: papers (DHKL01, BAR06, SN10, KKL02, PKH00), data sets (torus, cube, convex7), or
    /// items by the names that --list shows; everything by default
    #[arg(value_name = "WHAT")]
    what: Vec<String>,
    /// List the items and the data sets
    #[arg(long)]
    list: bool,
    /// Print the row of DHKL01's Table 1 for a mesh of its torus
    #[arg(long, value_name = "FILE")]
    measure_torus: Option<PathBuf>,
    /// The folder of real models, for the items that need one
    #[arg(long, value_name = "DIR", env = "CURVMESH_MODELS")]
    models: Option<PathBuf>,
    /// Fail when a number or claim is not what is on record
    #[arg(long)]
    check: bool,
    /// Leave out what is slow
    #[arg(long)]
    quick: bool,
    /// Put on record what is computed now (xtask/reproduce/recorded), after looking at it
    #[arg(long, conflicts_with_all = ["check", "quick"])]
    record: bool,
    /// Put the turning models into the page itself, so that it needs no file beside it
    #[arg(long)]
    embed: bool,
    /// The folder for the page, the pictures, the meshes and the numbers
    #[arg(long, value_name = "DIR", default_value = "target/reproduce")]
    out: PathBuf,
}

/// The items of a paper, in the order of the paper.
fn steps_of(paper: &str) -> &'static [Step] {
    match paper {
        "DHKL01" => &dhkl01::STEPS,
        "BAR06" => &bar06::STEPS,
        "SN10" => &sn10::STEPS,
        "KKL02" => &kkl02::STEPS,
        "PKH00" => &pkh00::STEPS,
        _ => &[],
    }
}

fn main() -> ExitCode {
    exit_code(run(&Reproduce::parse()))
}

/// Reproduces, prints a summary, and writes the page.
fn run(options: &Reproduce) -> Result<(), Failure> {
    if let Some(path) = &options.measure_torus {
        return dhkl01::torus::measure(path);
    }
    let papers = published::papers()?;
    if options.list {
        list(&papers);
        return Ok(());
    }
    let steps = selected(&papers, &options.what)?;
    std::fs::create_dir_all(&options.out).map_err(Failure::writing(&options.out))?;
    let run = Run { out: &options.out, models: options.models.as_deref(), quick: options.quick };
    let mut items = reproduce(steps, &run);
    let mut recorded = Recorded::read()?;
    if options.record {
        recorded = recorded.record(&items)?;
    }
    judge(&papers, &recorded, options.quick, &mut items);
    let papers = shown(papers, &items);
    files::write(&items, &options.out)?;
    page::write(&papers, &items, &options.out, options.embed)?;
    print!("{}", summary::text(&papers, &items));
    println!("\nThe page with pictures: {}", options.out.join("index.html").display());
    verdict_of(&items, options.check)
}

fn judge(papers: &[Paper], recorded: &Recorded, quick: bool, items: &mut [Item]) {
    for paper in papers {
        let judge = Judge { paper, recorded, quick };
        items.iter_mut().filter(|item| item.paper == paper.short).for_each(|item| judge.fill(item));
    }
}

/// Whether the run as a whole is good.
fn verdict_of(items: &[Item], check: bool) -> Result<(), Failure> {
    let failed = items.iter().filter(|item| item.failure.is_some()).count();
    let drifted = items.iter().flat_map(|i| &i.rows).filter(|r| !r.verdict.is_expected()).count();
    match (failed, drifted) {
        (1.., _) => Err(Failure::Check(format!(
            "{failed} of the items could not be computed; the table says why"
        ))),
        (_, 1..) if check => Err(Failure::Check(format!(
            "{drifted} numbers and claims differ from the record; the table says which"
        ))),
        _ => Ok(()),
    }
}

/// The papers that any of the items is of.
fn shown(mut papers: Vec<Paper>, items: &[Item]) -> Vec<Paper> {
    papers.retain(|paper| items.iter().any(|item| item.paper == paper.short));
    papers
}

/// Every item of the papers.
fn steps(papers: &[Paper]) -> impl Iterator<Item = (&Paper, &'static Step)> {
    papers.iter().flat_map(|paper| steps_of(&paper.short).iter().map(move |step| (paper, step)))
}

/// Prints the names that select items.
fn list(papers: &[Paper]) {
    println!("{:44} {:8} {:9} item", "name", "paper", "data set");
    for (paper, step) in steps(papers) {
        let name = step.named_item(&paper.short).file_name();
        println!("{name:44} {:8} {:9} {}", paper.short, step.data.join(", "), step.name);
    }
}

/// The items that the words ask for, in the order of the papers; all of them without words.
fn selected<'a>(
    papers: &'a [Paper],
    words: &[String],
) -> Result<Vec<(&'a Paper, &'static Step)>, Failure> {
    let is_known = |word: &&String| steps(papers).any(|(p, s)| s.is_asked_for(&p.short, word));
    if let Some(unknown) = words.iter().find(|word| !is_known(word)) {
        return Err(Failure::Usage(format!(
            "there is no paper, data set or item {unknown}; --list shows all of them"
        )));
    }
    let is_wanted = |(paper, step): &(&Paper, &Step)| {
        words.is_empty() || words.iter().any(|word| step.is_asked_for(&paper.short, word))
    };
    Ok(steps(papers).filter(is_wanted).collect())
}

/// Computes the items, several at once.
fn reproduce(steps: Vec<(&Paper, &Step)>, run: &Run<'_>) -> Vec<Item> {
    let bar = progress_bar(steps.len());
    bar.enable_steady_tick(Duration::from_millis(200));
    let compute = |(paper, step): (&Paper, &Step)| {
        bar.set_message(format!("{}, {}", paper.short, step.name));
        let item = step.item(&paper.short, run);
        bar.inc(1);
        item
    };
    let items = steps.into_par_iter().with_max_len(1).map(compute).collect();
    bar.finish_and_clear();
    items
}
