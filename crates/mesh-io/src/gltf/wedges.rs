//! Conversion of the vertices and corners of a model to vertices of glTF.

use mesh_core::as_u32;

use crate::error::WriteError;
use crate::format::Format;
use crate::model::Model;
use std::collections::HashMap;

/// The vertices of glTF: one for every combination of a vertex of the model, texture coordinates and normal. The first
/// combination keeps the index of the vertex, so that a mesh without seams keeps its numbering.
pub(super) struct Wedges {
    /// The vertex of the model and the corner that gives the attributes, if any.
    sources: Vec<(u32, u32)>,
    /// The glTF vertex of every corner of the model.
    of_corner: Vec<u32>,
}

/// Marks a vertex that no face uses.
const NO_CORNER: u32 = u32::MAX;

impl Wedges {
    pub(super) fn new(model: &Model, format: Format) -> Result<Self, WriteError> {
        let too_many = |found: usize| WriteError::TooLarge {
            format,
            what: "vertices",
            limit: u64::from(u32::MAX) - 1,
            found: found as u64,
        };
        let vertices = model.soup.vertex_count();
        let last = u32::try_from(vertices).map_err(|_| too_many(vertices))?;
        let mut sources: Vec<_> = (0..last).map(|vertex| (vertex, NO_CORNER)).collect();
        let is_plain = model.corner_uvs.is_none() && model.more_corner_uvs.is_empty();
        if is_plain && model.corner_normals.is_none() {
            return Ok(Self { sources, of_corner: model.soup.corners().to_vec() });
        }
        let key = |corner: u32| {
            let corner = corner as usize;
            let uv = model.corner_uvs.as_ref().map(|uvs| uvs[corner].map(f32::to_bits));
            let normal = model.corner_normals.as_ref().map(|all| all[corner].map(f32::to_bits));
            let more: Vec<_> =
                model.more_corner_uvs.iter().map(|uvs| uvs[corner].map(f32::to_bits)).collect();
            (uv, normal, more)
        };
        let mut extra = HashMap::<_, u32, foldhash::fast::RandomState>::default();
        let mut of_corner = Vec::with_capacity(model.soup.corners().len());
        for (corner, &vertex) in model.soup.corners().iter().enumerate() {
            let corner = as_u32(corner);
            let first = &mut sources[vertex as usize].1;
            if *first == NO_CORNER {
                *first = corner;
            }
            let wedge = if key(*first) == key(corner) {
                vertex
            } else {
                let next = u32::try_from(sources.len()).map_err(|_| too_many(sources.len()))?;
                let wedge = *extra.entry((vertex, key(corner))).or_insert(next);
                if wedge == next {
                    sources.push((vertex, corner));
                }
                wedge
            };
            of_corner.push(wedge);
        }
        Ok(Self { sources, of_corner })
    }

    pub(super) fn count(&self) -> usize {
        self.sources.len()
    }

    /// The vertex of the model for each glTF vertex, and the corner that supplies its attributes.
    pub(super) fn sources(&self) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
        let corner = |corner: u32| (corner != NO_CORNER).then_some(corner as usize);
        self.sources.iter().map(move |&(vertex, from)| (vertex as usize, corner(from)))
    }

    /// The vertices of glTF at the corners of the model.
    pub(super) fn of_corners(&self) -> &[u32] {
        &self.of_corner
    }
}
