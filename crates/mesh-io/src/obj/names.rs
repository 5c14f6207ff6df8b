//! Names in OBJ and MTL, which end at the end of the line.

use crate::distinct_names::distinct_names;
use crate::model::Model;

/// The names of the materials: unique, and each on one line. A material without a name is named by its index.
pub(super) fn material_names(model: &Model) -> Vec<String> {
    let name = |(place, material): (usize, &crate::model::Material)| {
        let name = one_line(&material.name);
        if name.is_empty() { format!("material_{place}") } else { name }
    };
    distinct_names(model.materials.iter().enumerate().map(name), &[])
}

/// A name that stays on its line: a backslash at the end would join the next line.
pub(super) fn one_line(name: &str) -> String {
    let joins = |c: char| c == '\\' || c.is_whitespace();
    name.replace(char::is_control, " ").trim_start().trim_end_matches(joins).to_owned()
}

/// The name of a file as the last word of an MTL line: the rest of the line. A name that starts with a hyphen needs a
/// prefix, since it would be read as an option. `None` for a name that no line can hold.
pub(super) fn file_name(name: &str) -> Option<String> {
    if name.is_empty() || one_line(name) != name {
        return None;
    }
    Some(if name.starts_with('-') { format!("./{name}") } else { name.to_owned() })
}
