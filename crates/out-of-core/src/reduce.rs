//! One region by itself: collapsed up to a cost, and how far that has taken it.

use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::blocks::{CostThreshold, FlatMesh, Fragment, Rules};

use crate::error::Error;
use crate::region::Region;

/// Collapses the edges of a region that cost less than a ceiling. What belongs to other cells stays as it
/// is, with everything next to it. The bits depend on nothing but what is given here.
#[must_use]
pub fn reduce(region: Region, rules: &Rules, ceiling: CostThreshold) -> Region {
    let pass = region.level as usize;
    let ceiling = ceiling.for_sheet(region.cell);
    let (fragment, places, rest) = region.into_fragment();
    let reduced = FlatMesh::from_fragment(fragment).reduce(pass, rules, ceiling).into_fragment();
    rest.followed_by(reduced, &places)
}

impl Region {
    /// The region after a pass over its fragment, whose vertices had these places: in the old order.
    fn followed_by(self, fragment: Fragment, places: &[u32]) -> Self {
        let Fragment { positions, own, quadrics, triangles, vertex_ids } = fragment;
        let place = |&v: &u32| places[v as usize];
        let mut order: Vec<(u32, u32)> =
            vertex_ids.iter().map(place).zip(0..vertex_ids.len() as u32).collect();
        order.sort_unstable();
        let mut number = vec![0_u32; order.len()];
        order.iter().enumerate().for_each(|(new, &(_, v))| number[v as usize] = new as u32);
        // Stuck vertices are own ones that did not take part.
        let left = own + self.stuck.len();
        let quadric = |&(_, v): &(u32, u32)| quadrics.get(v as usize).copied().unwrap_or_default();
        let of_old = |old: u32| order.partition_point(|&(place, _)| place < old) as u32;
        Self {
            level: self.level,
            cell: self.cell,
            own: left,
            vertex_ids: order.iter().map(|&(old, _)| self.vertex_ids[old as usize]).collect(),
            homes: self.homes,
            stuck: self.stuck.iter().map(|&old| of_old(old)).collect(),
            positions: order.iter().map(|&(_, v)| positions[v as usize]).collect(),
            quadrics: order[..left].iter().map(quadric).collect(),
            triangles: triangles.iter().map(|t| t.map(|v| number[v as usize])).collect(),
        }
    }
}

/// How far the faces of a cell are from what they have become, proved, both ways: an upper bound that is at
/// most `tolerance` too large, or more where that would take too long.
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
        // A cell whose faces are all gone is as far as can be; no collapse does that.
        _ => Ok(f64::INFINITY),
    }
}
