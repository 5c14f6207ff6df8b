//! The environment of the peers: a virtual environment of Python, packages of npm, compiled programs, and this program
//! itself.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::drivers::{DRIVERS, Driver, Runs};
use super::job::{Done, Job, Stop};
use super::tool::Tool;
use crate::command_output::{on_cores, succeed};
use crate::process::Process;
use crate::raw_mesh::RawMesh;
use crate::timing::Cost;
use xtask_common::{Failure, VirtualEnvironment};

/// The files that are written to the folder and run or included there.
const SOURCES: [(&str, &str); 4] = [
    ("simplify.py", include_str!("drivers/simplify.py")),
    ("gltf.mjs", include_str!("drivers/gltf.mjs")),
    ("raw.hpp", include_str!("drivers/raw.hpp")),
    ("errors.py", include_str!("errors.py")),
];

/// The packages of npm that `gltf.mjs` imports.
const NODE_PACKAGES: [&str; 4] =
    ["@gltf-transform/core", "@gltf-transform/functions", "gltfpack", "meshoptimizer"];

/// The folder with everything in it.
#[derive(Debug)]
pub(super) struct Environment {
    folder: PathBuf,
    python: VirtualEnvironment,
    /// The drivers with what is needed to run them, or the reason why that is missing.
    ready: Vec<(&'static Driver, Result<Ready, String>)>,
    /// The running programs of tools that answer requests.
    servers: RefCell<BTreeMap<String, Process>>,
}

/// A driver that can run.
#[derive(Clone, Debug)]
struct Ready {
    /// The program, and its first argument.
    program: PathBuf,
    script: Option<PathBuf>,
    /// Of the package or library, if it can be had.
    version: Option<String>,
}

impl Environment {
    /// Makes the parts that do not exist yet. `clones` has clones of libraries; `wanted` are the tools of this run.
    pub(super) fn prepare(
        folder: &Path,
        clones: Option<&Path>,
        wanted: &[Tool],
    ) -> Result<Self, Failure> {
        for (name, text) in SOURCES {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(Failure::writing(&path))?;
        }
        let mut environment = Self {
            folder: folder.to_owned(),
            python: VirtualEnvironment::make(&folder.join("environment"), "python3")?,
            ready: Vec::new(),
            servers: RefCell::default(),
        };
        environment.install()?;
        let others = wanted.iter().filter_map(|tool| match tool {
            Tool::Other(driver) => Some(*driver),
            _ => None,
        });
        environment.ready =
            others.map(|driver| (driver, environment.find(driver, clones))).collect();
        Ok(environment)
    }

    /// Installs the packages once, and again if this program knows other ones. `Open3D` and numpy also measure.
    fn install(&self) -> Result<(), Failure> {
        let mut names = vec!["numpy"];
        names.extend(DRIVERS.iter().filter_map(|driver| match driver.runs {
            Runs::Python { package, .. } => Some(package),
            _ => None,
        }));
        names.dedup();
        let note = self.folder.join("packages.txt");
        let text = [&names[..], &NODE_PACKAGES].concat().join("\n");
        if std::fs::read_to_string(&note).is_ok_and(|old| old == text) {
            return Ok(());
        }
        println!("installing the peers in {}", self.folder.display());
        self.python.install_if_there(&names, "the table is without it");
        if !self.imports("open3d") {
            return Err(Failure::Usage("without open3d nothing can be measured".into()));
        }
        let mut npm = Command::new("npm");
        npm.args(["install", "--silent", "--no-audit", "--no-fund"]).args(NODE_PACKAGES);
        if let Err(why) = succeed(npm.current_dir(&self.folder)) {
            println!("npm cannot install its packages: {why}; the tables are without them");
        }
        std::fs::write(&note, text).map_err(Failure::writing(&note))
    }

    fn imports(&self, module: &str) -> bool {
        let import =
            format!("import importlib.util as u, sys; sys.exit(not u.find_spec('{module}'))");
        succeed(self.python.python().args(["-c", &import])).is_ok()
    }

    /// What a driver needs to run.
    fn find(&self, driver: &Driver, clones: Option<&Path>) -> Result<Ready, String> {
        match driver.runs {
            Runs::Python { package, module } if self.imports(module) => Ok(Ready {
                program: self.python.program("python"),
                script: Some(self.folder.join("simplify.py")),
                version: self.python_version(package),
            }),
            Runs::Python { .. } => Err("its package could not be installed".into()),
            Runs::Node { package } => {
                let about = self.folder.join("node_modules").join(package).join("package.json");
                let about = std::fs::read_to_string(about)
                    .map_err(|_| "its package of npm could not be installed".to_owned())?;
                let about: serde_json::Value =
                    serde_json::from_str(&about).map_err(|e| e.to_string())?;
                let version = about.get("version").and_then(serde_json::Value::as_str);
                Ok(Ready {
                    program: "node".into(),
                    script: Some(self.folder.join("gltf.mjs")),
                    version: version.map(str::to_owned),
                })
            }
            Runs::Compiled(library) => {
                let (program, version) = library.compile(&self.folder, clones, &[])?;
                Ok(Ready { program, script: None, version: Some(version) })
            }
            Runs::Here if cfg!(not(feature = "meshopt")) => {
                Err("run with `cargo run --release -p benches --features meshopt -- peers`".into())
            }
            Runs::Here => Ok(Ready {
                program: std::env::current_exe().map_err(|e| e.to_string())?,
                script: Some("peer-job".into()),
                version: locked_version(include_str!("../../../Cargo.lock"), "meshopt"),
            }),
        }
    }

