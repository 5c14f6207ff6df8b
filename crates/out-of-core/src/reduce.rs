//! Collapses of one region up to a cost, and the proof of the distance that they cause.

use mesh_core::as_u32;
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::blocks::{CostThreshold, FlatMesh, Fragment, Rules};

use crate::error::Error;
use crate::region::Region;
use crate::renumber::{inverse, renumbered};

/// Collapses the edges of a region up to a cost. Vertices of other cells and their neighbours stay. The result is a
/// pure function of the arguments, bit for bit.
#[must_use]
pub fn reduce(region: Region, rules: &Rules, cost_threshold: CostThreshold) -> Region {
    let pass = region.level as usize;
    let cost_threshold = cost_threshold.for_sheet(region.cell);
    let (fragment, places, rest) = region.into_fragment();
    let reduced =
        FlatMesh::from_fragment(fragment).reduce(pass, rules, cost_threshold).into_fragment();
    rest.followed_by(reduced, &places)
}

impl Region {
    /// The region with its fragment after a pass, in the order of the region; `places` are the earlier indices of the
    /// vertices.
    fn followed_by(self, fragment: Fragment, places: &[u32]) -> Self {
        let Fragment { positions, own, quadrics, triangles, vertex_ids } = fragment;
        let place = |&v: &u32| places[v as usize];
        let mut order: Vec<(u32, u32)> =
            vertex_ids.iter().map(place).zip(0..as_u32(vertex_ids.len())).collect();
        order.sort_unstable();
        let number = inverse(order.iter().map(|&(_, v)| v));
        // Non-manifold vertices are own vertices as well.
        let left = own + self.non_manifold.len();
        let quadric = |&(_, v): &(u32, u32)| quadrics.get(v as usize).copied().unwrap_or_default();
        let of_old = |old: u32| as_u32(order.partition_point(|&(place, _)| place < old));
        Self {
            level: self.level,
            cell: self.cell,
            own: left,
            vertex_ids: order.iter().map(|&(old, _)| self.vertex_ids[old as usize]).collect(),
            other_cells: self.other_cells,
            non_manifold: self.non_manifold.iter().map(|&old| of_old(old)).collect(),
            positions: order.iter().map(|&(_, v)| positions[v as usize]).collect(),
            quadrics: order[..left].iter().map(quadric).collect(),
            triangles: renumbered(&triangles, &number),
        }
    }
}

/// A proved upper bound of the Hausdorff distance between the own faces of a region before and after a step, in model
/// units. The bound is at most `tolerance` too large; the excess can be larger if the proof would take too long.
///
/// # Errors
/// A position is not finite.
pub fn proved_distance(before: &Region, after: &Region, tolerance: f64) -> Result<f64, Error> {
    let surface = |region: &Region| {
        let triangles: Vec<[u32; 3]> = region.own_triangles().collect();
        if triangles.is_empty() {
            return Ok(None);
        }
        Surface::from_triangles(&region.positions, &triangles).map(Some)
    };
    match (surface(before)?, surface(after)?) {
        (Some(before), Some(after)) => {
            let options = CertifyOptions { tolerance, ..CertifyOptions::default() };
            Ok(hausdorff_bounds(&before, &after, &options).upper)
        }
        (None, None) => Ok(0.0),
        // Collapses do not remove all faces of a cell.
        _ => Ok(f64::INFINITY),
    }
}
