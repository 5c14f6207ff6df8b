//! The plan of a level: a pure function of the number of its faces and the forecasts of its regions.

use serde::{Deserialize, Serialize};
use simplify::blocks::{CostThreshold, Forecast};

use crate::capacity::Capacity;
use crate::split::DEEPEST;

/// The plan of a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The level.
    pub level: u32,
    /// The number of its cells.
    pub cells: u32,
    /// The number of faces of all cells.
    pub faces: u64,
    /// The number of results that are made from the cells of this level.
    pub results: u32,
    /// The next step.
    pub next: Next,
}

/// The step that follows a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Next {
    /// Each cell is collapsed up to a common cost, and neighbouring cells are joined.
    Pass {
        /// The cost.
        cost_threshold: CostThreshold,
        /// The number of faces that this leaves, approximately.
        aim: u64,
        /// The binary logarithm of the number of cells that become one.
        bits: u32,
    },
    /// The faces along the seams between cells, which were held so far, are collapsed up to a cost. The cells stay.
    SeamStrips {
        /// The cost.
        cost_threshold: CostThreshold,
    },
    /// All regions fit into memory: they are joined and collapsed as one mesh.
    InMemory,
    /// The cells are the last result, which does not fit into memory as one mesh.
    Done,
}

impl Plan {
    /// The number of cells of the next level; `None` if there is none.
    pub(crate) fn cells_above(&self) -> Option<u32> {
        match self.next {
            Next::Pass { bits, .. } => Some(self.cells.div_ceil(1 << bits)),
            Next::SeamStrips { .. } => Some(self.cells),
            Next::InMemory | Next::Done => None,
        }
    }

    /// Checks a plan that was read for a level. Level 0 of the run has `most_cells` cells, and the input `faces` faces.
    pub(crate) fn check(&self, level: u32, most_cells: u32, faces: u64) -> Result<(), String> {
        let Self { level: own_level, cells, .. } = *self;
        if own_level != level {
            return Err(format!("it is the plan of level {own_level}"));
        }
        if !cells.is_power_of_two() || cells > most_cells {
            return Err(format!("{cells} cells, where level 0 has {most_cells}"));
        }
        if self.faces > faces {
            return Err(format!("{} faces, where the input has {faces}", self.faces));
        }
        match self.next {
            Next::Pass { bits, .. } if bits > cells.trailing_zeros() => {
                Err(format!("2^{bits} cells become one, where there are {cells}"))
            }
            _ => Ok(()),
        }
    }
}

/// The data of a level with all of its regions, from which it is planned.
pub(crate) struct Situation<'s> {
    pub(crate) level: u32,
    pub(crate) cells: u32,
    pub(crate) faces: u64,
    pub(crate) forecasts: &'s [Forecast],
    /// The plan of the level below.
    pub(crate) before: Option<Plan>,
    /// Whether seams were collapsed since the last result.
    pub(crate) has_seam_strips: bool,
    /// The numbers of faces of the remaining results, from the largest down; at least one.
    pub(crate) targets: &'s [u64],
    pub(crate) capacity: Capacity,
}

/// A pass leaves at least one in this many faces. With fewer, seams become visible.
const PASS: u64 = 4;

