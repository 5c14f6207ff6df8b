//! Rules for the files that the content of a file refers to.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// The other files that the reader may open: material libraries of OBJ, buffers of glTF.
///
/// In any case, only regular files are opened: no pipes, no devices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum External {
    /// None. A glTF document with an external buffer is then an error; the materials of an OBJ file have only names.
    None,
    /// Files in the folder of the file and below it. A name must not lead out of it: no absolute path, no drive or
    /// share, no `..`, no symbolic link to a place outside.
    #[default]
    Folder,
    /// Any file, with names relative to the folder of the file. Only for trusted files.
    Any,
}

impl External {
    /// Opens a file that the content of another file names, such as the picture of an
    /// [`ImageData::Uri`](crate::ImageData::Uri), if it may be read. `folder` is the folder of the file that names it.
    ///
    /// # Errors
    /// The file must not or cannot be read, or is not a regular file: a folder, a pipe, a device.
    pub fn open(self, folder: &Path, name: &str) -> std::io::Result<File> {
        let files = Files { folder: Some(folder), external: self };
        let opened = files.resolve(name).and_then(|path| open(&path));
        opened.map(|(file, _)| file).map_err(std::io::Error::other)
    }
}

/// Whether an address of an image or buffer names a file, not data in the address itself or a place on the web.
pub(crate) fn is_file_name(address: &str) -> bool {
    !address.starts_with("data:") && !address.contains("://")
}

/// The folder of a file, and the rule for other files.
#[derive(Clone, Copy)]
pub(crate) struct Files<'o> {
    pub folder: Option<&'o Path>,
    pub external: External,
}

impl Files<'_> {
    /// The path, without links, of the file with this decoded name, in the notation of any system. The error is the
    /// reason why it must not be read.
    pub(crate) fn resolve(&self, name: &str) -> Result<PathBuf, String> {
        let refused = |why: &str| Err(why.to_owned());
        let Some(folder) = self.folder else {
            return refused("the folder that it is in is not known");
        };
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if name.is_empty() || name.contains(char::is_control) {
            return refused("it is not the name of a file");
        }
        let path = match self.external {
            External::None => return refused("other files are not to be read"),
            External::Folder => folder.join(below(name)?),
            External::Any => {
                let path = folder.join(name);
                if path.exists() { path } else { folder.join(name.replace('\\', "/")) }
            }
        };
        let absolute = |path: &Path| fs::canonicalize(path).map_err(|error| error.to_string());
        let path = absolute(&path)?;
        if self.external == External::Folder && !path.starts_with(absolute(folder)?) {
            return refused(
                "a link leads out of the folder of the file; allow it with --external any",
            );
        }
        Ok(path)
    }
}

/// Opens a regular file only: opening a pipe would wait for its other end.
pub(crate) fn open(path: &Path) -> Result<(File, u64), String> {
    let not_a_file = || "it is not a regular file".to_owned();
    if !fs::metadata(path).map_err(|error| error.to_string())?.is_file() {
        return Err(not_a_file());
    }
    let file = File::open(path).map_err(|error| error.to_string())?;
    let metadata = file.metadata().map_err(|error| error.to_string())?;
    if metadata.is_file() { Ok((file, metadata.len())) } else { Err(not_a_file()) }
}

/// The path of a name that consists of plain components.
pub(crate) fn below(name: &str) -> Result<PathBuf, String> {
    let mut path = PathBuf::new();
    for (place, part) in name.split(['/', '\\']).enumerate() {
        match part {
            "" if place == 0 => return Err(outside()),
            "" | "." => {}
            ".." => return Err(outside()),
            // Drives and streams of Windows, and schemes of URIs.
            _ if part.contains(':') || is_device(part) => return Err(outside()),
            _ => path.push(part),
        }
    }
    Ok(path)
}

fn outside() -> String {
    "it is not below the folder of the file; allow it with --external any".to_owned()
}

/// Whether Windows treats a name as a device, in any folder and with any extension.
fn is_device(part: &str) -> bool {
    let stem = part.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let numbered = stem.strip_prefix("COM").or(stem.strip_prefix("LPT"));
    cfg!(windows)
        && (["CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"].contains(&stem.as_str())
            || numbered.is_some_and(|n| n.chars().count() == 1))
}

#[cfg(test)]
mod tests {
    use super::below;

    #[test]
    fn only_plain_components_are_below_the_folder() {
        for name in [
            "/etc/passwd",
            "../a",
            "a/../../b",
            "..",
            "a\\..\\..\\b",
            "\\\\host\\share\\a",
            "\\a",
            "C:a",
            "c:\\a",
            "a:stream",
            "http://host/a",
            "file:///etc/passwd",
            "//host/a",
        ] {
            assert!(below(name).is_err(), "{name}");
        }
        for name in ["a.bin", "a b/c.mtl", "./a", "a\\b.png", "a//b", "..a", "a..b"] {
            assert!(below(name).is_ok(), "{name}");
        }
    }
}
