//! Normal sections as polygons, for drawings.

use glam::DVec3;

use crate::curvature_estimator::CurvatureEstimator;
use crate::disc_curvature::DiscCurvature;
use crate::scalar_walk::ScalarWalk;
use crate::section::Section;
use crate::section_curvature::section_curvature;
use crate::section_plane::SectionPlane;
use crate::surface_point::SurfacePoint;

/// A normal section of a disc.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SectionTrace {
    /// The polygon in which the plane cuts the mesh, from the backward end through the centre to the
    /// forward end.
    pub points: Vec<DVec3>,
    /// The index of the centre in `points`.
    pub center: usize,
    /// The normal curvature by the section rule of the estimator, in 1 / length, positive where convex.
    pub curvature: f64,
}

impl SectionTrace {
    /// The distance between both ends: the diameter of the disc, d in SN10.
    #[must_use]
    pub fn chord(&self) -> f64 {
        match self.points[..] {
            [first, .., last] => first.distance(last),
            _ => 0.0,
        }
    }
}

impl CurvatureEstimator<'_> {
    /// The section through the centre of a disc in the direction cos φ e₁ + sin φ e₂, of the length of
    /// the radius to either side. `angle` is φ in radians; `point` is the point of the disc.
    ///
    /// At the boundary of the mesh the polygon ends.
    #[must_use]
    pub fn trace(
        &self,
        point: impl Into<SurfacePoint>,
        disc: &DiscCurvature,
        angle: f64,
    ) -> SectionTrace {
        let (sin, cos) = angle.sin_cos();
        let [e1, e2, normal] = disc.frame;
        let tangent = (cos * e1 + sin * e2).normalize_or(e1);
        let plane = SectionPlane::new(disc.center, normal, tangent);
        let face = point.into().face();
        let walks = ScalarWalk::both_ways(self.mesh(), face, &plane);
        let [forward, backward] = match walks {
            Some(walks) => walks.map(|walk| polygon(walk, disc.radius)),
            None => [Vec::new(), Vec::new()],
        };
        let section = Section::measure(self.mesh(), face, &plane, normal, disc.radius);
        let center = backward.len();
        let offsets = backward.into_iter().rev().chain([DVec3::ZERO]).chain(forward);
        SectionTrace {
            points: offsets.map(|offset| disc.center + offset).collect(),
            center,
            curvature: section_curvature(self.params().section, &section),
        }
    }
}

/// The corners of one half-section up to a length, relative to its origin.
fn polygon(mut walk: ScalarWalk<'_>, length: f64) -> Vec<DVec3> {
    let mut corners = Vec::new();
    let mut left = length;
    let mut last = DVec3::ZERO;
    loop {
        let ahead = walk.crossing() - last;
        let step = ahead.length();
        if step >= left {
            corners.push(last + left / step * ahead);
            return corners;
        }
        left -= step;
        last += ahead;
        corners.push(last);
        if walk.step().is_err() {
            return corners;
        }
    }
}
