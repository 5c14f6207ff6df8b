//! The kinds of content of a mesh, to report what a command omits.

use std::collections::HashSet;

use mesh_io::{Lost, Model};

/// The kinds of content of a model by name.
#[derive(Debug)]
pub(crate) struct Inventory {
    kinds: Vec<(String, u64)>,
}

impl Inventory {
    pub(crate) fn of(model: &Model) -> Self {
        fn count<T>(values: Option<&Vec<T>>) -> u64 {
            values.map_or(0, |values| values.len() as u64)
        }
        let normals = count(model.vertex_normals.as_ref()) + count(model.corner_normals.as_ref());
        let fixed = [
            ("normals", normals),
            ("colours of vertices", count(model.vertex_colors.as_ref())),
            ("texture coordinates", count(model.corner_uvs.as_ref())),
            ("further sets of texture coordinates", model.more_corner_uvs.len() as u64),
            ("colours of faces", count(model.face_colors.as_ref())),
            ("smoothing groups", count(model.face_smoothing.as_ref())),
            ("groups", model.face_groups.as_ref().map_or(0, |_| model.groups.len() as u64)),
            (
                "materials",
                model.face_materials.as_ref().map_or(0, |_| model.materials.len() as u64),
            ),
        ];
        let mut kinds: Vec<(String, u64)> =
            fixed.into_iter().map(|(name, count)| (name.to_owned(), count)).collect();
        for (of, all) in [("vertices", &model.vertex_scalars), ("faces", &model.face_scalars)] {
            let named = all.iter().map(|s| (format!("{} of {of}", s.name), s.values.len() as u64));
            kinds.extend(named);
        }
        kinds.retain(|(_, count)| *count > 0);
        Self { kinds }
    }

    /// The kinds of content of this model that the other one lacks.
    pub(crate) fn missing_in(&self, other: &Self) -> Vec<Lost> {
        let there: HashSet<&str> = other.kinds.iter().map(|(name, _)| &**name).collect();
        let missing = self.kinds.iter().filter(|(name, _)| !there.contains(&**name));
        missing
            .map(|(name, count)| Lost::some(name, *count, "the command does not carry them over"))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use mesh_io::Scalars;

    use super::*;

    /// A comparison of each name with all names would take minutes.
    #[test]
    fn many_names_are_compared() {
        let numbers = |range: std::ops::Range<u32>| {
            let scalars = range.map(|i| Scalars::new(format!("n{i}"), vec![1.0]));
            Inventory::of(&Model { vertex_scalars: scalars.collect(), ..Model::default() })
        };
        let missing = numbers(0..200_000).missing_in(&numbers(1..200_000));
        assert_eq!(missing.iter().map(|lost| &*lost.what).collect::<Vec<_>>(), ["n0 of vertices"]);
    }
}
