//! The environment of the tools: a virtual environment, a compiled program, and this program itself.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::str::FromStr;
use std::time::Duration;

use xtask_common::{Failure, VirtualEnvironment};

use super::record::{Outcome, Record};
use super::tool::{Kind, Program, Tool};
use crate::command_output::{defined, on_cores, output_within, succeed};
use crate::machine::{self, Machine};
use crate::timing::Cost;

/// The programs that are written to the folder and run there.
const SOURCES: [(&str, &str); 5] = [
    ("simplify.py", include_str!("../peers/drivers/simplify.py")),
    ("errors.py", include_str!("../peers/errors.py")),
    ("flips.py", include_str!("flips.py")),
    ("distances.py", include_str!("distances.py")),
    ("cgal_distances.cpp", include_str!("cgal_distances.cpp")),
];

/// What a driver prints: seconds, seconds of the core, bytes beyond the input, and results. A dash is an unknown value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Answer {
    pub(super) cost: Cost,
    pub(super) results: Vec<Option<f64>>,
}

impl FromStr for Answer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let line = text.lines().last().unwrap_or_default();
        let mut words = line.split_whitespace();
        let mut next = || words.next();
        let seconds = next().and_then(|word| word.parse().ok());
        let seconds = seconds.ok_or_else(|| format!("no answer but {line:?}"))?;
        let cpu = next().and_then(|word| word.parse().ok());
        let peak = next().and_then(|word| word.parse().ok());
        let results = words.map(|word| word.parse().ok()).collect();
        Ok(Self { cost: Cost { seconds, cpu, peak }, results })
    }
}

impl std::fmt::Display for Answer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        fn told<T: ToString>(known: Option<T>) -> String {
            known.map_or_else(|| "-".to_owned(), |value| value.to_string())
        }
        write!(f, "{} {} {}", self.cost.seconds, told(self.cost.cpu), told(self.cost.peak))?;
        self.results.iter().try_for_each(|&result| write!(f, " {}", told(result)))
    }
}

/// The folder with everything in it, and how jobs are run.
#[derive(Debug)]
pub(super) struct Environment {
    pub(super) folder: PathBuf,
    pub(super) python: VirtualEnvironment,
    /// The program with CGAL, or the reason why it is missing.
    cgal: Result<PathBuf, String>,
    machine: Machine,
    pub(super) repeats: usize,
    pub(super) limit_seconds: u64,
}

impl Environment {
    /// Makes the parts that do not exist yet, for these tools only, and leaves out the tools that cannot be had.
    pub(super) fn prepare(
        folder: &Path,
        tools: &mut Vec<&'static Tool>,
        repeats: usize,
        limit_seconds: u64,
    ) -> Result<Self, Failure> {
        std::fs::create_dir_all(folder).map_err(Failure::writing(folder))?;
        let folder = std::path::absolute(folder).map_err(Failure::writing(folder))?;
        for (name, text) in SOURCES {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(Failure::writing(&path))?;
        }
        let python = VirtualEnvironment { folder: folder.join("environment") };
        let cgal = Err("it is not asked for".to_owned());
        let machine = Machine::this();
        let mut environment = Self { folder, python, cgal, machine, repeats, limit_seconds };
        environment.install(tools)?;
        if tools.iter().any(|tool| tool.program == Program::Cgal) {
            environment.cgal = environment.compile_cgal();
        }
        tools.retain(|tool| {
            let lacks = environment.lacks(tool);
            if let Some(why) = &lacks {
                println!("without {}: {why}", tool.name);
            }
            lacks.is_none()
        });
        Ok(environment)
    }

    /// Installs the packages of the tools that cannot be imported yet. Nothing is installed for our own tools.
    fn install(&mut self, tools: &[&Tool]) -> Result<(), Failure> {
        let packages = tools.iter().filter_map(|tool| match tool.program {
            Program::Python(package) => Some(package),
            _ => None,
        });
        let packages: Vec<_> = packages.collect();
        if packages.is_empty() {
            return Ok(());
        }
        self.python = VirtualEnvironment::make(&self.python.folder, "python3")?;
        let missing = packages.iter().filter(|package| !self.imports(package.module));
        let mut names: Vec<&str> = missing.map(|package| package.requirement).collect();
        if !self.imports("numpy") {
            names.push("numpy");
        }
        names.sort_unstable();
        names.dedup();
        if !names.is_empty() {
            println!("installing {} in {}", names.join(", "), self.folder.display());
            self.python.install_if_there(&names, "the table is without it");
        }
        Ok(())
    }

