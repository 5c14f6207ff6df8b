//! What files add to a mesh: a place and a size, attributes, seams, split vertices, reversed faces.

use glam::{DQuat, DVec3};
use mesh_core::PolygonSoup;
use mesh_io::{Format, Model, Scalars};

use crate::parts::{Choices, soup};

/// Attributes of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attributes {
    /// Positions and faces alone.
    None,
    /// Numbers and labels of vertices, labels of faces.
    Numbers,
    /// Texture coordinates: a chart for each side of a box around the mesh.
    Charts,
}

/// A model as a file has it.
#[derive(Clone, Debug)]
pub struct Worn {
    /// The model.
    pub model: Model,
    /// The format of its file.
    pub format: Format,
    /// The random choices, for messages.
    pub description: String,
}

/// Gives a mesh a size, a place, attributes and flaws.
#[must_use]
pub fn wear(mesh: &PolygonSoup, seed: u64) -> Worn {
    let mut choose = Choices::new(seed);
    let turn = match choose.one_in(2) {
        true => DQuat::IDENTITY,
        false => DQuat::from_axis_angle(choose.direction(), choose.between(0.0, 3.0)),
    };
    let scale = if choose.one_in(2) { 1.0 } else { choose.scale(1e-5, 1e5) };
    let shift = if choose.one_in(4) { 100.0 * scale * choose.direction() } else { DVec3::ZERO };
    let points: Vec<DVec3> = mesh.positions().iter().map(|&p| turn * (p * scale) + shift).collect();
    let mut faces: Vec<[u32; 3]> = mesh.faces().filter_map(|face| face.try_into().ok()).collect();
    let share = if choose.one_in(6) { choose.between(0.0, 0.45) } else { 0.0 };
    for [_, b, c] in &mut faces {
        if share > 0.0 && choose.between(0.0, 1.0) < share {
            core::mem::swap(b, c);
        }
    }
    let attributes = match choose.count(0, 3) {
        0 => Attributes::Numbers,
        1 => Attributes::Charts,
        _ => Attributes::None,
    };
    let formats = match attributes {
        Attributes::Numbers => [Format::Ply; 3],
        // glTF has no place for coordinates that are not finite.
        Attributes::Charts if !points.iter().all(|p| p.is_finite()) => [Format::Obj; 3],
        Attributes::Charts => [Format::Obj, Format::Glb, Format::Obj],
        Attributes::None => [Format::Off, Format::Ply, Format::Stl],
    };
    let format = formats[choose.count(0, 2)];
    let mut model = Model::from(soup(&points, &faces));
    match attributes {
        Attributes::None => {}
        Attributes::Numbers => number(&mut model, &mut choose, mesh),
        Attributes::Charts => model.corner_uvs = Some(charts(mesh, &faces)),
    }
    let description = format!(
        "turned {}, scale {scale:.3e}, shifted {}, reversed {share:.2}, {attributes:?}, {format:?}",
        turn != DQuat::IDENTITY,
        shift != DVec3::ZERO
    );
    Worn { model, format, description }
}

/// Numbers of vertices, and labels of vertices and faces that follow stripes.
fn number(model: &mut Model, choose: &mut Choices, mesh: &PolygonSoup) {
    let (across, width) = (choose.direction(), choose.scale(0.1, 1.0));
    let points = mesh.positions();
    let stripe = |at: DVec3| (at.dot(across) / width).floor().rem_euclid(5.0);
    let height = |p: &DVec3| if p.is_finite() { p.dot(across) as f32 } else { 0.0 };
    let heights: Vec<f32> = points.iter().map(height).collect();
    let zones: Vec<i32> = points.iter().map(|&p| stripe(p) as i32 * 7 - 3).collect();
    let parts: Vec<u8> = mesh
        .faces()
        .map(|face| face.iter().map(|&v| points[v as usize]).sum::<DVec3>() / face.len() as f64)
        .map(|centre| stripe(centre) as u8 * 50)
        .collect();
    model.vertex_scalars = vec![Scalars::new("height", heights), Scalars::new("zone", zones)];
    model.face_scalars = vec![Scalars::new("part", parts)];
}

/// Texture coordinates by projection along the largest component of each normal.
fn charts(mesh: &PolygonSoup, faces: &[[u32; 3]]) -> Vec<[f32; 2]> {
    let points = mesh.positions();
    let mut uvs = Vec::new();
    for (face, original) in faces.iter().zip(mesh.faces()) {
        let corner = |i: usize| points[original[i] as usize];
        let normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
        let axis = normal.abs().max_position();
        let side = 2 * axis + usize::from(normal[axis] < 0.0);
        uvs.extend(face.map(|vertex| {
            let point = points[vertex as usize];
            let [u, v] = [point[(axis + 1) % 3], point[(axis + 2) % 3]];
            [(u + 20.0 * side as f64) as f32, v as f32]
        }));
    }
    uvs
}
