//! What a run may be told.

use core::time::Duration;

use mesh_core::EdgeMap;

use crate::error::FlipError;

/// How to run; the default is the plain greedy run of DHKL01 with an exact queue.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FlipOptions {
    /// How many flips in a row are tried where no single one lowers the cost, up to
    /// [`FlipOptions::MAX_LOOK_AHEAD`]. 1 is the plain greedy run, 2 the look-ahead of DHKL01; the
    /// effort grows about sixfold with each step.
    pub look_ahead: usize,
    /// Rebuilding patch after patch after the greedy run; the result is never worse than without.
    /// The best there is against deep minima.
    pub rebuild: Option<Rebuild>,
    /// Simulated annealing after that; the result is never worse than without.
    pub anneal: Option<Anneal>,
    /// Edges between faces whose normals differ by more than this, in radians, are feature edges
    /// and never flip.
    pub feature_angle: Option<f64>,
    /// Edges marked here never flip.
    pub locked: Option<EdgeMap<bool>>,
    /// The largest angle, in radians, that a new face may make with the quadrilateral it is half
    /// of, unless the old faces made a larger one. The quadrilateral's direction is its vector
    /// area, which a flip does not change. Below a right angle, no face can be folded back.
    pub max_fold: Option<f64>,
    /// Refuse flips whose new triangles would cross or touch other triangles of the mesh. Exact,
    /// whatever the coordinates.
    pub forbid_intersections: bool,
    /// Which of the flips with the same gain comes first.
    pub ties: Ties,
    /// Which gains are computed again after a flip.
    pub update: Update,
    /// Stop after this many flips.
    pub max_flips: Option<u64>,
    /// Stop after this time. The only option that makes results depend on the machine.
    pub time_limit: Option<Duration>,
    /// An edge that has flipped this often rests, which guarantees that every run ends. By default
    /// 100 times for potentials, which hardly ever get there, and 8 times for other costs, which
    /// may go in circles.
    pub max_flips_per_edge: Option<u32>,
}

impl Default for FlipOptions {
    fn default() -> Self {
        Self {
            look_ahead: 1,
            rebuild: None,
            anneal: None,
            feature_angle: None,
            locked: None,
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
    /// The largest look-ahead. There are about a million rows of that length from each edge.
    pub const MAX_LOOK_AHEAD: usize = 8;

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
/// Each round starts from the best mesh so far. It flips random edges: always where that lowers
/// the cost, else with probability `exp(-rise / T)`. The temperature T falls by the same factor in
/// each step, from `start` to `end`, both in units of the mean absolute change that a flip of the
/// best mesh would make. A greedy run ends the round, and what is not better is undone. So the
/// result is never worse than that of the greedy run, and the same seed always gives the same one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Anneal {
    /// Where the random numbers start.
    pub seed: u64,
    /// How many rounds.
    pub rounds: usize,
    /// How many flips are tried in a round, per edge of the mesh.
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
/// Each round takes the vertices of a patch out of the triangulation, by flips, and puts them back one
/// after the other, each where it costs least, with flips and moves of its neighbours in between.
/// What has not lowered the cost, or breaks one of the rules that single flips obey, is undone. Patches
/// are of all sizes from three vertices to `largest`; vertices at the boundary, at feature edges and
/// locked ones stay in.
///
/// For points of a convex surface this finds the convex hull, the minimum of F2 and F3, from any
/// triangulation; see `cargo run -p benches -- convex-study`. A closed mesh is taken to have its faces outward, and
/// is never turned inside out. The result is never worse than that of the greedy run, and the same
/// seed always gives the same one.
///
/// The effort grows with the number of vertices, and a little with `largest`: now and then a vertex looks
/// at all faces of its patch when it comes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rebuild {
    /// Where the random numbers start.
    pub seed: u64,
    /// How often a vertex is taken out, in the mean, without anything getting better before that is
    /// the end. For small meshes more often, since there that takes no time: 600 vertices in all.
    pub effort: usize,
    /// How many vertices are taken out at once at most.
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

/// Which of the flips with the same gain comes first. Gains that agree in about ten digits count as
/// the same, so that rounding does not decide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Ties {
    /// That of the edge with the smaller id.
    #[default]
    EdgeId,
    /// That of the edge which comes first in a random order of all edges, made from this seed.
    Seeded(u64),
}

/// Which gains are computed again after a flip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Update {
    /// All that the flip affects, by the [reach](crate::Reach) of the cost.
    #[default]
    Exact,
    /// The 2-neighbourhood of the edge, as DHKL01 do. Gains of costs with a longer reach get
    /// stale: the order of flips is the paper's, but a flip that would not lower the cost any more
    /// when its turn comes is refused. For reproduction only; with look-ahead it counts for the
    /// first step.
    TwoNeighbourhood,
}
