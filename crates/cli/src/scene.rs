//! Scenes that stay scenes: a glTF file that is written as glTF.

use clap::{Args, ValueEnum};
use mesh_io::Format;
use mesh_work::SceneBudget;

use crate::console::Console;
use crate::failure::Failure;
use crate::given::Given;
use crate::load::Loading;
use crate::save::SaveOptions;
use crate::task::Task;
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
    /// Whether targets are for the whole scene or for each mesh. For the whole scene, faces are divided between meshes so
    /// that the error of the scene is least
    #[arg(
        long,
        value_name = "scene|mesh",
        value_enum,
        default_value_t,
        hide_possible_values = true
    )]
    per: Per,
    #[command(flatten)]
    pub(crate) merging: Merging,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Per {
    #[default]
    Scene,
    Mesh,
}

impl Scenes {
    pub(crate) fn budget(self) -> SceneBudget {
        match self.per {
            Per::Scene => SceneBudget::Scene,
            Per::Mesh => SceneBudget::Mesh,
        }
    }
}

impl Merging {
    /// Whether the input is a scene that stays one. It becomes one mesh, which is said, if an option is given that needs
    /// one mesh.
    pub(crate) fn keeps_scene(
        self,
        task: &Task,
        loading: &Loading,
        save: &SaveOptions,
        needing_one: &[&'static str],
        (given, console): (&Given, &Console),
    ) -> Result<bool, Failure> {
        let is_gltf = |format: Option<Format>| matches!(format, Some(Format::Gltf | Format::Glb));
        let written = task.output.as_ref().and_then(|output| save.format_of(output));
        if self.one_mesh || !is_gltf(written) || !is_gltf(loading.format(&task.input)?) {
            return Ok(false);
        }
        let needing = needing_one.iter().copied().find(|field| given.has(field));
        let needing = needing.or_else(|| loading.welds_within().then_some("weld"));
        if let Some(field) = needing {
            let (name, option) = (printable(task.input.display()), field.replace('_', "-"));
            console.message(format_args!(
                "{name}: --{option} works on one mesh, so that the scene becomes one mesh; without it, the scene stays whole"
            ));
        }
        Ok(needing.is_none())
    }
}
