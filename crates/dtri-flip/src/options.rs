//! Options of a run.

use core::time::Duration;

use mesh_core::EdgeMap;

use crate::cost::FlipCost;
use crate::error::FlipError;
use crate::shape::ShapeConstraint;

/// Options of a run. The default is the greedy algorithm of DHKL01 with an exact queue.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FlipOptions {
    /// Largest number of flips in a sequence, where no single flip lowers the cost; at most
    /// [`FlipOptions::MAX_LOOK_AHEAD`]. 1 is plain greedy descent, 2 is the look-ahead of DHKL01. Each
    /// further flip multiplies the effort by about 6.
    pub look_ahead: usize,
    /// Ruin and recreate after the greedy run. The result is never worse than without. This is the
    /// strongest strategy against deep local minima.
    pub rebuild: Option<Rebuild>,
    /// Simulated annealing after that. The result is never worse than without.
    pub anneal: Option<Anneal>,
    /// Dihedral angle, in radians, above which an edge is a feature edge and never flips.
    pub feature_angle: Option<f64>,
    /// Marked edges never flip.
    pub locked: Option<EdgeMap<bool>>,
    /// Constraint on the shape of new faces. `None`: the default of the cost,
    /// [`FlipCost::shape_constraint`](crate::FlipCost::shape_constraint).
    pub shape: Option<ShapeConstraint>,
    /// Largest angle, in radians, between the normal of a new face and its quadrilateral, unless an
    /// old face makes a larger one. The normal of the quadrilateral is its vector area, which a flip
    /// does not change. Below a right angle, no face can fold back.
    pub max_fold: Option<f64>,
    /// Reject flips whose new triangles cross or touch other triangles of the mesh. The test is exact.
    pub forbid_intersections: bool,
    /// Order of flips with equal gains.
    pub ties: Ties,
    /// The gains that are computed again after a flip.
    pub update: Update,
    /// Stop after this number of flips.
    pub max_flips: Option<u64>,
    /// Stop after this time. Only this option makes results depend on the machine.
    pub time_limit: Option<Duration>,
    /// Largest number of flips per edge, which guarantees termination. The default is 100 for
    /// potentials, which rarely reach it, and 8 for other costs, which may cycle.
    pub max_flips_per_edge: Option<u32>,
}

/// Default limit of flips per edge for a potential.
const FLIPS_PER_EDGE: u32 = 100;
/// Default limit of flips per edge for a cost that may cycle.
const FLIPS_PER_EDGE_WITH_CYCLES: u32 = 8;

impl Default for FlipOptions {
    fn default() -> Self {
        Self {
            look_ahead: 1,
            rebuild: None,
            anneal: None,
            feature_angle: None,
            locked: None,
            shape: None,
            max_fold: None,
            forbid_intersections: false,
            ties: Ties::EdgeId,
            update: Update::Exact,
            max_flips: None,
            time_limit: None,
            max_flips_per_edge: None,
        }
    }
}

impl FlipOptions {
    /// The largest look-ahead. About a million sequences of that length start at each edge.
    pub const MAX_LOOK_AHEAD: usize = 8;

    /// The options of a run with a cost: with the defaults of this cost where nothing was chosen.
    #[must_use]
    pub fn in_force<C: FlipCost>(&self, cost: &C) -> Self {
        Self {
            shape: Some(self.shape.unwrap_or_else(|| cost.shape_constraint())),
            max_flips_per_edge: Some(self.most_flips_per_edge(cost)),
            ..self.clone()
        }
    }

    pub(crate) fn most_flips_per_edge<C: FlipCost>(&self, cost: &C) -> u32 {
        let default = if cost.is_potential() { FLIPS_PER_EDGE } else { FLIPS_PER_EDGE_WITH_CYCLES };
        self.max_flips_per_edge.unwrap_or(default)
    }

