//! `cargo xtask instructions`: instruction counts of one fixed job of each layer, compared with the record.
//!
//! Run time varies on a busy machine; instruction counts by callgrind hardly vary. They depend on the
//! compiler and on the number of codegen units, so the record holds for a build as `.ci/run` makes it.
//! The count of a job is the difference between a run with the job and a run that only makes its input.

use std::env;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;

use comfy_table::presets::UTF8_FULL;
use comfy_table::{CellAlignment, Table};
use curvpatch::{CoverOptions, CurvatureEstimator, Params, cover};
use dcurv::{CurvatureOptions, Curvatures, VertexArea};
use dtri_flip::{CostName, FlipOptions};
use mesh_core::SplitMix64;
use mesh_core::{PolygonSoup, TriMesh};
use mesh_io::{Format, ReadOptions, WriteOptions, read_from, write_to};
use mesh_metric::{CompareOptions, Surface, compare};
use mesh_render::{Scene, Side, Style, View, render};
use mesh_shapes::{Torus, scramble};
use simplify::{Options, Preset, simplify};

use xtask_common::Failure;

/// The record: one line `job,instructions` per job.
const RECORD: &str = "benches/recorded/instructions.csv";

/// Largest relative deviation from the record.
const MARGIN: f64 = 0.1;

/// Counts the instructions of a job.
#[derive(Debug, clap::Args)]
pub(crate) struct Instructions {
    /// Fail when a job takes over a tenth more or fewer than is on record
    #[arg(long)]
    check: bool,
    /// Put on record what is counted now
    #[arg(long)]
    record: bool,
}

/// One job, or only its input; `instructions` starts this program again with it.
#[derive(Debug, clap::Args)]
pub(crate) struct InstructionsJob {
    name: String,
    /// Only make the input
    #[arg(long)]
    idle: bool,
}

/// A job on a mesh.
struct Job {
    name: &'static str,
    input: fn() -> Result<TriMesh, Failure>,
    work: fn(&TriMesh) -> Result<(), Failure>,
}

/// One job for each layer that computes.
const JOBS: [Job; 9] = [
    Job { name: "mesh-core: build a torus of 20,000 faces", input: torus, work: build },
    Job { name: "mesh-io: write it as text and read it", input: torus, work: write_and_read },
    Job { name: "dcurv: its curvature", input: torus, work: curvature },
    Job { name: "mesh-metric: distances of 10,000 samples", input: torus, work: distance },
    Job { name: "dtri-flip: 300 scrambled edges, F2", input: scrambled, work: flip },
    Job { name: "simplify: draft, to 1,000 faces", input: torus, work: draft },
    Job { name: "simplify: default, to 1,000 faces", input: torus, work: default },
    Job { name: "curvpatch: cover 800 faces", input: small_torus, work: patches },
    Job { name: "mesh-render: a picture of 200 by 200", input: torus, work: picture },
];

fn torus_of(rings: usize, sides: usize) -> Result<TriMesh, Failure> {
    let soup = Torus { major: 5.0, minor: 2.0 }.mesh(rings, sides).map_err(Failure::mesh)?;
    TriMesh::from_soup(&soup).map_err(Failure::mesh)
}

fn torus() -> Result<TriMesh, Failure> {
    torus_of(200, 50)
}

fn small_torus() -> Result<TriMesh, Failure> {
    torus_of(40, 10)
}

fn scrambled() -> Result<TriMesh, Failure> {
    let mut mesh = torus_of(80, 20)?;
    scramble(&mut mesh, 300, &mut SplitMix64::new(1), |_, _| true);
    Ok(mesh)
}

fn build(mesh: &TriMesh) -> Result<(), Failure> {
    let soup = PolygonSoup::from(mesh);
    black_box(TriMesh::from_soup(&soup).map_err(Failure::mesh)?);
    Ok(())
}

fn write_and_read(mesh: &TriMesh) -> Result<(), Failure> {
    let mut file = Vec::new();
    write_to(&mut file, mesh, Format::Obj, &WriteOptions::default()).map_err(Failure::mesh)?;
    black_box(read_from(&mut file.as_slice(), &ReadOptions::default()).map_err(Failure::mesh)?);
    Ok(())
}

fn curvature(mesh: &TriMesh) -> Result<(), Failure> {
    black_box(Curvatures::of(mesh, &CurvatureOptions::default()).totals());
    Ok(())
}

fn distance(mesh: &TriMesh) -> Result<(), Failure> {
    let coarse = Surface::new(&small_torus()?).map_err(Failure::mesh)?;
    let fine = Surface::new(mesh).map_err(Failure::mesh)?;
    let options = CompareOptions { samples: 10_000, vertices: false, edges: false, seed: 1 };
    black_box(compare(&fine, &coarse, &options));
    Ok(())
}

