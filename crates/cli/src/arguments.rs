//! The whole command line.

use clap::{Parser, Subcommand};

use crate::args::Common;
use crate::commands::compare::Compare;
use crate::commands::completions::Completions;
use crate::commands::convert::Convert;
use crate::commands::curvature::Curvature;
use crate::commands::distance::Distance;
use crate::commands::flip::Flip;
use crate::commands::info::Info;
use crate::commands::lod::Lod;
use crate::commands::man::Manual;
use crate::commands::patch::Patch;
use crate::commands::region::Region;
use crate::commands::render::Render;
use crate::commands::repair::Repair;
use crate::commands::simplify::Simplify;
use crate::commands::subdivide::Subdivide;
use crate::commands::view::View;

/// Curvature-driven work on triangle meshes.
#[derive(Debug, Parser)]
#[command(name = "curvmesh", version, max_term_width = 100, after_help = AFTER_HELP)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) common: Common,
    #[command(subcommand)]
    pub(crate) command: Command,
}

const AFTER_HELP: &str = "\
`curvmesh COMMAND --help` has examples and all options.
Formats, in and out: OBJ, PLY, STL, OFF, glTF, GLB.
Exit codes: 0 done; 2 wrong usage; 3 unreadable or malformed input; 4 the mesh cannot be
processed as requested, or some of many files failed; 130 interrupted; 1 any other error.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Info(Info),
    Convert(Convert),
    Curvature(Curvature),
    Flip(Flip),
    Patch(Patch),
    Simplify(Box<Simplify>),
    Lod(Box<Lod>),
    Distance(Distance),
    Compare(Compare),
    Subdivide(Subdivide),
    Repair(Repair),
    View(Box<View>),
    Render(Box<Render>),
    Region(Region),
    Completions(Completions),
    Man(Manual),
}
