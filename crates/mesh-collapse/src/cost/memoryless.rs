//! Memoryless simplification (Lindstrom and Turk 1998).

use glam::DVec3;

use super::Cost;
use super::garland_heckbert::length_tie;
use crate::geometry::edge_patch::EdgePatch;
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy, Scratch};

/// The quadric of the current faces, each counted once, without any memory of earlier faces.
#[derive(Clone, Copy, Debug, Default)]
pub struct Memoryless;

impl Policy for Memoryless {}

impl Cost for Memoryless {
    #[inline]
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        Some(patch.face_quadric() + *patch.border())
    }

    #[inline]
    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        x: DVec3,
        _: &mut Scratch,
    ) -> f64 {
        quadric.map_or(0.0, |q| q.value(x)).max(0.0) + length_tie(patch)
    }

    fn needs(&self) -> Needs {
        Needs::Sums
    }
}
