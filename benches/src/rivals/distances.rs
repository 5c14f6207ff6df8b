//! `cargo run --release -p benches -- distances`: our Hausdorff distances beside those of other programs.

use std::fmt;

use serde::{Deserialize, Serialize};
use simplify::{Options, Preset, simplify};
use xtask_common::{Failure, progress_bar};

use super::Common;
use super::environment::{Answer, Environment};
use super::record::Record;
use super::sets::{DistanceSet, Sets, of_name};
use super::source::{Mesh, Source};
use super::tool::{Kind, Tool, Value};
use crate::figures::{distinct, geometric_mean, told};
use crate::json_lines;
use crate::raw_mesh::RawMesh;

/// Between which meshes distances are computed, by which tools.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Distances {
    #[command(flatten)]
    common: Common,
    /// A set of benches/rivals.toml: tiny, full
    #[arg(long, value_name = "SET", default_value = "full")]
    jobs: String,
}

/// Two meshes, and how closely the distance is computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Job {
    meshes: [String; 2],
    /// Of the files, in hexadecimal digits; none if a mesh is generated.
    sha256: [Option<String>; 2],
    /// If the second mesh is a simplified version of the first, the share of the faces.
    ratio: Option<f64>,
    faces: [usize; 2],
    /// The largest difference between the bounds. The diagonal of the meshes is one.
    tolerance: Option<f64>,
    /// Points in each direction.
    samples: Option<u32>,
}

/// The distance; the diagonal of the meshes is one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Values {
    lower: f64,
    /// None if nothing is proved.
    upper: Option<f64>,
}

type Row = Record<Job, Values>;

/// Runs every tool on every pair, and prints the tables; or makes them from a record.
pub(crate) fn run(options: &Distances) -> Result<(), Failure> {
    if let Some(path) = &options.common.from {
        let rows: Vec<Row> = json_lines::read(path)?;
        return options.common.write_pages("distances", |table| block(table, &rows));
    }
    let set = of_name(Sets::read()?.distances, &options.jobs)?;
    let rows = run_set(&options.common, &set)?;
    let text = format!("{}\n{}\n{}", proved(&rows), sampled(&rows), closest(&rows));
    options.common.write_tables("distances", &text)
}

/// Two meshes that are compared.
struct Pair {
    names: [String; 2],
    ratio: Option<f64>,
}

