//! One command on many files: in parallel, each file by itself.
//!
//! The list of files, the places of their results and the order of the reports depend on the command line and the
//! folders alone, never on the number of threads. A file that fails is reported and skipped.

use std::collections::{BTreeMap, HashMap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Instant;

use mesh_io::Format;
use serde::Serialize;

use crate::args::is_standard;
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::given::Given;
use crate::interrupt::is_asked_to_end;
use crate::load::Loading;
use crate::save::{SAVE_OPTIONS, SaveOptions, check_folder_of, check_target};
use crate::session::{Outcome, Session};
use crate::task::{Done, Task};
use crate::text::printable;

/// Options of the commands that take many files.
#[derive(Debug, clap::Args)]
pub(crate) struct Job {
    /// Files to read, and folders: all mesh files in a folder and in the folders below are read. `-`
    /// is the standard input
    #[arg(value_name = "IN", required = true, help_heading = None)]
    pub(crate) inputs: Vec<PathBuf>,
    /// The file to write, a folder for the results of several files, or `-` for the standard output
    #[arg(short, long, value_name = "OUT", help_heading = None)]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) many: Many,
    #[command(flatten)]
    pub(crate) loading: Loading,
    #[command(flatten)]
    pub(crate) save: SaveOptions,
}

/// Which of many files are done.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Many files")]
pub(crate) struct Many {
    /// Skip files whose result exists and is not older than the file; `simplify --memory` continues an
    /// interrupted run
    #[arg(long)]
    pub(crate) resume: bool,
    /// Process only the K-th of N parts of the files, as in 2/16, for job arrays
    #[arg(long, value_name = "K/N", value_parser = parse_shard)]
    shard: Option<Shard>,
}

/// The K-th of N parts, counted from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    number: usize,
    of: usize,
}

pub(crate) fn parse_shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match parts {
        Some((number, of)) if 1 <= number && number <= of => Ok(Shard { number, of }),
        _ => Err("expected which part of how many, like 2/16".into()),
    }
}

impl Shard {
    /// The items that belong to this part.
    pub(crate) fn of_items<T>(self, items: impl IntoIterator<Item = T>) -> Vec<T> {
        items.into_iter().skip(self.number - 1).step_by(self.of).collect()
    }
}

/// The work of a command on one file.
type Work<'w> = dyn Fn(&Task, &Console) -> Result<Done, Failure> + Sync + 'w;

impl Job {
    /// Does the work on the file, or on all of them.
    pub(crate) fn run(&self, session: &Session, work: &Work<'_>) -> Result<Outcome, Failure> {
        self.run_as(session, &|path| self.save.format_of(path).map(Format::extension), work)
    }

    /// As [`Job::run`], for outputs that are not always meshes: `extension` returns the extension of the output for an
    /// input.
    pub(crate) fn run_as(
        &self,
        session: &Session,
        extension: &dyn Fn(&Path) -> Option<&'static str>,
        work: &Work<'_>,
    ) -> Result<Outcome, Failure> {
        if self.output.is_none() {
            session.given.refuse(&SAVE_OPTIONS, "without -o nothing is written")?;
            session.given.refuse(&["resume"], "without -o there are no results to pass over")?;
        }
        if let Some(single) = self.single(&session.given)? {
            let console = &*session.console.beside(single.output.as_deref())?;
            session.on_one_thing()?;
            work(&single, console)?.print(console)?;
            return Ok(Outcome::of_run());
        }
        let mut tasks = self.tasks(extension)?;
        if let Some(shard) = self.many.shard {
            tasks = shard.of_items(tasks);
        }
        all(&tasks, self.many.resume, session.on_many_files()?, work)
    }

    /// The only file, if there is only one and it does not go to a folder.
    fn single(&self, given: &Given) -> Result<Option<Task>, Failure> {
        let folder = self.output.as_deref().filter(|output| is_folder(output));
        let [input] = &self.inputs[..] else {
            refuse_standard(&self.inputs)?;
            if let Some(output) = self.output.as_deref().filter(|_| folder.is_none()) {
                self.check_folder(output)?;
            }
            return Ok(None);
        };
        if input.is_dir() || (folder.is_some() && !is_standard(input)) {
            if let Some(output) = self.output.as_deref().filter(|_| folder.is_none()) {
                self.check_folder(output)?;
            }
            return Ok(None);
        }
        if let Some(folder) = folder {
            let name = folder.display();
            let message = format!("{name} is a folder, and the standard input has no name in it");
            return Err(Failure::usage(message));
        }
        if !given.has("memory") {
            given.refuse(&["resume"], "there is one file only")?;
        }
        given.refuse(&["shard"], "there is one file only")?;
        if let Some(output) = self.output.as_deref().filter(|output| is_file_name(output)) {
            check_folder_of(output)?;
        }
        Ok(Some(Task { input: input.clone(), output: self.output.clone(), makes_folder: false }))
    }

