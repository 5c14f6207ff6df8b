//! Reasons for rejections of edges, and their counts.

use mesh_core::edit::CollapseRefusal;

/// The reason why an edge was not collapsed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Rejection {
    /// The ends share a neighbour that is not opposite to the edge: other edges would be merged.
    LinkCondition,
    /// An interior edge joins two boundary vertices: the surface would be pinched.
    JoinsBoundaries,
    /// The last face of its component would vanish.
    LastFace,
    /// The component is a tetrahedron.
    Tetrahedron,
    /// Both ends are locked.
    Locked,
    /// Feature lines would be joined, shortened or merged.
    Feature,
    /// The normal of a face would turn too far.
    NormalTurn,
    /// A face would become a sliver or lose its area.
    Sliver,
    /// A component would become too small.
    Component,
    /// Faces would intersect.
    Intersection,
    /// A face would fold over in the texture.
    TextureFold,
    /// The mesh would be too far from the original.
    Distance,
    /// An end of the edge has too many edges; the edge is tried again when it has fewer.
    Valence,
    /// An edge would become too long.
    MaxEdge,
    /// An angle of a face would become too small.
    MinAngle,
    /// A vertex would get too many edges.
    MaxValence,
    /// The cost or the new position is not a number.
    NotFinite,
    /// A custom constraint rejected the collapse for another reason.
    Other,
}

impl Rejection {
    /// All reasons, in order.
    pub const ALL: &'static [Self] = &[
        Self::LinkCondition,
        Self::JoinsBoundaries,
        Self::LastFace,
        Self::Tetrahedron,
        Self::Locked,
        Self::Feature,
        Self::NormalTurn,
        Self::Sliver,
        Self::Component,
        Self::Intersection,
        Self::TextureFold,
        Self::Distance,
        Self::Valence,
        Self::MaxEdge,
        Self::MinAngle,
        Self::MaxValence,
        Self::NotFinite,
        Self::Other,
    ];

    /// A short name in lower case, for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::LinkCondition => "link_condition",
            Self::JoinsBoundaries => "joins_boundaries",
            Self::LastFace => "last_face",
            Self::Tetrahedron => "tetrahedron",
            Self::Locked => "locked",
            Self::Feature => "feature",
            Self::NormalTurn => "normal_turn",
            Self::Sliver => "sliver",
            Self::Component => "component",
            Self::Intersection => "intersection",
            Self::TextureFold => "texture_fold",
            Self::Distance => "distance",
            Self::Valence => "valence",
            Self::MaxEdge => "max_edge",
            Self::MinAngle => "min_angle",
            Self::MaxValence => "max_valence",
            Self::NotFinite => "not_finite",
            Self::Other => "other",
        }
    }
}

impl From<CollapseRefusal> for Rejection {
    fn from(rejection: CollapseRefusal) -> Self {
        match rejection {
            CollapseRefusal::LinkCondition(_) => Self::LinkCondition,
            CollapseRefusal::JoinsBoundaries => Self::JoinsBoundaries,
            CollapseRefusal::LastFace(_) => Self::LastFace,
            CollapseRefusal::Tetrahedron => Self::Tetrahedron,
            _ => Self::Other,
        }
    }
}

/// Numbers of rejections, by reason. An edge that was tried several times counts each time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rejections([usize; Rejection::ALL.len()]);

impl Rejections {
    pub(crate) fn count(&mut self, rejection: Rejection) {
        self.0[rejection as usize] += 1;
    }

    /// Reverts the count of one rejection.
    pub(crate) fn take_back(&mut self, rejection: Rejection) {
        self.0[rejection as usize] -= 1;
    }

    /// Adds the counts of another run.
    pub fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(count, more)| *count += more);
    }

    /// The number of rejections for this reason.
    #[must_use]
    pub fn of(&self, rejection: Rejection) -> usize {
        self.0[rejection as usize]
    }

    /// The total number of rejections.
    #[must_use]
    pub fn total(&self) -> usize {
        self.0.iter().sum()
    }

    /// The reasons that occurred, with their counts.
    pub fn iter(&self) -> impl Iterator<Item = (Rejection, usize)> + '_ {
        Rejection::ALL.iter().copied().map(|r| (r, self.of(r))).filter(|&(_, count)| count > 0)
    }
}
