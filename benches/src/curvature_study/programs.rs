//! The other programs of the study: Python packages, and libraries with a driver that is compiled here.

use std::path::{Path, PathBuf};
use std::process::Command;

use glam::DVec3;
use xtask_common::{Failure, VirtualEnvironment};

use super::case::{Case, Estimate};
use super::cost::Cost;
use super::surfaces::Exact;
use crate::command_output::command_output;
use crate::process::Process;

/// The radius of averages over balls, in mean edges.
pub(super) const RADIUS: f64 = 3.0;

/// A library that is compiled with its driver.
struct Library {
    /// The name of the compiled program.
    name: &'static str,
    driver: (&'static str, &'static str),
    /// The folder of the library in `--clones`, and whether there are other places to look for it.
    clone: &'static str,
    is_required: bool,
    /// Folders of headers and sources in the clone.
    headers: &'static [&'static str],
    sources: &'static [&'static str],
    flags: &'static [&'static str],
    /// Names of programs in the tables, and the methods of the driver.
    methods: &'static [(&'static str, &'static str)],
}

const CGAL: (&str, &str) = ("cgal_curvature.cpp", include_str!("cgal_curvature.cpp"));

const LIBRARIES: [Library; 5] = [
    Library {
        name: "cgal-corrected",
        driver: CGAL,
        clone: "cgal",
        is_required: false,
        headers: &["include"],
        sources: &[],
        flags: &["-DPEER_CORRECTED", "-lgmp", "-lmpfr"],
        methods: &[("CGAL, corrected", "ball"), ("CGAL, corrected, star", "star")],
    },
    Library {
        name: "cgal-jets",
        driver: CGAL,
        clone: "cgal",
        is_required: false,
        headers: &["include"],
        sources: &[],
        flags: &["-DPEER_JETS", "-lgmp", "-lmpfr"],
        methods: &[("CGAL, jets 2, 2 rings", "2-2"), ("CGAL, jets 4, 3 rings", "4-3")],
    },
    Library {
        name: "dgtal",
        driver: ("dgtal_curvature.cpp", include_str!("dgtal_curvature.cpp")),
        clone: "DGtal",
        is_required: false,
        headers: &["src"],
        sources: &[],
        flags: &[],
        methods: &[("DGtal", "ball")],
    },
    Library {
        name: "pmp",
        driver: ("pmp_curvature.cpp", include_str!("pmp_curvature.cpp")),
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
        methods: &[("pmp", "operators"), ("pmp, tensor", "tensor")],
    },
    Library {
        name: "geometry-central",
        driver: ("geometry_central_curvature.cpp", include_str!("geometry_central_curvature.cpp")),
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
        methods: &[("geometry-central", "angles")],
    },
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
        for library in &LIBRARIES {
            write(library.driver.0, library.driver.1)?;
            peers.add_library(library, clones);
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

    fn add_library(&mut self, library: &Library, clones: Option<&Path>) {
        let found = self.compile(library, clones);
        for &(name, method) in library.methods {
            let name = name.to_owned();
            match &found {
                Ok((program, version)) => {
                    let compiled = Some((program.clone(), method));
                    self.programs.push(Program { name, version: version.clone(), compiled });
                }
                Err(reason) => {
                    self.missing.push(Missing { name, reason: reason.clone() });
                }
            }
        }
    }

    /// The compiled program and the version of its library, or the reason why there is none.
    fn compile(
        &self,
        library: &Library,
        clones: Option<&Path>,
    ) -> Result<(PathBuf, String), String> {
        let program = self.folder.join(library.name);
        let clone = clones.map(|clones| clones.join(library.clone)).filter(|clone| clone.exists());
        if !program.exists() {
            if library.is_required && clone.is_none() {
                return Err(format!(
                    "it has no package; give a folder with a clone `{}` with `--clones`",
                    library.clone
                ));
            }
            let mut compiler = Command::new("c++");
            compiler.args(["-O2", "-DNDEBUG", "-std=c++20", "-w", "-I"]).arg(&self.folder);
            if let Some(clone) = &clone {
                for headers in library.headers {
                    compiler.arg("-I").arg(clone.join(headers));
                }
                compiler.args(library.sources.iter().map(|source| clone.join(source)));
                compiler.arg(format!("-DPEER_VERSION=\"{}\"", commit(clone)));
            }
            compiler.arg("-I").arg(self.package_headers()?).arg("-I/usr/include/eigen3");
            compiler.arg(self.folder.join(library.driver.0)).arg("-o").arg(&program);
            compiler.args(library.flags);
            command_output(&mut compiler).map_err(|_| {
                let what = library.clone;
                format!("its driver does not compile here: it needs a C++ 20 compiler, Eigen and headers of {what}")
            })?;
        }
        let version = command_output(Command::new(&program).arg("--version"))?;
        let version = format!("{} {}", library.clone, String::from_utf8_lossy(&version).trim());
        Ok((program, version))
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

/// The commit of a clone, or `unknown`.
fn commit(clone: &Path) -> String {
    let mut git = Command::new("git");
    git.arg("-C").arg(clone).args(["rev-parse", "--short=12", "HEAD"]);
    let found = command_output(&mut git).unwrap_or_default();
    let found = String::from_utf8_lossy(&found).trim().to_owned();
    if found.is_empty() { "unknown".to_owned() } else { found }
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
