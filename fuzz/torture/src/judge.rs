//! Runs a job and checks its results.

use std::path::{Path, PathBuf};

use postconditions::{Promise, violations};
use serde_json::Value;

use super::child::{self, End, Ended, Limits};
use super::content::Content;
use super::jobs::{self, Faces, Job, Output};
use super::manifold::Counts;
use super::readers;
use super::record::Record;

/// A file and its report by `info`.
pub(super) struct Subject {
    pub(super) name: String,
    path: PathBuf,
    bytes: u64,
    /// The report of `info`, if the file could be read.
    info: Option<Value>,
    /// The diagonal of the bounding box, or 1 when there is none.
    diagonal: f64,
}

impl Subject {
    fn count(&self, what: &str) -> u64 {
        self.info.as_ref().and_then(|info| info.get(what)).and_then(Value::as_u64).unwrap_or(0)
    }

    fn stem(&self) -> String {
        self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// The program, its work folder and its limits.
pub(super) struct Trial<'a> {
    pub(super) program: &'a Path,
    pub(super) work: &'a Path,
    pub(super) limits: Limits,
}

/// Factor on the processor time of inherently slow jobs.
const LONG: u32 = 10;

/// The results of a job so far.
#[derive(Default)]
struct Course {
    exit: Option<i32>,
    seconds: f64,
    peak: u64,
    message: String,
    faces: Option<usize>,
    report: Option<Value>,
}

impl Trial<'_> {
    /// Runs `info` on a file, and compares its counts with the counts of another reader.
    pub(super) fn subject(&self, name: &str, path: &Path, bytes: u64) -> (Subject, Record) {
        let mut subject = Subject {
            name: name.to_owned(),
            path: path.to_owned(),
            bytes,
            info: None,
            diagonal: 1.0,
        };
        let (job, folder) = (jobs::info(), self.work.join(format!("info {name}")));
        let mut course = Course::default();
        let mut judged = self.steps(&subject, &job, &folder, 1, &mut course);
        subject.info = course.report.take();
        if let Some(info) = &subject.info {
            subject.diagonal = diagonal(info).unwrap_or(1.0);
            judged = judged.and_then(|()| agrees(info, path));
        }
        let record = record(&subject, &job, &folder, course, judged);
        (subject, record)
    }

    /// Runs a job on a file.
    pub(super) fn run(&self, subject: &Subject, job: &Job, number: usize) -> Record {
        let folder = self.work.join(format!("{number} {} {}", job.name, subject.name));
        let mut course = Course::default();
        let judged = self.judge(subject, job, &folder, &mut course);
        record(subject, job, &folder, course, judged)
    }

    fn judge(
        &self,
        subject: &Subject,
        job: &Job,
        folder: &Path,
        course: &mut Course,
    ) -> Result<(), String> {
        self.steps(subject, job, folder, 1, course)?;
        let out = folder.join("out");
        let Some(report) = course.report.take() else {
            return nothing_is_left(&out, job);
        };
        for output in &job.outputs {
            let path = out.join(output.file.replace("{stem}", &subject.stem()));
            let faces = check_output(&path, output, &report, subject)
                .map_err(|fault| format!("output {}: {fault}", output.file))?;
            course.faces = faces.or(course.faces);
            if let Some(promise) = &job.promise {
                keeps(promise, &subject.path, &path, &report)
                    .map_err(|fault| format!("output {}: {fault}", output.file))?;
            }
        }
        hidden_files(&out)?;
        if let Some(claim) = job.claim {
            claim(&report, subject.diagonal)?;
        }
        if job.is_repeated { self.repeat(subject, job, folder) } else { Ok(()) }
    }

    /// Runs the steps of a job until one does not end with exit 0. Returns a report if all did.
    fn steps(
        &self,
        subject: &Subject,
        job: &Job,
        folder: &Path,
        threads: usize,
        course: &mut Course,
    ) -> Result<(), String> {
        let failed = |error: std::io::Error| format!("cannot run it: {error}");
        let out = folder.join("out");
        std::fs::create_dir_all(&out).map_err(failed)?;
        let mut limits = self.limits;
        if job.takes_long {
            limits.processor *= LONG;
        }
        for step in &job.steps {
            let arguments = arguments(step, subject, &out, threads);
            let ended = child::run(self.program, &arguments, folder, limits).map_err(failed)?;
            course.seconds += ended.processor.as_secs_f64();
            course.peak = course.peak.max(ended.peak);
            course.report = None;
            course.exit = None;
            match ended.end {
                End::Exit(0) => {
                    course.exit = Some(0);
                    course.report = Some(parse(&ended.stdout)?);
                }
                End::Exit(code) if matches!(code, 3 | 4) || code == 2 && job.is_misuse => {
                    course.exit = Some(code);
                    return explains(&ended, code).map(|message| course.message = message);
                }
                End::Exit(code) => {
                    course.exit = Some(code);
                    return Err(format!("exit {code}: {}", last_words(&ended.stderr)));
                }
                End::Signal(signal) => {
                    return Err(format!("signal {signal}: {}", last_words(&ended.stderr)));
                }
                End::OutOfTime => {
                    let seconds = limits.processor.as_secs();
                    return Err(format!("not done after {seconds} s of processor time"));
                }
            }
        }
        Ok(())
    }

