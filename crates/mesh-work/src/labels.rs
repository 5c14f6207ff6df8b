//! Marks named numbers as labels or as measurements.

use mesh_io::Model;

/// The mesh has no numbers with this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there are no numbers named {name}; there are: {known}")]
pub struct UnknownNumbers {
    /// The requested name.
    pub name: String,
    /// The existing names.
    pub known: String,
}

impl UnknownNumbers {
    pub(crate) fn new(model: &Model, name: &str) -> Self {
        let all = model.vertex_scalars.iter().chain(&model.face_scalars);
        let known: Vec<&str> = all.map(|scalars| scalars.name.as_str()).collect();
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        Self { name: name.to_owned(), known }
    }
}

/// Marks named numbers of vertices and faces: `labels` are copied from the nearest element, and `blended` numbers
/// are interpolated. Other numbers stay as they are.
///
/// # Errors
/// The model has no numbers with one of the names.
pub fn mark_labels(
    model: &mut Model,
    labels: &[String],
    blended: &[String],
) -> Result<(), UnknownNumbers> {
    for (names, is_label) in [(labels, true), (blended, false)] {
        for name in names {
            let all = model.vertex_scalars.iter_mut().chain(&mut model.face_scalars);
            let mut found = false;
            for scalars in all.filter(|scalars| scalars.name == *name) {
                (scalars.is_label, found) = (is_label, true);
            }
            if !found {
                return Err(UnknownNumbers::new(model, name));
            }
        }
    }
    Ok(())
}
