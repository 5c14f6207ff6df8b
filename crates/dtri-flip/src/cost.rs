//! The interface between a cost and the optimiser.

use mesh_core::TriMesh;

use crate::quad::Quad;
use crate::shape::ShapeConstraint;

/// A cost of a triangulation that edge flips lower.
///
/// A cost states how a flip changes it and which other flips that affects. Example of a sum over
/// triangles:
///
/// ```
/// use dtri_flip::{Change, FlipCost, FlipOptions, Quad, Stencil, optimise};
/// use mesh_core::{TriMesh, VertexId};
/// use mesh_shapes::Torus;
///
/// /// The sum of the squared areas.
/// struct SquaredArea;
///
/// impl SquaredArea {
///     fn of(mesh: &TriMesh, corners: [VertexId; 3]) -> f64 {
///         let [a, b, c] = corners.map(|v| mesh.position(v));
///         0.25 * (b - a).cross(c - a).length_squared()
///     }
/// }
///
/// impl FlipCost for SquaredArea {
///     type Cache = ();
///     fn prepare(&self, _: &TriMesh) {}
///     fn total(&self, mesh: &TriMesh) -> f64 {
///         mesh.topology().faces().map(|f| Self::of(mesh, mesh.topology().face_vertices(f))).sum()
///     }
///     fn change(&self, mesh: &TriMesh, _: &(), quad: &Quad) -> Change {
///         let sum = |triangles: [_; 2]| triangles.map(|t| Self::of(mesh, t)).iter().sum();
///         Change { before: sum(quad.triangles()), after: sum(quad.flipped_triangles()) }
///     }
///     fn stencil(&self) -> Stencil {
///         Stencil::Triangles
///     }
///     fn length_exponent(&self) -> i32 {
///         4
///     }
/// }
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let torus = Torus { major: 5.0, minor: 2.0 }.shifted_mesh(12, 6)?;
/// let mut mesh = TriMesh::from_soup(&torus)?;
/// let report = optimise(&mut mesh, &SquaredArea, &FlipOptions::default())?;
/// assert!(report.cost_after < report.cost_before);
/// # Ok(())
/// # }
/// ```
pub trait FlipCost: Sync {
    /// Data that the cost keeps to evaluate flips quickly; `()` for none. Look-ahead uses copies.
    type Cache: Clone + Send + Sync;

    /// Computes the cache for a mesh.
    fn prepare(&self, mesh: &TriMesh) -> Self::Cache;

    /// Updates the cache after a flip; `flipped` is the quadrilateral after the flip. A flip and its
    /// reverse must restore the same bits.
    fn update(&self, _mesh: &TriMesh, _cache: &mut Self::Cache, _flipped: &Quad) {}

    /// Cost of the whole mesh, computed from scratch.
    fn total(&self, mesh: &TriMesh) -> f64;

    /// [`FlipCost::total`] of the mesh of this cache, with the same bits.
    fn prepared_total(&self, mesh: &TriMesh, _cache: &Self::Cache) -> f64 {
        self.total(mesh)
    }

    /// The part of [`FlipCost::total`] that no flip changes. The rounding error of a total is relative to
    /// the rest.
    fn constant(&self, _mesh: &TriMesh) -> f64 {
        0.0
    }

    /// The part of the cost that the flip of an edge would change, before and after the flip. It must
    /// depend only on the triangles in [`FlipCost::stencil`].
    fn change(&self, mesh: &TriMesh, cache: &Self::Cache, quad: &Quad) -> Change;

    /// [`FlipCost::change`] if it lowers the cost, with the same bits. May be `None` otherwise, so that a
    /// cost can stop early.
    #[inline]
    fn change_if_lower(&self, mesh: &TriMesh, cache: &Self::Cache, quad: &Quad) -> Option<Change> {
        Some(self.change(mesh, cache, quad))
    }

    /// [`FlipCost::change_if_lower`] of several quadrilaterals, with the same bits, for costs with a
    /// vectorised evaluation. `changes` is as long as `quads`.
    fn changes_if_lower(
        &self,
        mesh: &TriMesh,
        cache: &Self::Cache,
        quads: &[Option<Quad>],
        changes: &mut [Option<Change>],
    ) {
        for (change, quad) in core::iter::zip(changes, quads) {
            *change = quad.as_ref().and_then(|quad| self.change_if_lower(mesh, cache, quad));
        }
    }

    /// The triangles that [`FlipCost::change`] depends on.
    fn stencil(&self) -> Stencil;

    /// The unit of the cost as a power of length: 0 if it is scale-invariant, 1 for a length, 2 for an
    /// area. The optimiser derives the rounding error of a gain from it.
    fn length_exponent(&self) -> i32;

    /// Whether changes are differences of [`FlipCost::total`], so that each greedy flip lowers the
    /// total. If not, only the limit of flips per edge guarantees termination.
    fn is_potential(&self) -> bool {
        true
    }

    /// The default shape constraint. [`ShapeConstraint::KeepShape`] unless the theory of the cost needs
    /// convex quadrilaterals.
    fn shape_constraint(&self) -> ShapeConstraint {
        ShapeConstraint::KeepShape
    }
}

/// The part of a cost that a flip changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Change {
    /// This part before the flip.
    pub before: f64,
    /// This part after the flip.
    pub after: f64,
}

impl Change {
    /// Decrease of the cost: the swap value of DHKL01.
    #[inline]
    #[must_use]
    pub fn gain(self) -> f64 {
        self.before - self.after
    }

    /// The sum of this change and a following one.
    #[inline]
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        Self { before: self.before + next.before, after: self.after + next.after }
    }
}

/// The triangles that the change of a flip depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Stencil {
    /// The two triangles at the edge. A flip affects the five edges of these triangles.
    Triangles,
    /// The two triangles and the triangles that share an edge with them. A flip affects 13 edges, the
    /// 2-neighbourhood of DHKL01.
    AdjacentTriangles,
    /// All triangles at the four corners of the quadrilateral. A flip affects all edges of these
    /// triangles.
    CornerStars,
}
