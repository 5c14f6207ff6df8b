//! Cutting of polygons for formats that hold only triangles.

use glam::DVec3;
use mesh_core::build::Triangulator;
use mesh_core::{PolygonSoup, as_u32};

/// Cuts faces into triangles, along diagonals that stay inside.
#[derive(Default)]
pub(crate) struct Cutter {
    triangulator: Triangulator,
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter {
    /// The triangles of a face, as indices into the face; the number is that of its corners minus two.
    pub(crate) fn cut(&mut self, soup: &PolygonSoup, face: usize) -> &[[u32; 3]] {
        let vertices = soup.face(face);
        self.positions.clear();
        self.positions.extend(vertices.iter().map(|&v| soup.positions()[v as usize]));
        self.cut_here(vertices)
    }

    /// The triangles of a polygon, as indices into it, from the numbers and positions of its vertices.
    pub(crate) fn cut_polygon(&mut self, vertices: &[u64], corners: &[DVec3]) -> &[[u32; 3]] {
        self.positions.clear();
        self.positions.extend_from_slice(corners);
        if vertices.len() == 3 {
            return self.cut_here(&[0, 1, 2]);
        }
        // Only the equality of vertices matters.
        let mut sorted = vertices.to_vec();
        sorted.sort_unstable();
        let place = |v: &u64| as_u32(sorted.partition_point(|other| other < v));
        let local: Vec<u32> = vertices.iter().map(place).collect();
        self.cut_here(&local)
    }

    fn cut_here(&mut self, vertices: &[u32]) -> &[[u32; 3]] {
        self.triangles.clear();
        if self.positions.iter().all(|p| p.is_finite()) {
            self.triangulator.triangulate(&self.positions, vertices, &mut self.triangles);
        } else {
            // A degenerate polygon has no interior; any triangles are acceptable.
            self.triangles.extend((2..as_u32(vertices.len())).map(|last| [0, last - 1, last]));
        }
        &self.triangles
    }
}