impl Situation<'_> {
    pub(crate) fn plan(&self) -> Plan {
        let Self { level, cells, faces, targets, capacity, .. } = *self;
        let plan = |results: usize, next| {
            // There are as many results as were named on the command line.
            let results = u32::try_from(results).unwrap_or(u32::MAX);
            Plan { level, cells, faces, results, next }
        };
        if faces <= capacity.in_memory_faces || cells == 1 {
            return plan(0, Next::InMemory);
        }
        let is_stuck = self.is_stuck();
        let is_met =
            |&&target: &&u64| target > capacity.in_memory_faces && faces <= target + target / 200;
        let met = targets.iter().take_while(is_met).count();
        // Without cells to join, passes do not come closer to the target.
        let ends_here = is_stuck && !self.can_be_joined() && targets[0] > capacity.in_memory_faces;
        let results = met.max(usize::from(ends_here));
        let next = match targets.get(results) {
            None => Next::Done,
            Some(&target) if self.is_of_rest(target) => self.pass_to_rest(is_stuck),
            Some(&target) => {
                let has_seam_strips = self.has_seam_strips && results == 0;
                self.towards(
                    target,
                    has_seam_strips || target <= capacity.in_memory_faces,
                    is_stuck,
                )
            }
        };
        plan(results, next)
    }

    /// Whether this number of faces is made in memory from all regions, with a margin.
    fn is_of_rest(&self, target: u64) -> bool {
        // Targets are below 2^40.
        4 * target <= self.capacity.in_memory_faces.saturating_mul(3)
    }

    /// Whether the last pass removed less than 5 % of the faces, or, close to a result, less than half of the intended
    /// number: faces along seams prevent more collapses.
    fn is_stuck(&self) -> bool {
        let faces = self.faces;
        self.before.is_some_and(|before| match before.next {
            Next::Pass { aim, .. } if !self.is_of_rest(self.targets[0]) => {
                2 * faces > before.faces + aim
            }
            Next::SeamStrips { .. } => false,
            _ => 20 * faces > 19 * before.faces,
        })
    }

    fn depth(&self) -> u32 {
        self.cells.trailing_zeros()
    }

    /// Whether regions are small enough to be joined before they are collapsed.
    fn can_be_joined(&self) -> bool {
        self.capacity.depth(self.faces) < self.depth()
    }

    fn pass_to_rest(&self, is_stuck: bool) -> Next {
        // A tenth less, since forecasts are not exact.
        let rest = self.capacity.in_memory_faces;
        let aim = if rest < self.faces / PASS { self.faces / PASS } else { rest - rest / 10 };
        // If nothing else helps, neighbours are joined at any size.
        let bits = self.bits(aim).max(u32::from(is_stuck));
        Next::Pass {
            cost_threshold: CostThreshold::leaving(self.share(aim), &self.told()),
            aim,
            bits,
        }
    }

    /// Approaches the target from above in ever smaller steps: the error of forecasts is a share of what a pass
    /// removes. Before the last steps, when no more cells are joined, the faces along seams are collapsed up to the
    /// cost that the target needs.
    fn towards(&self, target: u64, has_seam_strips: bool, is_stuck: bool) -> Next {
        let over = self.faces - target;
        let near = target + target / 16;
        let wants_strips = !has_seam_strips && self.before.is_some() && !is_stuck;
        if wants_strips && self.bits(near) == 0 {
            return Next::SeamStrips {
                cost_threshold: CostThreshold::closest(self.share(target), &self.told()),
            };
        }
        let mut aim = if 24 * over <= target { target } else { target + over / 8 };
        if !has_seam_strips && over > target / 8 {
            aim = aim.max(near);
        }
        let aim = aim.max(self.faces / PASS);
        let must = is_stuck && (self.can_be_joined() || target <= self.capacity.in_memory_faces);
        let bits = self.bits(aim).max(u32::from(must));
        Next::Pass {
            cost_threshold: CostThreshold::closest(self.share(aim), &self.told()),
            aim,
            bits,
        }
    }

    /// The share of the faces that a pass leaves to come close to `aim`. Seams hold some faces. If the others had to
    /// make up for them, they would be collapsed at any cost, so a pass leaves one in [`PASS`] of the others as well.
    fn share(&self, aim: u64) -> f64 {
        let of_all = |count: fn(&Forecast) -> u64| self.forecasts.iter().map(count).sum::<u64>();
        let (faces, gone) = (of_all(Forecast::face_count), of_all(Forecast::gone_count));
        let asked = aim as f64 / self.faces as f64;
        if faces == 0 {
            return asked;
        }
        // Forecasts end at a share of the faces that is less than a pass leaves.
        let most = (1.0 - 1.0 / PASS as f64) / (1.0 - DEEPEST);
        asked.max(1.0 - most * gone as f64 / faces as f64)
    }

    fn told(&self) -> Vec<&Forecast> {
        self.forecasts.iter().collect()
    }

    /// The binary logarithm of the number of cells that become one when `aim` faces are left.
    fn bits(&self, aim: u64) -> u32 {
        self.depth() - self.capacity.depth(aim + aim / 10).min(self.depth())
    }
}

