//! `cargo run --release -p benches -- curvature-study`: estimates of curvature against the truth.
//!
//! Surfaces with exact curvature are meshed in several ways, with and without noise. Every estimator of ours, and of
//! other programs if wanted, estimates the principal curvatures of every vertex. Errors are relative to the mean of the
//! larger absolute principal curvature over the mesh, at interior vertices: the larger one of both errors, its median
//! and its 95th percentile. Positions are rounded to single precision.

mod case;
mod cost;
mod programs;
mod report;
mod row;
mod sampling;
mod speed;
mod surfaces;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use mesh_core::PolygonSoup;
use xtask_common::{Failure, Numbers, progress_bar};

use case::{Case, Estimate};
use cost::{Cost, measured};
use programs::Peers;
use row::{Key, Ours, Row};
use sampling::{Sampling, sample};
pub(crate) use speed::{CurvatureJob, run_job};
use surfaces::{Exact, Surface};

/// What is estimated, and by whom.
#[derive(Debug, clap::Args)]
pub(crate) struct CurvatureStudy {
    /// Which surfaces; all of them by default
    #[arg(long, value_name = "SURFACE", value_delimiter = ',')]
    surfaces: Vec<Surface>,
    /// How they are meshed; in all ways by default
    #[arg(long, value_name = "SAMPLING", value_delimiter = ',')]
    samplings: Vec<Sampling>,
    /// About how many vertices the meshes have
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "500,2000,8000")]
    vertices: Vec<usize>,
    /// Standard deviations of the noise along the normal, in mean edge lengths
    #[arg(long, value_name = "SHARE", value_delimiter = ',', default_value = "0,0.002,0.01,0.05")]
    noise: Vec<f64>,
    /// Also run libigl, MeshLab, VTK, trimesh, trueform, gpytoolbox, `DGtal` and CGAL, as far as their Python packages
    /// can be installed into OUT/environment, and their headers are there
    #[arg(long)]
    peers: bool,
    /// A folder with clones of libraries that have no package: pmp-library and geometry-central, also cgal (5.6 or newer)
    /// if the system has an older one
    #[arg(long, value_name = "DIR", requires = "peers")]
    clones: Option<PathBuf>,
    /// Also measure time and memory of every program on one thread, on a torus with about this number of vertices
    #[arg(long, value_name = "N")]
    speed: Option<usize>,
    /// Write every mesh as PLY with its exact curvature to this folder
    #[arg(long, value_name = "DIR")]
    export: Option<PathBuf>,
    /// 500 vertices, without noise and with noise of 0.01 only
    #[arg(long, conflicts_with_all = ["vertices", "noise"])]
    quick: bool,
    /// The folder for the tables (curvature-study.md), a plot (curvature-study.svg) and the numbers
    /// (curvature-study.csv). What is in the numbers already is not computed again
    #[arg(long, value_name = "DIR", default_value = "target/curvature-study")]
    out: PathBuf,
}

impl CurvatureStudy {
    /// The meshes: surface, sampling, vertices and noise.
    fn cells(&self) -> Vec<(Surface, Sampling, usize, f64)> {
        fn or_all<T: ValueEnum + Copy>(chosen: &[T]) -> Vec<T> {
            if chosen.is_empty() { T::value_variants().to_vec() } else { chosen.to_vec() }
        }
        let (sizes, levels) = if self.quick {
            (vec![500], vec![0.0, 0.01])
        } else {
            (self.vertices.clone(), self.noise.clone())
        };
        let mut cells = Vec::new();
        for surface in or_all(&self.surfaces) {
            for sampling in or_all(&self.samplings).into_iter().filter(|way| way.fits(surface)) {
                for &size in &sizes {
                    cells.extend(levels.iter().map(|&noise| (surface, sampling, size, noise)));
                }
            }
        }
        cells
    }
}