fn run_set(common: &Common, set: &DistanceSet) -> Result<Vec<Row>, Failure> {
    let mut tools = common.tools(Kind::Distances, &set.tools)?;
    let [repeats, limit] = common.repeats_and_limit(set.repeats as u64, set.limit_seconds);
    let environment = Environment::prepare(&common.out, &mut tools, repeats as usize, limit)?;
    let files = ["first.raw", "second.raw"].map(|file| environment.folder.join(file));
    let versions = set.meshes.iter().flat_map(|mesh| {
        let pair = |&ratio: &f64| Pair { names: [mesh.clone(), mesh.clone()], ratio: Some(ratio) };
        set.ratios.iter().map(pair)
    });
    let different = set.different.iter().map(|names| Pair { names: names.clone(), ratio: None });
    let pairs: Vec<Pair> = versions.chain(different).collect();
    let bar = progress_bar(pairs.len() * tools.len());
    let mut rows = Vec::new();
    for Pair { names, ratio } in &pairs {
        let first = Source::of_name(&names[0]).mesh(&common.models)?;
        let second = match ratio {
            Some(ratio) => simplified(&first, *ratio)?,
            None => Source::of_name(&names[1]).mesh(&common.models)?,
        };
        for (mesh, file) in [&first, &second].into_iter().zip(&files) {
            mesh.raw.write(file)?;
        }
        for tool in &tools {
            bar.set_message(format!("{} {} {}", names[0], names[1], tool.name));
            let values: Vec<Option<f64>> = match tool.value {
                Value::Tolerance => set.tolerances.iter().copied().map(Some).collect(),
                Value::Samples => vec![Some(f64::from(set.samples))],
                Value::None => vec![None],
            };
            for value in values {
                let job = Job {
                    meshes: names.clone(),
                    sha256: [first.sha256.clone(), second.sha256.clone()],
                    ratio: *ratio,
                    faces: [&first, &second].map(|mesh| mesh.raw.triangles.len()),
                    tolerance: value.filter(|_| tool.value == Value::Tolerance),
                    samples: (tool.value == Value::Samples).then_some(set.samples),
                };
                let files = [files[0].as_path(), files[1].as_path()];
                let row = environment.record(tool, job, value, files, Values::of);
                bar.suspend(|| println!("{row}"));
                rows.push(row);
            }
            bar.inc(1);
        }
        // A run takes long: intermediate results are saved in case it is aborted.
        json_lines::write(&rows, &environment.folder.join("distances.jsonl"))?;
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// A simplified version of a mesh, by the cheapest preset.
fn simplified(mesh: &Mesh, ratio: f64) -> Result<Mesh, Failure> {
    let faces = (mesh.raw.triangles.len() as f64 * ratio) as usize;
    let options = Options::preset(Preset::Draft).to_faces(faces);
    let mut small = simplify(&mesh.raw.to_mesh()?, &options).map_err(Failure::mesh)?.mesh;
    small.compact();
    Ok(Mesh { raw: RawMesh::of(&small), sha256: mesh.sha256.clone() })
}

impl Values {
    fn of(answer: &Answer) -> Result<Self, String> {
        match answer.results[..] {
            [Some(lower), upper] => Ok(Self { lower, upper }),
            _ => Err(format!("no bounds but {answer}")),
        }
    }
}

impl Row {
    fn pair(&self) -> (&[String; 2], Option<f64>) {
        (&self.job.meshes, self.job.ratio)
    }

    fn values(&self) -> Option<Values> {
        Some(self.outcome.as_ref()?.values)
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:16} ", title(self), self.tool)?;
        if let Some(tolerance) = self.job.tolerance {
            write!(f, "to {tolerance:e} ")?;
        }
        let (Some(Values { lower, upper }), Some(time)) = (self.values(), self.time()) else {
            return f.write_str(self.failure.as_deref().unwrap_or("it failed"));
        };
        let upper = upper.map_or_else(|| "–".to_owned(), |upper| format!("{upper:.9}"));
        write!(f, "{time:9.4} s  {lower:.9} to {upper}")
    }
}

/// The names of a pair.
fn title(row: &Row) -> String {
    let Job { meshes: [a, b], ratio, .. } = &row.job;
    ratio.map_or_else(|| format!("`{a}`, `{b}`"), |ratio| format!("`{a}`, {} %", 100.0 * ratio))
}

/// The tool that others are compared with.
const BASE: &str = "proved";

/// Our run of the same pair with the same tolerance.
fn ours<'r>(rows: &'r [Row], row: &Row) -> Option<&'r Row> {
    let same = |other: &&Row| {
        other.tool == BASE && other.pair() == row.pair() && other.job.tolerance == row.job.tolerance
    };
    rows.iter().find(same)
}

/// The closest bounds of a pair that we proved.
fn truth(rows: &[Row], row: &Row) -> Option<[f64; 2]> {
    let same = rows.iter().filter(|other| other.tool == BASE && other.pair() == row.pair());
    let bounds = same.filter_map(|other| {
        let values = other.values()?;
        Some([values.lower, values.upper?])
    });
    bounds.min_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
}

/// The times of a tool over ours, for the pairs that both did.
fn ratios(rows: &[Row], own: &[&Row]) -> Vec<f64> {
    own.iter().filter_map(|row| Some(row.time()? / ours(rows, row)?.time()?)).collect()
}

/// The tools that prove bounds, for each tolerance.
fn proved(rows: &[Row]) -> String {
    let mut text = String::from(
        "| | tolerance | done | time | least | at least ten times ours | memory | contradicts ours | version |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for tolerance in distinct(rows, |row| row.job.tolerance).into_iter().flatten() {
        for tool in Tool::all(Kind::Distances) {
            let is_own = |row: &&Row| row.tool == tool.name && row.job.tolerance == Some(tolerance);
            let own: Vec<&Row> = rows.iter().filter(is_own).collect();
            if own.is_empty() {
                continue;
            }
            let ratios = ratios(rows, &own);
            let much = ratios.iter().filter(|&&ratio| ratio >= 10.0).count();
            let least = ratios.iter().copied().fold(f64::NAN, f64::min);
            let is_base = tool.name == BASE;
            let contradicts = |row: &&&Row| {
                let (Some(Values { lower, upper }), Some([below, above])) =
                    (row.values(), truth(rows, row))
                else {
                    return false;
                };
                lower > above + ROUNDING || upper.is_some_and(|upper| upper < below - ROUNDING)
            };
            text += &format!(
                "| {} | {tolerance:e} | {} of {} | {} | {} | {} | {} | {} | {} |\n",
                tool.label,
                own.iter().filter(|row| row.outcome.is_some()).count(),
                own.len(),
                told(geometric_mean(ratios.iter().copied()), 1),
                told(least, 1),
                if is_base { String::new() } else { format!("{much} of {}", ratios.len()) },
                memory(&own),
                if is_base {
                    String::new()
                } else {
                    own.iter().filter(contradicts).count().to_string()
                },
                version(&own),
            );
        }
    }
    text
}

