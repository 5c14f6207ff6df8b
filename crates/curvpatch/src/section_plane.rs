//! The cutting plane of a normal section, and mesh vertices relative to it.

use glam::DVec3;

/// A plane through a point, spanned by a normal and a tangent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SectionPlane {
    /// The point that the section starts from.
    pub(crate) origin: DVec3,
    /// The unit tangent of the forward half of the section.
    pub(crate) tangent: DVec3,
    /// The unit normal of the plane.
    pub(crate) across: DVec3,
}

impl SectionPlane {
    pub(crate) fn new(origin: DVec3, normal: DVec3, tangent: DVec3) -> Self {
        Self { origin, tangent, across: normal.cross(tangent) }
    }
}

/// A vertex with its signed distance from a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SignedVertex {
    /// Position relative to the origin of the section.
    pub(crate) at: DVec3,
    /// Signed distance from the plane.
    pub(crate) distance: f64,
}

impl SignedVertex {
    #[inline]
    pub(crate) fn new(position: DVec3, origin: DVec3, across: DVec3) -> Self {
        let at = position - origin;
        Self { at, distance: across.dot(at) }
    }

    /// Whether the vertex is above the plane. A vertex in the plane counts as above.
    #[inline]
    pub(crate) fn is_above(&self) -> bool {
        self.distance >= 0.0
    }

    /// The point where the segment between vertices on either side crosses the plane.
    #[inline]
    pub(crate) fn crossing(from: &Self, to: &Self) -> DVec3 {
        from.at + from.distance / (from.distance - to.distance) * (to.at - from.at)
    }
}
