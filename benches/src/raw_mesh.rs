//! Meshes as plain arrays in a file, for programs in any language.
//!
//! Two counts as 64-bit integers, the coordinates of the vertices as 64-bit floats, the corners of
//! the triangles as 32-bit integers; little-endian, without gaps.

use std::path::Path;

use glam::DVec3;
use mesh_core::{BoundingBox, PolygonSoup, Repair, TriMesh, build};

use xtask_common::Failure;

/// Vertices and triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RawMesh {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl RawMesh {
    /// The arrays of a mesh without gaps.
    pub(crate) fn of(mesh: &TriMesh) -> Self {
        let triangles = mesh.topology().triangles().collect();
        Self { vertices: mesh.positions().to_vec(), triangles }
    }

    /// The arrays of a mesh file, repaired.
    pub(crate) fn from_file(path: &Path) -> Result<Self, Failure> {
        let model = mesh_io::read(path).map_err(Failure::reading(path))?;
        let mut mesh = build(&model.soup, &Repair::lenient()).map_err(Failure::mesh)?.mesh;
        mesh.compact();
        Ok(Self::of(&mesh))
    }

    /// The mesh around the origin with a diagonal of one, rounded to single precision: some tools compute in it. `None`
    /// if it has no extent.
    pub(crate) fn with_unit_diagonal(mut self) -> Option<Self> {
        let bounds = BoundingBox::of_points(self.vertices.iter().copied())
            .filter(|bounds| bounds.diagonal() > 0.0)?;
        let (center, diagonal) = (bounds.center(), bounds.diagonal());
        for vertex in &mut self.vertices {
            *vertex = ((*vertex - center) / diagonal).as_vec3().as_dvec3();
        }
        Some(self)
    }

    pub(crate) fn to_mesh(&self) -> Result<TriMesh, Failure> {
        let soup = PolygonSoup::from_triangles(&self.vertices, &self.triangles);
        Ok(build(&soup.map_err(Failure::mesh)?, &Repair::lenient()).map_err(Failure::mesh)?.mesh)
    }

    /// Unit normals of the vertices: means of the normals of their faces, weighted by area.
    #[cfg(feature = "meshopt")]
    pub(crate) fn vertex_normals(&self) -> Vec<[f32; 3]> {
        let mut sums = vec![DVec3::ZERO; self.vertices.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| self.vertices[v as usize]);
            let normal = (b - a).cross(c - a);
            triangle.iter().for_each(|&v| sums[v as usize] += normal);
        }
        sums.iter().map(|sum| sum.normalize_or_zero().as_vec3().to_array()).collect()
    }

    pub(crate) fn write(&self, path: &Path) -> Result<(), Failure> {
        let counts = [self.vertices.len(), self.triangles.len()].map(|n| n as u64);
        let mut bytes =
            Vec::with_capacity(16 + 24 * self.vertices.len() + 12 * self.triangles.len());
        counts.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        let coordinates = self.vertices.iter().flat_map(DVec3::as_ref);
        coordinates.for_each(|x| bytes.extend(x.to_le_bytes()));
        self.triangles.iter().flatten().for_each(|v| bytes.extend(v.to_le_bytes()));
        std::fs::write(path, bytes).map_err(Failure::writing(path))
    }

    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = std::fs::read(path).map_err(Failure::reading(path))?;
        Self::parse(&bytes)
            .ok_or_else(|| Failure::Usage(format!("{} is no raw mesh", path.display())))
    }

    fn parse(bytes: &[u8]) -> Option<Self> {
        let (counts, rest) = bytes.split_at_checked(16)?;
        let count = |at: usize| Some(u64::from_le_bytes(counts.get(at..at + 8)?.try_into().ok()?));
        let (vertices, triangles) = (count(0)? as usize, count(8)? as usize);
        let (coordinates, corners) = rest.split_at_checked(vertices.checked_mul(24)?)?;
        if corners.len() != triangles.checked_mul(12)? {
            return None;
        }
        let x = |bytes: &[u8]| bytes.try_into().map_or(f64::NAN, f64::from_le_bytes);
        let point = |bytes: &[u8]| DVec3::new(x(&bytes[..8]), x(&bytes[8..16]), x(&bytes[16..]));
        let corner = |bytes: &[u8]| bytes.try_into().map_or(u32::MAX, u32::from_le_bytes);
        let triangle = |bytes: &[u8]| [0, 4, 8].map(|at| corner(&bytes[at..at + 4]));
        Some(Self {
            vertices: coordinates.chunks_exact(24).map(point).collect(),
            triangles: corners.chunks_exact(12).map(triangle).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::RawMesh;
    use glam::DVec3;

    #[test]
    fn a_mesh_survives_the_way_through_the_file() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::new(0.1, -2.0, 1e-9)];
        let raw = RawMesh { vertices, triangles: vec![[0, 1, 2], [2, 1, 0]] };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.raw");
        raw.write(&path).unwrap();
        assert_eq!(RawMesh::read(&path).unwrap(), raw);
        let bytes = std::fs::read(&path).unwrap();
        assert!((0..bytes.len()).all(|end| RawMesh::parse(&bytes[..end]).is_none()));
    }
}