/// Whether seams were collapsed since the last result, by the plans of the levels below, from the highest down.
pub(crate) fn has_seam_strips<'p>(mut below: impl Iterator<Item = &'p Plan>) -> bool {
    let last = below.find(|plan| plan.results > 0 || matches!(plan.next, Next::SeamStrips { .. }));
    last.is_some_and(|plan| matches!(plan.next, Next::SeamStrips { .. }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]

    use super::*;

    /// A sequence of levels in which every pass leaves its intended number of faces plus a `rim` of faces.
    fn course(mut faces: u64, mut rim: u64, targets: &[u64], capacity: Capacity) -> Vec<Plan> {
        let (mut plans, mut met) = (Vec::<Plan>::new(), 0);
        let mut cells = 1 << capacity.depth(faces);
        while plans.len() < 60 {
            let level = plans.len() as u32;
            let situation = Situation {
                level,
                cells,
                faces,
                forecasts: &[],
                before: plans.last().copied(),
                has_seam_strips: has_seam_strips(plans.iter().rev()),
                targets: &targets[met..],
                capacity,
            };
            let plan = situation.plan();
            met += plan.results as usize;
            plans.push(plan);
            let (aim, bits) = match plan.next {
                Next::Pass { aim, bits, .. } => (aim, bits),
                Next::SeamStrips { .. } => {
                    faces -= (rim * u64::from(cells - 1)).min(faces / 9);
                    rim /= 4;
                    continue;
                }
                _ => return plans,
            };
            cells = cells.div_ceil(1 << bits);
            faces = faces.min(aim + rim * u64::from(cells - 1));
        }
        panic!("no end: {plans:?}");
    }

    #[test]
    fn every_target_is_met_once_and_the_rest_last() {
        let capacity = Capacity { region_faces: 1000, in_memory_faces: 1200, stream: 0 };
        for (targets, in_regions) in [
            (&[500][..], 0),
            (&[900], 0),
            (&[1100], 0),
            (&[8000], 1),
            (&[100_000, 40_000, 39_999, 10_000, 2000, 100], 5),
            (&[64_000, 64_000, 10], 2),
            (&[50_000, 49_900, 49_800], 3),
        ] {
            let plans = course(64_000, 0, targets, capacity);
            let met: u32 = plans.iter().map(|plan| plan.results).sum();
            assert_eq!(met, in_regions, "{targets:?} {plans:?}");
            let mut left = targets.iter();
            for plan in &plans {
                for &target in left.by_ref().take(plan.results as usize) {
                    assert!(plan.faces.abs_diff(target.min(64_000)) <= target / 100, "{plans:?}");
                }
            }
            let last = plans[plans.len() - 1];
            let is_whole = targets[targets.len() - 1] <= capacity.in_memory_faces;
            assert_eq!(last.next == Next::InMemory, is_whole);
            // The rest has at least as many faces as the results made from it.
            assert!(!is_whole || left.all(|&target| target <= last.faces), "{targets:?} {plans:?}");
        }
    }

    #[test]
    fn held_faces_do_not_cost_the_others_everything() {
        // Of the 1000 faces of a region, 400 are held, and the last 50 collapses destroy the shape.
        let region = r#"{"faces":1000,"gone":[[3,300],[9,250],[400,50]]}"#;
        let forecasts = vec![serde_json::from_str::<Forecast>(region).unwrap(); 4];
        let situation = Situation {
            level: 1,
            cells: 4,
            faces: 4000,
            forecasts: &forecasts,
            before: None,
            has_seam_strips: false,
            targets: &[500],
            capacity: Capacity { region_faces: 1000, in_memory_faces: 1200, stream: 0 },
        };
        // The aim needs more faces than there are in all regions together.
        let Next::Pass { cost_threshold, aim, .. } = situation.plan().next else { panic!() };
        assert!(4000 - aim > 4 * 600);
        let at_nine = CostThreshold::leaving(0.5, &[&forecasts[0]]);
        assert_eq!(cost_threshold, at_nine);
        assert!(at_nine < CostThreshold::leaving(0.41, &[&forecasts[0]]));
    }

    #[test]
    fn rims_that_do_not_move_are_no_endless_loop() {
        let capacity = Capacity { region_faces: 1000, in_memory_faces: 1200, stream: 0 };
        for rim in [10, 300, 2000] {
            for targets in [&[500][..], &[1100], &[8000], &[20_000, 5000, 4000, 700]] {
                let plans = course(64_000, rim, targets, capacity);
                let last = plans[plans.len() - 1];
                assert!(last.next != Next::Done || targets[targets.len() - 1] > 1200, "{plans:?}");
            }
        }
    }
}