    /// Refuses a single file for the results of many.
    fn check_folder(&self, output: &Path) -> Result<(), Failure> {
        if is_standard(output) || Format::from_extension(output).is_some() || output.is_file() {
            return Err(Failure::usage(format!(
                "{}: the results of several files go to a folder; name one with -o",
                output.display()
            )));
        }
        Ok(())
    }

    /// The files in the order of the command line; the files of a folder by name.
    fn tasks(
        &self,
        extension: &dyn Fn(&Path) -> Option<&'static str>,
    ) -> Result<Vec<Task>, Failure> {
        let found = files(&self.inputs, self.output.as_deref())?;
        let Some(folder) = &self.output else {
            return Ok(found.into_iter().map(|(input, _)| without_output(input)).collect());
        };
        let tasks = found.into_iter().map(|(input, name)| {
            let Some(extension) = extension(&input) else {
                let input = input.display();
                let message = format!("{input}: its name tells no format for its result; add --to");
                return Err(Failure::usage(message));
            };
            let output = Some(folder.join(name).with_extension(extension));
            Ok(Task { input, output, makes_folder: true })
        });
        let tasks: Vec<Task> = tasks.collect::<Result<_, Failure>>()?;
        check_outputs(&tasks)?;
        Ok(tasks)
    }
}

/// Runs a command that writes no file on one input, or on several and on the files of folders.
pub(crate) fn run_on(
    inputs: &[PathBuf],
    session: &Session,
    work: &Work<'_>,
) -> Result<Outcome, Failure> {
    if let [input] = inputs
        && !input.is_dir()
    {
        session.on_one_thing()?;
        work(&without_output(input.clone()), &session.console)?.print(&session.console)?;
        return Ok(Outcome::of_run());
    }
    refuse_standard(inputs)?;
    let tasks: Vec<Task> =
        files(inputs, None)?.into_iter().map(|(input, _)| without_output(input)).collect();
    all(&tasks, false, session.on_many_files()?, work)
}

fn without_output(input: PathBuf) -> Task {
    Task { input, output: None, makes_folder: false }
}

/// Refuses the standard input among several inputs.
fn refuse_standard(inputs: &[PathBuf]) -> Result<(), Failure> {
    if inputs.iter().any(|input| is_standard(input)) {
        return Err(Failure::usage("the standard input `-` stands alone, without files"));
    }
    Ok(())
}

/// The files among the inputs, and the mesh files in the folders among them. Each file has a name for the folder of
/// results. Files in the folder of results are no inputs.
fn files(inputs: &[PathBuf], output: Option<&Path>) -> Result<Vec<(PathBuf, PathBuf)>, Failure> {
    let mut found = Vec::new();
    for input in inputs {
        if !input.is_dir() {
            // A name without a file is a failure of this file alone.
            let name = input.file_name().map_or_else(|| input.clone(), PathBuf::from);
            found.push((input.clone(), name));
            continue;
        }
        let before = found.len();
        walk(input, Path::new(""), output, &mut found)?;
        if found.len() == before {
            return Err(Failure::NoFiles(input.clone()));
        }
    }
    Ok(found)
}

/// Adds the mesh files of a folder and of the folders below, by name, except those in the folder of results.
fn walk(
    root: &Path,
    below: &Path,
    output: Option<&Path>,
    found: &mut Vec<(PathBuf, PathBuf)>,
) -> Result<(), Failure> {
    let folder = root.join(below);
    let failed = |source| Failure::Folder { path: folder.clone(), source };
    let mut names = std::fs::read_dir(&folder)
        .map_err(failed)?
        .map(|entry| entry.and_then(|e| Ok((e.file_name(), e.file_type()?.is_dir()))))
        .collect::<Result<Vec<_>, _>>()
        .map_err(failed)?;
    names.sort();
    for (name, is_folder) in names {
        if name.to_string_lossy().starts_with('.') {
            continue;
        }
        let (path, name) = (folder.join(&name), below.join(&name));
        if is_folder {
            if !output.is_some_and(|output| is_same_file(output, &path)) {
                walk(root, &name, output, found)?;
            }
        } else if Format::from_extension(&path).is_some() && path.is_file() {
            found.push((path, name));
        }
    }
    Ok(())
}

