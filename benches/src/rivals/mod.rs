//! Flips and Hausdorff distances beside those of other programs: `benches flips` and `benches distances`.
//!
//! The jobs are data, in `benches/rivals.toml`. A tool is a driver: it reads meshes, does one job several times on one
//! core, and prints its least time, its memory and its result. Each job is a process of its own, which is ended at a
//! limit. The record has a JSON line for each job. The tables of a page are made from it.

mod distances;
mod environment;
mod flips;
mod job;
mod record;
mod sets;
mod source;
mod tool;

use std::path::{Path, PathBuf};

use xtask_common::Failure;

pub(crate) use distances::{Distances, run as run_distances};
pub(crate) use flips::{Flips, run as run_flips};
pub(crate) use job::{RivalJob, run as run_job};
use tool::{Kind, Tool};

use crate::marked_page;

/// Options of both commands.
#[derive(Clone, Debug, clap::Args)]
struct Common {
    /// The folder with the meshes
    #[arg(long, value_name = "DIR", env = "CURVMESH_MODELS", default_value = "meshes")]
    models: PathBuf,
    /// Instead of the tools of the set, these
    #[arg(long, value_name = "TOOL", value_delimiter = ',')]
    tools: Vec<String>,
    /// Runs whose least time counts; fewer where one takes long
    #[arg(long, value_name = "N")]
    repeats: Option<u64>,
    /// End jobs that take longer
    #[arg(long, value_name = "SECONDS")]
    limit: Option<u64>,
    /// The folder for the environment, the record and the tables
    #[arg(long, value_name = "DIR", default_value = "target/rivals")]
    out: PathBuf,
    /// Run nothing; write the tables of the pages from this record
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// The pages with tables, for --from
    #[arg(long, value_name = "FILE", value_delimiter = ',', requires = "from", default_value = PAGE)]
    pages: Vec<PathBuf>,
}

/// The page that has tables of the records between marker comments.
const PAGE: &str = "docs/results/flips-and-distances.md";

impl Common {
    /// The tools that are asked for.
    fn tools(&self, kind: Kind, of_set: &[String]) -> Result<Vec<&'static Tool>, Failure> {
        Tool::chosen(kind, if self.tools.is_empty() { of_set } else { &self.tools })
    }

    fn repeats_and_limit(&self, repeats: u64, limit: u64) -> [u64; 2] {
        [self.repeats.unwrap_or(repeats), self.limit.unwrap_or(limit)]
    }

    /// Writes the tables of a run beside its record, and prints them.
    fn write_tables(&self, name: &str, text: &str) -> Result<(), Failure> {
        let path = self.out.join(format!("{name}.md"));
        std::fs::write(&path, text).map_err(Failure::writing(&path))?;
        print!("{text}");
        Ok(())
    }

    /// Writes the tables of the pages anew.
    fn write_pages(
        &self,
        name: &str,
        table: impl Fn(&str) -> Result<String, Failure>,
    ) -> Result<(), Failure> {
        for path in &self.pages {
            let path: &Path = path;
            let old = std::fs::read_to_string(path).map_err(Failure::reading(path))?;
            let (new, blocks) = marked_page::rewrite(&old, name, &table)?;
            std::fs::write(path, new).map_err(Failure::writing(path))?;
            println!("{}: {blocks} tables", path.display());
        }
        Ok(())
    }
}
