//! Drivers in C++, which are compiled here with the headers and some sources of a library.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command_output::command_output;

/// A library that is compiled with its driver.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Library {
    /// The name of the compiled program.
    pub(crate) name: &'static str,
    /// The source of the driver. With `--version` it prints the version of the library. The version of a clone is its
    /// commit, as the macro `PEER_VERSION`.
    pub(crate) driver: &'static str,
    /// The folder of the library among the clones, and whether there are other places to look for it.
    pub(crate) clone: &'static str,
    pub(crate) is_required: bool,
    /// Folders of headers and sources in the clone.
    pub(crate) headers: &'static [&'static str],
    pub(crate) sources: &'static [&'static str],
    pub(crate) flags: &'static [&'static str],
}

impl Library {
    /// The compiled program and the version of its library, or the reason why there is none. `folder` has the program
    /// and the headers of drivers, `clones` the clones of libraries, `headers` more headers.
    pub(crate) fn compile(
        &self,
        folder: &Path,
        clones: Option<&Path>,
        headers: &[PathBuf],
    ) -> Result<(PathBuf, String), String> {
        let program = folder.join(self.name);
        let source = program.with_extension("cpp");
        let is_same = std::fs::read_to_string(&source).is_ok_and(|old| old == self.driver);
        if !is_same {
            std::fs::write(&source, self.driver)
                .map_err(|e| format!("{}: {e}", source.display()))?;
        }
        let clone = clones.map(|clones| clones.join(self.clone)).filter(|clone| clone.exists());
        if !is_same || !program.exists() {
            if self.is_required && clone.is_none() {
                return Err(format!(
                    "it has no package; give a folder with a clone `{}` with `--clones`",
                    self.clone
                ));
            }
            let mut compiler = Command::new("c++");
            compiler.args(["-O2", "-DNDEBUG", "-std=c++20", "-w", "-I"]).arg(folder);
            if let Some(clone) = &clone {
                for headers in self.headers {
                    compiler.arg("-I").arg(clone.join(headers));
                }
                compiler.args(self.sources.iter().map(|source| clone.join(source)));
                compiler.arg(format!("-DPEER_VERSION=\"{}\"", commit(clone)));
            }
            for headers in headers {
                compiler.arg("-I").arg(headers);
            }
            compiler.arg("-I/usr/include/eigen3").arg(source).arg("-o").arg(&program);
            compiler.args(self.flags);
            command_output(&mut compiler).map_err(|_| {
                let what = self.clone;
                format!("its driver does not compile here: it needs a C++ 20 compiler, Eigen and headers of {what}")
            })?;
        }
        let version = command_output(Command::new(&program).arg("--version"))?;
        Ok((program, String::from_utf8_lossy(&version).trim().to_owned()))
    }
}

/// The commit of a clone, or `unknown`.
fn commit(clone: &Path) -> String {
    let mut git = Command::new("git");
    git.arg("-C").arg(clone).args(["rev-parse", "--short=12", "HEAD"]);
    let found = command_output(&mut git).unwrap_or_default();
    let found = String::from_utf8_lossy(&found).trim().to_owned();
    if found.is_empty() { "unknown".to_owned() } else { found }
}