/// Whether a path means a folder: it is one, or ends like one.
fn is_folder(path: &Path) -> bool {
    let text = path.as_os_str().to_string_lossy();
    path.is_dir() || text.ends_with('/') || text.ends_with(std::path::MAIN_SEPARATOR)
}

/// Whether this is the name of a mesh or a record, not of a folder to be made.
fn is_file_name(path: &Path) -> bool {
    let is_record =
        path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    is_record || Format::from_extension(path).is_some()
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Refuses results that would overwrite each other, or an input that is still to be read.
fn check_outputs(tasks: &[Task]) -> Result<(), Failure> {
    let mut of_output = HashMap::new();
    for task in tasks {
        if let Some(other) = of_output.insert(&task.output, &task.input) {
            return Err(Failure::usage(format!(
                "the results of {} and {} would have the same name; give them by the folder that \
                 they are in, or one at a time",
                other.display(),
                task.input.display()
            )));
        }
    }
    let inputs: HashMap<PathBuf, usize> = tasks
        .iter()
        .enumerate()
        .filter_map(|(i, task)| Some((task.input.canonicalize().ok()?, i)))
        .collect();
    for (i, task) in tasks.iter().enumerate() {
        let output = task.output.as_deref().and_then(|output| output.canonicalize().ok());
        let read_by = output.and_then(|output| inputs.get(&output));
        if let Some(&other) = read_by.filter(|&&other| other != i) {
            return Err(Failure::usage(format!(
                "the result of {} would overwrite {}, which is to be read too",
                task.input.display(),
                tasks[other].input.display()
            )));
        }
    }
    Ok(())
}

/// The outcome of a file.
enum State {
    Done(Done),
    PassedOver,
    Failed(Failure),
    /// The run was interrupted before this file.
    Left,
}

/// The outcomes of all files.
#[derive(Default, Serialize)]
struct Summary {
    command: String,
    files: usize,
    done: usize,
    passed_over: usize,
    failed: usize,
    /// Number of files left by an interruption.
    #[serde(skip_serializing_if = "is_zero")]
    left: usize,
    /// Wall-clock time of the whole run.
    seconds: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// A skipped file.
#[derive(Serialize)]
struct PassedOver<'a> {
    command: &'a str,
    input: String,
    output: Option<String>,
    passed_over: &'static str,
}

/// Processes all files, in parallel.
fn all(
    tasks: &[Task],
    resume: bool,
    session: &Session,
    work: &Work<'_>,
) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let console = &session.console;
    let bar = console.progress_of_files(tasks.len() as u64);
    let inner = console.below(&bar);
    let (next, (send, receive)) = (AtomicUsize::new(0), mpsc::channel());
    let mut table = Table::default();
    let workers = session.files_at_a_time().min(tasks.len());
    // Separate threads instead of tasks in the pool of the libraries: a pool thread that waits for a part of one file
    // would start on another file in the meantime.
    std::thread::scope(|scope| {
        for _ in 0..workers {
            let send = send.clone();
            let worker = || {
                let send = send;
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(task) = tasks.get(i) else { break };
                    if send.send((i, one(task, resume, &inner, work))).is_err() {
                        break;
                    }
                }
            };
            std::thread::Builder::new()
                .stack_size(STACK)
                .spawn_scoped(scope, worker)
                .map_err(Failure::Threads)?;
        }
        drop(send);
        // Reports come in the order of the files.
        let mut waiting = BTreeMap::new();
        let mut reported = 0;
        for (i, state) in receive {
            bar.inc(1);
            waiting.insert(i, state);
            while let Some(state) = waiting.remove(&reported) {
                bar.suspend(|| table.add(&tasks[reported], state, console))?;
                reported += 1;
            }
        }
        Ok(())
    })?;
    bar.finish_and_clear();
    let command = console.command().to_owned();
    let seconds = start.elapsed().as_secs_f64();
    let summary = Summary { command, files: tasks.len(), seconds, ..table.counts };
    if console.is_json() {
        console.print(console.signed(&summary)?)?;
    } else {
        console.print(table_text(&table.rows, &summary))?;
    }
    Ok(match Outcome::of_run() {
        Outcome::Done if summary.failed > 0 => Outcome::SomeFailed,
        outcome => outcome,
    })
}

