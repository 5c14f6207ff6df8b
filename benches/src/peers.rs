//! `cargo run --release -p benches -- peers`: our presets beside other tools, at equal face counts or equal largest
//! errors.
//!
//! Every run is a separate process on a given number of cores. It times the call alone, without files, and takes the
//! minimum of several. Distances and normals are measured by `Open3D`, which is not one of the tools compared. Ratios
//! are between runs of the same command.
//!
//! The tools written in Python are installed in a virtual environment under `target/peers`. CGAL is included if its
//! headers and a C++ compiler are available, meshoptimizer if this program was built with the feature `meshopt`.

mod environment;
mod errors;
mod job;
mod raw;
mod table;
mod tool;

use std::path::{Path, PathBuf};

use mesh_core::BoundingBox;

use environment::Environment;
use job::{Job, Target};
pub(crate) use job::{PeerJob, run as run_job};
use raw::RawMesh;
use table::Row;
use tool::Tool;
use xtask_common::{Failure, progress_bar};

/// What to compare, and how.
#[derive(Debug, clap::Args)]
pub(crate) struct Peers {
    /// The folder with the meshes
    #[arg(long, value_name = "DIR", env = "CURVMESH_MODELS")]
    models: PathBuf,
    /// Which meshes, by file name; ten of different kinds by default
    #[arg(long, value_name = "FILE", value_delimiter = ',', default_values_t = MESHES.map(str::to_owned))]
    meshes: Vec<String>,
    /// How many faces are left, as shares of the input
    #[arg(long, value_name = "SHARE", value_delimiter = ',', default_value = "0.3,0.1,0.02")]
    ratios: Vec<f64>,
    /// Instead of face counts, largest errors in percent of the diagonal of the bounding box
    #[arg(long, value_name = "PERCENT", value_delimiter = ',', conflicts_with = "ratios")]
    max_errors: Vec<f64>,
    /// Which tools; all that are there by default, without extreme and the papers' presets
    #[arg(long, value_name = "TOOL", value_delimiter = ',')]
    tools: Vec<String>,
    /// Another program of ours, an earlier one perhaps, to run the presets too, as NAME=PROGRAM
    #[arg(long, value_name = "NAME=PROGRAM")]
    other: Vec<String>,
    /// Cores and threads that a tool may use
    #[arg(long, value_name = "N", default_value_t = 1)]
    threads: usize,
    /// Runs whose least time counts; fewer where one takes long
    #[arg(long, value_name = "N", default_value_t = 3)]
    repeats: usize,
    /// The tool that the others are ratios to: the first that is there of cgal-lt and meshlab
    #[arg(long, value_name = "TOOL")]
    base: Option<String>,
    /// The folder for the environment, the numbers (peers.csv) and the table (peers.md)
    #[arg(long, value_name = "DIR", default_value = "target/peers")]
    out: PathBuf,
}

/// Scans, heads, animals and mechanical parts; closed, with a boundary and in many pieces.
const MESHES: [&str; 10] = [
    "igea.ply",
    "rocker-arm.obj",
    "fandisk.obj",
    "horse.ply",
    "bunny10k_textured.obj",
    "max-planck_10k.obj",
    "elephant_40k.off",
    "screwdriver_be.ply",
    "casting.off",
    "mountain.obj",
];

/// Runs every tool on every mesh, and prints the table of geometric means.
pub(crate) fn run(options: &Peers) -> Result<(), Failure> {
    std::fs::create_dir_all(&options.out).map_err(Failure::writing(&options.out))?;
    let out = std::path::absolute(&options.out).map_err(Failure::writing(&options.out))?;
    let targets = targets(options);
    for name in &options.meshes {
        let path = options.models.join(name);
        if !path.is_file() {
            return Err(Failure::Usage(format!("there is no mesh {}", path.display())));
        }
    }
    let wanted = wanted(options)?;
    let environment = Environment::prepare(&out)?;
    let tools = with_others(there(wanted, options, &environment), options)?;
    let base = base(options, &tools)?;
    let runs = options.meshes.len() * targets.len() * tools.len();
    let bar = progress_bar(runs);
    let mut rows = Vec::new();
    for name in &options.meshes {
        let raw = unit_mesh(&options.models.join(name))?;
        let input = out.join("input.raw");
        raw.write(&input)?;
        for &target in &targets {
            for tool in &tools {
                bar.set_message(format!("{name} {target} {tool}"));
                let job = Job {
                    tool: tool.clone(),
                    target: target.of(&raw),
                    threads: options.threads,
                    repeats: options.repeats,
                    input: input.clone(),
                    output: out.join("output.raw"),
                };
                let row = match environment.run(&job) {
                    Ok(done) => {
                        let errors = errors::measure(&environment, &input, &job.output)?;
                        Row::done(name, &raw, target, tool, &done, &errors)
                    }
                    Err(why) => Row::failed(name, &raw, target, tool, why),
                };
                bar.suspend(|| println!("{row}"));
                rows.push(row);
                bar.inc(1);
            }
        }
        // A run takes long: intermediate results are saved in case it is aborted.
        table::write_csv(&rows, &out.join("peers.csv"))?;
    }
    bar.finish_and_clear();
    let text = table::markdown(&rows, &tools, &base, &targets, options.threads);
    let path = out.join("peers.md");
    std::fs::write(&path, &text).map_err(Failure::writing(&path))?;
    print!("{text}");
    Ok(())
}

fn targets(options: &Peers) -> Vec<Target> {
    if options.max_errors.is_empty() {
        options.ratios.iter().map(|&share| Target::Share(share)).collect()
    } else {
        options.max_errors.iter().map(|&percent| Target::Error(percent / 100.0)).collect()
    }
}

/// The requested tools, or all default tools.
fn wanted(options: &Peers) -> Result<Vec<Tool>, Failure> {
    let known = Tool::all();
    if options.tools.is_empty() {
        let bounds_errors = !options.max_errors.is_empty();
        let takes_part = |tool: &Tool| tool.is_usual() && tool.can_do(bounds_errors);
        return Ok(known.into_iter().filter(takes_part).collect());
    }
    let parse = |name: &String| {
        known.iter().find(|tool| tool.to_string() == *name).cloned().ok_or_else(|| {
            let names: Vec<String> = known.iter().map(ToString::to_string).collect();
            Failure::Usage(format!("there is no tool {name}; there are {}", names.join(", ")))
        })
    };
    options.tools.iter().map(parse).collect()
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
        None => find("cgal-lt").or_else(|| find("meshlab")).or_else(|| tools.first().cloned()),
    };
    found.ok_or_else(|| Failure::Usage("the base is none of the tools that are there".into()))
}

/// A mesh around the origin with a diagonal of one: some of the tools compute in single precision.
fn unit_mesh(path: &Path) -> Result<RawMesh, Failure> {
    let mut mesh = RawMesh::from_file(path)?;
    let bounds = BoundingBox::of_points(mesh.vertices.iter().copied())
        .filter(|bounds| bounds.diagonal() > 0.0)
        .ok_or_else(|| Failure::Usage(format!("{} has no extent", path.display())))?;
    let (center, diagonal) = (bounds.center(), bounds.diagonal());
    for vertex in &mut mesh.vertices {
        *vertex = ((*vertex - center) / diagonal).as_vec3().as_dvec3();
    }
    Ok(mesh)
}
