//! A copy of the mesh in flat arrays, ordered so that neighbours in space are neighbours in memory.
//!
//! The faces of a scan can be stored in any order. A walk over its half-edges then misses the cache at
//! each step. Here faces are sorted along a space-filling curve (Morton 1966), vertices are numbered in
//! the order in which the faces use them, and each face stores its corners and its neighbours together.
//!
//! Indices of this copy are called *`SoaMesh` indices*. They differ from the ids of the mesh.

use fearless_simd::Level;
use glam::DVec3;
use mesh_core::{FaceId, Handle, TriMesh, as_u32, parallel};

/// Corners and neighbours of a face. Side i runs from corner i to corner i + 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoaFace {
    /// `SoaMesh` indices of the vertices.
    pub(crate) corners: [u32; 3],
    /// The opposite side across each side: 3 × (`SoaMesh` index of the neighbour) + (number of its side).
    /// [`NONE`] at the boundary.
    pub(crate) opposite: [u32; 3],
}

/// Marks a missing index.
pub(crate) const NONE: u32 = u32::MAX;

/// The faces and vertices of a mesh in Morton order.
#[derive(Clone, Debug)]
pub(crate) struct SoaMesh {
    pub(crate) faces: Vec<SoaFace>,
    pub(crate) positions: Vec<DVec3>,
    /// The id of each face in the mesh.
    pub(crate) face_ids: Vec<FaceId>,
    /// The area of each face.
    pub(crate) areas: Vec<f64>,
    /// The `SoaMesh` index of each face of the mesh; [`NONE`] for removed faces.
    soa_indices: Vec<u32>,
    /// The instruction set of this processor.
    pub(crate) simd: Level,
}

impl SoaMesh {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let face_ids = morton_order(mesh);
        let mut soa_indices = vec![NONE; topology.face_capacity()];
        for (&face, index) in face_ids.iter().zip(0..) {
            soa_indices[face.index()] = index;
        }
        let mut soa_vertices = vec![NONE; topology.vertex_capacity()];
        let mut positions = Vec::with_capacity(topology.vertex_count());
        for &face in &face_ids {
            for vertex in topology.face_vertices(face) {
                let index = &mut soa_vertices[vertex.index()];
                if *index == NONE {
                    *index = as_u32(positions.len());
                    positions.push(mesh.position(vertex));
                }
            }
        }
        let faces = parallel::collect(face_ids.len(), |index| {
            let sides = topology.face_half_edges(face_ids[index]);
            SoaFace {
                corners: sides.map(|side| soa_vertices[topology.origin(side).index()]),
                opposite: sides.map(|side| {
                    let twin = side.twin();
                    topology.face(twin).map_or(NONE, |face| {
                        let [_, second, third] = topology.face_half_edges(face);
                        let number = u32::from(second == twin) + 2 * u32::from(third == twin);
                        3 * soa_indices[face.index()] + number
                    })
                }),
            }
        });
        let areas = parallel::collect(face_ids.len(), |index| mesh.face_area(face_ids[index]));
        Self { faces, positions, face_ids, areas, soa_indices, simd: Level::new() }
    }

    /// The `SoaMesh` index of a face of the mesh.
    pub(crate) fn index_of(&self, face: FaceId) -> u32 {
        self.soa_indices[face.index()]
    }

    /// The positions of three vertices, given by their `SoaMesh` indices.
    #[inline]
    pub(crate) fn triangle(&self, corners: [u32; 3]) -> [DVec3; 3] {
        corners.map(|corner| self.positions[corner as usize])
    }
}

/// All faces, sorted by the Morton code of their first corner and then by id.
fn morton_order(mesh: &TriMesh) -> Vec<FaceId> {
    let topology = mesh.topology();
    let (low, extent) = mesh.bounding_box().map_or((DVec3::ZERO, 1.0), |bounds| {
        let extent = (bounds.max - bounds.min).max_element();
        (bounds.min, if extent > 0.0 { extent } else { 1.0 })
    });
    let mut codes: Vec<(u32, FaceId)> = parallel::collect(topology.face_capacity(), |index| {
        let face = FaceId::from_index(index);
        let code = topology.contains_face(face).then(|| {
            let [corner, ..] = topology.face_vertices(face);
            let cell = (mesh.position(corner) - low) / extent * f64::from(CELLS - 1);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "below CELLS"
            )]
            let [x, y, z] = cell.to_array().map(|place| interleave(place as u32));
            x | y << 1 | z << 2
        });
        (code.unwrap_or(NONE), face)
    });
    codes.retain(|&(code, _)| code != NONE);
    codes.sort_unstable();
    codes.into_iter().map(|(_, face)| face).collect()
}

/// Number of grid cells along each axis.
const CELLS: u32 = 1 << 10;

/// Inserts two zero bits between the lowest ten bits of a number.
fn interleave(number: u32) -> u32 {
    let mut bits = number & (CELLS - 1);
    bits = (bits | bits << 16) & 0x0300_00FF;
    bits = (bits | bits << 8) & 0x0300_F00F;
    bits = (bits | bits << 4) & 0x030C_30C3;
    (bits | bits << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_interleaved_with_zeros() {
        assert_eq!(interleave(0b11_1111_1111), 0o1_111_111_111);
        assert_eq!(interleave(0b10_0000_0101), 0o1_000_000_101);
    }
}
