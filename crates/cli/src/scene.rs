//! Scenes that stay scenes: a glTF file that is written as glTF.

use std::collections::BTreeMap;
use std::path::Path;

use clap::{Args, ValueEnum};
use mesh_core::build::BuildReport;
use mesh_io::{Format, Lost};
use mesh_work::{SceneBudget, SceneRules};

use crate::args::parse_elements;
use crate::console::Console;
use crate::failure::Failure;
use crate::given::Given;
use crate::load::{Loading, needed};
use crate::text::printable;

/// What becomes of a scene.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Scenes (glTF and GLB, read and written)")]
pub(crate) struct Merging {
    /// Merge all meshes of a scene into one mesh. Nodes, names and animations are lost
    #[arg(long)]
    one_mesh: bool,
}

/// How a scene is simplified.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Scenes (glTF and GLB, read and written)")]
pub(crate) struct Scenes {
    /// What targets are for: the whole scene, each node that draws a mesh, or each mesh. For the whole scene, faces are
    /// divided between meshes so that the error of the scene is least. Nodes share a mesh unless their results differ:
    /// with --max-error or --errors, nodes of different scales get meshes of their own
    #[arg(
        long,
        value_name = "scene|node|mesh",
        value_enum,
        default_value_t,
        hide_possible_values = true
    )]
    per: Per,
    /// Number of poses in which the errors of meshes with skins or morph targets count, besides the pose of the file.
    /// They are the shapes that differ most: morph targets, key frames of animations. 0 for the pose of the file only
    #[arg(long, value_name = "N", default_value_t = SceneRules::default().poses, value_parser = parse_elements)]
    poses: usize,
    #[command(flatten)]
    pub(crate) merging: Merging,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Per {
    #[default]
    Scene,
    Node,
    Mesh,
}

/// The options of all commands that need one mesh.
const NEEDING_ONE: [&str; 9] = [
    "keep",
    "weight",
    "max_edge",
    "min_angle",
    "max_valence",
    "no_attributes",
    "labels",
    "blend",
    "view",
];

impl Scenes {
    /// The rules for scenes that a command loads, with the budget and the poses of these options.
    pub(crate) fn rules(self, loading: &Loading) -> SceneRules {
        SceneRules { budget: self.budget(), poses: self.poses, ..loading.scene_rules() }
    }

    fn budget(self) -> SceneBudget {
        match self.per {
            Per::Scene => SceneBudget::Scene,
            Per::Node => SceneBudget::Node,
            Per::Mesh => SceneBudget::Mesh,
        }
    }
}

impl Merging {
    /// Whether the input is a scene that stays one. It becomes one mesh, with a message, if an option is given that
    /// needs one mesh.
    pub(crate) fn keeps_scene(
        self,
        input: &Path,
        written: Option<Format>,
        loading: &Loading,
        also_needing_one: &[&'static str],
        (given, console): (&Given, &Console),
    ) -> Result<bool, Failure> {
        let is_gltf = |format: Option<Format>| matches!(format, Some(Format::Gltf | Format::Glb));
        if self.one_mesh || !is_gltf(written) || !is_gltf(loading.format(input)?) {
            return Ok(false);
        }
        let mut fields = also_needing_one.iter().chain(&NEEDING_ONE).copied();
        let needing = fields.find(|field| given.has(field));
        let needing = needing.or_else(|| loading.welds_within().then_some("weld"));
        if let Some(field) = needing {
            let (name, option) = (printable(input.display()), field.replace('_', "-"));
            console.message(format_args!(
                "{name}: --{option} works on one mesh, so that the scene becomes one mesh; without it, the scene stays whole"
            ));
        }
        Ok(needing.is_none())
    }
}

/// Reports charts that were merged.
pub(crate) fn tell_charts(title: &str, [before, after]: [usize; 2], console: &Console) {
    console.message(format_args!(
        "{title}: charts of textures, materials and primitives: {before} -> {after} (--keep-seams keeps them)"
    ));
}

/// Reports the repairs of the meshes of a scene.
pub(crate) fn tell_repairs<'r>(
    name: &str,
    reports: impl Iterator<Item = &'r BuildReport>,
    console: &Console,
) {
    let mut repairs = BTreeMap::new();
    for (what, count) in reports.flat_map(BuildReport::repairs) {
        *repairs.entry(what).or_insert(0) += count;
    }
    if !repairs.is_empty() {
        console.repaired(name, repairs.clone().into_iter());
        console.message(format_args!("{name}: {}", needed(repairs.into_iter())));
    }
}

/// Reports what a scene loses.
pub(crate) fn tell_lost(name: &str, lost: &[Lost], console: &Console) {
    for lost in lost {
        console.message(format_args!("{name}: lost {lost}"));
        console.lose(name, console.command(), lost);
    }
}
