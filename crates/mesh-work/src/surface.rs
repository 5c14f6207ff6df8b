//! The surface or the points of a file, for distances.

use mesh_core::PolygonSoup;
use mesh_core::build::Triangulator;
use mesh_metric::{Surface, SurfaceError};

/// Whether a file has points only, without faces between them.
#[must_use]
pub fn is_point_cloud(soup: &PolygonSoup) -> bool {
    soup.face_count() == 0 && soup.vertex_count() > 0
}

/// The surface of any polygons, or the points if there are no faces.
///
/// # Errors
/// As [`surface`] and [`Surface::of_points`].
pub fn surface_or_points(soup: &PolygonSoup) -> Result<Surface, SurfaceError> {
    if is_point_cloud(soup) { Surface::of_points(soup.positions()) } else { surface(soup) }
}

/// The surface of any polygons. They are cut into triangles and need not form a manifold.
///
/// # Errors
/// As [`Surface::from_triangles`].
pub fn surface(soup: &PolygonSoup) -> Result<Surface, SurfaceError> {
    let mut triangulator = Triangulator::default();
    let (mut triangles, mut local, mut positions) = (Vec::new(), Vec::new(), Vec::new());
    for face in soup.faces() {
        if let &[a, b, c] = face {
            triangles.push([a, b, c]);
            continue;
        }
        // A corner without a vertex is reported below.
        positions.clear();
        positions.extend(face.iter().filter_map(|&v| soup.positions().get(v as usize).copied()));
        if positions.len() < face.len() {
            triangles.extend(face.first_chunk::<3>());
            continue;
        }
        local.clear();
        triangulator.triangulate(&positions, face, &mut local);
        triangles.extend(local.iter().map(|t| t.map(|corner| face[corner as usize])));
    }
    Surface::from_triangles(soup.positions(), &triangles)
}
