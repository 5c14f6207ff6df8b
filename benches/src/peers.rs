//! `cargo run --release -p benches -- peers`: our presets beside other tools, at equal face counts or equal largest
//! errors.
//!
//! Every run is a separate process on a given number of cores. It times the call alone, without files, and takes the
//! minimum of several. Distances and normals are measured by `Open3D`, which is not one of the tools compared. Ratios
//! are between runs of the same command.
//!
//! The record of a run is a file of JSON lines, one for each job. The tables of the pages are made from such a record,
//! with `--from` without running anything; so is a page that sorts, filters and plots them.
//!
//! The other programs are data: see [`drivers`]. Packages of Python and npm are installed under `target/peers`. CGAL is
//! included if its headers and a C++ compiler are available, pmp if there is a clone of it, meshoptimizer if this program
//! was built with the feature `meshopt`.

mod drivers;
mod environment;
mod errors;
mod html;
mod job;
mod pages;
mod record;
mod table;
mod tool;
mod validity;
mod views;

use std::path::{Path, PathBuf};

use mesh_metric::Surface;
use sha2::{Digest, Sha256};

use crate::job_set::JobSet;
use crate::json_lines;
use crate::machine::{self, Machine};
use crate::raw_mesh::RawMesh;
use crate::timing::Cost;
use environment::Environment;
use errors::Meter;
use job::{Done, Job, Stop, Target};
pub(crate) use job::{PeerJob, run as run_job};
use record::{Outcome, Record};
use tool::Tool;
pub(crate) use validity::{Judge, Validity};
use xtask_common::{Failure, progress_bar};

/// What to compare, and how.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Peers {
    /// The folder with the meshes
    #[arg(long, value_name = "DIR", env = "CURVMESH_MODELS", required_unless_present = "from")]
    models: Option<PathBuf>,
    /// A set of benches/jobs.toml: short, usual, open, foreign or errors. The options below replace parts of it
    #[arg(long, value_name = "SET", default_value = "usual")]
    jobs: String,
    /// Which meshes, by file name
    #[arg(long, value_name = "FILE", value_delimiter = ',')]
    meshes: Vec<String>,
    /// How many faces are left, as shares of the input
    #[arg(long, value_name = "SHARE", value_delimiter = ',')]
    ratios: Vec<f64>,
    /// Instead of face counts, largest errors in percent of the diagonal of the bounding box
    #[arg(long, value_name = "PERCENT", value_delimiter = ',', conflicts_with = "ratios")]
    max_errors: Vec<f64>,
    /// Which tools
    #[arg(long, value_name = "TOOL", value_delimiter = ',')]
    tools: Vec<String>,
    /// Another program of ours, an earlier one perhaps, to run the presets too, as NAME=PROGRAM
    #[arg(long, value_name = "NAME=PROGRAM")]
    other: Vec<String>,
    /// Cores and threads that a tool may use
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: usize,
    /// Runs whose least time counts; fewer where one takes long
    #[arg(long, value_name = "N")]
    repeats: Option<usize>,
    /// The tool that the others are ratios to: the first that is there of cgal-lt and meshlab
    #[arg(long, value_name = "TOOL")]
    base: Option<String>,
    /// The folder for the environment, the record (peers.jsonl), the tables (peers.md) and the page (peers.html)
    #[arg(long, value_name = "DIR", default_value = "target/peers")]
    out: PathBuf,
    /// A folder with clones of libraries that have no package: pmp-library; and cgal, if not that of the system
    #[arg(long, value_name = "DIR")]
    clones: Option<PathBuf>,
    /// Keep the runs of the record in OUT, and do those that it does not have
    #[arg(long, conflicts_with_all = ["from", "keep"])]
    resume: bool,
    /// Run nothing; write the tables of the pages from this record
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// For --from: instead of the tables of pages, write a page that sorts, filters and plots
    #[arg(long, value_name = "FILE", requires = "from", conflicts_with = "pages")]
    html: Option<PathBuf>,
    /// Keep every result beside its input, as a page with both meshes in OUT/views; they take space
    #[arg(long, conflicts_with = "from")]
    keep: bool,
    /// The pages with tables, for --from
    #[arg(long, value_name = "FILE", value_delimiter = ',', requires = "from")]
    #[arg(default_values_t = PAGES.map(str::to_owned))]
    pages: Vec<String>,
}

/// The pages that have tables of a record between marker comments.
const PAGES: [&str; 3] = ["docs/results/peers.md", "README.md", "COMPARE.md"];

