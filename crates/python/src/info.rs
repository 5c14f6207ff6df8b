//! `curvmesh.info`.

use mesh_core::diagnose;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::failure::Failure;
use crate::host::{Call, run};
use crate::mesh::MeshData;

/// Counts, topology, defects and sizes of any polygons, with the vertices joined that all other
/// functions join.
#[pyfunction]
pub(crate) fn info<'py>(
    py: Python<'py>,
    call: &Call,
    mesh: &MeshData,
) -> PyResult<Bound<'py, PyDict>> {
    let content = mesh.content();
    let (found, measures, joined) = run(py, call, move |_| {
        let soup = content.joined();
        let joined = content.model.soup.vertex_count() - soup.vertex_count();
        Ok((diagnose(&soup).map_err(Failure::from)?, soup.measure(), joined))
    })?;
    let told = PyDict::new(py);
    let counts = [
        ("vertices", found.vertices),
        ("faces", found.triangles + found.quadrilaterals + found.larger_polygons),
        ("triangles", found.triangles),
        ("quadrilaterals", found.quadrilaterals),
        ("larger_polygons", found.larger_polygons),
        ("edges", found.edges),
        ("boundary_edges", found.boundary_edges),
        ("boundary_loops", found.boundary_loops),
        ("components", found.components),
        ("edge_components", found.edge_components),
        ("non_manifold_edges", found.non_manifold_edges),
        ("non_manifold_vertices", found.non_manifold_vertices),
        ("inconsistent_edges", found.inconsistent_edges),
        ("duplicate_faces", found.duplicate_faces),
        ("degenerate_faces", found.degenerate_faces()),
        ("repeated_vertex_faces", found.repeated_vertex_faces),
        ("zero_area_faces", found.zero_area_faces),
        ("sliver_faces", found.slivers),
        ("unreferenced_vertices", found.unreferenced_vertices),
        ("non_finite_vertices", found.non_finite_vertices),
        ("joined_vertices", joined),
    ];
    for (name, count) in counts {
        told.set_item(name, count)?;
    }
    told.set_item("inside_out", found.inside_out)?;
    told.set_item("euler_characteristic", found.euler_characteristic)?;
    told.set_item("closed", found.is_closed())?;
    told.set_item("manifold", found.is_manifold())?;
    told.set_item("oriented", found.is_oriented())?;
    let bounds = measures.bounds;
    told.set_item("bbox_min", bounds.map(|b| b.min.to_array()))?;
    told.set_item("bbox_max", bounds.map(|b| b.max.to_array()))?;
    let finite = |value: f64| value.is_finite().then_some(value);
    told.set_item("area", bounds.and_then(|_| finite(measures.area)))?;
    let encloses = found.is_closed() && found.is_oriented();
    let volume = bounds.and_then(|_| finite(measures.volume)).filter(|_| encloses);
    told.set_item("volume", volume)?;
    Ok(told)
}
