//! What is left of all regions, put together: the mesh, and the order of the collapses.

use std::borrow::Cow;

use mesh_core::{HalfEdgeId, VertexId};

use crate::collapse::log::LogEntry;
use crate::regions::region::{Done, Reduced};
use crate::regions::sheet::Sheet;
use crate::regions::tile::Step;

impl Sheet<'static> {
    /// Puts all regions of a sheet together again, in the order in which they were cut out.
    #[must_use]
    pub fn join(mut regions: Vec<Reduced>) -> Self {
        let largest = regions.iter().flat_map(|region| &region.vertices).max();
        let mut number = vec![u32::MAX; largest.map_or(0, |&v| v as usize + 1)];
        let left = regions.iter().flat_map(|region| &region.vertices);
        for (new, &v) in left.enumerate() {
            number[v as usize] = new as u32;
        }
        // What has been put together is given back, so that nothing is there twice.
        fn all<T>(regions: &mut [Reduced], of: impl Fn(&mut Reduced) -> &mut Vec<T>) -> Vec<T> {
            let count = regions.iter_mut().map(|region| of(region).len()).sum();
            let mut all = Vec::with_capacity(count);
            for region in regions {
                all.append(&mut core::mem::take(of(region)));
            }
            all
        }
        let regions = &mut regions;
        let mut triangles = all(regions, |region| &mut region.triangles);
        for corner in triangles.iter_mut().flatten() {
            *corner = number[*corner as usize];
        }
        drop(number);
        Self {
            whole: None,
            positions: Cow::Owned(all(regions, |region| &mut region.positions)),
            quadrics: all(regions, |region| &mut region.quadrics),
            vertex_ids: all(regions, |region| &mut region.vertex_ids),
            triangles,
            face_ids: all(regions, |region| &mut region.face_ids),
            half_edges: all(regions, |region| &mut region.half_edges),
        }
    }
}

/// Puts the collapses of regions of one pass into one order: by the largest cost so far of each.
pub(super) fn merge_steps(regions: &[Done], log: &mut Vec<LogEntry>, faces_before: &mut u32) {
    let mut order: Vec<(f64, u32, u32)> = Vec::new();
    for (region, done) in regions.iter().enumerate() {
        let mut largest = 0.0_f64;
        for (i, step) in done.steps.iter().enumerate() {
            largest = largest.max(step.cost);
            order.push((largest, region as u32, i as u32));
        }
    }
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    log.reserve(order.len());
    for (_, region, i) in order {
        let Step { removed, kept, half_edge, faces, position, cost } =
            regions[region as usize].steps[i as usize];
        log.push(LogEntry {
            half_edge: HalfEdgeId::new(half_edge),
            removed: VertexId::new(removed),
            kept: VertexId::new(kept),
            position,
            cost,
            faces_before: *faces_before,
        });
        *faces_before -= faces;
    }
}
