//! The other programs of the study: Python packages, and libraries with a driver that is compiled here.

use std::path::{Path, PathBuf};
use std::process::Command;

use glam::DVec3;
use xtask_common::{Failure, VirtualEnvironment};

use super::case::{Case, Estimate};
use super::cost::Cost;
use super::surfaces::Exact;
use crate::command_output::command_output;
use crate::compiled::Library;
use crate::process::Process;

/// The radius of averages over balls, in mean edges.
pub(super) const RADIUS: f64 = 3.0;

const CGAL: &str = include_str!("cgal_curvature.cpp");

/// Libraries, and their methods: names of programs in the tables, and arguments of the driver.
const LIBRARIES: [(Library, &[(&str, &str)]); 5] = [
    (
        Library {
            name: "cgal-corrected",
            driver: CGAL,
            clone: "cgal",
            is_required: false,
            headers: &["include"],
            sources: &[],
            flags: &["-DPEER_CORRECTED", "-lgmp", "-lmpfr"],
        },
        &[("CGAL, corrected", "ball"), ("CGAL, corrected, star", "star")],
    ),
    (
        Library {
            name: "cgal-jets",
            driver: CGAL,
            clone: "cgal",
            is_required: false,
            headers: &["include"],
            sources: &[],
            flags: &["-DPEER_JETS", "-lgmp", "-lmpfr"],
        },
        &[("CGAL, jets 2, 2 rings", "2-2"), ("CGAL, jets 4, 3 rings", "4-3")],
    ),
    (
        Library {
            name: "dgtal",
            driver: include_str!("dgtal_curvature.cpp"),
            clone: "DGtal",
            is_required: false,
            headers: &["src"],
            sources: &[],
            flags: &[],
        },
        &[("DGtal", "ball")],
    ),
    (
        Library {
            name: "pmp",
            driver: include_str!("pmp_curvature.cpp"),
            clone: "pmp-library",
            is_required: true,
            headers: &["src"],
            sources: &[
                "src/pmp/surface_mesh.cpp",
                "src/pmp/algorithms/curvature.cpp",
                "src/pmp/algorithms/differential_geometry.cpp",
                "src/pmp/algorithms/laplace.cpp",
                "src/pmp/algorithms/normals.cpp",
                "src/pmp/algorithms/numerics.cpp",
            ],
            flags: &["-DPMP_SCALAR_TYPE_64"],
        },
        &[("pmp", "operators"), ("pmp, tensor", "tensor")],
    ),
    (
        Library {
            name: "geometry-central",
            driver: include_str!("geometry_central_curvature.cpp"),
            clone: "geometry-central",
            is_required: true,
            headers: &["include", "deps/nanoflann/include"],
            sources: &[
                "src/surface/base_geometry_interface.cpp",
                "src/surface/embedded_geometry_interface.cpp",
                "src/surface/extrinsic_geometry_interface.cpp",
                "src/surface/intrinsic_geometry_interface.cpp",
                "src/surface/manifold_surface_mesh.cpp",
                "src/surface/polygon_mesh_helpers.cpp",
                "src/surface/surface_mesh.cpp",
                "src/surface/vertex_position_geometry.cpp",
                "src/utilities/disjoint_sets.cpp",
                "src/utilities/elementary_geometry.cpp",
                "src/utilities/utilities.cpp",
            ],
            flags: &[],
        },
        &[("geometry-central", "angles")],
    ),
];

/// A program of the study.
#[derive(Clone, Debug)]
pub(super) struct Program {
    pub(super) name: String,
    /// The library and its version.
    pub(super) version: String,
    /// The compiled program and its method; `None` for Python packages.
    compiled: Option<(PathBuf, &'static str)>,
}

/// A program that is not in the run.
#[derive(Clone, Debug)]
pub(super) struct Missing {
    pub(super) name: String,
    pub(super) reason: String,
}

/// All programs that run here.
pub(super) struct Peers {
    folder: PathBuf,
    python: VirtualEnvironment,
    pub(super) programs: Vec<Program>,
    pub(super) missing: Vec<Missing>,
    /// The running process; `None` before the first request and after a crash.
    process: Option<Process>,
}

impl Peers {
    const PACKAGES: [&str; 9] = [
        "dgtal==2.2.0",
        "gpytoolbox==0.3.8",
        "libigl==2.6.3",
        "numpy",
        "pymeshlab==2025.7.post1",
        "pyvista==0.49.1",
        "scipy",
        "trimesh[easy]==5.2.0",
        "trueform==0.10.7",
    ];

    /// Installs the packages, and compiles the drivers of libraries that do not run yet. `clones` is the folder with
    /// clones of libraries.
    pub(super) fn prepare(folder: &Path, clones: Option<&Path>) -> Result<Self, Failure> {
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(Failure::writing(&path))
        };
        write("peers.py", include_str!("peers.py"))?;
        write("peer.hpp", include_str!("peer.hpp"))?;
        let python = VirtualEnvironment::make(&folder.join("environment"), "python3")?;
        python.install_if_there(&Self::PACKAGES, "the study is without it");
        let mut peers = Self {
            folder: folder.to_owned(),
            python,
            programs: Vec::new(),
            missing: Vec::new(),
            process: None,
        };
        peers.find_packages()?;
        for (library, methods) in &LIBRARIES {
            peers.add_library(library, methods, clones);
        }
        Ok(peers)
    }

