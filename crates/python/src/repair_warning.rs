//! A warning for each mesh that was repaired without being asked.
//!
//! Meshes are built without the interpreter lock; the call that holds it again warns.

use std::ffi::CString;
use std::sync::{Mutex, MutexGuard, PoisonError};

use mesh_core::build::BuildReport;
use mesh_core::measure::cracks::Cracks;
use mesh_io::Lost;
use pyo3::prelude::*;

/// What no call has told yet.
static UNTOLD: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn untold() -> MutexGuard<'static, Vec<String>> {
    UNTOLD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps a warning that names repairs and how many there are of each.
pub(crate) fn put(repairs: &[(&str, usize)]) {
    let cure = "repair() returns the repaired mesh, validate() refuses such a mesh";
    keep("the mesh is repaired", repairs, cure);
}

/// Keeps a warning of content that is lost.
pub(crate) fn put_lost(lost: &Lost) {
    untold().push(format!("lost {lost}"));
}

/// Keeps a warning of narrow gaps.
pub(crate) fn put_cracks(Cracks { vertices, width }: &Cracks) {
    untold().push(format!(
        "{vertices} boundary vertices stay apart from others within {width:.1e}; \
         repair(mesh, weld={:.1e}) joins them",
        2.0 * width
    ));
}

/// Keeps a warning for the meshes of a scene. Vertices that the format splits are always merged.
pub(crate) fn put_of_scene(repairs: &[(&str, usize)]) {
    let repairs: Vec<_> =
        repairs.iter().copied().filter(|repair| repair.0 != BuildReport::MERGED).collect();
    let cure = "the result has the counts in its repairs";
    keep("meshes of the scene are repaired", &repairs, cure);
}

fn keep(what: &str, repairs: &[(&str, usize)], cure: &str) {
    if !repairs.is_empty() {
        let repairs: Vec<_> =
            repairs.iter().map(|(what, count)| format!("{what}: {count}")).collect();
        untold().push(format!("{what} for this: {} ({cure})", repairs.join(", ")));
    }
}

/// Warns of all repairs since the last call.
///
/// # Errors
/// Warnings are exceptions by a filter of the caller.
pub(crate) fn tell(py: Python<'_>) -> PyResult<()> {
    let untold = std::mem::take(&mut *untold());
    if untold.is_empty() {
        return Ok(());
    }
    let class = py.import("curvmesh._errors")?.getattr("RepairWarning")?;
    for text in untold {
        PyErr::warn(py, &class, &CString::new(text).unwrap_or_default(), 2)?;
    }
    Ok(())
}