/// Runs every tool on every mesh, and prints the tables; or makes them from a record.
pub(crate) fn run(options: &Peers) -> Result<(), Failure> {
    if let Some(path) = &options.from {
        let rows = json_lines::read(path)?;
        return match &options.html {
            Some(page) => write_html(&rows, page),
            None => write_pages(&rows, &options.pages),
        };
    }
    let (options, repeats) = completed(options)?;
    let options = &options;
    std::fs::create_dir_all(&options.out).map_err(Failure::writing(&options.out))?;
    let out = std::path::absolute(&options.out).map_err(Failure::writing(&options.out))?;
    let targets = targets(options);
    let models = options.models.as_deref().unwrap_or_else(|| Path::new("."));
    for name in &options.meshes {
        let path = models.join(name);
        if !path.is_file() {
            return Err(Failure::Usage(format!("there is no mesh {}", path.display())));
        }
    }
    let wanted = wanted(options)?;
    let environment = Environment::prepare(&out, options.clones.as_deref(), &wanted)?;
    let tools = with_others(there(wanted, options, &environment), options)?;
    let base = base(options, &tools)?;
    let versions: Vec<Option<String>> = tools.iter().map(|t| environment.version(t)).collect();
    let machine = Machine::this();
    let file = out.join("peers.jsonl");
    let mut rows =
        if options.resume && file.exists() { json_lines::read(&file)? } else { Vec::new() };
    let runs = options.meshes.len() * targets.len() * tools.len();
    let bar = progress_bar(runs);
    for name in &options.meshes {
        let path = models.join(name);
        let bytes = std::fs::read(&path).map_err(Failure::reading(&path))?;
        let sha256 = format!("{:x}", Sha256::digest(&bytes));
        let class = crate::fetch::class(&sha256)?;
        let raw = RawMesh::from_file(&path)?
            .with_unit_diagonal()
            .ok_or_else(|| Failure::Usage(format!("{} has no extent", path.display())))?;
        let input = out.join("input.raw");
        raw.write(&input)?;
        let mesh = raw.to_mesh()?;
        let surface = Surface::new(&mesh).map_err(Failure::mesh)?;
        let judge = Judge::new(&raw, &mesh, &surface)?;
        let mut meter = Meter::new(&environment, &input);
        for &target in &targets {
            for (tool, version) in tools.iter().zip(&versions) {
                let is_done =
                    |row: &Record| row.is_run(&sha256, &target.to_string(), &tool.to_string());
                if rows.iter().any(is_done) {
                    bar.inc(1);
                    continue;
                }
                bar.set_message(format!("{name} {target} {tool}"));
                let job = Job {
                    tool: tool.clone(),
                    target: target.of(&raw),
                    threads: options.threads,
                    repeats,
                    input: input.clone(),
                    output: out.join("output.raw"),
                };
                let load = machine::load();
                let outcome = outcome(&environment, &judge, &mut meter, &job);
                let [program, preset] = tool.program_and_preset();
                let row = Record {
                    name: tool.to_string(),
                    tool: program,
                    version: version.clone(),
                    preset,
                    mesh: name.clone(),
                    class: class.clone(),
                    sha256: sha256.clone(),
                    input_faces: raw.triangles.len(),
                    target: target.to_string(),
                    wanted: match job.target {
                        Stop::Faces(faces) => Some(faces),
                        Stop::Error(_) => None,
                    },
                    threads: options.threads,
                    repeats,
                    seed: errors::SEED,
                    machine: machine.clone(),
                    load,
                    failure: outcome.as_ref().err().cloned(),
                    outcome: outcome.ok(),
                };
                bar.suspend(|| println!("{row}"));
                if options.keep && row.outcome.is_some() {
                    views::write(&row, &out, &raw, &RawMesh::read(&job.output)?)?;
                }
                rows.push(row);
                bar.inc(1);
            }
        }
        // A run takes long: intermediate results are saved in case it is aborted.
        json_lines::write(&rows, &file)?;
    }
    bar.finish_and_clear();
    let text = table::report(&rows, &base.to_string());
    let path = out.join("peers.md");
    std::fs::write(&path, &text).map_err(Failure::writing(&path))?;
    print!("{text}");
    write_html(&rows, &out.join("peers.html"))
}

