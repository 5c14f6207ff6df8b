//! `cargo run -p torture -- --models DIR`: every command on every file of a folder, each run under limits.
//!
//! This is a program, so unlike the libraries it prints.
//!
//! A run is a process of the built program with a limit of time and memory ([`child`]). Its outputs are read by
//! [readers] that share no code with `mesh-io`, and compared with the report of the program ([`judge`]). A run may
//! succeed (exit 0), or refuse the file (3) or the mesh (4) with a message. Anything else is a fault. An output
//! that contradicts the report, or breaks a [promise](postconditions::Promise) of the command, is a fault, too. [`jobs`]
//! lists the commands and their options, [`table`] shows the outcome.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod child;
mod content;
mod jobs;
mod judge;
mod manifold;
mod readers;
mod record;
mod table;

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use clap::Parser;
use indicatif::ProgressBar;
use postconditions::{kinds, wear};
use rayon::prelude::*;
use xtask_common::{Failure, exit_code, progress_bar};

use child::Limits;
use jobs::Job;
use judge::{Subject, Trial};
use record::Record;

/// What to torture, and under which limits.
#[derive(Debug, Parser)]
#[command(
    name = "torture",
    about = "Runs every command on every file of a folder, under limits, and checks the results with other readers"
)]
struct Torture {
    /// The folder of files; all of them are taken, whatever they are
    #[arg(
        long,
        value_name = "DIR",
        env = "CURVMESH_MODELS",
        required_unless_present = "generated"
    )]
    models: Option<PathBuf>,
    /// Instead of a folder: so many meshes of the kinds that CAD programs and scanners make, and only the jobs that
    /// promise not to make a mesh worse
    #[arg(long, value_name = "N")]
    generated: Option<u64>,
    /// The number of the first generated mesh
    #[arg(long, value_name = "N", default_value_t = 0, requires = "generated")]
    first: u64,
    /// Only the jobs whose name contains one of these
    #[arg(long, value_name = "JOBS", value_delimiter = ',')]
    only: Vec<String>,
    /// Only the files whose name contains one of these
    #[arg(long, value_name = "FILES", value_delimiter = ',')]
    files: Vec<String>,
    /// Leave out files of more than 100 kB, and jobs that take long by their nature
    #[arg(long)]
    quick: bool,
    /// Only every Nth run, for a sample
    #[arg(long, value_name = "N", default_value = "1")]
    every: std::num::NonZero<usize>,
    /// Go on after the runs whose outcomes an earlier call has left in the folder of numbers
    #[arg(long)]
    resume: bool,
    /// How many runs at once [default: one per core]; each has one thread
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Processor time that a run may take, in seconds; ten times as much for jobs that take long by
    /// their nature
    #[arg(long, value_name = "SECONDS", default_value_t = 120)]
    seconds: u64,
    /// Address space that a run may take, in MiB
    #[arg(long, value_name = "MIB", default_value_t = 4096)]
    memory: u64,
    /// The program [default: built from this workspace, without optimisation of the release, so
    /// that overflows and broken assertions show]
    #[arg(long, value_name = "PATH")]
    program: Option<PathBuf>,
    /// The folder for the numbers (runs.csv, runs.json), the table, and the outputs of faulty runs
    #[arg(long, value_name = "DIR", default_value = "target/torture")]
    out: PathBuf,
}

/// Largest size of a small file, in bytes.
const SMALL: u64 = 100_000;

fn main() -> ExitCode {
    exit_code(run(&Torture::parse()))
}

/// Runs all jobs on all files, writes the numbers and prints the table.
fn run(options: &Torture) -> Result<(), Failure> {
    let program = options.program.clone().map_or_else(build, Ok)?;
    let program = std::path::absolute(&program).map_err(Failure::writing(&program))?;
    let work = options.out.join("work");
    if work.exists() {
        std::fs::remove_dir_all(&work).map_err(Failure::writing(&work))?;
    }
    std::fs::create_dir_all(&work).map_err(Failure::writing(&work))?;
    let limits = Limits {
        processor: Duration::from_secs(options.seconds),
        address_space: options.memory << 20,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.jobs.unwrap_or(0)).build();
    let pool = pool.map_err(|error| Failure::Usage(error.to_string()))?;
    let trial = Trial { program: &program, work: &work, limits };
    let records = pool.install(|| all(options, &trial))?;
    let text = table::text(&records);
    record::write(&records, &options.out)?;
    let path = options.out.join("table.txt");
    std::fs::write(&path, &text).map_err(Failure::writing(&path))?;
    print!("{text}");
    println!("\nEvery run: {}", options.out.join("runs.csv").display());
    match records.iter().filter(|record| record.fault.is_some()).count() {
        0 => Ok(()),
        faults => {
            Err(Failure::Check(format!("{faults} of the runs have faults; the table says which")))
        }
    }
}

