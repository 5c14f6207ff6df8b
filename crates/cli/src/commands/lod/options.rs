//! What `curvmesh lod` takes from the command line.

use std::path::PathBuf;

use clap::Args;
use mesh_core::TriMesh;
use mesh_work::{Length, LevelSteps, parse_length};

use crate::carry::Carry;
use crate::failure::Failure;
use crate::given::Given;
use crate::large::Large;
use crate::save::SaveOptions;
use crate::simplify_options::{NOT_FITTED, OF_FITS, Policy, parse_ratio};
use crate::task::Source;
use crate::view::Look;

/// Make levels of detail, each of them a stage of one run of collapses
///
/// The vertices of a level are what those of the finer ones have become, so levels are not fitted to
/// the input, as the results of `simplify` are. OUT is a folder for a file per level, or a GLB or glTF
/// file for all of them with the input as the finest (`MSFT_lod`).
///
/// The run can be recorded, and levels made from the record later; they are exactly the same.
///
/// With --memory, a mesh that does not fit is done region by region, and so are levels that do not fit: OUT is
/// a folder then, for PLY files or tiles.
///
///     curvmesh lod truck.glb -o truck-lod.glb --levels 0.5,0.25,0.1 --lenient
///     curvmesh lod scan.ply -o levels --errors 0.1%,1% --record scan.lod
///     curvmesh lod scan.ply -o small.ply --replay scan.lod --faces 3000
///     curvmesh lod huge.ply -o levels --levels 0.3,0.1,0.01 --memory 1GiB
#[derive(Debug, Args)]
#[command(
    verbatim_doc_comment,
    mut_arg("fit_rounds", |option| option.hide(true)),
    mut_arg("norm", |option| option.hide(true)),
    mut_arg("anneal_time", |option| option.hide(true)),
    mut_arg("seed", |option| option.hide(true))
)]
pub(crate) struct Lod {
    #[command(flatten)]
    pub(crate) source: Source,
    /// A folder for the levels, a GLB or glTF file for all of them, or a file or the standard output
    /// `-` for the only one
    #[arg(short, long, value_name = "OUT", help_heading = None)]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) steps: Steps,
    /// Write the collapses to a file
    #[arg(long, value_name = "FILE", conflicts_with = "replay", help_heading = None)]
    pub(crate) record: Option<PathBuf>,
    /// Take the collapses from a file instead of finding them
    #[arg(long, value_name = "FILE", help_heading = None)]
    pub(crate) replay: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) policy: Policy,
    #[command(flatten)]
    pub(crate) carry: Carry,
    #[command(flatten)]
    pub(crate) save: SaveOptions,
    #[command(flatten)]
    pub(crate) look: Look,
    #[command(flatten)]
    pub(crate) large: Large,
    /// Go on where an earlier run with --memory was interrupted
    #[arg(long, requires = "memory", help_heading = "Meshes larger than memory")]
    pub(crate) resume: bool,
    /// Write each level as a folder of tiles, a PLY file for each region, and tiles.json, which lists them
    #[arg(long, requires = "memory", help_heading = "Meshes larger than memory")]
    pub(crate) tiles: bool,
}

/// What the levels are.
#[derive(Debug, Args)]
#[command(next_help_heading = "Levels (in one of these ways)")]
#[group(required = true, multiple = false)]
pub(crate) struct Steps {
    /// Levels with these parts of the faces of the input
    #[arg(long, value_name = "RATIOS", value_delimiter = ',', value_parser = parse_ratio)]
    pub(crate) levels: Vec<f64>,
    /// Levels with so many faces, or one fewer
    #[arg(long, value_name = "COUNTS", value_delimiter = ',')]
    pub(crate) faces: Vec<usize>,
    /// The coarsest levels within these distances of the input
    #[arg(long, value_name = "LENGTHS", value_delimiter = ',', value_parser = parse_length)]
    pub(crate) errors: Vec<Length>,
}

impl Lod {
    /// Whether the mesh is done region by region: it does not fit into the memory that is allowed, as far as
    /// its length tells, or what only regions give is asked for.
    pub(crate) fn is_in_regions(&self) -> Result<bool, Failure> {
        let of_regions = self.tiles || (self.policy.proves() && self.steps.errors.is_empty());
        let is_needed = self.large.is_needed(&self.source.input, &self.source.loading)?;
        Ok(is_needed || (self.large.memory.is_some() && of_regions))
    }

    /// Refuses options that would do nothing with a mesh in memory.
    pub(crate) fn check_given(&self, given: &Given) -> Result<(), Failure> {
        given.refuse(&OF_FITS, NOT_FITTED)?;
        if self.steps.errors.is_empty() {
            given.refuse(&["verify"], "it is for --errors")?;
        }
        if self.replay.is_some() {
            let of_runs = [
                "preset",
                "placement",
                "curvature_weight",
                "lock_boundary",
                "feature_angle",
                "no_intersections",
                "components",
                "attribute_weight",
                "normal_weight",
            ];
            given.refuse(&of_runs, "with --replay the collapses are those of the record")?;
        }
        Ok(())
    }
}

impl Steps {
    /// The number of levels.
    pub(crate) fn count(&self) -> usize {
        self.levels.len() + self.faces.len() + self.errors.len()
    }

    /// The levels of a mesh, lengths in its units.
    pub(crate) fn of(&self, mesh: &TriMesh, relative: bool) -> Result<LevelSteps, Failure> {
        let errors = self.errors.iter().map(|e| e.on(mesh, relative).map_err(Failure::refused));
        Ok(LevelSteps {
            ratios: self.levels.clone(),
            faces: self.faces.clone(),
            errors: errors.collect::<Result<_, Failure>>()?,
        })
    }
}
