//! Errors of a patch against the mesh, and the limits that it has to keep.

/// Largest distances between a patch and the mesh, in model units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PatchErrors {
    /// Largest Euclidean distance of a test point of the patch from the mesh.
    ///
    /// Test points are q(u, φ) for u = 1/2 and u = 1 at 16 angles φ each.
    pub points: f64,
    /// Largest height difference between a mesh vertex and the patch, along the normal of the patch.
    ///
    /// All vertices over or under the footprint count.
    pub heights: f64,
    /// Largest distance from the mesh of a test point beyond its boundary, where such points are ignored; 0 where they
    /// are not. It tells how far the patch sticks out, and is no error.
    #[cfg_attr(feature = "serde", serde(default))]
    pub overhang: f64,
}

impl PatchErrors {
    /// The larger of both errors.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.points.max(self.heights)
    }
}

/// The conditions that an admissible patch fulfils.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FitLimits {
    /// The largest error, in model units.
    pub(crate) tolerance: f64,
    /// Whether test points beyond the boundary of the mesh are ignored.
    pub(crate) overhang: bool,
    /// Number of angles of the full test.
    pub(crate) angles: u32,
    /// Whether only the ends of the two principal arcs are tested, and no vertices.
    pub(crate) ends_only: bool,
}