/// Runs a job, and measures and judges its result.
fn outcome(
    environment: &Environment,
    judge: &Judge<'_>,
    meter: &mut Meter<'_>,
    job: &Job,
) -> Result<Outcome, String> {
    let done = environment.run(job)?;
    let result = RawMesh::read(&job.output).map_err(|e| e.to_string())?;
    let validity = judge.judge(&result).map_err(|e| e.to_string())?;
    let errors = meter.measure(&job.output)?;
    let Done { faces, cost: Cost { seconds, cpu, peak } } = done;
    Ok(Outcome { faces, seconds, cpu_seconds: cpu, memory: peak, errors, validity })
}

/// Writes the page of a record.
fn write_html(rows: &[Record], page: &Path) -> Result<(), Failure> {
    let text = html::page(rows, page.parent().unwrap_or_else(|| Path::new("")))?;
    std::fs::write(page, text).map_err(Failure::writing(page))?;
    println!("{}: {} runs", page.display(), rows.len());
    Ok(())
}

/// Writes the tables of pages anew.
fn write_pages(rows: &[Record], pages: &[String]) -> Result<(), Failure> {
    for page in pages {
        let path = Path::new(page);
        let old = std::fs::read_to_string(path).map_err(Failure::reading(path))?;
        let (new, blocks) = pages::rewrite(&old, rows)?;
        std::fs::write(path, new).map_err(Failure::writing(path))?;
        println!("{page}: {blocks} tables");
    }
    Ok(())
}

fn targets(options: &Peers) -> Vec<Target> {
    if options.max_errors.is_empty() {
        options.ratios.iter().map(|&share| Target::Share(share)).collect()
    } else {
        options.max_errors.iter().map(|&percent| Target::Error(percent / 100.0)).collect()
    }
}

/// The options with what the set of jobs says where they say nothing, and the number of repeats.
fn completed(options: &Peers) -> Result<(Peers, usize), Failure> {
    let JobSet { meshes, ratios, max_errors, tools, repeats } = JobSet::of_name(&options.jobs)?;
    let mut options = options.clone();
    if options.meshes.is_empty() {
        options.meshes = meshes;
    }
    if options.ratios.is_empty() && options.max_errors.is_empty() {
        (options.ratios, options.max_errors) = (ratios, max_errors);
    }
    if options.tools.is_empty() {
        options.tools = tools;
    }
    let repeats = options.repeats.unwrap_or(repeats);
    Ok((options, repeats))
}

/// The requested tools.
fn wanted(options: &Peers) -> Result<Vec<Tool>, Failure> {
    let known = Tool::all();
    let parse = |name: &String| {
        known.iter().find(|tool| tool.to_string() == *name).cloned().ok_or_else(|| {
            let names: Vec<String> = known.iter().map(ToString::to_string).collect();
            Failure::Usage(format!("there is no tool {name}; there are {}", names.join(", ")))
        })
    };
    options.tools.iter().map(parse).collect()
}

/// Whether a tool has this name, and can stop at a largest error, or else at a number of faces.
#[cfg(test)]
pub(crate) fn is_tool(name: &str, bounds_errors: bool) -> bool {
    Tool::all().iter().any(|tool| tool.to_string() == name && tool.can_do(bounds_errors))
}

/// The available tools that can do the job; prints why the others are left out.
fn there(mut tools: Vec<Tool>, options: &Peers, environment: &Environment) -> Vec<Tool> {
    tools.retain(|tool| {
        let lacks = if tool.can_do(!options.max_errors.is_empty()) {
            environment.lacks(tool)
        } else {
            Some("it has no such target".into())
        };
        if let Some(why) = &lacks {
            println!("without {tool}: {why}");
        }
        lacks.is_none()
    });
    tools
}

/// The tools, and our own again with each of the other programs.
fn with_others(mut tools: Vec<Tool>, options: &Peers) -> Result<Vec<Tool>, Failure> {
    for other in &options.other {
        let Some((name, program)) = other.split_once('=') else {
            return Err(Failure::Usage(format!("{other} is not NAME=PROGRAM")));
        };
        let ours: Vec<Tool> = tools.iter().filter_map(|t| t.by_program(name, program)).collect();
        tools.extend(ours);
    }
    Ok(tools)
}

fn base(options: &Peers, tools: &[Tool]) -> Result<Tool, Failure> {
    let find = |name: &str| tools.iter().find(|tool| tool.to_string() == name).cloned();
    let found = match &options.base {
        Some(name) => find(name),
        None => table::USUAL_BASES.into_iter().find_map(find).or_else(|| tools.first().cloned()),
    };
    found.ok_or_else(|| Failure::Usage("the base is none of the tools that are there".into()))
}
