//! Meshes shared by the benchmarks.

use std::path::PathBuf;

use mesh_core::build::{Repair, build};
use mesh_core::{PolygonSoup, TriMesh};
use mesh_shapes::Torus;

/// The numbers of faces at which scaling is measured.
pub const SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];

/// A regular torus of about `faces` triangles.
///
/// # Panics
/// Never for the sizes in [`SIZES`].
#[must_use]
#[allow(clippy::expect_used)]
pub fn torus_soup(faces: usize) -> PolygonSoup {
    let sides = ((faces / 4) as f64).sqrt().round() as usize;
    let rings = faces / (2 * sides);
    Torus { major: 5.0, minor: 2.0 }.mesh(rings, sides).expect("a torus of many rings")
}

/// [`torus_soup`] as a mesh.
///
/// # Panics
/// Never for the sizes in [`SIZES`].
#[must_use]
#[allow(clippy::expect_used)]
pub fn torus(faces: usize) -> TriMesh {
    TriMesh::from_soup(&torus_soup(faces)).expect("a torus is a manifold")
}

/// The index triples of a soup of triangles.
#[must_use]
pub fn triangles(soup: &PolygonSoup) -> Vec<[u32; 3]> {
    soup.corners().as_chunks().0.to_vec()
}

/// A real mesh, if the environment variable `CURVMESH_MODELS` names a folder that has it.
#[must_use]
pub fn model(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("CURVMESH_MODELS")?;
    Some(PathBuf::from(folder).join(name)).filter(|path| path.is_file())
}

/// [`model`], read and repaired as needed.
///
/// # Panics
/// When the file cannot be read: a benchmark without its mesh is useless.
#[must_use]
#[allow(clippy::expect_used)]
pub fn model_mesh(name: &str) -> Option<TriMesh> {
    let model = mesh_io::read(model(name)?).expect("the model can be read");
    Some(build(&model.soup, &Repair::lenient()).expect("repairs leave a manifold").mesh)
}