/// First runs `info` on all files, then everything else.
fn all(options: &Torture, trial: &Trial<'_>) -> Result<Vec<Record>, Failure> {
    let wanted = |name: &str, words: &[String]| {
        words.is_empty() || words.iter().any(|word| name.contains(word))
    };
    let generated = options.out.join("generated");
    let folder = match (options.generated, &options.models) {
        (Some(count), _) => {
            generate(&generated, options.first..options.first + count)?;
            &generated
        }
        (None, Some(models)) => models,
        (None, None) => return Err(Failure::Usage("name a folder of models".into())),
    };
    let mut files = files(folder)?;
    files.retain(|(name, _, size)| {
        wanted(name, &options.files) && !(options.quick && *size > SMALL)
    });
    if files.is_empty() {
        return Err(Failure::Usage(format!("{} has no such files", folder.display())));
    }
    let bar = ticking_bar();
    bar.set_length(files.len() as u64);
    let subjects: Vec<(Subject, Record)> = files
        .par_iter()
        .map(|(name, path, size)| {
            let known = trial.subject(name, path, *size);
            bar.inc(1);
            known
        })
        .collect();
    let own = options.generated.is_none().then(jobs::all).unwrap_or_default();
    let jobs: Vec<Job> = own
        .into_iter()
        .chain(jobs::promising())
        .filter(|job| wanted(&job.name, &options.only) && !(options.quick && job.takes_long))
        .collect();
    let runs: Vec<(&Subject, &Job)> = subjects
        .iter()
        .flat_map(|(subject, _)| jobs.iter().map(move |job| (subject, job)))
        .step_by(options.every.get())
        .collect();
    bar.set_length((files.len() + runs.len()) as u64);
    let (numbers, known) = record::open(&options.out, options.resume)?;
    let known: HashMap<(String, String), Record> = known
        .into_iter()
        .map(|record| ((record.file.clone(), record.job.clone()), record))
        .collect();
    let numbers = Mutex::new(numbers);
    let judge = |(number, (subject, job)): (usize, (&Subject, &Job))| {
        let earlier = known.get(&(subject.name.clone(), job.name.clone()));
        if let Some(record) = earlier {
            bar.inc(1);
            return Ok(record.clone());
        }
        bar.set_message(format!("{} {}", subject.name, job.name));
        let record = trial.run(subject, job, number);
        if let Some(fault) = &record.fault {
            bar.suspend(|| eprintln!("{}: {}: {fault}", record.file, record.job));
        }
        bar.inc(1);
        numbers.lock().unwrap_or_else(PoisonError::into_inner).add_fields(&record)?;
        Ok(record)
    };
    let judged = runs.into_par_iter().with_max_len(1).enumerate().map(judge);
    let judged: Vec<Record> = judged.collect::<Result<_, Failure>>()?;
    bar.finish_and_clear();
    let mut records: Vec<Record> = subjects.into_iter().map(|(_, record)| record).collect();
    records.extend(judged);
    Ok(records)
}

/// Writes generated meshes into a folder.
fn generate(folder: &Path, numbers: Range<u64>) -> Result<(), Failure> {
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(Failure::writing(folder))?;
    }
    std::fs::create_dir_all(folder).map_err(Failure::writing(folder))?;
    for number in numbers {
        let kind = number as usize % kinds::count();
        let worn = wear::wear(&kinds::mesh(kind, number, 1.0), number);
        let name = format!("{} {number}.{}", kinds::name(kind), worn.format.extension());
        let path = folder.join(name);
        mesh_io::write(&path, &worn.model, &mesh_io::WriteOptions::default())
            .map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    }
    Ok(())
}

fn ticking_bar() -> ProgressBar {
    let bar = progress_bar(0);
    bar.unset_length();
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// The files of the folder: name, path and size, by name.
fn files(folder: &Path) -> Result<Vec<(String, PathBuf, u64)>, Failure> {
    let absolute = std::path::absolute(folder).map_err(Failure::reading(folder))?;
    let mut files = Vec::new();
    for entry in std::fs::read_dir(&absolute).map_err(Failure::reading(folder))? {
        let entry = entry.map_err(Failure::reading(folder))?;
        let metadata = entry.metadata().map_err(Failure::reading(folder))?;
        if metadata.is_file() {
            let name = entry.file_name().to_string_lossy().into_owned();
            files.push((name, entry.path(), metadata.len()));
        }
    }
    files.sort();
    Ok(files)
}

/// Builds the program and returns its path.
fn build() -> Result<PathBuf, Failure> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args([
        "build",
        "--package",
        "curvmesh-cli",
        "--message-format",
        "json-render-diagnostics",
    ]);
    command.stderr(std::process::Stdio::inherit());
    let failed = |why: String| Failure::Usage(format!("cannot build the program: {why}"));
    let output = command.output().map_err(|error| failed(error.to_string()))?;
    let messages = String::from_utf8_lossy(&output.stdout);
    let mut executables = messages.lines().filter_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        message.get("executable")?.as_str().map(PathBuf::from)
    });
    executables.next_back().ok_or_else(|| failed("cargo names no executable".into()))
}
