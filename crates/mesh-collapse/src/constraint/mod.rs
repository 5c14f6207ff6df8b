//! Constraints: rules that reject collapses at any cost.
//!
//! The mesh itself rejects collapses that would not leave a manifold ([`mesh_core::Topology::check_collapse`]).
//! Constraints reject collapses that leave a bad mesh. A rejected edge is tried again when its neighbourhood has
//! changed.

mod component;
mod face_limits;
mod intersection;
mod normal;
pub(crate) mod shape;

pub use component::ComponentConstraint;
pub use face_limits::FaceLimits;
pub use intersection::IntersectionConstraint;
pub use normal::NormalConstraint;
pub use shape::ShapeConstraint;

use core::fmt;

use glam::DVec3;
use mesh_core::{Remap, TriMesh};

use crate::geometry::edge_patch::{Collapse, EdgePatch};
use crate::policy::{Policy, Scratch};
use crate::rejection::Rejection;

/// A rule that collapses must follow.
///
/// A constraint is `Clone`, because it is also used with trial copies of the mesh.
///
/// ```
/// use glam::DVec3;
/// use mesh_core::{Remap, TriMesh, VertexMap};
/// use mesh_collapse::{Collapse, EdgePatch, Constraint, Policy, Rejection, Scratch};
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
/// impl Constraint for Painted {
///     fn check(&self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
///         let is_painted = |v| self.0.get(v).is_some_and(|&painted| painted);
///         let both = is_painted(patch.removed()) && is_painted(patch.kept());
///         if both { Err(Rejection::Other) } else { Ok(()) }
///     }
/// }
/// ```
pub trait Constraint: Policy + CloneConstraint {
    /// Whether the edge may be collapsed with the remaining vertex at `x`, relative to the midpoint.
    ///
    /// # Errors
    /// The reason for the rejection.
    fn check(
        &self,
        patch: &EdgePatch<'_>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> Result<(), Rejection>;
}

/// Copies constraints of any type. It is implemented for every constraint that is [`Clone`].
pub trait CloneConstraint {
    /// A copy in the current state.
    fn clone_constraint(&self) -> Box<dyn Constraint>;
}

impl<G: Constraint + Clone + 'static> CloneConstraint for G {
    fn clone_constraint(&self) -> Box<dyn Constraint> {
        Box::new(self.clone())
    }
}

/// A list of constraints that follow a mesh. A collapse must satisfy all of them.
#[derive(Default)]
pub struct Constraints(Vec<Box<dyn Constraint>>);

impl Constraints {
    /// Adds a constraint, which is checked after the earlier ones.
    pub fn push(&mut self, constraint: impl Constraint + 'static) {
        self.0.push(Box::new(constraint));
    }

    /// Appends other constraints.
    #[must_use]
    pub fn and(mut self, others: Self) -> Self {
        self.0.extend(others.0);
        self
    }

    /// Checks the constraints in order.
    pub(crate) fn check(
        &self,
        patch: &EdgePatch<'_>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> Result<(), Rejection> {
        self.0.iter().try_for_each(|constraint| constraint.check(patch, x, scratch))
    }
}

impl Policy for Constraints {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.0.iter_mut().for_each(|constraint| constraint.prepare(mesh));
    }

    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        self.0.iter_mut().for_each(|constraint| constraint.collapsed(mesh, collapse));
    }

    fn compacted(&mut self, mesh: &TriMesh, remap: &Remap) {
        self.0.iter_mut().for_each(|constraint| constraint.compacted(mesh, remap));
    }
}

impl Clone for Constraints {
    fn clone(&self) -> Self {
        Self(self.0.iter().map(|constraint| constraint.clone_constraint()).collect())
    }
}

impl fmt::Debug for Constraints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} constraints", self.0.len())
    }
}
