//! A warning for each mesh that was repaired without being asked.
//!
//! Meshes are built without the interpreter lock; the call that holds it again warns.

use std::ffi::CString;
use std::sync::{Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;

/// What no call has told yet.
static UNTOLD: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn untold() -> MutexGuard<'static, Vec<String>> {
    UNTOLD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps a warning that names repairs and how many there are of each.
pub(crate) fn put(repairs: &[(&str, usize)]) {
    if !repairs.is_empty() {
        let repairs: Vec<_> =
            repairs.iter().map(|(what, count)| format!("{what}: {count}")).collect();
        let text = format!(
            "the mesh is repaired for this: {} (repair() returns the repaired mesh, validate() refuses such a mesh)",
            repairs.join(", ")
        );
        untold().push(text);
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
