//! The partition of space into cells with equally many vertices: a k-d tree.

use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{BoundingBox, as_u32};
use serde::{Deserialize, Serialize};

/// A k-d tree: a complete binary tree of planes across the axes. Its leaves are the cells of level 0, numbered from
/// left to right. Cells of higher levels are subtrees. The number of the joined cell is the number of a cell without
/// its last binary digits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cells {
    /// The planes as a heap: the children of plane i are 2 i + 1 and 2 i + 2.
    planes: Vec<Plane>,
}

/// A plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Plane {
    axis: u8,
    /// Points with a smaller coordinate are on the left.
    at: f64,
}

impl Cells {
    /// Makes 2^`depth` cells with equal numbers of sites, as far as the sites have different positions. The depth is at
    /// most 20.
    pub(crate) fn new(mut sites: Vec<DVec3>, depth: u32) -> Self {
        let unset = Plane { axis: 0, at: 0.0 };
        let mut cells = Self { planes: vec![unset; (1 << depth) - 1] };
        cells.halve(&mut sites, 0);
        cells
    }

    fn halve(&mut self, sites: &mut [DVec3], node: usize) {
        if node >= self.planes.len() {
            return;
        }
        let low = sites.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let extent = sites.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max) - low;
        let axis =
            (1..3).fold(0, |longest, i| if extent[i] > extent[longest] { i } else { longest });
        let middle = sites.len() / 2;
        let mut at = 0.0;
        if middle > 0 {
            sites.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
            at = sites[middle][axis];
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0, 1 or 2")]
        let plane = Plane { axis: axis as u8, at };
        self.planes[node] = plane;
        // Points on the plane go right, as in `cell_of`.
        let (mut left, mut right): (Vec<DVec3>, Vec<DVec3>) =
            sites.iter().partition(|site| site[axis] < at);
        self.halve(&mut left, 2 * node + 1);
        self.halve(&mut right, 2 * node + 2);
    }

    /// Checks a tree that was read: its depth, its axes and its planes.
    pub(crate) fn check(&self, depth: u32) -> Result<(), String> {
        if self.planes.len() as u64 != (1 << depth) - 1 {
            return Err(format!("{} planes instead of 2^{depth} - 1", self.planes.len()));
        }
        let is_good = |plane: &Plane| plane.axis < 3 && plane.at.is_finite();
        match self.planes.iter().find(|plane| !is_good(plane)) {
            None => Ok(()),
            Some(Plane { axis, at }) => Err(format!("a plane across axis {axis} at {at}")),
        }
    }

    /// The number of cells of level 0.
    #[must_use]
    pub fn count(&self) -> u32 {
        // There are at most 2^20 - 1 planes.
        as_u32(self.planes.len()) + 1
    }

    /// The box of a cell, which is infinite towards the outside.
    #[must_use]
    pub fn bounds(&self, cell: u32) -> BoundingBox {
        let mut bounds = BoundingBox { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
        let mut node = cell as usize + self.planes.len();
        while node > 0 {
            let (parent, is_left) = ((node - 1) / 2, node % 2 == 1);
            let Plane { axis, at } = self.planes[parent];
            let axis = usize::from(axis);
            if is_left {
                bounds.max[axis] = bounds.max[axis].min(at);
            } else {
                bounds.min[axis] = bounds.min[axis].max(at);
            }
            node = parent;
        }
        bounds
    }

    /// Calls `visit` with each cell that intersects or touches a box, in ascending order.
    pub(crate) fn each_cell_of(
        &self,
        low: DVec3,
        high: DVec3,
        visit: &mut dyn FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.each_below(0, low, high, visit)
    }

    fn each_below(
        &self,
        node: usize,
        low: DVec3,
        high: DVec3,
        visit: &mut dyn FnMut(u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Some(plane) = self.planes.get(node) else {
            // There are at most 2^20 leaves.
            return visit(as_u32(node - self.planes.len()));
        };
        let axis = usize::from(plane.axis);
        if low[axis] <= plane.at {
            self.each_below(2 * node + 1, low, high, visit)?;
        }
        if high[axis] >= plane.at {
            self.each_below(2 * node + 2, low, high, visit)?;
        }
        ControlFlow::Continue(())
    }

    /// The cell of a point.
    #[must_use]
    pub fn cell_of(&self, point: DVec3) -> u32 {
        let mut node = 0;
        while let Some(plane) = self.planes.get(node) {
            node = 2 * node + if point[usize::from(plane.axis)] < plane.at { 1 } else { 2 };
        }
        as_u32(node - self.planes.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_of_equal_size_and_cover_space() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut point = || DVec3::new(random.f64(), 3.0 * random.f64(), random.f64().powi(4));
        let sites: Vec<DVec3> = (0..20_000).map(|_| point()).collect();
        let cells = Cells::new(sites.clone(), 4);
        let mut counts = [0; 16];
        sites.iter().for_each(|&site| counts[cells.cell_of(site) as usize] += 1);
        assert!(counts.iter().all(|&count| (1200..1300).contains(&count)), "{counts:?}");
        assert!(cells.cell_of(DVec3::splat(1e30)) < 16 && cells.cell_of(DVec3::splat(-1e30)) < 16);
        assert_eq!(Cells::new(sites, 0).count(), 1);
        // Equal points are all in one cell.
        let same = Cells::new(vec![DVec3::ONE; 100], 3);
        assert_eq!(same.cell_of(DVec3::ONE), same.cell_of(DVec3::splat(1.0)));
        assert_eq!(Cells::new(Vec::new(), 2).count(), 4);
    }
}