/// The usual stack size of the main thread.
const STACK: usize = 8 << 20;

/// Processes one of many files.
fn one(task: &Task, resume: bool, console: &Console, work: &Work<'_>) -> State {
    if is_asked_to_end() {
        return State::Left;
    }
    if resume && is_done(task) {
        return State::PassedOver;
    }
    match catch_unwind(AssertUnwindSafe(|| work(task, console))) {
        Ok(Ok(done)) => State::Done(done),
        Ok(Err(failure)) => State::Failed(failure),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            State::Failed(Failure::Panic(text.unwrap_or("it panicked").to_owned()))
        }
    }
}

/// Whether the result exists and is not older than the input. Files appear whole or not at all.
fn is_done(task: &Task) -> bool {
    let changed = |path: &Path| std::fs::metadata(path).and_then(|m| m.modified()).ok();
    let Some(output) = &task.output else { return false };
    if is_same_file(output, &task.input) {
        return false;
    }
    matches!((changed(&task.input), changed(output)), (Some(i), Some(o)) if i <= o)
}

/// The summary as text.
#[derive(Default)]
struct Table {
    rows: Vec<[String; 4]>,
    counts: Summary,
}

impl Table {
    /// Records the outcome of a file, and prints it at once in JSON mode.
    fn add(&mut self, task: &Task, state: State, console: &Console) -> Result<(), Failure> {
        let input = task.input.display().to_string();
        let line = match &state {
            _ if !console.is_json() => None,
            State::Done(done) => Some(done.json.clone()),
            State::Failed(failure) => Some(console.failed(Some(&input), failure)?),
            State::PassedOver => Some(console.signed(PassedOver {
                command: console.command(),
                input: input.clone(),
                output: task.output.as_ref().map(|output| output.display().to_string()),
                passed_over: "the output is there and not older than the input",
            })?),
            State::Left => None,
        };
        if let Some(line) = line {
            console.print(line)?;
        }
        let file = printable(&input);
        let row = match state {
            State::Done(done) => {
                self.counts.done += 1;
                [file, "done".into(), format!("{:.2} s", done.seconds), done.brief]
            }
            State::PassedOver => {
                self.counts.passed_over += 1;
                [file, "passed over".into(), String::new(), String::new()]
            }
            State::Failed(failure) => {
                self.counts.failed += 1;
                let message = failure.message();
                console.error(format_args!("error: {message}"));
                [file, "failed".into(), String::new(), message]
            }
            State::Left => {
                self.counts.left += 1;
                [file, "left".into(), String::new(), String::new()]
            }
        };
        self.rows.push(row);
        Ok(())
    }
}

fn table_text(rows: &[[String; 4]], summary: &Summary) -> String {
    let width =
        |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let [first, second, third] = [0, 1, 2].map(width);
    let mut text = String::new();
    for [file, state, seconds, brief] in rows {
        let row = format!("{file:first$}  {state:second$}  {seconds:>third$}  {brief}");
        text += row.trim_end();
        text.push('\n');
    }
    let Summary { files, done, passed_over, failed, left, seconds, .. } = summary;
    text += &format!("{} in {seconds:.2} s: {done} done", counted(*files, "files"));
    for (count, what) in [(passed_over, "passed over"), (failed, "failed"), (left, "left")] {
        if *count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    text
}

/// Refuses an output that cannot be written as asked, for a command whose output is a mesh.
pub(crate) fn check_output(job: &Job, given: &Given) -> Result<(), Failure> {
    match &job.output {
        Some(output) if !is_folder(output) && job.inputs.len() == 1 && !job.inputs[0].is_dir() => {
            check_target(output, &job.save, given)
        }
        // With many files, each has the format of its input, or all have the given format.
        Some(output) if job.save.to.is_some() => check_target(output, &job.save, given),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_counted_from_one() {
        assert_eq!(parse_shard("2/16"), Ok(Shard { number: 2, of: 16 }));
        for bad in ["0/4", "5/4", "1", "a/b", "1/0", "-1/2", "1/2/3"] {
            assert!(parse_shard(bad).is_err(), "{bad}");
        }
    }
}
