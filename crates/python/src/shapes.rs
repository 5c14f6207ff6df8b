//! Shapes with known curvature, for tests and examples.

use mesh_core::PolygonSoup;
use mesh_core::build::Weld;
use mesh_shapes::{Sphere, Torus, polyhedra};
use pyo3::prelude::*;

use crate::failure::Failure;
use crate::mesh::MeshData;

fn made<E: std::fmt::Display>(py: Python<'_>, soup: Result<PolygonSoup, E>) -> PyResult<MeshData> {
    let soup = soup.map_err(|error| Failure::option(error).raise(py))?;
    Ok(MeshData::new(soup.into(), Weld::None))
}

/// A sphere of an icosahedron cut into four so many times.
#[pyfunction]
pub(crate) fn sphere(py: Python<'_>, level: u32, radius: f64) -> PyResult<MeshData> {
    made(py, Sphere { radius }.icosphere(level))
}

/// A torus; `shifted` turns every other ring by half a step.
#[pyfunction]
pub(crate) fn torus(
    py: Python<'_>,
    rings: usize,
    sides: usize,
    major: f64,
    minor: f64,
    shifted: bool,
) -> PyResult<MeshData> {
    let torus = Torus { major, minor };
    made(py, if shifted { torus.shifted_mesh(rings, sides) } else { torus.mesh(rings, sides) })
}

/// A regular polyhedron by its number of faces.
#[pyfunction]
pub(crate) fn polyhedron(py: Python<'_>, faces: usize) -> PyResult<MeshData> {
    let found = match faces {
        4 => Ok(polyhedra::tetrahedron()),
        6 => Ok(polyhedra::cube()),
        8 => Ok(polyhedra::octahedron()),
        20 => Ok(polyhedra::icosahedron()),
        _ => Err(format!("there is no polyhedron of {faces} faces here; there are 4, 6, 8 and 20")),
    };
    made(py, found)
}
