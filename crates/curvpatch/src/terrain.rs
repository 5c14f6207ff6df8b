//! A mesh laid out for growing regions and walking sections: what is near in space is near in memory.
//!
//! The faces of a scan may stand in any order, so that to walk over the half-edges waits for another
//! place of memory at each step. Here faces stand in the order of a curve that fills space (Morton
//! 1966), vertices in the order in which faces need them, and each face has its corners and neighbours
//! side by side.

use fearless_simd::Level;
use glam::DVec3;
use mesh_core::{FaceId, Handle, TriMesh, parallel};

/// The corners of a face and what is beyond its sides; side i runs from corner i to corner i + 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceLinks {
    /// Places of vertices.
    pub(crate) corners: [u32; 3],
    /// The same sides as the faces beyond have them: three times the place of a face and the number of its
    /// side; [`NONE`] at the boundary.
    pub(crate) beyond: [u32; 3],
}

/// No place.
pub(crate) const NONE: u32 = u32::MAX;

/// The faces and vertices of a mesh in an order of their own, in which each has a place.
#[derive(Clone, Debug)]
pub(crate) struct Terrain {
    pub(crate) links: Vec<FaceLinks>,
    pub(crate) positions: Vec<DVec3>,
    pub(crate) face_at: Vec<FaceId>,
    /// The areas of the faces.
    pub(crate) areas: Vec<f64>,
    /// [`NONE`] for removed faces.
    place_of_face: Vec<u32>,
    /// What the processor can do.
    pub(crate) simd: Level,
}

impl Terrain {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let face_at = along_curve(mesh);
        let mut place_of_face = vec![NONE; topology.face_capacity()];
        for (&face, place) in face_at.iter().zip(0..) {
            place_of_face[face.index()] = place;
        }
        let mut place_of_vertex = vec![NONE; topology.vertex_capacity()];
        let mut positions = Vec::with_capacity(topology.vertex_count());
        for &face in &face_at {
            for vertex in topology.face_vertices(face) {
                let place = &mut place_of_vertex[vertex.index()];
                if *place == NONE {
                    *place = positions.len() as u32;
                    positions.push(mesh.position(vertex));
                }
            }
        }
        let links = parallel::collect(face_at.len(), |place| {
            let sides = topology.face_half_edges(face_at[place]);
            FaceLinks {
                corners: sides.map(|side| place_of_vertex[topology.origin(side).index()]),
                beyond: sides.map(|side| {
                    let twin = side.twin();
                    topology.face(twin).map_or(NONE, |face| {
                        let [_, second, third] = topology.face_half_edges(face);
                        let number = u32::from(second == twin) + 2 * u32::from(third == twin);
                        3 * place_of_face[face.index()] + number
                    })
                }),
            }
        });
        let areas = parallel::collect(face_at.len(), |place| mesh.face_area(face_at[place]));
        Self { links, positions, face_at, areas, place_of_face, simd: Level::new() }
    }

    /// The place of a face of the mesh.
    pub(crate) fn place(&self, face: FaceId) -> u32 {
        self.place_of_face[face.index()]
    }

    /// Where the vertices at these places are.
    #[inline]
    pub(crate) fn triangle(&self, corners: [u32; 3]) -> [DVec3; 3] {
        corners.map(|corner| self.positions[corner as usize])
    }
}

/// All faces, by the place of their first corner on the curve and then by number.
fn along_curve(mesh: &TriMesh) -> Vec<FaceId> {
    let topology = mesh.topology();
    let (low, extent) = mesh.bounding_box().map_or((DVec3::ZERO, 1.0), |bounds| {
        let extent = (bounds.max - bounds.min).max_element();
        (bounds.min, if extent > 0.0 { extent } else { 1.0 })
    });
    let mut keys: Vec<(u32, FaceId)> = parallel::collect(topology.face_capacity(), |index| {
        let face = FaceId::from_index(index);
        let place = topology.contains_face(face).then(|| {
            let [corner, ..] = topology.face_vertices(face);
            let steps = (mesh.position(corner) - low) / extent * f64::from(STEPS - 1);
            spread_bits(steps.x as u32)
                | spread_bits(steps.y as u32) << 1
                | spread_bits(steps.z as u32) << 2
        });
        (place.unwrap_or(NONE), face)
    });
    keys.retain(|&(place, _)| place != NONE);
    keys.sort_unstable();
    keys.into_iter().map(|(_, face)| face).collect()
}

/// Steps along each axis.
const STEPS: u32 = 1 << 10;

/// Puts two zeros between each two of the lowest ten bits.
fn spread_bits(number: u32) -> u32 {
    let mut bits = number & (STEPS - 1);
    bits = (bits | bits << 16) & 0x0300_00FF;
    bits = (bits | bits << 8) & 0x0300_F00F;
    bits = (bits | bits << 4) & 0x030C_30C3;
    (bits | bits << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread() {
        assert_eq!(spread_bits(0b11_1111_1111), 0o1_111_111_111);
        assert_eq!(spread_bits(0b10_0000_0101), 0o1_000_000_101);
    }
}
