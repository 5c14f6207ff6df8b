//! Names in OBJ and MTL, which end with their line.

use crate::distinct_names::distinct_names;
use crate::model::Model;

/// The names of the materials: on one line each, and different. One without a name is called after
/// its place.
pub(super) fn material_names(model: &Model) -> Vec<String> {
    let name = |(place, material): (usize, &crate::model::Material)| {
        let name = one_line(&material.name);
        if name.is_empty() { format!("material_{place}") } else { name }
    };
    distinct_names(model.materials.iter().enumerate().map(name), &[])
}

/// A name that stays on its line: a backslash at the end would join it with the next.
pub(super) fn one_line(name: &str) -> String {
    let joins = |c: char| c == '\\' || c.is_whitespace();
    name.replace(char::is_control, " ").trim_start().trim_end_matches(joins).to_owned()
}

/// The name of a file as the last word of a line in MTL: everything up to the end of the line, but
/// what begins with a hyphen would be an option. None for a name that no line holds.
pub(super) fn file_name(name: &str) -> Option<String> {
    if name.is_empty() || one_line(name) != name {
        return None;
    }
    Some(if name.starts_with('-') { format!("./{name}") } else { name.to_owned() })
}
