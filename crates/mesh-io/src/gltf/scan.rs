//! Scanning glTF: the bytes of the file are in memory, and the positions and indices of one mesh at a time.

use super::accessor::at;
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
    // An accessor without bytes can have any number of vertices.
    input.spend(plan.bytes(), || at("the scene"))?;
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
        let transforms = transforms(&document, placed)?;
        if transforms.is_empty() {
            return Ok(());
        }
        let positions = mesh_plan.sets.iter().map(|set| {
            let path = path_of(placed.mesh, set.primitive);
            document.values(set.positions, &path, 3..=3)?.to_vec::<3>(0.0)
        });
        let positions = positions.collect::<Result<Vec<_>, _>>()?;
        let mut parts = Vec::with_capacity(mesh_plan.parts.len());
        for part in &mesh_plan.parts {
            let vertices = positions.get(part.set);
            if let (Some(vertices), Some(primitive)) =
                (vertices, mesh.primitives.get(part.primitive))
            {
                let path = path_of(placed.mesh, part.primitive);
                let indices = vertex_indices(&document, primitive, vertices.len(), &path)?;
                parts.push((primitive.mode, indices, vertices));
            }
        }
        for transform in &transforms {
            let is_mirrored = DMat3::from_mat4(*transform).determinant() < 0.0;
            for (mode, indices, vertices) in &parts {
                each_triangle(*mode, indices, |mut triangle| {
                    if is_mirrored {
                        triangle.swap(1, 2);
                    }
                    let corners = triangle.map(|vertex| {
                        let position = vertices.get(vertex as usize).copied().unwrap_or_default();
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
