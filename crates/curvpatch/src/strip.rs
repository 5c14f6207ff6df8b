//! Patches at equal distances along a normal section (SN10, Fig. 8).

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};

use crate::curvature_error::{CurvatureError, check_radius};
use crate::curvature_estimator::CurvatureEstimator;
use crate::patch_fit::{FitError, PatchFit};
use crate::scalar_walk::ScalarWalk;
use crate::section_arc::WalkEnd;
use crate::section_plane::SectionPlane;
use crate::shape::Shape;
use crate::surface_point::SurfacePoint;

/// Options for a strip of patches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StripOptions {
    /// The radius `r_g` of every patch, in model units.
    pub radius: f64,
    /// The shape of every patch.
    pub shape: Shape,
    /// The distance of consecutive centres along the section, in model units.
    pub spacing: f64,
    /// The largest number of patches.
    pub max_patches: usize,
}

impl StripOptions {
    /// Circular patches of this radius, 1.5 radii apart, at most 100.
    #[must_use]
    pub fn new(radius: f64) -> Self {
        Self { radius, shape: Shape::Circle, spacing: 1.5 * radius, max_patches: 100 }
    }
}

/// The reason why a strip ends.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StripEnd {
    /// The strip has `max_patches` patches.
    MaxPatches,
    /// The section ended at the boundary of the mesh.
    Boundary,
    /// The section returned to its first face.
    Closed,
    /// There is no patch at the next point.
    NoPatch(FitError),
}

/// Patches along a section.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// The patches, in the order of the section.
    pub patches: Vec<PatchFit>,
    /// The reason why the strip ends.
    pub end: StripEnd,
}

/// The reason why there is no strip.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StripError {
    /// There is no patch at the start.
    #[error(transparent)]
    Start(#[from] FitError),
    /// The direction is zero, not finite, or parallel to the normal.
    #[error(
        "direction {direction} is parallel to the normal of face {face}, zero or not finite; give a tangential direction"
    )]
    BadDirection {
        /// The direction.
        direction: DVec3,
        /// The face of the start.
        face: FaceId,
    },
    /// The spacing is zero, negative or not finite.
    #[error("the spacing of a strip is {spacing}, but it must be positive and finite")]
    BadSpacing {
        /// The spacing.
        spacing: f64,
    },
}

impl CurvatureEstimator<'_> {
    /// Patches with centres at equal distances along the normal section through `start`, in the
    /// tangential part of `direction`.
    ///
    /// # Errors
    /// No patch at the start, a direction parallel to the normal, or a spacing that is not positive.
    pub fn strip(
        &self,
        start: impl Into<SurfacePoint>,
        direction: DVec3,
        options: &StripOptions,
    ) -> Result<Strip, StripError> {
        let StripOptions { radius, shape, spacing, max_patches } = *options;
        let start = start.into();
        if !(spacing > 0.0 && spacing.is_finite()) {
            return Err(StripError::BadSpacing { spacing });
        }
        check_radius(radius).map_err(FitError::from)?;
        let first = self.patch(start, radius, shape)?;
        let normal = self.mesh().face_normal(start.face());
        let tangent = (direction - direction.dot(normal) * normal)
            .try_normalize()
            .ok_or(StripError::BadDirection { direction, face: start.face() })?;
        let mut patches = vec![first];
        let plane = SectionPlane::new(first.curvature.center, normal, tangent);
        let end = self.follow(start, &plane, spacing, |point| {
            if patches.len() >= max_patches {
                return Some(StripEnd::MaxPatches);
            }
            match self.patch(point, radius, shape) {
                Ok(fit) => patches.push(fit),
                Err(error) => return Some(StripEnd::NoPatch(error)),
            }
            None
        });
        Ok(Strip { patches, end })
    }

    /// Visits points at multiples of `spacing` along the forward half of a section, until `visit` returns
    /// a reason or the section ends.
    fn follow(
        &self,
        start: SurfacePoint,
        plane: &SectionPlane,
        spacing: f64,
        mut visit: impl FnMut(SurfacePoint) -> Option<StripEnd>,
    ) -> StripEnd {
        let mesh = self.mesh();
        let Some([mut walk, _]) = ScalarWalk::both_ways(mesh, start.face(), plane) else {
            let error = CurvatureError::DegenerateFace { face: start.face() };
            return StripEnd::NoPatch(error.into());
        };
        let mut last = DVec3::ZERO;
        let mut until_next = spacing;
        loop {
            let crossing = walk.crossing();
            let length = crossing.distance(last);
            let mut walked = 0.0;
            while walked + until_next <= length {
                walked += until_next;
                until_next = spacing;
                let at = plane.origin + last + walked / length * (crossing - last);
                if let Some(end) = visit(inside(mesh, walk.face(), at)) {
                    return end;
                }
            }
            until_next -= length - walked;
            last = crossing;
            match walk.step() {
                Ok(()) => {}
                Err(WalkEnd::Boundary) => return StripEnd::Boundary,
                Err(WalkEnd::Returned | WalkEnd::StepLimit) => return StripEnd::Closed,
            }
        }
    }
}

/// A position on a face as an interior point: its barycentric coordinates are at least a millionth.
fn inside(mesh: &TriMesh, face: FaceId, at: DVec3) -> SurfacePoint {
    let [a, b, c] = mesh.triangle(face);
    let normal = (b - a).cross(c - a);
    let share = |p: DVec3, q: DVec3| (p - at).cross(q - at).dot(normal).max(0.0);
    let weights = [share(b, c), share(c, a), share(a, b)];
    let sum: f64 = weights.iter().sum();
    let inner = weights.map(|weight| weight.max(1e-6 * sum));
    // A face without area has no interior. Its barycentre leads to the corresponding error.
    SurfacePoint::new(face, inner).unwrap_or(SurfacePoint::barycentre(face))
}
