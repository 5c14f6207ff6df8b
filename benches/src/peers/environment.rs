//! The environment of the peers: a virtual environment, a compiled program, and this program itself.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::job::{Cost, Done, Job, Stop};
use super::raw::RawMesh;
use super::tool::{Package, Tool};
use crate::command_output::command_output;
use xtask_common::{Failure, VirtualEnvironment};

/// The programs that are written to the folder and run there.
const SOURCES: [(&str, &str); 3] = [
    ("simplify.py", include_str!("simplify.py")),
    ("errors.py", include_str!("errors.py")),
    ("cgal.cpp", include_str!("cgal.cpp")),
];

/// The folder with everything in it.
#[derive(Debug)]
pub(super) struct Environment {
    folder: PathBuf,
    python: VirtualEnvironment,
    /// The packages that can be imported.
    packages: Vec<Package>,
    /// The program with CGAL, or the reason why it is missing.
    cgal: Result<PathBuf, String>,
}

impl Environment {
    /// Makes the parts that do not exist yet.
    pub(super) fn prepare(folder: &Path) -> Result<Self, Failure> {
        for (name, text) in SOURCES {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(Failure::writing(&path))?;
        }
        let mut environment = Self {
            folder: folder.to_owned(),
            python: VirtualEnvironment::make(&folder.join("environment"), "python3")?,
            packages: Vec::new(),
            cgal: Err(String::new()),
        };
        environment.install()?;
        environment.packages = Package::ALL
            .into_iter()
            .filter(|package| environment.imports(package.module()))
            .collect();
        environment.cgal = environment.compile_cgal();
        Ok(environment)
    }

    /// Installs the packages once, and again if this program knows other ones. `Open3D` and numpy also measure.
    fn install(&self) -> Result<(), Failure> {
        let mut names = vec!["numpy"];
        names.extend(Package::ALL.map(Package::distribution));
        names.dedup();
        let note = self.python.folder.join("packages.txt");
        let text = names.join("\n");
        if std::fs::read_to_string(&note).is_ok_and(|old| old == text) {
            return Ok(());
        }
        println!("installing the peers in {}", self.folder.display());
        self.python.install_if_there(&names, "the table is without it");
        if !self.imports("open3d") {
            return Err(Failure::Usage("without open3d nothing can be measured".into()));
        }
        std::fs::write(&note, text).map_err(Failure::writing(&note))
    }

    fn imports(&self, module: &str) -> bool {
        let import =
            format!("import importlib.util as u, sys; sys.exit(not u.find_spec('{module}'))");
        succeed(self.python.python().args(["-c", &import])).is_ok()
    }

    fn compile_cgal(&self) -> Result<PathBuf, String> {
        let program = self.folder.join("cgal");
        let mut compiler = Command::new("c++");
        compiler
            .args(["-O3", "-DNDEBUG", "-std=c++17", "-I/usr/include/eigen3"])
            .arg(self.folder.join("cgal.cpp"))
            .arg("-o")
            .arg(&program)
            .args(["-lgmp", "-lmpfr"]);
        if !program.exists() {
            succeed(&mut compiler).map_err(|_| {
                "it does not compile here: it needs a C++ compiler, CGAL and Eigen".to_owned()
            })?;
        }
        Ok(program)
    }

    /// The reason why a tool is missing.
    pub(super) fn lacks(&self, tool: &Tool) -> Option<String> {
        match tool {
            Tool::Meshopt if cfg!(not(feature = "meshopt")) => {
                Some("run with `cargo run --release -p benches --features meshopt -- peers`".into())
            }
            Tool::CgalLindstromTurk | Tool::CgalGarlandHeckbert => self.cgal.clone().err(),
            Tool::Python(package) if !self.packages.contains(package) => {
                Some("its package could not be installed".into())
            }
            _ => None,
        }
    }

    /// The version of a tool, if it can be had.
    pub(super) fn version(&self, tool: &Tool) -> Option<String> {
        match tool {
            Tool::Ours(_) | Tool::OursProved(_) => Some(env!("CARGO_PKG_VERSION").into()),
            Tool::OurProgram { program, .. } => {
                let answer = succeed(Command::new(program).arg("--version")).ok()?;
                Some(answer.split_whitespace().last()?.to_owned())
            }
            Tool::Meshopt => locked_version(include_str!("../../../Cargo.lock"), "meshopt"),
            Tool::CgalLindstromTurk | Tool::CgalGarlandHeckbert => {
                let header = std::fs::read_to_string("/usr/include/CGAL/version.h").ok()?;
                defined(&header, "CGAL_VERSION")
            }
            Tool::Python(package) => {
                // Open3D has a second package, which runs without a graphics card.
                let ask = |name: &str| {
                    let code =
                        format!("import importlib.metadata as m; print(m.version('{name}'))");
                    succeed(self.python.python().args(["-c", &code])).ok()
                };
                let name = package.distribution();
                let answer = ask(name).or_else(|| ask(&format!("{name}-cpu")))?;
                Some(answer.trim().to_owned())
            }
        }
    }

