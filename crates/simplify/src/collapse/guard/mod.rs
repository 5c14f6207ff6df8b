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

use core::fmt;

use glam::DVec3;
use mesh_core::{Remap, TriMesh};

use crate::collapse::patch::{Collapse, EdgePatch};
use crate::collapse::policy::{Policy, Scratch};
use crate::collapse::refusal::Refusal;

/// A rule that collapses must follow.
///
/// A guard is `Clone`, since it is asked about meshes that are tried and given up again.
///
/// ```
/// use glam::DVec3;
/// use mesh_core::{Remap, TriMesh, VertexMap};
/// use simplify::{Collapse, EdgePatch, Guard, Policy, Refusal, Scratch};
///
/// /// Vertices that were painted stay apart from each other.
/// #[derive(Clone)]
/// struct Painted(VertexMap<bool>);
///
/// impl Policy for Painted {
///     fn collapsed(&mut self, _: &TriMesh, collapse: &Collapse) {
///         if self.0.get(collapse.removed).is_some_and(|&painted| painted) {
///             self.0.insert(collapse.kept, true);
///         }
///     }
///
///     fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
///         self.0 = self.0.compact(remap);
///     }
/// }
///
/// impl Guard for Painted {
///     fn check(&self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> Result<(), Refusal> {
///         let is_painted = |v| self.0.get(v).is_some_and(|&painted| painted);
///         let both = is_painted(patch.removed()) && is_painted(patch.kept());
///         if both { Err(Refusal::Other) } else { Ok(()) }
///     }
/// }
/// ```
pub trait Guard: Policy + CloneGuard {
    /// Whether the edge may be collapsed with its vertex going to `x`, relative to the midpoint.
    ///
    /// # Errors
    /// The reason why not.
    fn check(&self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) -> Result<(), Refusal>;
}

/// Copies guards of any type; every guard that is [`Clone`] has it.
pub trait CloneGuard {
    /// A copy, as it is by now.
    fn clone_guard(&self) -> Box<dyn Guard>;
}

impl<G: Guard + Clone + 'static> CloneGuard for G {
    fn clone_guard(&self) -> Box<dyn Guard> {
        Box::new(self.clone())
    }
}

/// Guards that follow a mesh, all of which a collapse has to pass.
#[derive(Default)]
pub struct Guards(Vec<Box<dyn Guard>>);

impl Guards {
    /// One more guard, which is asked after those before it.
    pub fn push(&mut self, guard: impl Guard + 'static) {
        self.0.push(Box::new(guard));
    }

    /// Asks one after the other.
    pub(crate) fn check(
        &self,
        patch: &EdgePatch<'_>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> Result<(), Refusal> {
        self.0.iter().try_for_each(|guard| guard.check(patch, x, scratch))
    }
}

impl Policy for Guards {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.0.iter_mut().for_each(|guard| guard.prepare(mesh));
    }

    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        self.0.iter_mut().for_each(|guard| guard.collapsed(mesh, collapse));
    }

    fn compacted(&mut self, mesh: &TriMesh, remap: &Remap) {
        self.0.iter_mut().for_each(|guard| guard.compacted(mesh, remap));
    }
}

impl Clone for Guards {
    fn clone(&self) -> Self {
        Self(self.0.iter().map(|guard| guard.clone_guard()).collect())
    }
}

impl fmt::Debug for Guards {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} guards", self.0.len())
    }
}
