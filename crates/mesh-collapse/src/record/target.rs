//! When to stop collapsing, and why it stopped.

use core::time::Duration;

/// Target; the first one that is reached ends the run. Without any, edges are collapsed for as long
/// as it is allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Target {
    /// Stop with this many faces, or one fewer: a collapse inside the surface removes two.
    pub faces: Option<usize>,
    /// Stop with this many vertices, those without faces not counted.
    pub vertices: Option<usize>,
    /// Stop at this ratio of faces to faces of the input.
    pub ratio: Option<f64>,
    /// Stop before a collapse that costs more than this. The unit is that of the cost.
    pub cost: Option<f64>,
    /// Stop after this many collapses.
    pub collapses: Option<usize>,
    /// Stop after this time. The result then depends on how fast the machine is.
    pub time: Option<Duration>,
}

/// Why no more edges were collapsed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum StopReason {
    /// The number of faces was reached, given as such or as a ratio.
    Faces,
    /// The number of vertices was reached.
    Vertices,
    /// The number of collapses was reached.
    Collapses,
    /// Every collapse that is left costs more than allowed.
    Cost,
    /// More collapses would have exceeded the largest allowed error.
    Error,
    /// The time was up.
    Time,
    /// The observer said so.
    Cancelled,
    /// Every edge that is left was rejected.
    NothingLeft,
}

impl StopReason {
    /// A short name in lower case, for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Faces => "faces",
            Self::Vertices => "vertices",
            Self::Collapses => "collapses",
            Self::Cost => "cost",
            Self::Error => "error",
            Self::Time => "time",
            Self::Cancelled => "cancelled",
            Self::NothingLeft => "nothing_left",
        }
    }
}

impl Target {
    /// The number of faces to stop at for a mesh of so many, from the count and the ratio.
    #[must_use]
    pub fn face_target(&self, faces: usize) -> usize {
        let by_ratio = self.ratio.map_or(0, |ratio| (ratio * faces as f64).ceil() as usize);
        self.faces.unwrap_or(0).max(by_ratio)
    }
}
