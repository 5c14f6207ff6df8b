//! Which collapses are refused, however cheap they are.
//!
//! The mesh itself refuses those that would not leave a manifold
//! ([`mesh_core::Topology::check_collapse`]). Guards refuse those that leave a bad one. An edge
//! that was refused is tried again once its neighbourhood has changed.

mod component;
mod intersection;
mod normal;
mod shape;

pub use component::ComponentGuard;
pub use intersection::IntersectionGuard;
pub use normal::NormalGuard;
pub use shape::ShapeGuard;

use glam::DVec3;
use mesh_core::TriMesh;

use crate::collapse::patch::{Collapse, EdgePatch};
use crate::collapse::refusal::Refusal;

/// A rule that collapses must follow.
pub trait Guard {
    /// Called once, before anything is checked.
    fn prepare(&mut self, mesh: &TriMesh) {
        let _ = mesh;
    }

    /// Whether the edge may be collapsed with its vertex going to `x`, relative to the midpoint.
    ///
    /// # Errors
    /// The reason why not.
    fn check(&self, patch: &EdgePatch<'_>, x: DVec3) -> Result<(), Refusal>;

    /// Called after each collapse, with the mesh as it is then.
    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        let _ = (mesh, collapse);
    }
}
