//! Functions shared by the tests.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout)]

use mesh_core::{PolygonSoup, TriMesh};
use mesh_shapes::Torus;

pub(crate) const TORUS: Torus = Torus { major: 5.0, minor: 2.0 };

pub(crate) fn mesh_of(soup: &PolygonSoup) -> TriMesh {
    TriMesh::from_soup(soup).unwrap()
}

/// The shifted torus of DHKL01 sec. 4.
pub(crate) fn paper_torus() -> TriMesh {
    mesh_of(&TORUS.shifted_mesh(12, 6).unwrap())
}

/// The faces as sorted triples, each starting with its smallest vertex.
pub(crate) fn face_set(mesh: &TriMesh) -> Vec<[u32; 3]> {
    mesh.topology().canonical_triangles()
}

/// A mesh from the folder named by `CURVMESH_MODELS`; prints a message if there is none.
pub(crate) fn model(name: &str) -> Option<TriMesh> {
    let Some(folder) = std::env::var_os("CURVMESH_MODELS") else {
        println!("skipped: set CURVMESH_MODELS");
        return None;
    };
    let path = std::path::Path::new(&folder).join(name);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(mesh_of(&mesh_io::read(path).unwrap().soup))
}
