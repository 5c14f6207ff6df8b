//! Targets that a run did not reach because every remaining collapse was rejected.

use mesh_collapse::{Rejection, Rejections, StopReason, Target};

/// A number of faces or vertices that was not reached, and the reasons.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Shortfall {
    /// The number of faces at which the run should have ended; `None` if there was no such target.
    pub wanted_faces: Option<usize>,
    /// The number of vertices at which the run should have ended; `None` if there was no such target.
    pub wanted_vertices: Option<usize>,
    /// The reasons for which edges were rejected during the run, each with its count, the most frequent first.
    pub held_by: Vec<(Rejection, usize)>,
}

impl Shortfall {
    /// The shortfall of a run on a mesh with `faces_before` faces; `None` if it reached a target or had none.
    pub(crate) fn of(
        target: &Target,
        faces_before: usize,
        stop: StopReason,
        rejections: &Rejections,
    ) -> Option<Self> {
        let counts_faces = target.faces.is_some() || target.ratio.is_some();
        let wanted_faces = counts_faces.then(|| target.face_target(faces_before));
        let wanted_vertices = target.vertices;
        let has_target = wanted_faces.is_some() || wanted_vertices.is_some();
        if stop != StopReason::NothingLeft || !has_target {
            return None;
        }
        let mut held_by: Vec<(Rejection, usize)> = rejections.iter().collect();
        held_by.sort_by_key(|&(reason, count)| (core::cmp::Reverse(count), reason));
        Some(Self { wanted_faces, wanted_vertices, held_by })
    }
}