/// Runs the rows that are missing in the file of numbers, and prints the tables.
pub(crate) fn run(options: &CurvatureStudy) -> Result<(), Failure> {
    std::fs::create_dir_all(&options.out).map_err(Failure::writing(&options.out))?;
    let path = options.out.join("curvature-study.csv");
    let parse = |record: &csv::StringRecord| {
        record.deserialize(Some(&csv::StringRecord::from(HEADER.to_vec()))).ok()
    };
    let (mut numbers, mut rows) = Numbers::open(path, &HEADER, parse)?;
    let known: HashSet<Key> = rows.iter().map(Row::key).collect();
    let prepare = || Peers::prepare(&options.out, options.clones.as_deref());
    let mut peers = options.peers.then(prepare).transpose()?;
    let cells = options.cells();
    let bar = progress_bar(cells.len());
    for (surface, sampling, vertices, noise) in cells {
        bar.set_message(format!("{} {} {vertices} {noise}", surface.name(), sampling.name()));
        let (case, soup) = Case::new(sample(surface, sampling, vertices)?, noise)?;
        if let Some(folder) = &options.export {
            let name = format!("{}-{}-{vertices}-{noise}.ply", surface.name(), sampling.name());
            export(&folder.join(name), soup, &case.exact)?;
        }
        let key = |program: &str| {
            let [surface, sampling] = [surface.name(), sampling.name()];
            (surface, sampling, vertices, noise.to_string(), program.to_owned())
        };
        let is_wanted = |program: &str| !known.contains(&key(program));
        let mut add = |program: &str, estimates: &[Estimate], seconds: f64| {
            let row = case.row(key(program), estimates, seconds);
            numbers.add_fields(&row)?;
            rows.push(row);
            Ok::<_, Failure>(())
        };
        for ours in Ours::value_variants().iter().filter(|ours| is_wanted(ours.name())) {
            let (estimates, cost) = measured(|| ours.estimate(&case))?;
            add(ours.name(), &estimates, cost.seconds)?;
        }
        if let Some(peers) = &mut peers {
            for program in peers.programs.clone() {
                if !is_wanted(&program.name) {
                    continue;
                }
                let none = (vec![Estimate::UNKNOWN; case.exact.len()], Cost::UNKNOWN);
                let (estimates, cost) = peers.estimate(&program, &case).unwrap_or(none);
                add(&program.name, &estimates, cost.seconds)?;
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let mut text = report::tables(&rows);
    if let Some(vertices) = options.speed {
        text += &format!("\n{}", speed::table(vertices, peers.as_mut())?);
    }
    if let Some(peers) = &peers {
        text += &format!("\n{}", report::programs(&peers.programs, &peers.missing));
    }
    let write = |name: &str, text: &str| {
        let path = options.out.join(name);
        std::fs::write(&path, text).map_err(Failure::writing(&path))
    };
    write("curvature-study.md", &text)?;
    write("curvature-study.svg", &report::plot(&rows).file())?;
    print!("{text}");
    Ok(())
}

const HEADER: [&str; 14] = [
    "surface",
    "sampling",
    "vertices",
    "noise",
    "program",
    "k_median",
    "k_95",
    "mean_median",
    "gaussian_median",
    "direction_median",
    "normal_median",
    "unknown",
    "within",
    "seconds",
];

/// A mesh with its exact curvature as named numbers.
fn export(path: &Path, soup: PolygonSoup, exact: &[Exact]) -> Result<(), Failure> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(Failure::writing(folder))?;
    }
    let mut model = mesh_io::Model { soup, ..mesh_io::Model::default() };
    let mut add = |name: &str, of: &dyn Fn(&Exact) -> f64| {
        let values: Vec<f64> = exact.iter().map(of).collect();
        model.vertex_scalars.push(mesh_io::Scalars::new(name, values));
    };
    add("exact_k1", &|exact| exact.principal[0]);
    add("exact_k2", &|exact| exact.principal[1]);
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        add(&format!("exact_direction_{letter}"), &|exact| exact.direction[axis]);
        add(&format!("exact_normal_{letter}"), &|exact| exact.normal[axis]);
    }
    let options = mesh_io::WriteOptions::default();
    mesh_io::write(path, &model, &options).map(drop).map_err(Failure::mesh)
}
