//! Where levels of detail are written.

use std::path::{Path, PathBuf};

use crate::args::is_standard;
use crate::commands::lod::options::Lod;
use crate::failure::Failure;
use crate::given::Given;
use crate::large::is_folder;
use crate::save::{check_target, paths_of_levels};

/// The files of the levels.
pub(super) enum Place {
    /// All into one file.
    Together(PathBuf),
    /// Each level in its own file.
    Apart(Vec<PathBuf>),
}

impl Place {
    /// The file with the first level. All files are in its folder.
    pub(super) fn first(&self) -> Option<&Path> {
        match self {
            Self::Together(path) => Some(path),
            Self::Apart(paths) => paths.first().map(PathBuf::as_path),
        }
    }

    pub(super) fn new(options: &Lod, count: usize, given: &Given) -> Result<Self, Failure> {
        let output = &options.output;
        if is_standard(output) {
            check_target(output, &options.save, given)?;
            if count > 1 {
                let message = "the standard output takes one level; name one, or a folder";
                return Err(Failure::usage(message));
            }
            return Ok(Self::Apart(vec![output.clone()]));
        }
        let extension = output.extension().map(|e| e.to_string_lossy().to_lowercase());
        let holds_all = matches!(extension.as_deref(), Some("glb" | "gltf"));
        if holds_all {
            check_target(output, &options.save, given)?;
        }
        if holds_all && !(count == 1 && options.replay.is_some()) {
            return Ok(Self::Together(output.clone()));
        }
        if !is_folder(output, &options.save, count) {
            check_target(output, &options.save, given)?;
            if count > 1 {
                return Err(Failure::Usage(format!(
                    "{}: one file for several levels must be GLB or glTF; name one, or a folder",
                    output.display()
                )));
            }
            return Ok(Self::Apart(vec![output.clone()]));
        }
        let input = &options.source.input;
        let own = input.extension().unwrap_or_default().to_string_lossy();
        let paths = paths_of_levels(input, output, count, &options.save, &own);
        paths.iter().try_for_each(|path| check_target(path, &options.save, given))?;
        Ok(Self::Apart(paths))
    }
}
