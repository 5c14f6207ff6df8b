//! What an edge costs, found out in steps.
//!
//! A bound from the ends of the edge alone comes first, then a bound from what the faces around it add up to,
//! then the cost itself, then the cost modifiers; as soon as one of them is above the threshold, that is enough.
//! The faces are collected as late as the policies let them.

use glam::DVec3;
use mesh_core::{EdgeId, TriMesh};

use crate::cost::Cost;
use crate::engine::vertex_freedom::VertexFreedom;
use crate::geometry::edge_patch::{EdgePatch, LazyPatch, Place};
use crate::placement::Placement;
use crate::policies::Policies;
use crate::policy::Scratch;
use crate::rejection::Rejection;

/// What is known of the cost of an edge.
pub(super) enum Assessment {
    /// It is more than the threshold, and no less than this.
    Above(f64),
    /// It is exactly this when the vertex that remains goes to this place.
    Exact(Place, f64),
}

/// A bound of the cost of an edge from its ends alone, if there is one.
#[inline]
pub(super) fn early_bound<C: Cost, P>(
    mesh: &TriMesh,
    policies: &Policies<C, P>,
    fixed: &VertexFreedom,
    edge: EdgeId,
) -> Option<f64> {
    let patch = EdgePatch::without_faces(mesh, edge.half_edge());
    let patch = patch.with_border(fixed.border(&patch));
    policies.cost.early_bound(&patch).filter(|bound| !bound.is_nan())
}

/// The place and the cost of an edge, or a bound of the cost when that is above the threshold.
#[inline]
pub(super) fn assess<C: Cost, P: Placement>(
    Policies { cost, modifiers, placement, .. }: &Policies<C, P>,
    fixed: &VertexFreedom,
    lazy: &mut LazyPatch<'_>,
    ceiling: f64,
    scratch: &mut Scratch,
) -> Result<Assessment, Rejection> {
    let patch = &lazy.as_is();
    let forced = fixed.place(patch)?;
    let quadric = cost.quadric(patch);
    let quadric = quadric.as_ref();
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
        Some(bound) if bound > ceiling => return Ok(Assessment::Above(bound)),
        _ => {}
    }
    let base = cost.cost(patch, quadric, x, scratch);
    if !modifiers.is_empty() && base > ceiling {
        return Ok(Assessment::Above(base));
    }
    let cost = raise(base, x, lazy, scratch);
    if cost.is_nan() { Err(Rejection::NotFinite) } else { Ok(Assessment::Exact(place, cost)) }
}

/// What it costs to collapse an edge to a place, relative to its midpoint.
pub(super) fn cost_at<C: Cost, P>(
    Policies { cost, modifiers, .. }: &Policies<C, P>,
    patch: &EdgePatch<'_>,
    x: DVec3,
    scratch: &mut Scratch,
) -> f64 {
    let quadric = cost.quadric(patch);
    let base = cost.cost(patch, quadric.as_ref(), x, scratch);
    modifiers.iter().fold(base, |cost, modifier| modifier.raise(cost, patch, x, scratch))
}
