//! How much memory the collapses take, to be said before it is missing.

use mesh_core::TriMesh;

use crate::dispatch::{Regional, regional};
use crate::error::SimplifyError;
use crate::options::Options;

/// About how many bytes the collapses take at most beside the mesh that they are given, with the result.
///
/// In regions that is 65 bytes for each face, or 420 for each face that is wanted where this is more, and
/// 60 for each that a record is kept of, as with a largest error; else 420 for each face. Fitting and
/// measuring come after the collapses, and take memory in proportion to the mesh for the tree over the original
/// and to the result.
#[must_use]
pub fn memory_needed(mesh: &TriMesh, options: &Options) -> u64 {
    let faces = mesh.topology().face_count() as f64;
    let target = options.collapse.limits.face_target(mesh.topology().face_count()) as f64;
    let per_face = match regional(mesh, options) {
        Some(Regional { rules, is_start: false }) => {
            let collapses = (420.0 * target / faces.max(1.0)).clamp(65.0, 250.0);
            collapses + if rules.record { 60.0 } else { 0.0 }
        }
        _ => 420.0,
    };
    // Regions that are at work, whatever the size of the mesh.
    16_000_000 + (per_face * faces) as u64
}

/// An error if the system is known to have less memory than the collapses need.
pub(crate) fn check_memory(mesh: &TriMesh, options: &Options) -> Result<(), SimplifyError> {
    let needed = memory_needed(mesh, options);
    match available() {
        Some(available) if available < needed => Err(SimplifyError::Memory { needed, available }),
        _ => Ok(()),
    }
}

/// The memory that can be had, where the system says it.
fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let kibibytes = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.split_whitespace().next()?.parse::<u64>().ok()
    };
    let free = kibibytes("MemAvailable:")?;
    Some(1024 * (free + kibibytes("SwapFree:").unwrap_or(0)))
}
