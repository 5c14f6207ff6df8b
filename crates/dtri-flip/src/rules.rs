//! What every flip of a run has to obey, and what counts as a gain.

use std::time::Instant;

use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, EdgeMap, FaceTree, Topology, TriMesh, VertexId};

use crate::cost::{Change, FlipCost};
use crate::features::locked_edges;
use crate::fold::{flattens, folds, is_flat};
use crate::intersection::crossed_by_flip;
use crate::options::FlipOptions;
use crate::quad::Quad;
use crate::waiting::Refusal;

/// The part of a run that trying out flips does not change, so that many can be tried at once.
pub(crate) struct Rules<'a, C: FlipCost> {
    pub(crate) cost: &'a C,
    pub(crate) options: &'a FlipOptions,
    pub(crate) locked: EdgeMap<bool>,
    /// How often each edge has flipped.
    pub(crate) flips_of_edge: EdgeMap<u32>,
    /// When the time is over.
    pub(crate) deadline: Option<Instant>,
    /// Smaller gains are rounding.
    noise: f64,
    /// Smaller distances are rounding.
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
            flips_of_edge: mesh.topology().edge_map(0),
            deadline,
            noise: noise_floor(mesh, cost.length_exponent()),
            resolution: resolution(mesh),
            max_flips_per_edge: options.max_flips_per_edge.unwrap_or(if cost.is_potential() {
                FLIPS_PER_EDGE
            } else {
                FLIPS_PER_EDGE_IN_CIRCLES
            }),
        }
    }

    /// The quadrilateral of an edge that may flip as far as locks and boundary go.
    #[inline]
    pub(crate) fn quad(&self, topology: &Topology, edge: EdgeId) -> Option<Quad> {
        if self.locked[edge] || !topology.contains_edge(edge) {
            return None;
        }
        Quad::around(topology, edge)
    }

    /// What the flip of an edge would change, legal or not.
    #[inline]
    pub(crate) fn change(&self, mesh: &TriMesh, cache: &C::Cache, edge: EdgeId) -> Option<Change> {
        self.quad(mesh.topology(), edge).map(|quad| self.cost.change(mesh, cache, &quad))
    }

    /// Whether a change lowers the cost by more than rounding. Never for NaN.
    #[inline]
    pub(crate) fn is_gain(&self, change: Change) -> bool {
        change.gain() > self.noise + RELATIVE_NOISE * (change.before.abs() + change.after.abs())
    }

    /// Whether a triangle has no area, as far as the coordinates tell.
    pub(crate) fn is_flat(&self, mesh: &TriMesh, triangle: [VertexId; 3]) -> bool {
        is_flat(mesh, triangle, self.resolution)
    }

    /// Whether an edge may flip: the check of the mesh, and the guards that were asked for.
    pub(crate) fn allow(
        &self,
        mesh: &TriMesh,
        tree: Option<&FaceTree>,
        edge: EdgeId,
    ) -> Result<LegalFlip, Refusal> {
        let quad = self.quad(mesh.topology(), edge).ok_or(Refusal::Never)?;
        let flip = mesh.topology().check_flip(edge)?;
        if self.flips_of_edge[edge] >= self.max_flips_per_edge {
            return Err(Refusal::Cycle);
        }
        if flattens(mesh, &quad, self.resolution) {
            return Err(Refusal::Flat);
        }
        if self.options.max_fold.is_some_and(|limit| folds(mesh, &quad, limit)) {
            return Err(Refusal::Fold);
        }
        match tree.and_then(|tree| crossed_by_flip(tree, mesh, &quad)) {
            Some(face) => Err(Refusal::Intersection(face)),
            None => Ok(flip),
        }
    }
}

/// Relative rounding of the sums that a change consists of.
const RELATIVE_NOISE: f64 = 1e-12;

/// How often an edge may flip by default, for potentials and for other costs.
const FLIPS_PER_EDGE: u32 = 100;
const FLIPS_PER_EDGE_IN_CIRCLES: u32 = 8;

/// The gain that rounding the coordinates could make.
///
/// Rounding changes a length by the [`resolution`]; a cost with the unit length^k changes by about
/// that times l^(k-1), where l is the typical edge length.
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

/// Distances that sums and products of a few coordinates of the mesh's faces cannot tell from 0.
fn resolution(mesh: &TriMesh) -> f64 {
    let bounds = mesh.bounding_box();
    let size = bounds.map_or(0.0, |box_| box_.min.abs().max(box_.max.abs()).max_element());
    64.0 * f64::EPSILON * size
}
