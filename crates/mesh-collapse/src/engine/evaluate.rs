//! The cost of an edge, evaluated in steps.
//!
//! The first step is a bound from the ends of the edge alone. Then come a bound from sums over the faces around it, the
//! cost itself, and the cost modifiers. The evaluation ends as soon as a step exceeds the threshold. The faces are
//! collected as late as the policies allow.

use glam::DVec3;
use mesh_core::{EdgeId, TriMesh};

use crate::cost::Cost;
use crate::engine::vertex_freedom::VertexFreedom;
use crate::geometry::edge_patch::{EdgePatch, LazyPatch, Place};
use crate::placement::Placement;
use crate::policies::Policies;
use crate::policy::Scratch;
use crate::rejection::Rejection;

/// The result of an evaluation.
pub(super) enum Assessment {
    /// The cost is above the threshold, and at least this.
    Above(f64),
    /// The exact cost, with the position of the remaining vertex.
    Exact(Place, f64),
}

/// A lower bound of the cost of an edge from its ends alone, if there is one.
#[inline]
pub(super) fn early_bound<C: Cost, P>(
    mesh: &TriMesh,
    policies: &Policies<C, P>,
    fixed: &VertexFreedom,
    edge: EdgeId,
) -> Option<f64> {
    let patch = EdgePatch::without_faces(mesh, edge.half_edge());
    let patch = patch.with_border(fixed.border(&patch));
    let bound = policies.cost.early_bound(&patch).map(|bound| bound * fixed.cost_factor(&patch));
    bound.filter(|bound| !bound.is_nan())
}

/// The position and the cost of an edge, or a lower bound of the cost if it is above the threshold.
#[inline]
pub(super) fn assess<C: Cost, P: Placement>(
    Policies { cost, modifiers, placement, .. }: &Policies<C, P>,
    fixed: &VertexFreedom,
    lazy: &mut LazyPatch<'_>,
    threshold: f64,
    scratch: &mut Scratch,
) -> Result<Assessment, Rejection> {
    let patch = &lazy.as_is();
    let forced = fixed.place(patch)?;
    let quadric = cost.quadric(patch);
    let quadric = quadric.as_ref();
    let factor = fixed.cost_factor(patch);
    let raise = |base: f64, x: DVec3, lazy: &mut LazyPatch<'_>, scratch: &mut Scratch| {
        if modifiers.is_empty() {
            return base;
        }
        let patch = &lazy.with_faces();
        modifiers.iter().fold(base, |cost, modifier| modifier.raise(cost, patch, x, scratch))
    };
    let place = forced.unwrap_or_else(|| {
        let mut at = |x| raise(cost.cost(patch, quadric, x, scratch), x, lazy, scratch);
        placement.place(patch, quadric, &mut at)
    });
    let x = patch.offset(place);
    if !x.is_finite() {
        return Err(Rejection::NotFinite);
    }
    match cost.lower_bound(patch, quadric, x) {
        Some(bound) if bound * factor > threshold => return Ok(Assessment::Above(bound * factor)),
        _ => {}
    }
    let base = cost.cost(patch, quadric, x, scratch);
    if !modifiers.is_empty() && base * factor > threshold {
        return Ok(Assessment::Above(base * factor));
    }
    let cost = raise(base, x, lazy, scratch) * factor;
    if cost.is_nan() { Err(Rejection::NotFinite) } else { Ok(Assessment::Exact(place, cost)) }
}

/// The cost of a collapse of an edge to a position, relative to its midpoint.
pub(super) fn cost_at<C: Cost, P>(
    Policies { cost, modifiers, .. }: &Policies<C, P>,
    fixed: &VertexFreedom,
    patch: &EdgePatch<'_>,
    x: DVec3,
    scratch: &mut Scratch,
) -> f64 {
    let quadric = cost.quadric(patch);
    let base = cost.cost(patch, quadric.as_ref(), x, scratch);
    let raised =
        modifiers.iter().fold(base, |cost, modifier| modifier.raise(cost, patch, x, scratch));
    raised * fixed.cost_factor(patch)
}
