//! What a cost has to tell the optimiser.

use mesh_core::TriMesh;

use crate::quad::Quad;

/// A cost of a triangulation that edge flips lower.
///
/// The optimiser needs to know what a flip would change and which other flips that affects. A cost
/// that is a sum over triangles looks like this:
///
/// ```
/// use dtri_flip::{Change, FlipCost, FlipOptions, Quad, Reach, optimise};
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
///     fn reach(&self) -> Reach {
///         Reach::Triangles
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
    /// What the cost keeps at hand to evaluate flips quickly; `()` for nothing. Look-ahead tries
    /// flips on copies of it.
    type Cache: Clone + Send + Sync;

    /// Computes the cache for a mesh.
    fn prepare(&self, mesh: &TriMesh) -> Self::Cache;

    /// Brings the cache up to date after a flip; `flipped` is the quadrilateral as it is now. A flip
    /// and its way back must leave the same bits.
    fn update(&self, _mesh: &TriMesh, _cache: &mut Self::Cache, _flipped: &Quad) {}

    /// The cost of the whole mesh, computed afresh.
    fn total(&self, mesh: &TriMesh) -> f64;

    /// [`FlipCost::total`] of the mesh that a cache was prepared for, with the same bits.
    fn prepared_total(&self, mesh: &TriMesh, _cache: &Self::Cache) -> f64 {
        self.total(mesh)
    }

    /// The part of the cost that the flip of an edge would change, before and after it. It must
    /// not depend on anything that [`FlipCost::reach`] does not cover.
    fn change(&self, mesh: &TriMesh, cache: &Self::Cache, quad: &Quad) -> Change;

    /// [`FlipCost::change`] where that lowers the cost. May be `None` where it does not, so that a
    /// cost can give up as soon as that is clear; must give the same bits otherwise.
    #[inline]
    fn change_if_lower(&self, mesh: &TriMesh, cache: &Self::Cache, quad: &Quad) -> Option<Change> {
        Some(self.change(mesh, cache, quad))
    }

    /// [`FlipCost::change_if_lower`] of several edges, for costs that evaluate them faster side by
    /// side; must give the same bits. `changes` is as long as `quads`.
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

    /// Where [`FlipCost::change`] looks.
    fn reach(&self) -> Reach;

    /// The power of a length that the cost has as its unit: 0 when it does not depend on scale, 1
    /// for a length, 2 for an area. With it, the optimiser tells gains from rounding.
    fn length_exponent(&self) -> i32;

    /// Whether the changes are differences of [`FlipCost::total`], so that a greedy run lowers the
    /// total with each flip. Where not, only the limit of flips per edge guarantees an end.
    fn is_potential(&self) -> bool {
        true
    }
}

/// What a flip changes: parts of the cost, other parts staying as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Change {
    /// The part that would change, before the flip.
    pub before: f64,
    /// The same part after the flip.
    pub after: f64,
}

impl Change {
    /// How much lower the cost would be: the swap value of DHKL01.
    #[inline]
    #[must_use]
    pub fn gain(self) -> f64 {
        self.before - self.after
    }

    /// This change and one that follows it.
    #[inline]
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        Self { before: self.before + next.before, after: self.after + next.after }
    }
}

/// Where the change that a flip makes depends on: what else a flip affects follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reach {
    /// The two triangles at the edge. A flip affects the five edges of these triangles.
    Triangles,
    /// The two triangles and the up to four that share an edge with them. A flip affects 13 edges,
    /// the 2-neighbourhood of DHKL01.
    AdjacentTriangles,
    /// All triangles at the four corners of the quadrilateral. A flip affects every edge of every
    /// triangle at one of its corners.
    CornerStars,
}
