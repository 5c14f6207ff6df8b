//! `cargo run --release -p benches -- curvature-study`: estimates of curvature against the truth.
//!
//! Surfaces with exact curvature are meshed in several ways, with and without noise. Every estimator of ours, and of
//! other programs if wanted, estimates the principal curvatures of every vertex. Errors are relative to the mean of the
//! larger absolute principal curvature over the mesh, at interior vertices: the larger one of both errors, its median
//! and its 95th percentile. Positions are rounded to single precision.

mod cost;
mod programs;
mod report;
mod row;
mod sampling;
mod surfaces;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use curvpatch::{CurvatureEstimator, Params};
use dcurv::{
    CurvatureOptions, Curvatures, FitOptions, FitScale, FittedCurvature, PrincipalFrame,
    ball_curvatures, corrected_curvatures, estimate_noise, fitted_curvatures,
};
use glam::DVec3;
use mesh_core::{PolygonSoup, TriMesh, VertexId, VertexMap};
use mesh_shapes::{add_normal_noise, mean_edge_length};
use xtask_common::{Failure, Numbers, progress_bar};

use cost::{Cost, measured};
pub(crate) use cost::{CurvatureJob, run_job};
use programs::Peers;
use row::{Key, Ours, Row};
use sampling::{Sampled, Sampling, sample};
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
    /// Also run libigl, MeshLab, VTK, trimesh, trueform, gpytoolbox, DGtal and CGAL, as far as their Python packages can
    /// be installed into OUT/environment, and their headers are there
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

/// What a program says of a vertex. NaN where it says nothing.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    principal: [f64; 2],
    direction: DVec3,
    normal: DVec3,
    error: f64,
}

impl Estimate {
    const UNKNOWN: Self = Self {
        principal: [f64::NAN; 2],
        direction: DVec3::NAN,
        normal: DVec3::NAN,
        error: f64::NAN,
    };

    fn of_frame(frame: &PrincipalFrame, error: f64) -> Self {
        Self {
            principal: [frame.k_max.value(), frame.k_min.value()],
            direction: frame.direction_max,
            normal: frame.normal,
            error,
        }
    }
}

/// A mesh with the truth at its vertices.
struct Case {
    mesh: TriMesh,
    exact: Vec<Exact>,
    edge: f64,
}

impl Case {
    fn new(sampled: Sampled, noise: f64) -> Result<(Self, PolygonSoup), Failure> {
        let Sampled { mut soup, exact } = sampled;
        if noise > 0.0 {
            add_normal_noise(&mut soup, noise, 7);
        }
        soup.positions_mut().iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
        let mesh = TriMesh::from_soup(&soup).map_err(Failure::mesh)?;
        Ok((Self { mesh, exact, edge: mean_edge_length(&soup) }, soup))
    }

    /// The row of a program.
    fn row(&self, key: Key, estimates: &[Estimate], seconds: f64) -> Row {
        let topology = self.mesh.topology();
        let larger = |exact: &Exact| exact.principal[0].abs().max(exact.principal[1].abs());
        let scale = self.exact.iter().map(larger).sum::<f64>() / self.exact.len() as f64;
        let mut errors: [Vec<f64>; 5] = Default::default();
        let (mut unknown, mut predicted, mut within, mut count) = (0, 0, 0, 0);
        for vertex in topology.vertices().filter(|&v| !topology.is_boundary_vertex(v)) {
            let (estimate, exact) = (&estimates[vertex.index()], &self.exact[vertex.index()]);
            count += 1;
            let ([k1, k2], [e1, e2]) = (estimate.principal, exact.principal);
            if k1.is_nan() || k2.is_nan() {
                unknown += 1;
                continue;
            }
            let error = (k1 - e1).abs().max((k2 - e2).abs());
            errors[0].push(error / scale);
            errors[1].push((0.5 * (k1 + k2) - 0.5 * (e1 + e2)).abs() / scale);
            errors[2].push((k1 * k2 - e1 * e2).abs() / (scale * scale));
            let angle = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b).abs()).to_degrees();
            if e1 - e2 > 0.2 * scale && estimate.direction.is_finite() {
                errors[3].push(angle(estimate.direction, exact.direction));
            }
            if estimate.normal.is_finite() {
                errors[4].push(angle(estimate.normal, exact.normal));
            }
            if estimate.error.is_finite() {
                predicted += 1;
                within += usize::from(error <= estimate.error);
            }
        }
        let rank = |values: &mut Vec<f64>, share: f64| {
            if values.is_empty() {
                return f64::NAN;
            }
            values.sort_by(f64::total_cmp);
            values[((values.len() - 1) as f64 * share) as usize]
        };
        let (surface, sampling, vertices, noise, program) = key;
        let share = |part: usize, all: usize| {
            if all == 0 { f64::NAN } else { part as f64 / all as f64 }
        };
        let [k, mean, gaussian, direction, normal] = &mut errors;
        Row {
            surface,
            sampling,
            vertices,
            noise: noise.parse().unwrap_or(f64::NAN),
            program,
            k_median: rank(k, 0.5),
            k_95: rank(k, 0.95),
            mean_median: rank(mean, 0.5),
            gaussian_median: rank(gaussian, 0.5),
            direction_median: rank(direction, 0.5),
            normal_median: rank(normal, 0.5),
            unknown: share(unknown, count),
            within: share(within, predicted),
            seconds,
        }
    }
}

