//! What is done with a level: from the number of its faces and what its regions tell, and from nothing else.

use serde::{Deserialize, Serialize};
use simplify::blocks::{CostThreshold, Forecast};

use crate::sizes::Sizes;

/// What is done with a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The level.
    pub level: u32,
    /// The number of its cells.
    pub cells: u32,
    /// The faces of all of them.
    pub faces: u64,
    /// How many of the levels of detail this level is, cell by cell.
    pub results: u32,
    /// What comes next.
    pub next: Next,
}

/// What comes after a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Next {
    /// Every cell is collapsed up to a common cost, and neighbours are joined.
    Pass {
        /// The cost.
        ceiling: CostThreshold,
        /// How many faces that leaves, about.
        aim: u64,
        /// How many binary digits the numbers of cells lose.
        bits: u32,
    },
    /// The rims of the cells, which have stayed as they were so far, are collapsed up to a cost; the cells stay.
    Strips {
        /// The cost.
        ceiling: CostThreshold,
    },
    /// Everything fits into memory: the rest is done in one piece.
    InOnePiece,
    /// There are few enough faces, and still too many for one piece: the cells are the last result.
    Cells,
}

/// What is known of a level when all its regions are there.
pub(crate) struct Situation<'s> {
    pub(crate) level: u32,
    pub(crate) cells: u32,
    pub(crate) faces: u64,
    pub(crate) forecasts: &'s [Forecast],
    /// What was done with the level below.
    pub(crate) before: Option<Plan>,
    /// Whether rims were collapsed since the last result.
    pub(crate) has_strips: bool,
    /// The numbers of faces of the results that no level below is, from the largest down; one at least.
    pub(crate) targets: &'s [u64],
    pub(crate) sizes: Sizes,
}

/// A pass leaves no fewer than one in so many faces; by then, rims stand out.
const PASS: u64 = 4;

impl Situation<'_> {
    pub(crate) fn plan(&self) -> Plan {
        let Self { level, cells, faces, targets, sizes, .. } = *self;
        let plan =
            |results: usize, next| Plan { level, cells, faces, results: results as u32, next };
        if faces <= sizes.rest_faces || cells == 1 {
            return plan(0, Next::InOnePiece);
        }
        let is_stuck = self.is_stuck();
        let is_met = |&&target: &&u64| target > sizes.rest_faces && faces <= target + target / 200;
        let met = targets.iter().take_while(is_met).count();
        // Closer than that is not to be had where no more cells fit together.
        let ends_here = is_stuck && !self.can_be_joined() && targets[0] > sizes.rest_faces;
        let results = met.max(usize::from(ends_here));
        let next = match targets.get(results) {
            None => Next::Cells,
            Some(&target) if self.is_of_rest(target) => self.pass_to_rest(is_stuck),
            Some(&target) => {
                let has_strips = self.has_strips && results == 0;
                self.towards(target, has_strips || target <= sizes.rest_faces, is_stuck)
            }
        };
        plan(results, next)
    }

    /// Whether so many faces are made of a rest that fits into memory, with room between.
    fn is_of_rest(&self, target: u64) -> bool {
        4 * target <= 3 * self.sizes.rest_faces
    }

    /// Whether next to nothing went, or of the last little less than half: rims are in the way.
    fn is_stuck(&self) -> bool {
        let faces = self.faces;
        self.before.is_some_and(|before| match before.next {
            Next::Pass { aim, .. } if !self.is_of_rest(self.targets[0]) => {
                2 * faces > before.faces + aim
            }
            Next::Strips { .. } => false,
            _ => 20 * faces > 19 * before.faces,
        })
    }

    fn depth(&self) -> u32 {
        self.cells.trailing_zeros()
    }

    /// Whether regions are small enough to be joined as they are.
    fn can_be_joined(&self) -> bool {
        self.sizes.depth(self.faces) < self.depth()
    }

    fn pass_to_rest(&self, is_stuck: bool) -> Next {
        // A little less, for regions do not tell exactly.
        let rest = self.sizes.rest_faces;
        let aim = if rest < self.faces / PASS { self.faces / PASS } else { rest - rest / 10 };
        // Neighbours are joined whatever their size where nothing else helps.
        let bits = self.bits(aim).max(u32::from(is_stuck));
        Next::Pass { ceiling: CostThreshold::leaving(self.share(aim), &self.told()), aim, bits }
    }

    /// From above, ever closer: what regions do not tell exactly is a share of what goes. Before the last steps,
    /// when no more cells are to be joined, the rims are collapsed, as far as everything else will be.
    fn towards(&self, target: u64, has_strips: bool, is_stuck: bool) -> Next {
        let over = self.faces - target;
        let near = target + target / 16;
        let wants_strips = !has_strips && self.before.is_some() && !is_stuck;
        if wants_strips && self.bits(near) == 0 {
            return Next::Strips {
                ceiling: CostThreshold::closest(self.share(target), &self.told()),
            };
        }
        let mut aim = if 24 * over <= target { target } else { target + over / 8 };
        if !has_strips && over > target / 8 {
            aim = aim.max(near);
        }
        let aim = aim.max(self.faces / PASS);
        let must = is_stuck && (self.can_be_joined() || target <= self.sizes.rest_faces);
        let bits = self.bits(aim).max(u32::from(must));
        Next::Pass { ceiling: CostThreshold::closest(self.share(aim), &self.told()), aim, bits }
    }

    fn share(&self, aim: u64) -> f64 {
        aim as f64 / self.faces as f64
    }

    fn told(&self) -> Vec<&Forecast> {
        self.forecasts.iter().collect()
    }

    /// How many binary digits the numbers of cells lose when so many faces are left.
    fn bits(&self, aim: u64) -> u32 {
        self.depth() - self.sizes.depth(aim + aim / 10).min(self.depth())
    }
}

