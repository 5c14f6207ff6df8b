//! Targets of a run, and reasons for its end.

use core::time::Duration;

/// The limits of a run; the first one that is reached ends it. Without limits, edges are collapsed as long as any
/// collapse is allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Target {
    /// Stop with this many faces, or one fewer: a collapse inside the surface removes two.
    pub faces: Option<usize>,
    /// Stop with this many vertices, not counting vertices without faces.
    pub vertices: Option<usize>,
    /// Stop at this ratio of faces to faces of the input.
    pub ratio: Option<f64>,
    /// Stop before a collapse that costs more than this, in the unit of the cost.
    pub cost: Option<f64>,
    /// Stop after this many collapses.
    pub collapses: Option<usize>,
    /// Stop after this time. The result then depends on the speed of the machine.
    pub time: Option<Duration>,
}

/// The reason why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum StopReason {
    /// The number of faces was reached, given directly or as a ratio.
    Faces,
    /// The number of vertices was reached.
    Vertices,
    /// The number of collapses was reached.
    Collapses,
    /// Every remaining collapse costs more than allowed.
    Cost,
    /// More collapses would exceed the error limit.
    Error,
    /// The time limit was reached.
    Time,
    /// The observer stopped the run.
    Cancelled,
    /// Every remaining edge was rejected.
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
    /// The number of faces at which a run stops, from the count and the ratio, for a mesh with `faces` faces.
    #[must_use]
    pub fn face_target(&self, faces: usize) -> usize {
        let by_ratio = self.ratio.map_or(0, |ratio| (ratio * faces as f64).ceil() as usize);
        self.faces.unwrap_or(0).max(by_ratio)
    }
}
