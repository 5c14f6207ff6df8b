//! Preparing a mesh for 3D printing: drops debris, turns components outward, separates touching parts.

use std::collections::HashMap;

use mesh_core::measure::Facing;
use mesh_core::{FaceId, MeshError, TriMesh, VertexId, as_u32, unit_sized_points};

use crate::loaded::Loaded;

/// Parts that touch are separated by this share of the diagonal of the bounding box, or slightly more if single
/// precision is coarser.
const SEPARATION: f64 = 1e-6;
/// The largest share.
const LARGEST_STEP: f64 = 1e-2;

/// Touching parts cannot be separated in single precision without a change of the shape.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{count} vertices have equal positions in single precision, which formats of 3D printing have; with coordinates up to {largest:e}, it cannot keep them apart; move the mesh to the origin"
)]
#[non_exhaustive]
pub struct TooFarToSeparate {
    /// The number of vertices.
    pub count: usize,
    /// The largest coordinate.
    pub largest: f64,
}

impl Loaded {
    /// Drops connected components whose bounding box has a diagonal below `share` of the diagonal of the whole mesh.
    /// Returns the number of dropped components.
    ///
    /// # Errors
    /// A position is not finite.
    pub fn drop_debris(&mut self, share: f64) -> Result<usize, MeshError> {
        let Some(whole) = self.mesh.bounding_box() else { return Ok(0) };
        let parts = self.mesh.split_components()?;
        let is_debris = |mesh: &TriMesh| {
            mesh.bounding_box().is_some_and(|part| part.diagonal() < share * whole.diagonal())
        };
        let dropped: Vec<_> = parts.iter().filter(|part| is_debris(&part.mesh)).collect();
        if dropped.is_empty() {
            return Ok(0);
        }
        let mut is_kept = vec![true; self.mesh.topology().face_capacity()];
        for part in &dropped {
            part.face_source.iter().for_each(|face| is_kept[face.index()] = false);
        }
        self.rebuild(|face| is_kept[face.index()], |_| false)?;
        Ok(dropped.len())
    }

    /// Turns components that are inside out, as [`Repair::reorient`](mesh_core::Repair::reorient) does. Returns their
    /// number.
    ///
    /// # Errors
    /// A position is not finite.
    pub fn turn_outward(&mut self) -> Result<usize, MeshError> {
        let facings = self.mesh.facings();
        let count = facings.count(Facing::InsideOut);
        if count > 0 {
            let mut is_turned = vec![false; self.mesh.topology().face_capacity()];
            facings.inside_out().flatten().for_each(|face| is_turned[face.index()] = true);
            self.rebuild(|_| true, |face| is_turned[face.index()])?;
        }
        Ok(count)
    }

    /// The mesh of some faces, some of which are reversed.
    fn rebuild(
        &mut self,
        is_kept: impl Fn(FaceId) -> bool,
        is_reversed: impl Fn(FaceId) -> bool,
    ) -> Result<(), MeshError> {
        let topology = self.mesh.topology();
        let turn = |face: FaceId, [a, b, c]: [u32; 3]| match is_reversed(face) {
            true => [a, c, b],
            false => [a, b, c],
        };
        let mut triangles = Vec::new();
        let (mut face_source, mut corner_source) = (Vec::new(), Vec::new());
        let mut is_used = vec![false; topology.vertex_capacity()];
        for face in topology.faces().filter(|&face| is_kept(face)) {
            let vertices = topology.face_vertices(face);
            vertices.iter().for_each(|v| is_used[v.index()] = true);
            triangles.push(turn(face, vertices.map(VertexId::get)));
            face_source.push(self.provenance.face_source[face.index()]);
            corner_source.push(turn(face, self.provenance.corner_source[face.index()]));
        }
        let mut new_index = vec![0; is_used.len()];
        let (mut positions, mut vertex_source) = (Vec::new(), Vec::new());
        for v in topology.vertices().filter(|v| is_used[v.index()]) {
            new_index[v.index()] = as_u32(positions.len());
            positions.push(self.mesh.position(v));
            vertex_source.push(self.provenance.vertex_source[v.index()]);
        }
        triangles.as_flattened_mut().iter_mut().for_each(|v| *v = new_index[*v as usize]);
        self.mesh = TriMesh::from_triangles(&positions, &triangles)?;
        self.provenance.vertex_source = vertex_source;
        self.provenance.face_source = face_source;
        self.provenance.corner_source = corner_source;
        Ok(())
    }

    /// Separates vertices at the same position, by a small step of each against its normal. Where parts touch, readers
    /// that join vertices by position, like STL readers, would otherwise join the parts at edges of four faces.
    /// Positions count as equal if they are equal in single precision. Returns the number of moved vertices.
    ///
    /// # Errors
    /// The mesh is so far from the origin that the step would be more than 1 % of its diagonal.
    pub fn separate_touching(&mut self) -> Result<usize, TooFarToSeparate> {
        let Some(bounds) = self.mesh.bounding_box() else { return Ok(0) };
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let step = (SEPARATION * bounds.diagonal()).max(8.0 * f64::from(f32::EPSILON) * largest);
        // In single precision at the size of the mesh, or at unit size. Adding zero turns -0.0 into 0.0.
        let (places, _) = unit_sized_points(self.mesh.positions());
        let key = |v: VertexId| places[v.index()].to_array().map(|x| (x as f32 + 0.0).to_bits());
        let mut count_at: HashMap<[u32; 3], usize> = HashMap::new();
        for v in self.mesh.topology().vertices() {
            *count_at.entry(key(v)).or_default() += 1;
        }
        let touching: Vec<VertexId> =
            self.mesh.topology().vertices().filter(|&v| count_at[&key(v)] > 1).collect();
        if !touching.is_empty() && step > LARGEST_STEP * bounds.diagonal() {
            return Err(TooFarToSeparate { count: touching.len(), largest });
        }
        let moved: Vec<_> = touching
            .iter()
            .map(|&v| self.mesh.position(v) - step * self.mesh.vertex_normal(v))
            .collect();
        drop(places);
        for (&v, position) in touching.iter().zip(moved) {
            self.mesh.positions_mut()[v.index()] = position;
        }
        Ok(touching.len())
    }
}
