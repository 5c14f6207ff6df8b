//! The command line of `curvmesh simplify`.

use crate::batch::Job;
use crate::carry::Carry;
use crate::interrupt::Interruption;
use crate::large::Large;
use crate::scene::Scenes;
use crate::simplify_options::{Constraining, Policy, Targets};
use crate::view::Look;

/// Simplify a mesh by collapsing edges
///
/// A glTF or GLB file that is written as glTF or GLB stays a scene: each of its meshes is simplified
/// once, with all data of its vertices, and everything else stays as it is. More faces remain where
/// they lower the error of the scene most.
///
/// The first target that is reached ends the run, and the report names it. Without a target, half of
/// the faces stay.
///
///     curvmesh simplify scan.ply -o half.ply
///     curvmesh simplify scan.ply -o small.ply --faces 3000
///     curvmesh simplify part.stl -o part.obj --max-error 0.2% --verify
///     curvmesh simplify truck.glb -o truck-30.glb --ratio 0.3 --preset quality
///     curvmesh simplify scan.obj -o upload.glb --bytes 5MB
///     curvmesh simplify part.ply -o part-lite.ply --keep selected --max-edge 5% --min-angle 10
///     curvmesh simplify a.stl b.stl scans/ -o small/ --ratio 0.1 --resume
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment, mut_arg("output", |output| output.required(true)))]
pub(crate) struct Simplify {
    #[command(flatten)]
    pub(crate) targets: Targets,
    #[command(flatten)]
    pub(crate) policy: Policy,
    #[command(flatten)]
    pub(crate) constraining: Constraining,
    #[command(flatten)]
    pub(crate) carry: Carry,
    /// Keep all borders of texture charts, materials, groups and labels, even if the shape suffers. By default,
    /// small charts are merged if the borders need more than a fifth of the wanted faces
    #[arg(long, help_heading = "Attributes", conflicts_with = "no_attributes")]
    pub(crate) keep_seams: bool,
    #[command(flatten)]
    interruption: Interruption,
    #[command(flatten)]
    pub(crate) look: Look,
    #[command(flatten)]
    pub(crate) scenes: Scenes,
    #[command(flatten)]
    pub(crate) large: Large,
    #[command(flatten)]
    pub(crate) job: Job,
}
