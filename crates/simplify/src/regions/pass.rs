//! One pass over all regions: each is collapsed by itself, and what is left is put together.

use std::borrow::Cow;

use glam::DVec3;
use mesh_core::parallel;

use crate::collapse::log::LogEntry;
use crate::collapse::quadric::Quadric;
use crate::collapse::refusal::Refusals;
use crate::regions::corners::NONE;
use crate::regions::partition::Partition;
use crate::regions::rules::Rules;
use crate::regions::sheet::Sheet;
use crate::regions::tile::{Goal, Part, Step, Tile};

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
        }
        strangers.sort_unstable();
        strangers.dedup();
        let number = |v: u32| match strangers.binary_search(&v) {
            _ if of_region(v) == region => partition.rank[v as usize] - first as u32,
            Ok(place) | Err(place) => (own.len() + place) as u32,
        };
        let triangles = faces.iter().map(|&face| corners(face).map(number)).collect();
        let half_edges = if rules.record {
            faces.iter().map(|&face| sheet.half_edges(face as usize)).collect()
        } else {
            Vec::new()
        };
        let quadrics = if sheet.quadrics.is_empty() {
            Vec::new()
        } else {
            own.iter().map(|&v| sheet.quadrics[v as usize]).collect()
        };
        let vertices: Vec<u32> = own.iter().chain(&strangers).copied().collect();
        let positions = vertices.iter().map(|&v| sheet.positions[v as usize]).collect();
        let part = Part { triangles, positions, quadrics, own: own.len(), half_edges };
        Self { part, faces, handed_on, vertices }
    }
}

/// How many faces go at which costs when a region is collapsed as far as it allows: by bucket.
pub(super) fn forecast(
    sheet: &Sheet<'_>,
    partition: &Partition,
    region: usize,
    rules: &Rules,
    goal: impl Fn(usize) -> Goal,
) -> (usize, Vec<(usize, u32)>) {
    let cut = Cut::new(sheet, partition, region, &Rules { record: false, ..*rules });
    let faces = cut.part.triangles.len();
    let mut tile = Tile::new(cut.part, *rules);
    let mut gone: Vec<(usize, u32)> = Vec::new();
    tile.run(goal(faces), &mut |_, _| true, &mut |bucket, faces| match gone.last_mut() {
        Some((last, count)) if *last == bucket => *count += faces,
        _ => gone.push((bucket, faces)),
    });
    (faces, gone)
}

/// Collapses a region up to a bucket of cost.
pub(super) fn reduce(
    sheet: &Sheet<'_>,
    partition: &Partition,
    region: usize,
    rules: &Rules,
    goal: Goal,
    goes_on: &mut dyn FnMut(usize, usize) -> bool,
) -> (Reduced, bool) {
    let Cut { part, faces, handed_on, vertices } = Cut::new(sheet, partition, region, rules);
    let own = part.own;
    let mut tile = Tile::new(part, *rules);
    let is_whole = tile.run(goal, goes_on, &mut |_, _| {});
    let mut is_gone = vec![false; own];
    tile.merged.iter().for_each(|&[removed, _]| is_gone[removed as usize] = true);
    let left: Vec<usize> = (0..own).filter(|&v| !is_gone[v]).collect();
    let mut reduced = Reduced {
        vertices: left.iter().map(|&v| vertices[v]).collect(),
        positions: left.iter().map(|&v| tile.position(v)).collect(),
        quadrics: left.iter().map(|&v| tile.quadric(v)).collect(),
        ..Reduced::default()
    };
    for (face, triangle) in tile.triangles().take_while(|&(face, _)| face < handed_on) {
        reduced.triangles.push(triangle.map(|v| vertices[v as usize]));
        reduced.face_ids.push(sheet.face_id(faces[face] as usize));
        if rules.record {
            reduced.half_edges.push(tile.half_edges(face));
        }
    }
    let id = |v: u32| sheet.vertex_id(vertices[v as usize]);
    let step = |step: &Step| Step { removed: id(step.removed), kept: id(step.kept), ..*step };
    reduced.done = Done {
        merged: tile.merged.iter().map(|pair| pair.map(id)).collect(),
        steps: tile.steps.iter().map(step).collect(),
        refusals: tile.refusals,
        max_cost: tile.max_cost,
    };
    (reduced, is_whole)
}

/// Puts regions together again.
pub(super) fn join(sheet: &Sheet<'_>, regions: &[Reduced]) -> Sheet<'static> {
    let mut number = vec![NONE; sheet.vertex_capacity()];
    let left = regions.iter().flat_map(|region| &region.vertices);
    for (new, &v) in left.enumerate() {
        number[v as usize] = new as u32;
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
    let mut vertex_ids = all(regions, |region| &region.vertices);
    vertex_ids.iter_mut().for_each(|v| *v = sheet.vertex_id(*v));
    Sheet {
        whole: None,
        positions: Cow::Owned(all(regions, |region| &region.positions)),
        quadrics: all(regions, |region| &region.quadrics),
        vertex_ids,
        triangles,
        face_ids: all(regions, |region| &region.face_ids),
        half_edges: all(regions, |region| &region.half_edges),
    }
}

/// The values of a function of the index that each take long, from `range`.
pub(super) fn each<T: Send>(
    range: core::ops::Range<usize>,
    value: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    parallel::collect_each(range.len(), |i| value(range.start + i))
}

/// Puts the collapses of regions of one pass into one order: by the largest cost so far of each.
pub(super) fn merge_steps(regions: &[Done], log: &mut Vec<LogEntry>, faces_before: &mut u32) {
    use mesh_core::{Handle, VertexId};
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
            half_edge: mesh_core::HalfEdgeId::from_index(half_edge as usize),
            removed: VertexId::new(removed),
            kept: VertexId::new(kept),
            position,
            cost,
            faces_before: *faces_before,
        });
        *faces_before -= faces;
    }
}
