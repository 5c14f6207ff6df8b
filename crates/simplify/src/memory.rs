//! Memory that the collapses take, checked before the work.

use mesh_core::TriMesh;

use crate::error::SimplifyError;
use crate::options::Options;
use crate::plan::Plan;

/// Upper estimate of the bytes that the collapses take besides the input, the result included.
///
/// In blocks these are 65 bytes per face, or 420 per wanted face if that is more, and 60 per face if collapses are
/// recorded or a largest error is set; otherwise 420 per face. Refinement and measurement follow the collapses; their
/// memory is proportional to the input, for its search tree, and to the result.
#[must_use]
pub fn memory_needed(mesh: &TriMesh, options: &Options) -> u64 {
    needed_by(&Plan::of(options, mesh), mesh, options)
}

fn needed_by(plan: &Plan, mesh: &TriMesh, options: &Options) -> u64 {
    let faces = mesh.topology().face_count() as f64;
    let target = options.target.face_target(mesh.topology().face_count()) as f64;
    let per_face = match plan {
        Plan::Blocks { rules } => {
            let collapses = (420.0 * target / faces.max(1.0)).clamp(65.0, 250.0);
            collapses + if rules.record { 60.0 } else { 0.0 }
        }
        Plan::BlocksThenGreedy { .. } | Plan::GreedyInBlocks | Plan::Greedy => 420.0,
    };
    // Blocks in progress, independent of the size of the mesh.
    16_000_000 + (per_face * faces) as u64
}

/// An error if the system is known to have less memory than the collapses need.
pub(crate) fn check_memory(
    plan: &Plan,
    mesh: &TriMesh,
    options: &Options,
) -> Result<(), SimplifyError> {
    let needed = needed_by(plan, mesh, options);
    match available() {
        Some(available) if available < needed => Err(SimplifyError::Memory { needed, available }),
        _ => Ok(()),
    }
}

/// Available memory in bytes, where the system tells it.
fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let kibibytes = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.split_whitespace().next()?.parse::<u64>().ok()
    };
    let free = kibibytes("MemAvailable:")?;
    Some(1024 * (free + kibibytes("SwapFree:").unwrap_or(0)))
}
