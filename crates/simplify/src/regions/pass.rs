//! What is left of all regions, put together: the mesh, and the order of the collapses.

use std::borrow::Cow;

use mesh_core::{HalfEdgeId, VertexId};

use crate::collapse::log::LogEntry;
use crate::regions::region::{Done, Reduced};
use crate::regions::sheet::Sheet;
use crate::regions::tile::Step;

<<<<<<< HEAD
/// What a region has become.
#[derive(Debug, Default)]
pub(super) struct Reduced {
    /// The vertices that are left, in numbers of the sheet.
    vertices: Vec<u32>,
    positions: Vec<DVec3>,
    quadrics: Vec<Quadric>,
    /// In numbers of the sheet.
    triangles: Vec<[u32; 3]>,
    face_ids: Vec<u32>,
    half_edges: Vec<[u32; 3]>,
    pub(super) done: Done,
}

impl Reduced {
    pub(super) fn face_count(&self) -> usize {
        self.triangles.len()
    }
}

/// What was done with a region, in numbers of the original.
#[derive(Debug, Default)]
pub(crate) struct Done {
    /// The vertices that have gone, and those that they have become.
    pub(crate) merged: Vec<[u32; 2]>,
    /// Every collapse, if they are recorded, with the number of faces that went.
    pub(crate) steps: Vec<Step>,
    pub(crate) refusals: Refusals,
    pub(crate) max_cost: f64,
}

/// The faces of a region; those that the region is to hand on come first.
struct Cut {
    part: Part,
    faces: Vec<u32>,
    handed_on: usize,
    /// The vertices, in numbers of the sheet.
    vertices: Vec<u32>,
}

impl Cut {
    fn new(sheet: &Sheet<'_>, partition: &Partition, region: usize, rules: &Rules) -> Self {
        let own = partition.vertices(region);
        let first = region * partition.size;
        let corners = |face: u32| sheet.triangle(face as usize).unwrap_or_default();
        let of_region = |v: u32| partition.region_of(v);
        // A face belongs to the first of the regions of its corners.
        let is_handed_on =
            |&face: &u32| corners(face).into_iter().map(of_region).min() == Some(region);
        let (mut faces, others): (Vec<u32>, Vec<u32>) =
            partition.faces(region).iter().partition(|&face| is_handed_on(face));
        let handed_on = faces.len();
        faces.extend(others);
        let mut strangers: Vec<u32> = Vec::new();
        for &face in &faces {
            strangers.extend(corners(face).into_iter().filter(|&v| of_region(v) != region));
=======
impl Sheet<'static> {
    /// Puts all regions of a sheet together again, in the order in which they were cut out.
    #[must_use]
    pub fn join(regions: &[Reduced]) -> Self {
        let largest = regions.iter().flat_map(|region| &region.vertices).max();
        let mut number = vec![u32::MAX; largest.map_or(0, |&v| v as usize + 1)];
        let left = regions.iter().flat_map(|region| &region.vertices);
        for (new, &v) in left.enumerate() {
            number[v as usize] = new as u32;
>>>>>>> collapse
        }
        fn all<'a, T: Copy + 'a>(
            regions: &'a [Reduced],
            of: impl Fn(&'a Reduced) -> &'a Vec<T>,
        ) -> Vec<T> {
            let count = regions.iter().map(|region| of(region).len()).sum();
            let mut all = Vec::with_capacity(count);
            regions.iter().for_each(|region| all.extend_from_slice(of(region)));
            all
        }
        let mut triangles = all(regions, |region| &region.triangles);
        for corner in triangles.iter_mut().flatten() {
            *corner = number[*corner as usize];
        }
        Self {
            whole: None,
            positions: Cow::Owned(all(regions, |region| &region.positions)),
            quadrics: all(regions, |region| &region.quadrics),
            vertex_ids: all(regions, |region| &region.vertex_ids),
            triangles,
            face_ids: all(regions, |region| &region.face_ids),
            half_edges: all(regions, |region| &region.half_edges),
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
