//! `cargo run --release -p benches -- flips`: our edge flips beside those of other programs.

use std::fmt;
use std::path::Path;

use dcurv::VertexArea;
use dtri_flip::CostName;
use glam::DVec3;
use mesh_metric::Surface;
use serde::{Deserialize, Serialize};
use xtask_common::{Failure, progress_bar};

use super::Common;
use super::environment::Environment;
use super::record::Record;
use super::sets::{FlipSet, Sets, of_name};
use super::source::Source;
use super::tool::{Kind, Tool};
use crate::figures::{distinct, geometric_mean, told};
use crate::json_lines;
use crate::peers::{Judge, Validity};
use crate::process::Process;
use crate::raw_mesh::RawMesh;

/// Which meshes are flipped, by which tools.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Flips {
    #[command(flatten)]
    common: Common,
    /// Sets of benches/rivals.toml: tiny, full, growth
    #[arg(long, value_name = "SET", value_delimiter = ',', default_value = "full")]
    jobs: Vec<String>,
    /// Instead of the meshes of the set, these: files, or torus-N and noisy-N with about N faces
    #[arg(long, value_name = "MESH", value_delimiter = ',')]
    meshes: Vec<String>,
}

/// The input of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Job {
    mesh: String,
    /// Of the file, in hexadecimal digits; none if the mesh is generated.
    sha256: Option<String>,
    faces: usize,
}

/// The triangulations before and after.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Values {
    before: Quality,
    after: Quality,
    /// The same of the result, computed by numpy.
    foreign: Option<Quality>,
    validity: Validity,
}

/// How good a triangulation is. The mesh has a diagonal of one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Quality {
    f1: f64,
    f2: f64,
    f3: f64,
    /// The smallest angle of all faces, and the mean over the faces of their smallest angle, in degrees.
    smallest_angle: f64,
    mean_smallest_angle: f64,
}

type Row = Record<Job, Values>;

impl Quality {
    fn of(raw: &RawMesh) -> Result<Self, Failure> {
        let mesh = raw.to_mesh()?;
        let total = |cost: CostName| cost.total(&mesh, VertexArea::default());
        let smallest: Vec<f64> =
            raw.triangles.iter().filter_map(|&t| smallest_angle(raw, t)).collect();
        Ok(Self {
            f1: total(CostName::F1),
            f2: total(CostName::F2),
            f3: total(CostName::F3),
            smallest_angle: smallest.iter().copied().fold(f64::INFINITY, f64::min),
            mean_smallest_angle: smallest.iter().sum::<f64>() / smallest.len() as f64,
        })
    }
}

/// The smallest angle of a triangle in degrees.
fn smallest_angle(raw: &RawMesh, triangle: [u32; 3]) -> Option<f64> {
    let corner = |v: u32| raw.vertices.get(v as usize).copied();
    let [a, b, c] = triangle.map(corner);
    let angle = |a: DVec3, b: DVec3, c: DVec3| {
        let (x, y) = (b - a, c - a);
        x.cross(y).length().atan2(x.dot(y)).to_degrees()
    };
    let (a, b, c) = (a?, b?, c?);
    Some(angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b)))
}

/// Runs every tool on every mesh, and prints the tables; or makes them from a record.
pub(crate) fn run(options: &Flips) -> Result<(), Failure> {
    if let Some(path) = &options.common.from {
        let rows: Vec<Row> = json_lines::read(path)?;
        return options.common.write_pages("flips", |table| block(table, &rows));
    }
    let mut rows = Vec::new();
    for name in &options.jobs {
        let mut set = of_name(Sets::read()?.flips, name)?;
        if !options.meshes.is_empty() {
            set.meshes.clone_from(&options.meshes);
        }
        run_set(options, &set, &mut rows)?;
    }
    let text = format!("{}\n{}\n{}", quality(&rows), growth(&rows), agreement(&rows));
    options.common.write_tables("flips", &text)
}

