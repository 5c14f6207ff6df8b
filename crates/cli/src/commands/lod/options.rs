//! The command line of `curvmesh lod`.

use std::path::PathBuf;

use clap::Args;
use mesh_core::TriMesh;
use mesh_work::{Length, LevelSteps, SceneSteps, parse_length};

use crate::args::parse_elements;
use crate::carry::Carry;
use crate::console::Console;
use crate::failure::Failure;
use crate::given::Given;
use crate::large::Large;
use crate::save::SaveOptions;
use crate::scene::Scenes;
use crate::simplify_options::{Constraining, NOT_FITTED, OF_FITS, Policy, parse_ratio};
use crate::task::Source;
use crate::view::Look;

/// Make levels of detail from one sequence of collapses
///
/// Each vertex of a level comes from vertices of the finer levels. So levels are not fitted to the input, as the
/// results of `simplify` are. Only faces that the collapses have turned over are turned back.
///
/// OUT is a folder for one file per level, or a GLB or glTF file for all levels, with the input as the finest one
/// (`MSFT_lod`). A glTF scene whose levels are glTF or GLB stays a scene in each level. Without --levels, --faces or
/// --errors, the levels have 50 %, 25 %, 10 % and 5 % of the faces.
///
/// --record writes the collapses to a file. --replay makes exactly the same levels from it later.
///
/// With --memory, a mesh that does not fit into memory is simplified region by region, and so are levels that do not
/// fit. OUT is then a folder for PLY files or tiles.
#[derive(Debug, Args)]
#[command(
    after_long_help = EXAMPLES,
    mut_arg("fit_rounds", |option| option.hide(true)),
    mut_arg("norm", |option| option.hide(true)),
    mut_arg("anneal_time", |option| option.hide(true)),
    mut_arg("seed", |option| option.hide(true))
)]
pub(crate) struct Lod {
    #[command(flatten)]
    pub(crate) source: Source,
    /// A folder for the levels, or a GLB or glTF file for all of them. A single level can also go to any file or to the
    /// standard output `-`
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
    pub(crate) constraining: Constraining,
    #[command(flatten)]
    pub(crate) carry: Carry,
    /// Keep all borders of texture charts, materials, groups and labels, even if the shape suffers. By default, small
    /// charts are merged, in all levels, if the borders need more than a fifth of the faces of the coarsest level
    #[arg(long, help_heading = "Attributes", conflicts_with = "no_attributes")]
    pub(crate) keep_seams: bool,
    #[command(flatten)]
    pub(crate) save: SaveOptions,
    #[command(flatten)]
    pub(crate) look: Look,
    #[command(flatten)]
    pub(crate) scenes: Scenes,
    #[command(flatten)]
    pub(crate) large: Large,
    /// Resume an interrupted run with --memory
    #[arg(long, requires = "memory", help_heading = "Meshes larger than memory")]
    pub(crate) resume: bool,
    /// Write each level as a folder of tiles: a PLY file for each region, and tiles.json, which lists them
    #[arg(long, requires = "memory", help_heading = "Meshes larger than memory")]
    pub(crate) tiles: bool,
}

/// The levels.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Levels (in one of these ways)")]
#[group(multiple = false)]
pub(crate) struct Steps {
    /// Levels with these shares of the faces of the input [default: 0.5,0.25,0.1,0.05]
    #[arg(long, value_name = "RATIOS", value_delimiter = ',', value_parser = parse_ratio)]
    pub(crate) levels: Vec<f64>,
    /// Levels with these numbers of faces, or one fewer; for example 10k,3000
    #[arg(long, value_name = "COUNTS", value_delimiter = ',', value_parser = parse_elements)]
    pub(crate) faces: Vec<usize>,
    /// The coarsest levels within these distances from the input
    #[arg(long, value_name = "LENGTHS", value_delimiter = ',', value_parser = parse_length)]
    pub(crate) errors: Vec<Length>,
}

const EXAMPLES: &str = "\
Examples:
    curvmesh lod scan.ply -o levels
    curvmesh lod truck.glb -o truck-lod.glb --levels 0.5,0.25,0.1
    curvmesh lod scan.ply -o levels --errors 0.1%,1% --record scan.lod
    curvmesh lod scan.ply -o small.ply --replay scan.lod --faces 3000
    curvmesh lod huge.ply -o levels --levels 0.3,0.1,0.01 --memory 1GiB";

/// The shares of the faces that levels have by default.
const DEFAULT_RATIOS: [f64; 4] = [0.5, 0.25, 0.1, 0.05];

/// No default level has fewer faces, except for the finest one.
const FEWEST_FACES: f64 = 100.0;

impl Lod {
    /// Whether the mesh is simplified region by region: judged by its length it does not fit into memory, or the options
    /// ask for tiles or proofs.
    pub(crate) fn is_in_regions(&self) -> Result<bool, Failure> {
        let of_regions = self.tiles || (self.policy.proves() && self.steps.errors.is_empty());
        let is_needed = self.large.is_needed(&self.source.input, &self.source.loading)?;
        Ok(is_needed || (self.large.memory.is_some() && of_regions))
    }

    /// Refuses options that have no effect on a mesh in memory.
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
                "keep",
                "weight",
                "max_edge",
                "min_angle",
                "max_valence",
                "keep_seams",
            ];
            given.refuse(&of_runs, "with --replay the collapses come from the record")?;
        }
        Ok(())
    }
}

impl Steps {
    /// The levels that are asked for. If none is, default levels for a mesh of `faces` faces, and a message that names them.
    pub(crate) fn or_default(&self, faces: Option<usize>, console: &Console) -> Self {
        let steps = self.or_quiet_default(faces);
        if self.count() == 0 {
            let shares: Vec<String> =
                steps.levels.iter().map(|ratio| format!("{} %", 100.0 * ratio)).collect();
            console.message(format_args!(
                "no levels are named: making levels with {} of the faces; name others with --levels",
                shares.join(", ")
            ));
        }
        steps
    }

    /// As [`Steps::or_default`], without a report.
    pub(crate) fn or_quiet_default(&self, faces: Option<usize>) -> Self {
        let mut steps = self.clone();
        if self.count() == 0 {
            let is_large = |ratio: f64| faces.is_none_or(|n| n as f64 * ratio >= FEWEST_FACES);
            let [finest, coarser @ ..] = DEFAULT_RATIOS;
            let coarser = coarser.into_iter().filter(|&ratio| is_large(ratio));
            steps.levels = std::iter::once(finest).chain(coarser).collect();
        }
        steps
    }

    /// The number of levels.
    pub(crate) fn count(&self) -> usize {
        self.levels.len() + self.faces.len() + self.errors.len()
    }

    /// The levels of a scene.
    pub(crate) fn of_scene(&self, relative: bool) -> SceneSteps {
        let Self { levels, faces, errors } = self.clone();
        SceneSteps { ratios: levels, faces, errors, relative }
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
