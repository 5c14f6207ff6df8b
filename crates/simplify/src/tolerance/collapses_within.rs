//! The number of collapses of a run whose result stays within a distance, without refinement.

use mesh_collapse::CollapseLog;
use mesh_core::TriMesh;
use mesh_metric::Surface;
use mesh_refine::Observer;

use crate::error::SimplifyError;
use crate::tolerance::measure::{ErrorCheck, Measuring};

/// The largest number of collapses of a run after which the level is within a distance of the mesh that the run was
/// made on, in both directions. The search stops within 0.5 % of the vertices. The distance is measured as for
/// [`ToleranceOptions::distance`](crate::ToleranceOptions::distance).
///
/// # Errors
/// The limit is negative or not finite, the mesh has no faces, or the log belongs to another mesh.
pub fn collapses_within(
    mesh: &TriMesh,
    log: &CollapseLog,
    limit: f64,
    check: ErrorCheck,
) -> Result<usize, SimplifyError> {
    let fits = limit >= 0.0 && limit.is_finite();
    SimplifyError::unless(fits, "limit", limit, "at least 0 and finite")?;
    let original = Surface::new(mesh)?;
    let measuring = Measuring { original: &original, check, limit: Some(limit) };
    let is_within = |collapses: usize| -> Result<bool, SimplifyError> {
        let (level, _) = log.level(mesh, collapses)?;
        let error = measuring.measure(&level, &mut Observer::none())?;
        Ok(error.is_some_and(|error| error.is_within(limit)))
    };
    let (mut good, mut bad) = (0, log.len());
    if is_within(bad)? {
        return Ok(bad);
    }
    let vertices = mesh.topology().vertex_count();
    while bad - good > 1 + (vertices - good) / 200 {
        // The geometric mean of the vertex counts: errors grow with the size of the faces.
        let middle = vertices as f64 - (((vertices - good) * (vertices - bad)) as f64).sqrt();
        let middle = (middle as usize).clamp(good + 1, bad - 1);
        *(if is_within(middle)? { &mut good } else { &mut bad }) = middle;
    }
    Ok(good)
}