    /// Checks the options against the size of a mesh.
    pub(crate) fn check(&self, edges: usize) -> Result<(), FlipError> {
        if self.look_ahead > Self::MAX_LOOK_AHEAD {
            return Err(FlipError::LookAhead {
                given: self.look_ahead,
                limit: Self::MAX_LOOK_AHEAD,
            });
        }
        FlipError::check_angle("feature_angle", self.feature_angle)?;
        FlipError::check_angle("max_fold", self.max_fold)?;
        if let Some(rebuild) = &self.rebuild {
            rebuild.check()?;
        }
        if let Some(anneal) = &self.anneal {
            anneal.check()?;
        }
        match &self.locked {
            Some(map) if map.len() != edges => {
                Err(FlipError::LockedLength { given: map.len(), edges })
            }
            _ => Ok(()),
        }
    }
}

/// A schedule for simulated annealing (Kirkpatrick, Gelatt and Vecchi 1983).
///
/// Each round starts from the best mesh so far. It flips random edges: always if that lowers the cost,
/// else with probability `exp(-rise / T)`. The temperature T falls geometrically from `start` to
/// `end`, in units of the mean absolute change that a flip of the best mesh would make. Greedy descent
/// ends the round. A round that does not improve the mesh is undone, so the result is never worse
/// than that of greedy descent. The same seed gives the same result.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Anneal {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of rounds.
    pub rounds: usize,
    /// Number of trial flips per round and edge of the mesh.
    pub steps_per_edge: usize,
    /// The first temperature.
    pub start: f64,
    /// The last temperature.
    pub end: f64,
}

impl Default for Anneal {
    fn default() -> Self {
        Self { seed: 0, rounds: 8, steps_per_edge: 50, start: 0.2, end: 0.01 }
    }
}

impl Anneal {
    pub(crate) fn check(&self) -> Result<(), FlipError> {
        let range = "a positive, finite temperature";
        for (option, value) in [("anneal.start", self.start), ("anneal.end", self.end)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(FlipError::OutOfRange { option, value, range });
            }
        }
        Ok(())
    }
}

/// Ruin and recreate (Schrimpf, Schneider, Stamm-Wilbrandt and Dueck 2000).
///
/// Each round removes the vertices of a patch from the triangulation by flips. Then it inserts them one
/// by one where each costs least, with flips and relocations of its neighbours. A round is undone if it
/// does not lower the cost or violates a constraint on single flips. Patches have from three to `largest`
/// vertices. Vertices at the boundary, at feature edges and at locked edges stay.
///
/// For points of a convex surface this finds the convex hull, the minimum of F2 and F3, from any triangulation, with
/// [`ShapeConstraint::Unrestricted`]; see `cargo run -p benches -- convex-study`. The faces of a closed mesh must point
/// outwards; the mesh is never turned inside out. The result is never worse than that of greedy descent. The same seed
/// gives the same result.
///
/// The effort is proportional to the number of vertices and grows slowly with `largest`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rebuild {
    /// Seed of the random numbers.
    pub seed: u64,
    /// The search ends when each vertex was removed this many times on average without improvement,
    /// but not before 600 removals in total.
    pub effort: usize,
    /// Largest number of vertices in a patch.
    pub largest: usize,
}

impl Default for Rebuild {
    fn default() -> Self {
        Self { seed: 0, effort: 2, largest: 1000 }
    }
}

impl Rebuild {
    pub(crate) fn check(&self) -> Result<(), FlipError> {
        let range = "at least 3";
        match self.largest {
            0..3 => Err(FlipError::OutOfRange {
                option: "rebuild.largest",
                value: self.largest as f64,
                range,
            }),
            _ => Ok(()),
        }
    }
}

/// Order of flips with equal gains. Gains that agree to about ten digits are equal, so that rounding does
/// not decide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Ties {
    /// By edge id.
    #[default]
    EdgeId,
    /// By a random permutation of the edges with this seed.
    Seeded(u64),
}

/// The gains that are computed again after a flip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Update {
    /// All gains that the flip affects, by the [stencil](crate::Stencil) of the cost.
    #[default]
    Exact,
    /// The 2-neighbourhood of the edge, as in DHKL01. For costs with a larger stencil, gains become
    /// stale. The order of flips is then that of the paper, but a flip that no longer lowers the cost
    /// is rejected. For reproduction only. With look-ahead it applies to the first flip.
    TwoNeighbourhood,
}
