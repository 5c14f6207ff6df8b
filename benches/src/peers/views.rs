//! Results beside their inputs, one page of `mesh-view` for each run.

use std::path::Path;

use mesh_metric::Surface;
use mesh_view::{Exhibit, Field, On, Page, Section};

use super::record::Record;
use crate::raw_mesh::RawMesh;
use xtask_common::Failure;

/// The page of a run, relative to the folder of the record.
pub(super) fn path(row: &Record) -> String {
    let plain = |text: &str| -> String {
        text.chars()
            .filter(|c| *c != ' ')
            .map(|c| if c.is_ascii_alphanumeric() || ".-_".contains(c) { c } else { '-' })
            .collect()
    };
    format!("views/{}_{}_{}.html", plain(&row.mesh), plain(&row.target), plain(&row.name))
}

/// Writes the page of a run: both meshes, coloured by the distance of their vertices from the other one.
pub(super) fn write(
    row: &Record,
    folder: &Path,
    input: &RawMesh,
    result: &RawMesh,
) -> Result<(), Failure> {
    let exhibits = [("input", input, result), (&*row.name, result, input)];
    let exhibits = exhibits.map(|(name, mesh, other)| exhibit(name, mesh, other));
    let [input, result] = exhibits;
    let title = format!("{} to {}: {}", row.mesh, row.target, row.name);
    let mut page = Page::new(title, vec![input?, result?]);
    page.report.push(Section::of_rows("Run", [("result", row.to_string())]));
    let path = folder.join(path(row));
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent).map_err(Failure::writing(parent))?;
    }
    std::fs::write(&path, page.to_html().map_err(Failure::mesh)?).map_err(Failure::writing(&path))
}

fn exhibit(name: &str, mesh: &RawMesh, other: &RawMesh) -> Result<Exhibit, Failure> {
    let surface =
        Surface::from_triangles(&other.vertices, &other.triangles).map_err(Failure::mesh)?;
    let distances = surface.distances(&mesh.vertices);
    Ok(Exhibit {
        name: name.into(),
        positions: mesh.vertices.clone(),
        triangles: mesh.triangles.clone(),
        fields: vec![Field::new("distance", On::Vertices, distances)],
        ..Exhibit::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::record::tests::record;

    #[test]
    fn a_view_has_both_meshes_under_a_plain_name() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let input = RawMesh {
            vertices: points.map(Into::into).to_vec(),
            triangles: vec![[0, 1, 2], [0, 1, 3]],
        };
        let result = RawMesh { triangles: vec![[0, 1, 2]], ..input.clone() };
        let mut row = record("fast", 1, 1.0, 3.0);
        row.mesh = "a b/c.obj".into();
        let folder = tempfile::tempdir().unwrap();
        write(&row, folder.path(), &input, &result).unwrap();
        assert_eq!(path(&row), "views/ab-c.obj_10-_fast.html");
        let text = std::fs::read_to_string(folder.path().join(path(&row))).unwrap();
        assert!(text.contains("a b/c.obj to 10 %: fast") && text.contains("distance"));
    }
}