fn run_set(options: &Flips, set: &FlipSet, rows: &mut Vec<Row>) -> Result<(), Failure> {
    let Common { models, out, .. } = &options.common;
    let mut tools = options.common.tools(Kind::Flips, &set.tools)?;
    let [repeats, limit] = options.common.repeats_and_limit(set.repeats as u64, set.limit_seconds);
    let environment = Environment::prepare(out, &mut tools, repeats as usize, limit)?;
    let bar = progress_bar(set.meshes.len() * tools.len());
    for name in &set.meshes {
        let source = Source::of_name(name).mesh(models)?;
        let [input, output] = ["input.raw", "output.raw"].map(|file| environment.folder.join(file));
        source.raw.write(&input)?;
        let mesh = source.raw.to_mesh()?;
        let surface = Surface::new(&mesh).map_err(Failure::mesh)?;
        let judge = Judge::new(&source.raw, &mesh, &surface)?;
        let before = Quality::of(&source.raw)?;
        let mut meter = Meter::new(&environment, &input);
        for tool in &tools {
            bar.set_message(format!("{name} {}", tool.name));
            let job = Job {
                mesh: name.clone(),
                sha256: source.sha256.clone(),
                faces: source.raw.triangles.len(),
            };
            let files = [input.as_path(), output.as_path()];
            let row = environment.record(tool, job, None, files, |_| {
                let result = RawMesh::read(&output).map_err(|e| e.to_string())?;
                let after = Quality::of(&result).map_err(|e| e.to_string())?;
                let validity = judge.judge(&result).map_err(|e| e.to_string())?;
                Ok(Values { before, after, foreign: meter.measure(&output), validity })
            });
            bar.suspend(|| println!("{row}"));
            rows.push(row);
            bar.inc(1);
        }
        // A run takes long: intermediate results are saved in case it is aborted.
        json_lines::write(rows, &environment.folder.join("flips.jsonl"))?;
    }
    bar.finish_and_clear();
    Ok(())
}

/// Measures results with numpy, if it is there.
struct Meter {
    process: Option<Process>,
}

impl Meter {
    fn new(environment: &Environment, input: &Path) -> Self {
        let mut command = environment.python.python();
        command.arg(environment.folder.join("flips.py")).arg(input);
        let mut process = Process::start(&mut command).ok();
        // The first answer is about the input.
        if process.as_mut().and_then(Process::answer).is_none() {
            process = None;
        }
        Self { process }
    }

    fn measure(&mut self, result: &Path) -> Option<Quality> {
        let answer = self.process.as_mut()?.ask(result.to_str()?)?;
        let numbers: Vec<f64> = answer.split_whitespace().filter_map(|w| w.parse().ok()).collect();
        let [f1, f2, f3, smallest_angle, mean_smallest_angle] = numbers[..] else { return None };
        Some(Quality { f1, f2, f3, smallest_angle, mean_smallest_angle })
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:24} {:20} ", self.job.mesh, self.tool)?;
        let (Some(outcome), Some(time)) = (&self.outcome, self.time()) else {
            return f.write_str(self.failure.as_deref().unwrap_or("it failed"));
        };
        let Values { before, after, .. } = outcome.values;
        write!(
            f,
            "{time:9.4} s  f1 {:.4} f2 {:.4} f3 {:.4}  angle {:.2}° to {:.2}°",
            after.f1 / before.f1,
            after.f2 / before.f2,
            after.f3 / before.f3,
            before.mean_smallest_angle,
            after.mean_smallest_angle,
        )
    }
}

