//! Constraints on every flip of a run, and the smallest gain that counts.

use std::time::Instant;

use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, EdgeMap, FaceTree, Topology, TriMesh, VertexId};

use crate::blocked_edges::Rejection;
use crate::cost::{Change, FlipCost};
use crate::features::locked_edges;
use crate::fold::{folds, is_degenerate, makes_degenerate};
use crate::options::FlipOptions;
use crate::quad::Quad;
use crate::self_intersection::crossed_by_flip;
use crate::shape::ShapeCheck;

/// The part of a run that trial flips do not change, so that threads can share it.
pub(crate) struct Rules<'a, C: FlipCost> {
    pub(crate) cost: &'a C,
    pub(crate) options: &'a FlipOptions,
    pub(crate) locked: EdgeMap<bool>,
    pub(crate) shape: ShapeCheck,
    /// Number of flips of each edge.
    pub(crate) flips_of_edge: EdgeMap<u32>,
    /// The end of the time limit.
    pub(crate) deadline: Option<Instant>,
    /// [`FlipCost::constant`] of the mesh.
    constant: f64,
    /// Gains below this are rounding.
    noise: f64,
    /// Distances below this are rounding.
    resolution: f64,
    max_flips_per_edge: u32,
}

impl<'a, C: FlipCost> Rules<'a, C> {
    pub(crate) fn new(
        mesh: &TriMesh,
        cost: &'a C,
        options: &'a FlipOptions,
        deadline: Option<Instant>,
    ) -> Self {
        Self {
            cost,
            options,
            locked: locked_edges(mesh, options),
            shape: ShapeCheck::new(mesh, options.shape.unwrap_or_else(|| cost.shape_constraint())),
            flips_of_edge: mesh.topology().edge_map(0),
            deadline,
            constant: cost.constant(mesh),
            noise: noise_floor(mesh, cost.length_exponent()),
            resolution: resolution(mesh),
            max_flips_per_edge: options.most_flips_per_edge(cost),
        }
    }

    /// The quadrilateral of an edge that is neither locked nor on the boundary.
    #[inline]
    pub(crate) fn quad(&self, topology: &Topology, edge: EdgeId) -> Option<Quad> {
        if self.locked[edge] || !topology.contains_edge(edge) {
            return None;
        }
        Quad::around(topology, edge)
    }

    /// The change that the flip of an edge would make, legal or not.
    #[inline]
    pub(crate) fn change(&self, mesh: &TriMesh, cache: &C::Cache, edge: EdgeId) -> Option<Change> {
        self.quad(mesh.topology(), edge).map(|quad| self.cost.change(mesh, cache, &quad))
    }

    /// Whether a change lowers the cost by more than rounding. Never for NaN.
    #[inline]
    pub(crate) fn is_gain(&self, change: Change) -> bool {
        change.gain() > self.noise + RELATIVE_NOISE * (change.before.abs() + change.after.abs())
    }

    /// [`Rules::is_gain`] of a change from one total to another.
    pub(crate) fn is_gain_of_totals(&self, [before, after]: [f64; 2]) -> bool {
        self.is_gain(Change { before: before - self.constant, after: after - self.constant })
    }

    /// Whether the height of a triangle is below the resolution of the coordinates.
    pub(crate) fn is_degenerate(&self, mesh: &TriMesh, triangle: [VertexId; 3]) -> bool {
        is_degenerate(mesh, triangle, self.resolution)
    }

    /// The largest turn of a face that is always allowed, if turns are limited.
    pub(crate) fn max_turn(&self) -> Option<f64> {
        let limits = [self.options.max_fold, self.shape.max_turn()];
        limits.into_iter().flatten().reduce(f64::min)
    }

    /// Whether an edge may flip: the check of the mesh and the constraints of the options.
    pub(crate) fn allow(
        &self,
        mesh: &TriMesh,
        tree: Option<&FaceTree>,
        edge: EdgeId,
    ) -> Result<LegalFlip, Rejection> {
        let quad = self.quad(mesh.topology(), edge).ok_or(Rejection::Never)?;
        let flip = mesh.topology().check_flip(edge)?;
        if self.flips_of_edge[edge] >= self.max_flips_per_edge {
            return Err(Rejection::Cycle);
        }
        if makes_degenerate(mesh, &quad, self.resolution) {
            return Err(Rejection::Flat);
        }
        if self.options.max_fold.is_some_and(|limit| folds(mesh, &quad, limit)) {
            return Err(Rejection::Fold);
        }
        self.shape.check(mesh, &quad)?;
        match tree.and_then(|tree| crossed_by_flip(tree, mesh, &quad)) {
            Some(face) => Err(Rejection::Intersection(face)),
            None => Ok(flip),
        }
    }
}

/// Relative rounding error of the sums in a change.
const RELATIVE_NOISE: f64 = 1e-12;

/// The gain that rounding of the coordinates can make.
///
/// Rounding changes a length by the [`resolution`]. A cost with the unit length^k then changes by about
/// the resolution times l^(k-1), where l is the mean edge length.
fn noise_floor(mesh: &TriMesh, length_exponent: i32) -> f64 {
    let topology = mesh.topology();
    let lengths = topology.edges().map(|e| {
        let [a, b] = mesh.segment(e);
        a.distance(b)
    });
    let mean = lengths.sum::<f64>() / (topology.edge_count().max(1) as f64);
    let floor = resolution(mesh) * mean.powi(length_exponent - 1);
    if floor.is_finite() { floor } else { 0.0 }
}

/// Rounding error of a distance that is computed from a few coordinates of the mesh.
fn resolution(mesh: &TriMesh) -> f64 {
    let bounds = mesh.bounding_box();
    let size = bounds.map_or(0.0, |box_| box_.min.abs().max(box_.max.abs()).max_element());
    64.0 * f64::EPSILON * size
}