    /// Runs the job again with two threads and compares the outputs.
    fn repeat(&self, subject: &Subject, job: &Job, folder: &Path) -> Result<(), String> {
        let again = folder.join("again");
        self.steps(subject, job, &again, 2, &mut Course::default())?;
        for output in &job.outputs {
            let file = output.file.replace("{stem}", &subject.stem());
            let [first, second] = [folder, again.as_path()]
                .map(|folder| std::fs::read(folder.join("out").join(&file)).ok());
            if first != second {
                return Err(format!("output {file} differs with two threads"));
            }
        }
        Ok(())
    }
}

/// The command line of a step.
fn arguments(step: &str, subject: &Subject, out: &Path, threads: usize) -> Vec<String> {
    let fill = |word: &str| {
        let mut word = word
            .replace("{in}", &subject.path.to_string_lossy())
            .replace("{out}", &out.to_string_lossy());
        while let Some((before, factor, after)) = length(&word) {
            word = format!("{before}{:e}{after}", factor * subject.diagonal);
        }
        word
    };
    let common = ["--json".to_owned(), "--threads".to_owned(), threads.to_string()];
    step.split(' ').filter(|word| !word.is_empty()).map(fill).chain(common).collect()
}

/// The factor of the first `{len:FACTOR}`, and the text before and after it.
fn length(word: &str) -> Option<(String, f64, String)> {
    let (before, rest) = word.split_once("{len:")?;
    let (factor, after) = rest.split_once('}')?;
    Some((before.to_owned(), factor.parse().ok()?, after.to_owned()))
}

fn diagonal(info: &Value) -> Option<f64> {
    let corner = |key: &str| -> Option<Vec<f64>> {
        info.get(key)?.as_array()?.iter().map(Value::as_f64).collect()
    };
    let (min, max) = (corner("bbox_min")?, corner("bbox_max")?);
    let squares = min.iter().zip(&max).map(|(a, b)| (b - a) * (b - a));
    Some(squares.sum::<f64>().sqrt()).filter(|length| *length > 0.0 && length.is_finite())
}

/// The one JSON object on stdout.
fn parse(stdout: &str) -> Result<Value, String> {
    match serde_json::from_str(stdout) {
        Ok(value @ Value::Object(_)) => Ok(value),
        Ok(_) => Err("stdout is JSON, but no object".into()),
        Err(error) => Err(format!("stdout is not one JSON object: {error}")),
    }
}

/// A refusal must have a reason: on stderr as text, and on stdout as JSON.
fn explains(ended: &Ended, code: i32) -> Result<String, String> {
    let message = ended.stderr.lines().find_map(|line| line.strip_prefix("error: "));
    let message = message.ok_or("refused without a word")?;
    let is_printable = |c: char| !c.is_control() || c == '\n';
    if let Some(control) = ended.stderr.chars().find(|&c| !is_printable(c)) {
        return Err(format!("there is a control character on stderr: {control:?}"));
    }
    let report = parse(&ended.stdout)?;
    let reported = report.pointer("/error/exit_code").and_then(Value::as_i64);
    if reported != Some(i64::from(code)) {
        return Err(format!("exit {code}, but the report says {reported:?}"));
    }
    match report.pointer("/error/message").and_then(Value::as_str) {
        Some(reported) if reported.starts_with(message) => Ok(message.to_owned()),
        _ => Err("the report has another message than stderr".into()),
    }
}

fn last_words(stderr: &str) -> String {
    let panicked = stderr.lines().skip_while(|line| !line.contains("panicked at"));
    let panicked: Vec<&str> = panicked.take(2).collect();
    if panicked.is_empty() {
        stderr.lines().next_back().unwrap_or("no message").to_owned()
    } else {
        panicked.join(" ")
    }
}

/// After a refusal, no output of the last step may exist.
fn nothing_is_left(out: &Path, job: &Job) -> Result<(), String> {
    hidden_files(out)?;
    let is_early = |name: &str| {
        let of_earlier = job.outputs.iter().filter(|output| matches!(output.faces, Faces::Opaque));
        of_earlier.into_iter().any(|output| output.file == name)
    };
    match names(out)?.into_iter().find(|name| !is_early(name)) {
        Some(name) => Err(format!("refused, but left {name} behind")),
        None => Ok(()),
    }
}

/// Checks the promise of a command.
fn keeps(promise: &Promise, input: &Path, output: &Path, report: &Value) -> Result<(), String> {
    let read = |path: &Path| mesh_io::read(path).map_err(|error| error.to_string());
    let (before, after) = (read(input)?, read(output)?);
    let format = |path: &Path| mesh_io::Format::from_extension(path);
    let found = violations((&before, format(input)), (&after, format(output)), report, promise);
    if found.is_empty() { Ok(()) } else { Err(found.join("; ")) }
}

/// Files being written are hidden, and must not exist afterwards.
fn hidden_files(out: &Path) -> Result<(), String> {
    match names(out)?.into_iter().find(|name| name.starts_with('.') || name.contains(".tmp")) {
        Some(name) => Err(format!("left {name} behind")),
        None => Ok(()),
    }
}