/// What each tool reaches on files, and how long it takes.
fn quality(rows: &[Row]) -> String {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.job.sha256.is_some()).collect();
    let mut text = String::from(
        "| | done | time | F1 | F2 | F3 | mean smallest angle | new defects | version |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    let base = |mesh: &str| {
        let mut own = rows.iter().filter(|row| row.job.mesh == mesh && row.tool == BASE);
        own.find_map(|row| row.time())
    };
    for tool in Tool::all(Kind::Flips) {
        let own: Vec<&Row> = rows.iter().filter(|row| row.tool == tool.name).copied().collect();
        if own.is_empty() {
            continue;
        }
        let times = own.iter().filter_map(|row| Some(row.time()? / base(&row.job.mesh)?));
        let done: Vec<&Values> =
            own.iter().filter_map(|row| row.outcome.as_ref()).map(|o| &o.values).collect();
        let ratio = |of: fn(&Quality) -> f64| {
            told(geometric_mean(done.iter().map(|v| of(&v.after) / of(&v.before))), 3)
        };
        let angle = |of: fn(&Values) -> Quality| {
            done.iter().map(|v| of(v).mean_smallest_angle).sum::<f64>() / done.len() as f64
        };
        let defects: usize =
            done.iter().flat_map(|v| v.validity.new_defects()).map(|(_, n)| n).sum();
        text += &format!(
            "| {} | {} of {} | {} | {} | {} | {} | {} → {} | {defects} | {} |\n",
            tool.label,
            done.len(),
            own.len(),
            told(geometric_mean(times), 2),
            ratio(|q| q.f1),
            ratio(|q| q.f2),
            ratio(|q| q.f3),
            told(angle(|v| v.before), 1) + "°",
            told(angle(|v| v.after), 1) + "°",
            own.iter().find_map(|row| row.version.as_deref()).unwrap_or("–"),
        );
    }
    text
}

/// The tool whose time is one.
const BASE: &str = "f2";

/// How the time grows: generated meshes of one kind and several sizes.
fn growth(rows: &[Row]) -> String {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.job.sha256.is_none()).collect();
    let kind = |row: &&Row| row.job.mesh.split('-').next().unwrap_or_default().to_owned();
    let mut text = String::from(
        "| | mesh | faces | time | times the faces | times the time |\n|---|---|---|---|---|---|\n",
    );
    for tool in Tool::all(Kind::Flips) {
        for kind_of_mesh in distinct(&rows, kind) {
            let own = rows.iter().filter(|row| row.tool == tool.name && kind(row) == kind_of_mesh);
            let own: Vec<&&Row> = own.collect();
            let Some(first) = own.first() else { continue };
            for row in &own {
                let ratio = |a: f64, b: f64| told(a / b, 1);
                let (time, least) =
                    (row.time().unwrap_or(f64::NAN), first.time().unwrap_or(f64::NAN));
                text += &format!(
                    "| {} | {kind_of_mesh} | {} | {} s | {} | {} |\n",
                    tool.label,
                    row.job.faces,
                    told(time, 2),
                    ratio(row.job.faces as f64, first.job.faces as f64),
                    ratio(time, least),
                );
            }
        }
    }
    text
}

/// How closely the foreign numbers agree with ours, on results without a boundary and without defects.
fn agreement(rows: &[Row]) -> String {
    let values = rows.iter().filter_map(|row| Some(&row.outcome.as_ref()?.values));
    let sound = values.filter(|v| v.validity.output.is_closed_and_sound());
    let mut worst = 0.0_f64;
    let mut count = 0;
    for (after, foreign) in sound.filter_map(|v| Some((v.after, v.foreign?))) {
        count += 1;
        for (a, b) in [(after.f1, foreign.f1), (after.f2, foreign.f2), (after.f3, foreign.f3)] {
            worst = worst.max((a / b - 1.0).abs());
        }
    }
    format!(
        "F1, F2 and F3 of {count} closed results, computed again by numpy, agree within {worst:.0e} of their value.\n"
    )
}

fn block(table: &str, rows: &[Row]) -> Result<String, Failure> {
    match table {
        "quality" => Ok(quality(rows)),
        "growth" => Ok(growth(rows)),
        "agreement" => Ok(agreement(rows)),
        _ => Err(Failure::Usage(format!(
            "there is no table `{table}` of flips; there are quality, growth and agreement"
        ))),
    }
}
