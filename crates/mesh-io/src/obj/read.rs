//! Reading OBJ.

use super::filter::{Filter, Kept, Run};
use super::material;
use crate::Model;
use crate::error::{Location, ReadErrorKind};
use crate::input::Input;
use mesh_core::PolygonSoup;
use std::path::Path;

pub(crate) fn read(input: &mut Input<'_>, folder: Option<&Path>) -> Result<Model, ReadErrorKind> {
    let options = tobj::LoadOptions {
        triangulate: false,
        single_index: false,
        ignore_points: true,
        ignore_lines: true,
    };
    let mut filter = Filter::new(input);
    // Material libraries do not get this far: the filter keeps their names.
    let no_library = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let parsed = tobj::load_obj_buf(&mut filter, &options, no_library);
    let (kept, (batches, _)) = filter.finish(parsed)?;
    let mut model = assemble(kept, batches)?;
    material::read_libraries(&mut model, folder);
    Ok(model)
}

/// Puts the faces that `tobj` read together with what the filter kept.
fn assemble(mut kept: Kept, batches: Vec<tobj::Model>) -> Result<Model, ReadErrorKind> {
    let mut faces = Faces::new(&kept);
    for batch in batches {
        faces.append(&kept, &batch.mesh)?;
    }
    *faces.soup.positions_mut() = std::mem::take(&mut kept.positions);
    let has_groups = !kept.groups.is_empty();
    let has_materials = !kept.materials.is_empty();
    Ok(Model {
        soup: faces.soup,
        vertex_colors: (!kept.colors.is_empty()).then_some(kept.colors),
        corner_normals: faces.normals,
        corner_uvs: faces.uvs,
        face_groups: has_groups.then(|| per_face(&kept.runs, kept.faces, |run| run.group)),
        groups: kept.groups,
        face_materials: has_materials.then(|| per_face(&kept.runs, kept.faces, |run| run.material)),
        materials: kept.materials.into_iter().map(material::named).collect(),
        material_libraries: kept.libraries,
        notes: kept.notes,
        ..Model::default()
    })
}

fn per_face(runs: &[Run], faces: usize, value: impl Fn(&Run) -> u32) -> Vec<u32> {
    let mut values = Vec::with_capacity(faces);
    for (index, run) in runs.iter().enumerate() {
        let end = runs.get(index + 1).map_or(faces, |next| next.first_face);
        values.resize(end, value(run));
    }
    values
}

/// Faces as they are put together.
struct Faces {
    soup: PolygonSoup,
    uvs: Option<Vec<[f32; 2]>>,
    normals: Option<Vec<[f32; 3]>>,
    /// The run of the next face.
    run: usize,
}

impl Faces {
    fn new(kept: &Kept) -> Self {
        let room = kept.corners;
        Self {
            soup: PolygonSoup::with_capacity(0, kept.faces, kept.corners),
            uvs: kept.runs.iter().any(|run| run.has_uv).then(|| Vec::with_capacity(room)),
            normals: kept.runs.iter().any(|run| run.has_normal).then(|| Vec::with_capacity(room)),
            run: 0,
        }
    }

    /// Appends an object of `tobj`, whose positions, texture coordinates and normals are indices.
    fn append(&mut self, kept: &Kept, mesh: &tobj::Mesh) -> Result<(), ReadErrorKind> {
        let triangles = mesh.indices.len() / 3;
        let arities = mesh.face_arities.iter().map(|&arity| arity as usize);
        let all_triangles = std::iter::repeat_n(3, triangles * usize::from(arities.len() == 0));
        let mut face = Vec::new();
        let mut corner = 0;
        for arity in arities.chain(all_triangles) {
            while kept
                .runs
                .get(self.run + 1)
                .is_some_and(|r| r.first_face <= self.soup.face_count())
            {
                self.run += 1;
            }
            let run = kept.runs.get(self.run).ok_or_else(lost)?;
            face.clear();
            for corner in corner..corner + arity {
                face.push(file_index(&mesh.indices, &mesh.positions, 3, corner)? as u32);
                if let Some(uvs) = &mut self.uvs {
                    uvs.push(if run.has_uv {
                        let index = file_index(&mesh.texcoord_indices, &mesh.texcoords, 2, corner)?;
                        *kept.uvs.get(index).ok_or_else(lost)?
                    } else {
                        [f32::NAN; 2]
                    });
                }
                if let Some(normals) = &mut self.normals {
                    normals.push(if run.has_normal {
                        let index = file_index(&mesh.normal_indices, &mesh.normals, 3, corner)?;
                        *kept.normals.get(index).ok_or_else(lost)?
                    } else {
                        [f32::NAN; 3]
                    });
                }
            }
            corner += arity;
            self.soup.push_face(&face)?;
        }
        Ok(())
    }
}

/// The index in the file of what a corner refers to: the first number of its entry.
fn file_index(
    indices: &[u32],
    entries: &[f64],
    width: usize,
    corner: usize,
) -> Result<usize, ReadErrorKind> {
    let entry = indices.get(corner).and_then(|&index| entries.get(width * index as usize));
    entry.map(|&index| index as usize).ok_or_else(lost)
}

/// `tobj` returned something else than it was given, which would be a defect of this crate.
fn lost() -> ReadErrorKind {
    ReadErrorKind::malformed(Location::Line(1), "faces that tobj can keep apart", "others")
}
