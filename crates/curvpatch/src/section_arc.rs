//! One half of a section: its end, its length, and the reason why it is short.

use glam::DVec3;

/// The reason why a walk along a section stopped early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WalkEnd {
    /// It reached the boundary of the mesh.
    Boundary,
    /// It returned to its first face.
    Returned,
    /// It crossed more faces than [`max_steps`].
    StepLimit,
}

impl WalkEnd {
    /// Whether the section closes on itself, or counts as closed.
    pub(crate) fn is_closed(self) -> bool {
        matches!(self, Self::Returned | Self::StepLimit)
    }
}

/// The largest number of faces that a walk crosses in a mesh of `faces` faces.
///
/// A section enters a face at most twice. On a surface of well-shaped faces it crosses about √`faces`.
/// It crosses more near the apex of a fan of very many faces; such a section counts as closed.
pub(crate) fn max_steps(faces: usize) -> usize {
    const ROOTS: f64 = 16.0;
    let across = 1024 + (ROOTS * (faces as f64).sqrt()) as usize;
    across.min(2 * faces + 16)
}

/// One half of a section, from its origin on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SectionArc {
    /// The end, relative to the origin of the section.
    pub(crate) end: DVec3,
    /// The length along the section.
    pub(crate) length: f64,
    /// Why the arc is shorter than requested, if it is.
    pub(crate) cut_short: Option<WalkEnd>,
}

impl SectionArc {
    /// An arc of length zero.
    pub(crate) const EMPTY: Self =
        Self { end: DVec3::ZERO, length: 0.0, cut_short: Some(WalkEnd::Boundary) };

    /// An arc of the full `length`, which ends inside a face.
    ///
    /// The face is entered at `from` after the length `walked`; `ahead`, of length `step`, leads to where
    /// the section leaves it.
    #[inline]
    pub(crate) fn full(length: f64, walked: f64, from: DVec3, ahead: DVec3, step: f64) -> Self {
        Self { end: from + (length - walked) / step * ahead, length, cut_short: None }
    }

    /// The other half of a section whose first half is this arc, if both close on themselves.
    ///
    /// The other half is then the same loop in the opposite direction. `exits` are the points where this
    /// half and the other half leave the first face; `limit` is the requested length.
    pub(crate) fn reversed(&self, [this, other]: [DVec3; 2], limit: f64) -> Option<Self> {
        let length = self.length - this.length() + other.length();
        let returns = self.cut_short == Some(WalkEnd::Returned) && length < limit;
        returns.then_some(Self { end: this, length, ..*self })
    }
}