    fn find_packages(&mut self) -> Result<(), Failure> {
        let mut list = self.python.python();
        let list =
            command_output(list.arg(self.folder.join("peers.py"))).map_err(Failure::Usage)?;
        for line in String::from_utf8_lossy(&list).lines() {
            let (name, version) = line.split_once('\t').unwrap_or((line, ""));
            let (name, version) = (name.to_owned(), version.trim().to_owned());
            if version.is_empty() {
                let reason = "its Python package cannot be installed here".to_owned();
                self.missing.push(Missing { name, reason });
            } else {
                self.programs.push(Program { name, version, compiled: None });
            }
        }
        Ok(())
    }

    fn add_library(
        &mut self,
        library: &Library,
        methods: &[(&str, &'static str)],
        clones: Option<&Path>,
    ) {
        let headers = self.package_headers().map(|folder| vec![folder]);
        let found = headers.and_then(|headers| library.compile(&self.folder, clones, &headers));
        for &(name, method) in methods {
            let name = name.to_owned();
            match &found {
                Ok((program, version)) => {
                    let compiled = Some((program.clone(), method));
                    self.programs.push(Program {
                        name,
                        version: format!("{} {version}", library.clone),
                        compiled,
                    });
                }
                Err(reason) => {
                    self.missing.push(Missing { name, reason: reason.clone() });
                }
            }
        }
    }

    /// The folder of headers that come with Python packages.
    fn package_headers(&self) -> Result<PathBuf, String> {
        let code = "import sysconfig; print(sysconfig.get_path('purelib'))";
        let folder = command_output(self.python.python().args(["-c", code]))?;
        Ok(Path::new(String::from_utf8_lossy(&folder).trim()).join("include"))
    }

    fn process(&mut self) -> Option<&mut Process> {
        if self.process.is_none() {
            let mut command = self.python.python();
            command.arg(self.folder.join("peers.py")).arg(&self.folder);
            self.process = Some(Process::start(on_one_thread(&mut command)).ok()?);
        }
        self.process.as_mut()
    }

    /// Ends the process of the Python packages, so that the next request has a new one.
    pub(super) fn end_process(&mut self) {
        self.process = None;
    }

    /// The estimates of a program, its time and its memory. `None` if it fails.
    ///
    /// Some programs have the other sign; the sign with the smaller error counts.
    pub(super) fn estimate(
        &mut self,
        program: &Program,
        case: &Case,
    ) -> Option<(Vec<Estimate>, Cost)> {
        case.write_raw(&self.folder).ok()?;
        let radius = RADIUS * case.edge;
        let answer = if let Some((path, method)) = &program.compiled {
            let mut command = Command::new(path);
            command.arg(&self.folder).arg(method).arg(radius.to_string());
            let answer = command_output(on_one_thread(&mut command)).ok()?;
            String::from_utf8_lossy(&answer).into_owned()
        } else {
            let request = format!("{}\t{radius}", program.name);
            let Some(answer) = self.process()?.ask(&request) else {
                self.process = None;
                return None;
            };
            answer
        };
        let cost = answer.parse().ok()?;
        let values = read_numbers(&self.folder.join("out.raw")).ok()?;
        let signed = |sign: f64| -> Vec<Estimate> {
            let of = |pair: &[f64; 2]| {
                let [a, b] = pair.map(|value| sign * value);
                Estimate { principal: [a.max(b), a.min(b)], ..Estimate::UNKNOWN }
            };
            values.as_chunks::<2>().0.iter().map(of).collect()
        };
        let error = |estimates: &[Estimate]| -> f64 {
            let difference = |(estimate, exact): (&Estimate, &Exact)| {
                let [a, b] = [0, 1].map(|i| (estimate.principal[i] - exact.principal[i]).abs());
                if a.is_nan() || b.is_nan() { 0.0 } else { a.max(b).sqrt() }
            };
            estimates.iter().zip(&case.exact).map(difference).sum()
        };
        let [plus, minus] = [1.0, -1.0].map(signed);
        if plus.len() != case.exact.len() {
            return None;
        }
        let best = if error(&plus) <= error(&minus) { plus } else { minus };
        Some((best, cost))
    }
}

/// A command that computes on one thread, as far as the library lets itself be told.
fn on_one_thread(command: &mut Command) -> &mut Command {
    command
        .env("OMP_NUM_THREADS", "1")
        .env("OPENBLAS_NUM_THREADS", "1")
        .env("VTK_SMP_MAX_THREADS", "1")
}

/// The numbers of a raw array.
fn read_numbers(path: &Path) -> std::io::Result<Vec<f64>> {
    let bytes = std::fs::read(path)?;
    Ok(bytes.as_chunks().0.iter().map(|&number| f64::from_le_bytes(number)).collect())
}

impl Case {
    /// Writes vertices and faces as raw arrays.
    pub(super) fn write_raw(&self, folder: &Path) -> std::io::Result<()> {
        let topology = self.mesh.topology();
        let numbers = self.mesh.positions().iter().flat_map(DVec3::to_array);
        let numbers: Vec<u8> = numbers.flat_map(f64::to_le_bytes).collect();
        std::fs::write(folder.join("vertices.raw"), numbers)?;
        let corners = topology.faces().flat_map(|face| topology.face_vertices(face));
        let corners: Vec<u8> = corners.flat_map(|v| (v.index() as u32).to_le_bytes()).collect();
        std::fs::write(folder.join("faces.raw"), corners)
    }
}
