//! Scanning glTF: the bytes of the file are in memory, and the positions of one mesh at a time.

use super::lost;
use super::plan::{Plan, path_of};
use super::read::{each_triangle, load, vertex_indices};
use super::scene::{Placed, each_placed, transforms};
use crate::error::ReadErrorKind;
use crate::external::Files;
use crate::input::Input;
use crate::item::{Item, Visit, stopped};
use crate::lost::{Lost, STREAMED};
use crate::notes::Notes;
use glam::{DMat3, DVec3};
use std::ops::ControlFlow;

/// Passes on the triangles by their positions, since glTF duplicates vertices where texture coordinates or normals
/// differ.
pub(crate) fn scan(
    input: &mut Input<'_>,
    files: &Files<'_>,
    visit: &mut Visit<'_>,
    notes: &mut Notes,
) -> Result<ControlFlow<()>, ReadErrorKind> {
    let document = load(input, files, notes)?;
    let plan = Plan::of(&document, &[], notes)?;
    lost::note(&document.root, notes);
    let counts = [
        (plan.has_normals, "vertex normals"),
        (plan.has_colors, "vertex colours"),
        (plan.has_uvs, "texture coordinates"),
        (!document.root.materials.is_empty(), "materials"),
    ];
    for (_, what) in counts.into_iter().filter(|(is_lost, _)| *is_lost) {
        notes.lose(Lost::new(what, STREAMED));
    }
    let mut flow = ControlFlow::Continue(());
    let passed = each_placed(&document.root, |placed: &Placed<'_>| {
        let mesh = document.root.meshes.get(placed.mesh as usize);
        let (Some(mesh), Some(mesh_plan)) = (mesh, plan.meshes.get(&placed.mesh)) else {
            return Ok(());
        };
        for transform in transforms(&document, placed)? {
            let is_mirrored = DMat3::from_mat4(transform).determinant() < 0.0;
            for part in &mesh_plan.parts {
                let path = path_of(placed.mesh, part.primitive);
                let set = mesh_plan.sets.get(part.set);
                let (Some(set), Some(primitive)) = (set, mesh.primitives.get(part.primitive))
                else {
                    continue;
                };
                let positions = document.values(set.positions, &path, 3..=3)?.to_vec::<3>(0.0)?;
                let indices = vertex_indices(&document, primitive, set.count, &path)?;
                each_triangle(primitive.mode, &indices, |mut triangle| {
                    if is_mirrored {
                        triangle.swap(1, 2);
                    }
                    let corners = triangle.map(|vertex| {
                        let position = positions.get(vertex as usize).copied().unwrap_or_default();
                        transform.transform_point3(DVec3::from(position.map(f64::from)))
                    });
                    flow = visit(Item::Facet(&corners));
                    if flow.is_break() { Err(stopped()) } else { Ok(()) }
                })?;
            }
        }
        Ok(())
    });
    if flow.is_break() { Ok(flow) } else { passed.map(|()| flow) }
}
