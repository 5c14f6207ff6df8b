//! Where in this repository a public function is.

use std::path::{Path, PathBuf};

/// A link from a page in `folder` to the file that defines `path`, like `dtri_flip::optimise` or
/// `dtri_flip::CostName::total`.
pub(super) fn link(path: &str, folder: &Path) -> Option<String> {
    let file = file_of(path)?;
    let (file, folder) = (file.canonicalize().ok()?, folder.canonicalize().ok()?);
    let shared = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| PathBuf::from(".."));
    let down: PathBuf = file.components().skip(shared).collect();
    let link: PathBuf = up.chain([down]).collect();
    Some(link.to_string_lossy().replace('\\', "/"))
}

/// The file that defines a function, method or type.
pub(crate) fn file_of(path: &str) -> Option<PathBuf> {
    let mut segments: Vec<&str> = path.split("::").collect();
    let (name, package) = (segments.pop()?, segments.first()?.replace('_', "-"));
    let owner = segments.last().filter(|s| s.starts_with(char::is_uppercase));
    let sources =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates").join(package).join("src");
    let defines = |text: &str| {
        let definition = ["fn", "struct", "enum", "trait"].iter().any(|kind| {
            text.match_indices(&format!("pub {kind} {name}")).any(|(start, found)| {
                let next = text[start + found.len()..].chars().next();
                !next.is_some_and(|c| c.is_alphanumeric() || c == '_')
            })
        });
        definition && owner.is_none_or(|owner| text.contains(owner))
    };
    files_below(&sources)
        .into_iter()
        .find(|file| std::fs::read_to_string(file).is_ok_and(|text| defines(&text)))
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let below = |path: PathBuf| if path.is_dir() { files_below(&path) } else { vec![path] };
    paths.into_iter().flat_map(below).collect()
}

#[cfg(test)]
mod tests {
    use super::file_of;

    #[test]
    fn functions_methods_and_types_are_found() {
        for path in ["dtri_flip::optimise", "dtri_flip::CostName::total", "mesh_metric::compare"] {
            assert!(file_of(path).is_some(), "{path}");
        }
        assert_eq!(file_of("dtri_flip::no_such_function"), None);
        assert_eq!(file_of("dtri_flip::optimis"), None);
    }
}