impl Ours {
    fn estimate(self, case: &Case) -> Result<Vec<Estimate>, Failure> {
        let Case { mesh, edge, .. } = case;
        let fitted = |scale| {
            let fits = fitted_curvatures(mesh, &FitOptions { scale, ..FitOptions::default() });
            let of = |fit: &Option<FittedCurvature>| match fit {
                Some(fit) => Estimate::of_frame(&fit.frame, fit.error.value()),
                None => Estimate::UNKNOWN,
            };
            fits.as_slice().iter().map(of).collect()
        };
        let of_ball = |frame: Option<PrincipalFrame>| {
            frame.map_or(Estimate::UNKNOWN, |frame| Estimate::of_frame(&frame, f64::NAN))
        };
        Ok(match self {
            Self::Auto => fitted(FitScale::Noise(estimate_noise(mesh))),
            Self::FitNearest => fitted(FitScale::Nearest),
            Self::Fit2Rings => fitted(FitScale::Rings(2)),
            Self::Fit3Edges => fitted(FitScale::Radius(3.0 * edge)),
            Self::Vertex => {
                let all = Curvatures::of(mesh, &CurvatureOptions::default());
                let of = |v: VertexId| Estimate {
                    principal: all[v].principal().map(dcurv::Pointwise::value),
                    ..Estimate::UNKNOWN
                };
                mesh.topology().vertices().map(of).collect()
            }
            Self::Ball4Edges => {
                let balls = ball_curvatures(mesh, 4.0 * edge).map_err(Failure::mesh)?;
                balls.as_slice().iter().map(|ball| of_ball(ball.principal())).collect()
            }
            Self::Corrected4Edges => {
                let balls = corrected_curvatures(mesh, 4.0 * edge).map_err(Failure::mesh)?;
                balls.as_slice().iter().map(|ball| of_ball(ball.principal())).collect()
            }
            Self::Face => of_faces(mesh)?,
        })
    }
}

/// Means of the curvatures of the faces around each vertex.
fn of_faces(mesh: &TriMesh) -> Result<Vec<Estimate>, Failure> {
    let estimator = CurvatureEstimator::new(mesh, Params::default()).map_err(Failure::mesh)?;
    let discs = estimator.all_faces(estimator.default_size()).map_err(Failure::mesh)?;
    let mut sums: VertexMap<[f64; 3]> = mesh.topology().vertex_map([0.0; 3]);
    for face in mesh.topology().faces() {
        let Ok(disc) = &discs[face] else { continue };
        for vertex in mesh.topology().face_vertices(face) {
            let [k1, k2] = disc.curvatures;
            for (sum, value) in sums[vertex].iter_mut().zip([k1, k2, 1.0]) {
                *sum += value;
            }
        }
    }
    let of = |&[k1, k2, count]: &[f64; 3]| Estimate {
        principal: [k1 / count, k2 / count],
        ..Estimate::UNKNOWN
    };
    Ok(sums.as_slice().iter().map(of).collect())
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
        text += &format!("\n{}", cost::table(vertices, peers.as_mut())?);
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