    /// The version of a package. `Open3D` has a second package, which runs without a graphics card.
    fn python_version(&self, package: &str) -> Option<String> {
        let ask = |name: &str| {
            let code = format!("import importlib.metadata as m; print(m.version('{name}'))");
            succeed(self.python.python().args(["-c", &code])).ok()
        };
        let answer = ask(package).or_else(|| ask(&format!("{package}-cpu")))?;
        Some(answer.trim().to_owned())
    }

    fn ready(&self, driver: &Driver) -> Result<&Ready, String> {
        let found = self.ready.iter().find(|(other, _)| *other == driver);
        let (_, ready) = found.ok_or_else(|| format!("{} is not prepared", driver.name))?;
        ready.as_ref().map_err(Clone::clone)
    }

    /// The reason why a tool is missing.
    pub(super) fn lacks(&self, tool: &Tool) -> Option<String> {
        let Tool::Other(driver) = tool else { return None };
        self.ready(driver).err()
    }

    /// The version of a tool, if it can be had.
    pub(super) fn version(&self, tool: &Tool) -> Option<String> {
        match tool {
            Tool::Ours(_) | Tool::OursProved(_) => Some(env!("CARGO_PKG_VERSION").into()),
            Tool::OurProgram { program, .. } => {
                let answer = succeed(Command::new(program).arg("--version")).ok()?;
                Some(answer.split_whitespace().last()?.to_owned())
            }
            Tool::Other(driver) => self.ready(driver).ok()?.version.clone(),
        }
    }

    /// Runs a tool.
    pub(super) fn run(&self, job: &Job) -> Result<Done, String> {
        let (program, script) = match &job.tool {
            Tool::OurProgram { program, preset, .. } => {
                return self.run_our_program(job, program, preset);
            }
            Tool::Ours(_) | Tool::OursProved(_) => {
                let program = std::env::current_exe().map_err(|e| e.to_string())?;
                (program, Some("peer-job".into()))
            }
            Tool::Other(driver) => {
                let Ready { program, script, .. } = self.ready(driver)?.clone();
                (program, script)
            }
        };
        let mut command = on_cores(job.threads, &program, &self.folder);
        command.args(script).arg(job.tool.to_string());
        let [kind, value] = job.target.arguments();
        let [threads, repeats] = [job.threads, job.repeats].map(|number| number.to_string());
        let files = [&job.input, &job.output].map(|path| path.display().to_string());
        let [input, output] = files;
        let arguments = [kind, value, threads, repeats, input, output];
        if let Tool::Other(Driver { runs: Runs::Python { .. }, .. }) = job.tool {
            return self.ask(&job.tool, &mut command, &arguments.join("\t"));
        }
        succeed(command.args(arguments))?.parse()
    }

    /// Asks a program that answers requests; it is started if it does not run.
    fn ask(&self, tool: &Tool, command: &mut Command, request: &str) -> Result<Done, String> {
        let mut servers = self.servers.borrow_mut();
        let server = match servers.entry(tool.to_string()) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                entry.insert(Process::start(command).map_err(|e| e.to_string())?)
            }
        };
        let Some(answer) = server.ask(request) else {
            servers.remove(&tool.to_string());
            return Err("its process has ended".into());
        };
        match answer.trim().strip_prefix("failed: ") {
            Some(why) => Err(why.to_owned()),
            None => answer.parse(),
        }
    }

    /// Another build of our program reads and writes files, but reports its time without them.
    fn run_our_program(&self, job: &Job, program: &Path, preset: &str) -> Result<Done, String> {
        let [input, output] = ["input.ply", "output.ply"].map(|name| self.folder.join(name));
        let mesh = RawMesh::read(&job.input).and_then(|raw| raw.to_mesh());
        let mesh = mesh.map_err(|e| e.to_string())?;
        let options = mesh_io::WriteOptions::default();
        mesh_io::write(&input, &mesh, &options).map_err(|e| e.to_string())?;
        let mut seconds = f64::INFINITY;
        let mut faces = 0;
        for _ in 0..job.repeats {
            let mut command = on_cores(job.threads, program, &self.folder);
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

#[cfg(test)]
mod tests {
    use super::locked_version;

    #[test]
    fn versions_are_read_from_lock_files() {
        let lock = include_str!("../../../Cargo.lock");
        assert_eq!(locked_version(lock, "benches").as_deref(), Some(env!("CARGO_PKG_VERSION")));
        assert!(locked_version(lock, "meshopt").is_some());
        assert_eq!(locked_version(lock, "no such crate"), None);
    }
}
