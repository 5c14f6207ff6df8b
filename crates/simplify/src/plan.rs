//! The plan of a run: which engine collapses which part.
//!
//! [`Plan::of`] is the one place that decides it. The run, the estimate of memory and the out-of-core crate follow the
//! plan.
//!
//! The parallel schedule over blocks knows accumulated quadrics, optimal placement, and limits on normals and shapes.
//! With the hybrid metric these quadrics do the first part, and the greedy loop does the rest, block by block as long
//! as there are enough faces. Any other option makes the greedy loop do the whole run over the whole mesh: other
//! metrics and placements, attributes, poses, locked vertices and boundaries, feature lines, kept faces, importance of
//! vertices, limits on edges, angles, valences, components and intersections, custom policies, and targets other than
//! faces and time.

use mesh_collapse::blocks::Rules;
use mesh_collapse::{Boundary, Protect, Schedule, Target};
use mesh_core::TriMesh;

use crate::options::{Metric, Options, PlacementRule};

/// Which engine collapses which part of a run.
#[derive(Clone, Copy, Debug)]
pub enum Plan {
    /// Blocks of the mesh side by side, from the beginning to the end.
    Blocks {
        /// The rules of the blocks.
        rules: Rules,
    },
    /// Blocks by accumulated quadrics first, then the greedy loop by the metric of the options.
    BlocksThenGreedy {
        /// The rules of the blocks.
        rules: Rules,
        /// The number of faces at which the greedy loop takes over.
        switch_at: usize,
    },
    /// The greedy loop, block by block as long as there are enough faces.
    GreedyInBlocks,
    /// The greedy loop over the whole mesh.
    Greedy,
}

impl Plan {
    /// The plan for a mesh.
    #[must_use]
    pub fn of(options: &Options, mesh: &TriMesh) -> Self {
        let diagonal = mesh.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
        let faces = mesh.topology().face_count();
        match BlockRules::of(options, diagonal) {
            Some(BlockRules { rules, is_start: false }) => Self::Blocks { rules },
            Some(BlockRules { rules, is_start: true }) => {
                match switch_at(options, faces, options.target.face_target(faces)) {
                    Some(switch_at) => Self::BlocksThenGreedy { rules, switch_at },
                    None if options.cost.switch_ratio.is_some() => Self::GreedyInBlocks,
                    None => Self::Greedy,
                }
            }
            None => Self::Greedy,
        }
    }
}

/// The part of a run that blocks can do.
pub(crate) struct BlockRules {
    pub(crate) rules: Rules,
    /// Whether blocks can do the start only, since they do not support the metric.
    pub(crate) is_start: bool,
}

impl BlockRules {
    /// The rules for a mesh whose bounding box has this diagonal; `None` where the options need the greedy loop.
    pub(crate) fn of(options: &Options, diagonal: f64) -> Option<Self> {
        let Options { cost, protect, tolerance, attributes, .. } = options;
        let is_start = match cost.metric {
            Metric::Quadric | Metric::IncrementalQuadric if cost.curvature_weight <= 0.0 => false,
            Metric::Hybrid => !is_left_to_decimation(options),
            _ => return None,
        };
        let keep_volume = match options.placement {
            PlacementRule::OptimalVolume => true,
            PlacementRule::Optimal => false,
            _ => return None,
        };
        let Protect { boundary, min_cosine, min_shape, .. } = *protect;
        let Target { faces: _, ratio: _, time: _, vertices, cost: most, collapses } =
            options.target;
        let can = cost.schedule == Schedule::Parallel
            && attributes.counting().is_none()
            && attributes.poses.is_none()
            // Levels that are refined as they are have more faces when they come from blocks.
            && (tolerance.distance.is_none() || tolerance.decimate)
            && boundary != Boundary::Lock
            && protect.locked.is_none()
            && protect.features.is_none()
            && protect.kept.is_none()
            && protect.importance.is_none()
            && !protect.limits.is_any()
            && protect.min_component_vertices.is_none()
            && !protect.forbid_intersections
            && (vertices, most, collapses) == (None, None, None);
        let rules = Rules {
            marginal: cost.metric != Metric::Quadric,
            keep_volume,
            border: boundary == Boundary::Quadrics,
            min_cosine,
            min_shape,
            record: options.record || tolerance.distance.is_some(),
            ..Rules::of_size(diagonal)
        };
        can.then_some(Self { rules, is_start })
    }

    /// The rules for a run in which no process has the whole mesh, so that its distance from a result cannot be
    /// measured.
    pub(crate) fn without_mesh(options: &Options, diagonal: f64) -> Option<Self> {
        Self::of(options, diagonal).filter(|_| options.tolerance.distance.is_none())
    }
}

/// Rules by which blocks carry out the options, or the start of a run, on a mesh whose bounding box has this diagonal;
/// `None` where the options need the whole mesh.
#[must_use]
pub fn rules(options: &Options, diagonal: f64) -> Option<Rules> {
    let found = BlockRules::without_mesh(options, diagonal);
    found.map(|found| Rules { record: false, ..found.rules })
}

/// The largest weight of the curvature factor that makes no difference to a later decimation to a tolerance.
const LITTLE_CURVATURE: f64 = 0.1;

/// Whether decimation to a tolerance makes the choice of another metric superfluous. If only an error limit ends the
/// collapses, decimation removes three of four faces of the level that it starts from. On ten models, with limits of
/// 0.05, 0.2 and 1 % of the diagonal, the mean numbers of faces after quadrics alone agree within 0.4 %.
fn is_left_to_decimation(options: &Options) -> bool {
    let is_alone = (options.target.faces, options.target.ratio) == (None, None);
    let has_little = options.cost.curvature_weight <= LITTLE_CURVATURE;
    options.tolerance.decimate && is_alone && options.cost.switch_ratio.is_some() && has_little
}

/// The largest share of the faces at which another metric takes over. With more faces left, its start takes as long as
/// the blocks save.
const MAX_SHARE: f64 = 0.6;

/// If the limit on the share delays the metric, it still takes over at that share, provided that this is at least the
/// given multiple of the wanted number of faces. On ten models, mean errors agree within 0.1 %, and the time is 0.9 of
/// the former time.
const MIN_MULTIPLE: f64 = 1.9;

/// The number of faces at which the greedy loop takes over, if blocks are worth their time at all.
pub(crate) fn switch_at(options: &Options, faces: usize, target: usize) -> Option<usize> {
    let asked = options.cost.switch_ratio? * target as f64;
    let most = MAX_SHARE * faces as f64;
    let is_early_enough = most >= asked.min(MIN_MULTIPLE * target as f64);
    (target > 0 && is_early_enough).then_some(asked.min(most) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preset::Preset;

    #[test]
    fn another_metric_takes_over_where_that_is_worth_it() {
        let left = |switch_ratio: f64, faces: usize, target: usize| {
            let mut options = Options::preset(Preset::Default);
            options.cost.switch_ratio = Some(switch_ratio);
            switch_at(&options, faces, target)
        };
        assert_eq!(left(8.0, 50_000, 1_000), Some(8_000));
        // At most 60 % of the faces, if that is enough more than the wanted number.
        assert_eq!([3_750, 5_000].map(|target| left(8.0, 50_000, target)), [Some(30_000); 2]);
        assert_eq!([3_100, 3_200].map(|n| left(8.0, 10_000, n)), [Some(6_000), None]);
        assert_eq!([4_000, 4_100].map(|n| left(1.5, 10_000, n)), [Some(6_000), None]);
        assert_eq!(left(8.0, 100_000, 0), None);
    }
}