    /// Runs a tool.
    pub(super) fn run(&self, job: &Job) -> Result<Done, String> {
        let [kind, value] = job.target.arguments();
        let numbers = [kind, value, job.threads.to_string(), job.repeats.to_string()];
        let mut command = self.on_cores(job.threads, &self.program(job)?);
        match &job.tool {
            Tool::OurProgram { preset, .. } => return self.run_our_program(job, preset),
            Tool::Ours(_) | Tool::OursProved(_) | Tool::Meshopt => {
                command.arg("peer-job").arg(job.tool.to_string()).args(&numbers);
            }
            Tool::Python(package) => {
                command.arg(self.folder.join("simplify.py")).arg(package.name()).args(&numbers);
            }
            Tool::CgalLindstromTurk => drop(command.arg("lindstrom-turk").args(&numbers)),
            Tool::CgalGarlandHeckbert => drop(command.arg("garland-heckbert").args(&numbers)),
        }
        command.arg(&job.input).arg(&job.output);
        succeed(&mut command)?.parse()
    }

    fn program(&self, job: &Job) -> Result<PathBuf, String> {
        match &job.tool {
            Tool::Ours(_) | Tool::OursProved(_) | Tool::Meshopt => {
                std::env::current_exe().map_err(|e| e.to_string())
            }
            Tool::OurProgram { program, .. } => Ok(program.clone()),
            Tool::Python(_) => Ok(self.python.program("python")),
            Tool::CgalLindstromTurk | Tool::CgalGarlandHeckbert => self.cgal.clone(),
        }
    }

    /// Another build of our program reads and writes files, but reports its time without them.
    fn run_our_program(&self, job: &Job, preset: &str) -> Result<Done, String> {
        let [input, output] = ["input.ply", "output.ply"].map(|name| self.folder.join(name));
        let mesh = RawMesh::read(&job.input).and_then(|raw| raw.to_mesh());
        let mesh = mesh.map_err(|e| e.to_string())?;
        let options = mesh_io::WriteOptions::default();
        mesh_io::write(&input, &mesh, &options).map_err(|e| e.to_string())?;
        let mut seconds = f64::INFINITY;
        let mut faces = 0;
        for _ in 0..job.repeats {
            let mut command = self.on_cores(job.threads, &self.program(job)?);
            command.arg("simplify").arg(&input).arg("-o").arg(&output);
            match job.target {
                Stop::Faces(faces) => drop(command.arg("--faces").arg(faces.to_string())),
                Stop::Error(distance) => {
                    command.arg("--max-error").arg(distance.to_string());
                }
            }
            command.args(["--preset", preset, "--threads", &job.threads.to_string(), "--json"]);
            let report: serde_json::Value =
                serde_json::from_str(&succeed(&mut command)?).map_err(|e| e.to_string())?;
            let took = report.pointer("/seconds/compute").and_then(serde_json::Value::as_f64);
            seconds = seconds.min(took.ok_or("the report does not tell the time")?);
            let read = RawMesh::from_file(&output).map_err(|e| e.to_string())?;
            faces = read.triangles.len();
            read.write(&job.output).map_err(|e| e.to_string())?;
        }
        Ok(Done { faces, cost: Cost { seconds, cpu: None, peak: None } })
    }

    /// A command that is restricted to some cores, if the system supports it.
    fn on_cores(&self, threads: usize, program: &Path) -> Command {
        let has_taskset = succeed(Command::new("taskset").arg("--version")).is_ok();
        let mut command = if has_taskset {
            let mut command = Command::new("taskset");
            command.args(["-c", &format!("0-{}", threads.max(1) - 1)]).arg(program);
            command
        } else {
            Command::new(program)
        };
        command.env("OMP_NUM_THREADS", threads.to_string()).current_dir(&self.folder);
        command
    }

    /// A command that runs a script of the folder.
    pub(super) fn script(&self, name: &str, arguments: &[&OsStr]) -> Command {
        let mut command = self.python.python();
        command.arg(self.folder.join(name)).args(arguments);
        command
    }
}

/// The version of a crate in a lock file.
fn locked_version(lock: &str, name: &str) -> Option<String> {
    let heading = format!("name = \"{name}\"");
    let mut lines = lock.lines().skip_while(|line| *line != heading);
    let version = lines.nth(1)?.strip_prefix("version = \"")?.strip_suffix('"')?;
    Some(version.to_owned())
}

/// The text that a header defines a name as.
fn defined(header: &str, name: &str) -> Option<String> {
    let words = header.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    words.into_iter().find_map(|words| match words[..] {
        ["#define", defined, value] if defined == name => Some(value.to_owned()),
        _ => None,
    })
}

/// The text that a command prints, or the last line of its error messages.
fn succeed(command: &mut Command) -> Result<String, String> {
    Ok(String::from_utf8_lossy(&command_output(command)?).into_owned())
}

#[cfg(test)]
mod tests {
    use super::{defined, locked_version};

    #[test]
    fn versions_are_read_from_lock_files_and_headers() {
        let lock = include_str!("../../../Cargo.lock");
        assert_eq!(locked_version(lock, "benches").as_deref(), Some(env!("CARGO_PKG_VERSION")));
        assert!(locked_version(lock, "meshopt").is_some());
        assert_eq!(locked_version(lock, "no such crate"), None);
        let header = "#define CGAL_VERSION_NR 1060101000\n#define CGAL_VERSION 6.1\n";
        assert_eq!(defined(header, "CGAL_VERSION").as_deref(), Some("6.1"));
        assert_eq!(defined(header, "CGAL"), None);
    }
}
