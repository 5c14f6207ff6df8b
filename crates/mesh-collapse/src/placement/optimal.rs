//! The minimum of the quadric.

use glam::DVec3;

use super::Placement;
use crate::geometry::edge_patch::{EdgePatch, Place};
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy};

/// Puts the vertex at the minimum of the quadric of the cost, or of the memoryless quadric if the cost has none.
///
/// If the minimum is undetermined, or farther than ten edge lengths from the midpoint of the edge, the best of the
/// midpoint and the two ends is used.
#[derive(Clone, Copy, Debug)]
pub struct Optimal {
    /// Whether only positions that keep the volume are allowed (Lindstrom and Turk 1998).
    pub keep_volume: bool,
}

impl Default for Optimal {
    fn default() -> Self {
        Self { keep_volume: true }
    }
}

/// The largest accepted distance from the midpoint of the edge, in edge lengths.
const FARTHEST: f64 = 10.0;

impl Policy for Optimal {}

impl Placement for Optimal {
    #[inline]
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        _: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        let quadric = quadric.copied().unwrap_or_else(|| patch.face_quadric() + *patch.border());
        let plane = if self.keep_volume { patch.volume_plane() } else { None };
        let near = FARTHEST * FARTHEST * patch.squared_length();
        match quadric.minimizer(plane) {
            Some(x) if x.length_squared() <= near => Place::At(x),
            _ => best_on_edge(patch, &quadric),
        }
    }

    fn needs(&self) -> Needs {
        Needs::Sums
    }
}

/// The best of the midpoint and the two ends, in this order for equal values.
fn best_on_edge(patch: &EdgePatch<'_>, quadric: &Quadric) -> Place {
    let mut best = (quadric.constant, Place::At(DVec3::ZERO));
    for place in [Place::Removed, Place::Kept] {
        let value = quadric.value(patch.offset(place));
        if value < best.0 {
            best = (value, place);
        }
    }
    best.1
}
