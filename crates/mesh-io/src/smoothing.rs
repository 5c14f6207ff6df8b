//! Normals in the form that a format has: from smoothing groups where it has no groups, of vertices where it has none of
//! corners.

use crate::format::Format;
use crate::model::Model;
use glam::DVec3;
use mesh_core::unit_sized_points;
use std::borrow::Cow;

/// The model with normals instead of smoothing groups, if the format has normals that can express them. A model with
/// its own normals keeps them and its groups; normals of corners become normals of vertices if all corners of every
/// vertex agree and the format has no others.
pub(crate) fn with_normals(model: Cow<'_, Model>, format: Format) -> Cow<'_, Model> {
    if let (Format::Ply | Format::Off, Some(of_corners), None) =
        (format, &model.corner_normals, &model.vertex_normals)
        && let Some(normals) = vertex_normals(&model, of_corners)
    {
        let model = model.into_owned();
        return Cow::Owned(Model { vertex_normals: Some(normals), corner_normals: None, ..model });
    }
    let has_normals = model.corner_normals.is_some() || model.vertex_normals.is_some();
    let Some(groups) = model.face_smoothing.as_deref().filter(|_| !has_normals) else {
        return model;
    };
    match format {
        Format::Gltf | Format::Glb => {
            let normals = Some(corner_normals(&model, groups));
            let model = model.into_owned();
            Cow::Owned(Model { corner_normals: normals, face_smoothing: None, ..model })
        }
        Format::Ply | Format::Off => {
            match vertex_normals(&model, &corner_normals(&model, groups)) {
                Some(normals) => {
                    let model = model.into_owned();
                    Cow::Owned(Model {
                        vertex_normals: Some(normals),
                        face_smoothing: None,
                        ..model
                    })
                }
                None => model,
            }
        }
        Format::Obj | Format::Stl => model,
    }
}

/// The normal of every corner. In group 0 it is the normal of the face. Otherwise it is the mean over the faces of the
/// group at the vertex, weighted by their angles there.
fn corner_normals(model: &Model, groups: &[u32]) -> Vec<[f32; 3]> {
    let soup = &model.soup;
    let (positions, _) = unit_sized_points(soup.positions());
    let mut normals = vec![DVec3::ZERO; soup.corners().len()];
    // The vertex, the group and the index of every corner of a group.
    let mut members: Vec<(u32, u32, usize)> = Vec::new();
    for (face, &group) in groups.iter().enumerate().take(soup.face_count()) {
        let vertices = soup.face(face);
        let corners: Vec<DVec3> = vertices.iter().map(|&v| positions[v as usize]).collect();
        let of_face = face_normal(&corners);
        for (place, corner) in soup.corner_range(face).enumerate() {
            if group == 0 {
                normals[corner] = of_face;
            } else {
                normals[corner] = of_face * angle_at(&corners, place);
                members.push((vertices[place], group, corner));
            }
        }
    }
    members.sort_unstable();
    for same in members.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let sum: DVec3 = same.iter().map(|&(.., corner)| normals[corner]).sum();
        let mean = sum.normalize_or(DVec3::Z);
        same.iter().for_each(|&(.., corner)| normals[corner] = mean);
    }
    normals.into_iter().map(|normal| normal.as_vec3().to_array()).collect()
}

/// One normal per vertex, if the corners of every vertex agree. Vertices without a face have none.
fn vertex_normals(model: &Model, of_corners: &[[f32; 3]]) -> Option<Vec<[f32; 3]>> {
    let mut normals = vec![[0.0; 3]; model.soup.vertex_count()];
    let mut known = vec![false; normals.len()];
    for (&vertex, normal) in model.soup.corners().iter().zip(of_corners) {
        let vertex = vertex as usize;
        let is_same = normals[vertex].map(f32::to_bits) == normal.map(f32::to_bits);
        if std::mem::replace(&mut known[vertex], true) && !is_same {
            return None;
        }
        normals[vertex] = *normal;
    }
    Some(normals)
}

/// The unit normal of a polygon by Newell's formula; upwards if it has no area.
fn face_normal(corners: &[DVec3]) -> DVec3 {
    let next = corners.iter().cycle().skip(1);
    let sum: DVec3 = corners.iter().zip(next).map(|(a, b)| a.cross(*b)).sum();
    sum.normalize_or(DVec3::Z)
}

/// The angle between the sides at a corner, in radians.
fn angle_at(corners: &[DVec3], place: usize) -> f64 {
    let count = corners.len();
    let here = corners[place];
    let before = corners[(place + count - 1) % count] - here;
    let after = corners[(place + 1) % count] - here;
    before.cross(after).length().atan2(before.dot(after))
}