fn names(folder: &Path) -> Result<Vec<String>, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| error.to_string())?;
    let name = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.map(|entry| entry.file_name().to_string_lossy().into_owned())
    };
    entries.map(name).collect::<Result<_, _>>().map_err(|error| error.to_string())
}

/// Checks that a file agrees with the report; returns its number of faces.
fn check_output(
    path: &Path,
    output: &Output,
    report: &Value,
    subject: &Subject,
) -> Result<Option<usize>, String> {
    match output.faces {
        Faces::Opaque => return Ok(None),
        Faces::Json => {
            let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
            return parse(&text).map(|_| None);
        }
        _ => {}
    }
    let content = readers::read(path).map_err(|error| error.to_string())?;
    if let Some((face, vertex)) = content.out_of_range() {
        return Err(format!("face {face} has vertex {vertex} of {}", content.positions.len()));
    }
    // An output that was not built may have the defects of the input.
    if output.is_built || subject.count("non_finite_vertices") == 0 {
        if let Some(vertex) = content.not_finite_vertex() {
            return Err(format!("vertex {vertex} is at {:?}", content.positions[vertex]));
        }
        if let Some(number) = &content.not_finite {
            return Err(format!("it has a {number}"));
        }
    }
    check_count(&content, output, report, subject)?;
    if output.is_built {
        let triangles = content.triangles().ok_or("not all faces are triangles")?;
        if content.is_indexed
            && let Some(defect) = Counts::of(&triangles, content.positions.len()).defect()
        {
            return Err(defect);
        }
    }
    Ok(Some(content.face_count()))
}

fn check_count(
    content: &Content,
    output: &Output,
    report: &Value,
    subject: &Subject,
) -> Result<(), String> {
    let at = |place: &str| {
        let found = report.pointer(place).and_then(Value::as_u64);
        found.ok_or_else(|| format!("the report has no count {place}"))
    };
    let reported = match output.faces {
        Faces::Reported(place) => at(place)?,
        Faces::AllLevels => {
            let levels = report.get("levels").and_then(Value::as_array).ok_or("no levels")?;
            let faces =
                levels.iter().filter_map(|level| level.get("faces").and_then(Value::as_u64));
            at("/faces")? + faces.sum::<u64>()
        }
        Faces::Any | Faces::Json | Faces::Opaque => return Ok(()),
    };
    let found = content.face_count() as u64;
    // Triangle formats cut larger faces, and omit smaller ones.
    let are_cut = !content.is_indexed
        && !output.is_built
        && subject.count("quadrilaterals") + subject.count("larger_polygons") > 0;
    if found == reported || are_cut {
        return Ok(());
    }
    Err(format!("{found} faces, but {reported} are reported"))
}

/// Checks that `info` counts the same as another reader, if that can read the file.
fn agrees(info: &Value, path: &Path) -> Result<(), String> {
    let Ok(content) = readers::read(path) else {
        return Ok(());
    };
    let check = |key: &str, found: usize| {
        let reported = info.get(key).and_then(Value::as_u64);
        if reported == Some(found as u64) {
            return Ok(());
        }
        Err(format!("info says {key} {reported:?}, but another reader finds {found}"))
    };
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if extension == "glb" || extension == "gltf" {
        // Nodes may show a mesh several times, or not at all.
        return Ok(());
    }
    // Counts are of triangles, except the counts of polygons by corners.
    let corners =
        |wanted: fn(usize) -> bool| content.faces().filter(|face| wanted(face.len())).count();
    check("triangles", corners(|count| count == 3))?;
    check("quadrilaterals", corners(|count| count == 4))?;
    check("larger_polygons", corners(|count| count > 4))?;
    if !content.is_indexed {
        return Ok(());
    }
    check("vertices", content.positions.len())?;
    let Some(triangles) = content.triangles().filter(|_| content.out_of_range().is_none()) else {
        return Ok(());
    };
    let counts = Counts::of(&triangles, content.positions.len());
    check("edges", counts.edges)?;
    check("boundary_edges", counts.boundary)?;
    check("non_manifold_edges", counts.non_manifold)?;
    check("inconsistent_edges", counts.inconsistent)?;
    check("repeated_vertex_faces", counts.degenerate)?;
    check("non_manifold_vertices", counts.pinched)
}

/// The record of a job. The outputs of a faulty job are kept for inspection.
fn record(
    subject: &Subject,
    job: &Job,
    folder: &Path,
    course: Course,
    judged: Result<(), String>,
) -> Record {
    if judged.is_ok() {
        // The folder is no longer needed; errors of removing it are ignored.
        let _ = std::fs::remove_dir_all(folder);
    }
    Record {
        file: subject.name.clone(),
        bytes: subject.bytes,
        command: job.command().to_owned(),
        job: job.name.clone(),
        exit: course.exit,
        fault: judged.err(),
        seconds: course.seconds,
        peak_mib: course.peak as f64 / f64::from(1 << 20),
        faces: course.faces,
        message: course.message,
    }
}