/// Whether rims were collapsed since the last result, by the plans of the levels below, from the highest down.
pub(crate) fn has_strips<'p>(mut below: impl Iterator<Item = &'p Plan>) -> bool {
    let last = below.find(|plan| plan.results > 0 || matches!(plan.next, Next::Strips { .. }));
    last.is_some_and(|plan| matches!(plan.next, Next::Strips { .. }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels one after the other, where every pass leaves what it was to leave and a `rim` of faces.
    fn course(mut faces: u64, mut rim: u64, targets: &[u64], sizes: Sizes) -> Vec<Plan> {
        let (mut plans, mut met) = (Vec::<Plan>::new(), 0);
        let mut cells = 1 << sizes.depth(faces);
        while plans.len() < 60 {
            let level = plans.len() as u32;
            let situation = Situation {
                level,
                cells,
                faces,
                forecasts: &[],
                before: plans.last().copied(),
                has_strips: has_strips(plans.iter().rev()),
                targets: &targets[met..],
                sizes,
            };
            let plan = situation.plan();
            met += plan.results as usize;
            plans.push(plan);
            let (aim, bits) = match plan.next {
                Next::Pass { aim, bits, .. } => (aim, bits),
                Next::Strips { .. } => {
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
        let sizes = Sizes { region_faces: 1000, rest_faces: 1200, stream: 0 };
        for (targets, in_regions) in [
            (&[500][..], 0),
            (&[900], 0),
            (&[1100], 0),
            (&[8000], 1),
            (&[100_000, 40_000, 39_999, 10_000, 2000, 100], 5),
            (&[64_000, 64_000, 10], 2),
            (&[50_000, 49_900, 49_800], 3),
        ] {
            let plans = course(64_000, 0, targets, sizes);
            let met: u32 = plans.iter().map(|plan| plan.results).sum();
            assert_eq!(met, in_regions, "{targets:?} {plans:?}");
            let mut left = targets.iter();
            for plan in &plans {
                for &target in left.by_ref().take(plan.results as usize) {
                    assert!(plan.faces.abs_diff(target.min(64_000)) <= target / 100, "{plans:?}");
                }
            }
            let last = plans[plans.len() - 1];
            let is_whole = targets[targets.len() - 1] <= sizes.rest_faces;
            assert_eq!(last.next == Next::InOnePiece, is_whole);
            // The rest is not coarser than what is made of it.
            assert!(!is_whole || left.all(|&target| target <= last.faces), "{targets:?} {plans:?}");
        }
    }

    #[test]
    fn rims_that_do_not_move_are_no_endless_loop() {
        let sizes = Sizes { region_faces: 1000, rest_faces: 1200, stream: 0 };
        for rim in [10, 300, 2000] {
            for targets in [&[500][..], &[1100], &[8000], &[20_000, 5000, 4000, 700]] {
                let plans = course(64_000, rim, targets, sizes);
                let last = plans[plans.len() - 1];
                assert!(last.next != Next::Cells || targets[targets.len() - 1] > 1200, "{plans:?}");
            }
        }
    }
}