/// Bounds are computed with rounding: differences up to this contradict nothing.
const ROUNDING: f64 = 1e-12;

/// The tools that sample: their time, and which share of the distance they find.
fn sampled(rows: &[Row]) -> String {
    let mut text = String::from(
        "| | points | done | time | found, mean | found, least | above the distance | memory | version |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    // Their time is compared with the least of ours that proves something.
    let base = |row: &Row| {
        let same = rows.iter().filter(|other| other.tool == BASE && other.pair() == row.pair());
        same.filter_map(Row::time).min_by(f64::total_cmp)
    };
    for tool in Tool::all(Kind::Distances).filter(|tool| tool.value != Value::Tolerance) {
        let own: Vec<&Row> = rows.iter().filter(|row| row.tool == tool.name).collect();
        let Some(first) = own.first() else { continue };
        let times = own.iter().filter_map(|row| Some(row.time()? / base(row)?));
        let shares: Vec<f64> =
            own.iter().filter_map(|row| Some(row.values()?.lower / truth(rows, row)?[1])).collect();
        let above = shares.iter().filter(|&&share| share > 1.0 + SINGLE).count();
        text += &format!(
            "| {} | {} | {} of {} | {} | {} | {} | {above} | {} | {} |\n",
            tool.label,
            first.job.samples.map_or_else(|| "vertices".to_owned(), |samples| samples.to_string()),
            own.iter().filter(|row| row.outcome.is_some()).count(),
            own.len(),
            told(geometric_mean(times), 2),
            told(geometric_mean(shares.iter().copied()), 4),
            told(shares.iter().copied().fold(f64::NAN, f64::min), 4),
            memory(&own),
            version(&own),
        );
    }
    text
}

/// Some tools compute in single precision: distances that are higher by this share are rounded.
const SINGLE: f64 = 1e-5;

/// The pairs in which the other program that proves bounds comes closest to our time.
fn closest(rows: &[Row]) -> String {
    const PAIRS: usize = 10;
    let mut pairs: Vec<(f64, &Row, &Row)> = Vec::new();
    for row in rows.iter().filter(|row| row.tool == "cascading") {
        if let Some(ours) = ours(rows, row)
            && let Some(&ratio) = ratios(rows, &[row]).first()
        {
            pairs.push((ratio, row, ours));
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut text = String::from(
        "| pair | faces | tolerance | distance | ours | cascading upper bounds | ratio |\n|---|---|---|---|---|---|---|\n",
    );
    for (ratio, row, ours) in pairs.into_iter().take(PAIRS) {
        let [a, b] = row.job.faces;
        text += &format!(
            "| {} | {a}, {b} | {:e} | {} | {} s | {} | {} |\n",
            title(row),
            row.job.tolerance.unwrap_or(f64::NAN),
            ours.values().map_or_else(String::new, |values| format!("{:.6}", values.lower)),
            told(ours.time().unwrap_or(f64::NAN), 3),
            told(row.time().unwrap_or(f64::NAN), 3) + " s",
            told(ratio, 1),
        );
    }
    text
}

/// The largest memory beyond the input.
fn memory(own: &[&Row]) -> String {
    let bytes = own.iter().filter_map(|row| row.outcome.as_ref()?.cost.peak).max();
    bytes.map_or_else(String::new, |bytes| format!("{} MB", bytes.div_ceil(1_000_000)))
}

fn version(own: &[&Row]) -> String {
    own.iter().find_map(|row| row.version.clone()).unwrap_or_else(|| "–".to_owned())
}

fn block(table: &str, rows: &[Row]) -> Result<String, Failure> {
    match table {
        "proved" => Ok(proved(rows)),
        "sampled" => Ok(sampled(rows)),
        "closest" => Ok(closest(rows)),
        _ => Err(Failure::Usage(format!(
            "there is no table `{table}` of distances; there are proved, sampled and closest"
        ))),
    }
}
