//! The discrete curvature norm (Kim, Kim and Levin 2002).

use glam::DVec3;
use mesh_core::{Remap, TriMesh};

use super::curvature_change::CurvatureChange;
use super::curvature_change::measure::Measure;
use super::{Cost, Reach};
use crate::geometry::edge_patch::EdgePatch;
use crate::geometry::quadric::Quadric;
use crate::policy::{Needs, Policy, Scratch};

/// The two norms of [`CurvatureNorm`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Norm {
    /// The sum of |k1| + |k2| over the vertices (KKL02 eq. 1), in units of one over length.
    L1,
    /// The sum of k1² + k2² = 4 H² - 2 K over the vertices (KKL02 eq. 2), in units of one over squared length.
    L2,
}

impl Norm {
    pub(super) fn measure(self) -> Measure {
        match self {
            Self::L1 => Measure::AbsSum,
            Self::L2 => Measure::SquaredSum,
        }
    }
}

/// By how much a collapse changes the discrete curvature norm of the mesh: the absolute difference
/// before and after (KKL02 section 3.2). Curvatures are pointwise, with a third of the adjacent
/// faces as the area of a vertex.
///
/// A collapse changes the curvature of the neighbours of its vertex. As published, it updates the costs of the edges
/// from these neighbours to their neighbours. The costs of some edges beyond change too, where a neighbour lies
/// opposite to them. These are evaluated again when they reach the head of the queue.
#[derive(Clone, Debug)]
pub struct CurvatureNorm {
    change: CurvatureChange,
}

impl CurvatureNorm {
    /// The cost with this norm.
    #[must_use]
    pub fn new(norm: Norm) -> Self {
        Self { change: CurvatureChange::new(norm.measure()) }
    }

    /// The cost with this norm, with unsigned dihedral angles: H of a vertex is the sum of
    /// |e| |beta| / 4 over its edges, divided by its area.
    ///
    /// KKL02 section 2.1 defines beta as "the angle between the normals of the adjacent triangles",
    /// which allows both readings. [`CurvatureNorm::new`] gives beta a sign, as DHKL01 does, from
    /// which the curvatures are taken.
    #[must_use]
    pub fn unsigned(norm: Norm) -> Self {
        let measure = match norm {
            Norm::L1 => Measure::UnsignedAbsSum,
            Norm::L2 => Measure::UnsignedSquaredSum,
        };
        Self { change: CurvatureChange::new(measure) }
    }
}

impl Policy for CurvatureNorm {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.change.prepare(mesh);
    }

    fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
        self.change.compacted(remap);
    }
}

impl Cost for CurvatureNorm {
    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        _: Option<&Quadric>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> f64 {
        let sums = self.change.of(patch, x, scratch);
        (sums.before - sums.after).abs()
    }

    fn needs(&self) -> Needs {
        Needs::Ends
    }

    fn reach(&self) -> Reach {
        Reach::OneRing
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        self.change.collapsing(patch, x, scratch);
    }
}
