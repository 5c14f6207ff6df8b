//! Content without vertices at infinite or undefined positions.

use glam::DVec3;
use mesh_core::as_u32;
use mesh_core::build::{BuildReport, Triangulator};
use mesh_io::{Model, ModelError};

/// Drops vertices at infinite or undefined positions, and the faces at them. The report has their numbers. The content
/// need not be a manifold. If there are such vertices, the faces of the result are triangles; content with faces of
/// vertices that do not exist stays as it is.
///
/// # Errors
/// The model is inconsistent.
pub fn drop_not_finite(model: Model) -> Result<(Model, BuildReport), ModelError> {
    let soup = &model.soup;
    let mut report = BuildReport::default();
    let mut new_ids = vec![u32::MAX; soup.vertex_count()];
    let (mut positions, mut vertex_source) = (Vec::new(), Vec::new());
    for ((&position, id), new_id) in soup.positions().iter().zip(0_u32..).zip(&mut new_ids) {
        if position.is_finite() {
            *new_id = as_u32(positions.len());
            positions.push(position);
            vertex_source.push(id);
        } else {
            report.not_finite_vertices.extend([id]);
        }
    }
    let exists = |&vertex: &u32| (vertex as usize) < new_ids.len();
    if report.not_finite_vertices.is_empty() || !soup.corners().iter().all(exists) {
        return Ok((model, BuildReport::default()));
    }
    let (mut triangles, mut face_source, mut corner_source) = (Vec::new(), Vec::new(), Vec::new());
    let (mut triangulator, mut local) = (Triangulator::default(), Vec::new());
    for (face, id) in (0..soup.face_count()).zip(0_u32..) {
        let vertices: Vec<u32> =
            soup.face(face).iter().map(|&vertex| new_ids[vertex as usize]).collect();
        if vertices.contains(&u32::MAX) {
            report.dropped_not_finite.extend([id]);
            continue;
        }
        let at: Vec<DVec3> = vertices.iter().map(|&vertex| positions[vertex as usize]).collect();
        local.clear();
        triangulator.triangulate(&at, &vertices, &mut local);
        let first = as_u32(soup.corner_range(face).start);
        for corners in &local {
            triangles.push(corners.map(|corner| vertices[corner as usize]));
            face_source.push(id);
            corner_source.push(corners.map(|corner| first + corner));
        }
    }
    let model =
        model.reindexed(&positions, &triangles, &vertex_source, &face_source, &corner_source)?;
    Ok((model, report))
}
