//! Cutting polygons for formats that hold nothing but triangles.

use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_core::build::Triangulator;

/// Cuts faces into triangles, along diagonals that stay inside.
#[derive(Default)]
pub(crate) struct Cutter {
    triangulator: Triangulator,
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter {
    /// The triangles of a face, as places in the face: two fewer than it has corners.
    pub(crate) fn cut(&mut self, soup: &PolygonSoup, face: usize) -> &[[u32; 3]] {
        let vertices = soup.face(face);
        self.triangles.clear();
        self.positions.clear();
        self.positions.extend(vertices.iter().map(|&v| soup.positions()[v as usize]));
        if self.positions.iter().all(|p| p.is_finite()) {
            self.triangulator.triangulate(&self.positions, vertices, &mut self.triangles);
        } else {
            // Nowhere is inside; any triangles will do.
            self.triangles.extend((2..vertices.len() as u32).map(|last| [0, last - 1, last]));
        }
        &self.triangles
    }
}