fn flip(mesh: &TriMesh) -> Result<(), Failure> {
    // By name: a cost given as a type would be compiled here, less optimised than the layers.
    let (mut mesh, options) = (mesh.clone(), FlipOptions::default());
    let goes_on = &mut |_| ControlFlow::Continue(());
    let report = CostName::F2.optimise(&mut mesh, VertexArea::default(), &options, goes_on);
    black_box(report.map_err(Failure::mesh)?);
    Ok(())
}

fn draft(mesh: &TriMesh) -> Result<(), Failure> {
    simplified(mesh, Preset::Draft)
}

fn default(mesh: &TriMesh) -> Result<(), Failure> {
    simplified(mesh, Preset::Default)
}

fn simplified(mesh: &TriMesh, preset: Preset) -> Result<(), Failure> {
    let options = Options::preset(preset).to_faces(1_000);
    black_box(simplify(mesh, &options).map_err(Failure::mesh)?);
    Ok(())
}

fn patches(mesh: &TriMesh) -> Result<(), Failure> {
    let estimator = CurvatureEstimator::new(mesh, Params::robust()).map_err(Failure::mesh)?;
    black_box(cover(&estimator, &CoverOptions::new(0.2)).map_err(Failure::mesh)?);
    Ok(())
}

fn picture(mesh: &TriMesh) -> Result<(), Failure> {
    let Some(view) = View::of_side(mesh, Side::Corner) else { return Ok(()) };
    let style = Style { size: [200, 200], edge_width: 1.0, ..Style::default() };
    black_box(render(&Scene::of(mesh), &view, &style).map_err(Failure::mesh)?);
    Ok(())
}

pub(crate) fn run_job(options: &InstructionsJob) -> Result<(), Failure> {
    let job = JOBS.iter().find(|job| job.name == options.name);
    let job = job.ok_or_else(|| Failure::Usage(format!("there is no job {:?}", options.name)))?;
    let input = (job.input)()?;
    if options.idle { Ok(()) } else { (job.work)(&input) }
}

pub(crate) fn run(options: &Instructions) -> Result<(), Failure> {
    let record = Path::new(RECORD);
    let known = if options.record { Vec::new() } else { recorded(record)? };
    let mut table = Table::new();
    table.load_preset(UTF8_FULL).set_header(["job", "instructions", "on record", "change"]);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let (mut counts, mut changed) = (Vec::new(), 0);
    for job in &JOBS {
        let count = counted(job.name, false)?.saturating_sub(counted(job.name, true)?);
        let before = known.iter().find(|(name, _)| name == job.name).map(|&(_, before)| before);
        let change = before.map(|before| count as f64 / before as f64 - 1.0);
        changed += usize::from(change.is_none_or(|change| change.abs() > MARGIN));
        table.add_row([
            job.name.to_owned(),
            format!("{:.2} M", count as f64 / 1e6),
            before.map_or_else(|| "-".to_owned(), |n| format!("{:.2} M", n as f64 / 1e6)),
            change.map_or_else(|| "-".to_owned(), |x| format!("{:+.1} %", 100.0 * x)),
        ]);
        counts.push((job.name, count));
    }
    println!("{table}");
    if options.record {
        return write(record, &counts);
    }
    if options.check && changed > 0 {
        return Err(Failure::Check(format!(
            "{changed} jobs take over a tenth more or fewer instructions than on record; the table says which"
        )));
    }
    Ok(())
}

/// The instructions of one run of this program.
fn counted(name: &str, idle: bool) -> Result<u64, Failure> {
    let own = env::current_exe().map_err(Failure::reading(Path::new("benches")))?;
    let mut valgrind = Command::new("valgrind");
    valgrind.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(own);
    valgrind.args(["instructions-job", name]).env("RAYON_NUM_THREADS", "1");
    if idle {
        valgrind.arg("--idle");
    }
    let output = valgrind.output().map_err(|_| {
        Failure::Usage("valgrind, which counts instructions, cannot be started; install it".into())
    })?;
    let said = String::from_utf8_lossy(&output.stderr);
    let collected = said.lines().filter_map(|line| line.split_once("Collected :"));
    let count = collected.filter_map(|(_, n)| n.trim().parse().ok()).next_back();
    match count {
        Some(count) if output.status.success() => Ok(count),
        _ => Err(Failure::Usage(format!("valgrind did not count {name:?}:\n{said}"))),
    }
}

fn recorded(path: &Path) -> Result<Vec<(String, u64)>, Failure> {
    let mut reader = csv::Reader::from_path(path).map_err(Failure::numbers)?;
    reader.deserialize().collect::<Result<_, _>>().map_err(Failure::numbers)
}

fn write(path: &Path, counts: &[(&str, u64)]) -> Result<(), Failure> {
    let mut writer = csv::Writer::from_path(path).map_err(Failure::numbers)?;
    writer.write_record(["job", "instructions"]).map_err(Failure::numbers)?;
    for count in counts {
        writer.serialize(count).map_err(Failure::numbers)?;
    }
    writer.flush().map_err(Failure::writing(path))
}