    fn imports(&self, module: &str) -> bool {
        let import =
            format!("import importlib.util as u, sys; sys.exit(not u.find_spec('{module}'))");
        succeed(self.python.python().args(["-c", &import])).is_ok()
    }

    fn compile_cgal(&self) -> Result<PathBuf, String> {
        let program = self.folder.join("cgal_distances");
        if !program.exists() {
            let mut compiler = Command::new("c++");
            compiler
                .args(["-O3", "-DNDEBUG", "-std=c++17", "-w", "-I/usr/include/eigen3"])
                .arg(self.folder.join("cgal_distances.cpp"))
                .arg("-o")
                .arg(&program)
                .args(["-lgmp", "-lmpfr"]);
            succeed(&mut compiler).map_err(|_| {
                "it does not compile here: it needs a C++ compiler, CGAL 5.5 and Eigen".to_owned()
            })?;
        }
        Ok(program)
    }

    /// The reason why a tool is missing.
    fn lacks(&self, tool: &Tool) -> Option<String> {
        match tool.program {
            Program::Ours => None,
            Program::Cgal => self.cgal.clone().err(),
            Program::Python(package) => (!self.imports(package.module))
                .then(|| format!("{} could not be installed", package.requirement)),
        }
    }

    /// The version of a tool, if it can be had.
    fn version(&self, tool: &Tool) -> Option<String> {
        match tool.program {
            Program::Ours => Some(env!("CARGO_PKG_VERSION").to_owned()),
            Program::Cgal => {
                let header = std::fs::read_to_string("/usr/include/CGAL/version.h").ok()?;
                defined(&header, "CGAL_VERSION")
            }
            Program::Python(package) => {
                let name = package.distribution();
                let code = format!("import importlib.metadata as m; print(m.version('{name}'))");
                let answer = succeed(self.python.python().args(["-c", &code])).ok()?;
                Some(answer.trim().to_owned())
            }
        }
    }

    /// Runs a job on one core, and returns its record. `values` measures the result.
    pub(super) fn record<J, V>(
        &self,
        tool: &Tool,
        job: J,
        value: Option<f64>,
        files: [&Path; 2],
        values: impl FnOnce(&Answer) -> Result<V, String>,
    ) -> Record<J, V> {
        let load = machine::load();
        let run = || {
            let answer = self.run(tool, value, files)?;
            Ok(Outcome { cost: answer.cost, values: values(&answer)? })
        };
        let outcome: Result<_, String> = run();
        Record {
            tool: tool.name.to_owned(),
            version: self.version(tool),
            job,
            repeats: self.repeats,
            limit_seconds: self.limit_seconds,
            machine: self.machine.clone(),
            load,
            failure: outcome.as_ref().err().cloned(),
            outcome: outcome.ok(),
        }
    }

    fn run(&self, tool: &Tool, value: Option<f64>, files: [&Path; 2]) -> Result<Answer, String> {
        let mut command = match tool.program {
            Program::Ours => {
                let own = std::env::current_exe().map_err(|e| e.to_string())?;
                let mut command = on_cores(1, &own, &self.folder);
                command.arg("rival-job");
                command
            }
            Program::Cgal => on_cores(1, self.cgal.as_ref()?, &self.folder),
            Program::Python(_) => {
                let mut command = on_cores(1, &self.python.program("python"), &self.folder);
                command.arg(match tool.kind {
                    Kind::Flips => "flips.py",
                    Kind::Distances => "distances.py",
                });
                command
            }
        };
        let value = value.map_or_else(|| "-".to_owned(), |value| value.to_string());
        command.args([tool.method, &value, &self.repeats.to_string()]).args(files);
        output_within(&mut command, Duration::from_secs(self.limit_seconds))?.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::{Answer, Cost};

    #[test]
    fn an_answer_survives_the_way_through_the_text() {
        for (cpu, peak, results) in [
            (None, None, vec![]),
            (Some(0.5), Some(7), vec![Some(0.25), None]),
            (Some(0.5), None, vec![None, Some(1.0)]),
        ] {
            let answer = Answer { cost: Cost { seconds: 0.25, cpu, peak }, results };
            assert_eq!(format!("noise\n{answer}\n").parse(), Ok(answer));
        }
        assert!("nothing".parse::<Answer>().is_err());
    }
}
