//! Merging vertices by position.

use std::hash::{BuildHasher, RandomState};

use glam::DVec3;

use crate::build::edges::NONE;
use crate::index::as_u32;
use crate::topology::handle::{Handle, VertexId};

/// Which vertex every vertex merges into: the first one with equal coordinates, where `-0.0`
/// equals `0.0`. Vertices that stay map to themselves. Takes linear time.
///
/// Coordinates that are not a number merge with nothing.
///
/// # Panics
/// There are [`Handle::LIMIT`] positions or more.
#[must_use]
pub fn weld_exact(positions: &[DVec3]) -> Vec<u32> {
    let mut table = VertexTable::with_room_for(positions.len());
    positions
        .iter()
        .enumerate()
        .map(|(vertex, &position)| {
            let key = position_key(position);
            table.find_or_insert(key, as_u32(vertex), |other| positions[other as usize] == position)
        })
        .collect()
}

/// The bits of a position, equal for equal positions.
pub(crate) fn position_key(position: DVec3) -> [u64; 3] {
    // Adding zero turns -0.0 into 0.0 and changes nothing else.
    (position + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// Which vertex every vertex merges into: in order of their index, each merges into the first
/// vertex within `distance` that did not itself merge.
///
/// Merging is not transitive: along a row of vertices less than `distance` apart, the first absorbs the vertices within
/// `distance` of itself, and the next one that remains absorbs vertices in turn. So no vertex moves by more than
/// `distance`, and the remaining vertices are more than `distance` apart. This also bounds the number of vertices in a
/// cell of the hash grid, so that the time is linear, even with vertices far away.
///
/// A `distance` of zero merges the same vertices as [`weld_exact`]; positions that are not finite merge with nothing.
/// `distance` must be finite and not negative.
///
/// # Panics
/// There are [`Handle::LIMIT`] positions or more.
#[must_use]
pub fn weld_within(positions: &[DVec3], distance: f64) -> Vec<u32> {
    let cell_size = 4.0 * distance;
    if distance == 0.0 || !cell_size.is_normal() {
        return weld_exact(positions);
    }
    let mut grid = Grid {
        positions,
        cells: VertexTable::with_room_for(positions.len()),
        cell_size,
        previous_in_cell: vec![NONE; positions.len()],
        last_in_cell: vec![NONE; positions.len()],
    };
    let mut target: Vec<u32> = (0..as_u32(positions.len())).collect();
    for (vertex, &position) in positions.iter().enumerate() {
        if !position.is_finite() {
            continue;
        }
        match grid.first_within(position, distance) {
            Some(earlier) => target[vertex] = earlier,
            None => grid.insert(as_u32(vertex)),
        }
    }
    target
}

/// A hash grid of the vertices that stay. A cell is named by the first vertex in it.
struct Grid<'a> {
    positions: &'a [DVec3],
    cells: VertexTable,
    cell_size: f64,
    /// Per vertex, the vertex that was put into the same cell before it.
    previous_in_cell: Vec<u32>,
    /// Per vertex that names a cell, the vertex that was put into the cell last.
    last_in_cell: Vec<u32>,
}

impl Grid<'_> {
    /// The vertex with the smallest index within `distance` of a position.
    fn first_within(&self, position: DVec3, distance: f64) -> Option<u32> {
        let reach = DVec3::splat(distance);
        let low = cell_of(position - reach, self.cell_size);
        let high = cell_of(position + reach, self.cell_size);
        // A cell is twice as large as the reach to both sides, so these two cells cover everything in between.
        let along = |axis: usize| {
            let upper = (low[axis] != high[axis]).then_some(high[axis]);
            core::iter::once(low[axis]).chain(upper)
        };
        let mut first = NONE;
        for x in along(0) {
            for y in along(1) {
                for z in along(2) {
                    first = first.min(self.first_in_cell([x, y, z], position, distance));
                }
            }
        }
        (first != NONE).then_some(first)
    }

    /// The vertex with the smallest index within `distance` of a position in one cell, or [`NONE`].
    fn first_in_cell(&self, cell: [u64; 3], position: DVec3, distance: f64) -> u32 {
        let is_same = |other: u32| cell_of(self.positions[other as usize], self.cell_size) == cell;
        let name = self.cells.probe(cell, is_same).ok();
        let mut vertex = name.map_or(NONE, |name| self.last_in_cell[name as usize]);
        let mut first = NONE;
        while vertex != NONE {
            // Scaled by the distance, so that squaring neither over- nor underflows.
            let offset = (self.positions[vertex as usize] - position) / distance;
            if offset.length_squared() <= 1.0 {
                first = first.min(vertex);
            }
            vertex = self.previous_in_cell[vertex as usize];
        }
        first
    }

    fn insert(&mut self, vertex: u32) {
        let positions = self.positions;
        let cell_size = self.cell_size;
        let cell = cell_of(positions[vertex as usize], cell_size);
        let is_same = |other: u32| cell_of(positions[other as usize], cell_size) == cell;
        let name = self.cells.find_or_insert(cell, vertex, is_same);
        let last = &mut self.last_in_cell[name as usize];
        self.previous_in_cell[vertex as usize] = *last;
        *last = vertex;
    }
}

/// The grid cell of a position, along the three axes: the bits of its number, which is an integer below 2^53. Farther
/// out, neighbouring floating-point numbers are more than the reach apart, and every coordinate is its own cell.
fn cell_of(position: DVec3, cell_size: f64) -> [u64; 3] {
    const LARGEST_NUMBER: f64 = 9_007_199_254_740_992.0;
    position.to_array().map(|coordinate| {
        let quotient = coordinate / cell_size;
        if quotient.abs() < LARGEST_NUMBER {
            // Rounds down; calling `floor` is slow on targets that have no instruction for it.
            let towards_zero = quotient as i64;
            let is_above = towards_zero as f64 > quotient;
            ((towards_zero - i64::from(is_above)) as f64).to_bits()
        } else {
            coordinate.to_bits()
        }
    })
}

/// A hash table of vertices whose keys are computed from the vertices.
///
/// Open addressing with linear probing. A slot holds a vertex and half of its hash, so that few wrong vertices
/// are compared. The hash has a random seed per table, so that no file can be made whose vertices all collide.
/// Results do not depend on the seed.
struct VertexTable {
    slots: Vec<[u32; 2]>,
    seeds: [u64; 4],
}

impl VertexTable {
    /// A table for at most this number of vertices; it is at most half full.
    fn with_room_for(vertices: usize) -> Self {
        assert!(vertices < VertexId::LIMIT, "more positions than 32-bit indices can address");
        let source = RandomState::new();
        Self {
            slots: vec![[NONE; 2]; (2 * vertices.max(1)).next_power_of_two()],
            seeds: [0, 1, 2, 3].map(|i: u64| source.hash_one(i)),
        }
    }

    /// The vertex with this key. If there is none, the slot for it and the tag to store beside the vertex.
    fn probe(&self, key: [u64; 3], is_same: impl Fn(u32) -> bool) -> Result<u32, (usize, u32)> {
        let hash = mix(key, self.seeds);
        #[allow(clippy::cast_possible_truncation, reason = "32 bits are left")]
        let tag = (hash >> 32) as u32;
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        loop {
            match self.slots[slot] {
                [NONE, _] => return Err((slot, tag)),
                [vertex, other] if other == tag && is_same(vertex) => return Ok(vertex),
                _ => slot = (slot + 1) & mask,
            }
        }
    }

    /// The vertex with this key; inserts `vertex` if there is none.
    fn find_or_insert(&mut self, key: [u64; 3], vertex: u32, is_same: impl Fn(u32) -> bool) -> u32 {
        self.probe(key, is_same).unwrap_or_else(|(slot, tag)| {
            self.slots[slot] = [vertex, tag];
            vertex
        })
    }
}

/// Hashes a key to 64 bits: folded products with the random seed.
fn mix([x, y, z]: [u64; 3], [a, b, c, d]: [u64; 4]) -> u64 {
    let fold = |u: u64, v: u64| {
        let product = u128::from(u) * u128::from(v);
        product as u64 ^ (product >> 64) as u64
    };
    fold(fold(x ^ a, y ^ b) ^ z, c | 1) ^ fold(z ^ d, b | 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    /// The definition, in quadratic time.
    fn weld_slowly(positions: &[DVec3], distance: f64) -> Vec<u32> {
        let mut target: Vec<u32> = Vec::new();
        for (i, p) in positions.iter().enumerate() {
            let stays = |j: &usize| target[*j] == *j as u32;
            let is_near = |j: &usize| p.distance_squared(positions[*j]) <= distance * distance;
            target.push((0..i).filter(stays).find(is_near).unwrap_or(i) as u32);
        }
        target
    }

    #[test]
    fn equal_coordinates_merge() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        let positions = [p(0.0, 1.0), p(-0.0, 1.0), p(1.0, 0.0), p(0.0, 1.0), p(1.0, -0.0)];
        assert_eq!(weld_exact(&positions), [0, 0, 2, 0, 2]);
        assert_eq!(weld_within(&positions, 0.0), [0, 0, 2, 0, 2]);
        let nan = [DVec3::NAN, DVec3::NAN, DVec3::INFINITY, DVec3::INFINITY];
        assert_eq!(weld_within(&nan, 1.0), [0, 1, 2, 3]);
        assert_eq!(weld_exact(&nan)[..2], [0, 1]);
    }

    #[test]
    fn welding_within_a_distance_follows_its_definition() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let cloud: Vec<DVec3> =
            (0..600).map(|_| DVec3::new(random(), random(), random())).collect();
        for distance in [1e-9, 0.01, 0.05, 0.2, 0.7, 3.0] {
            for (scale, shift) in
                [(1.0, 0.0), (1e-200, 0.0), (1e200, 0.0), (1.0, 1e6), (1.0, 1e15), (1.0, 1e17)]
            {
                let cloud: Vec<DVec3> = cloud.iter().map(|p| (*p + shift) * scale).collect();
                let unit: Vec<DVec3> = cloud.iter().map(|p| *p / scale).collect();
                assert_eq!(
                    weld_within(&cloud, distance * scale),
                    weld_slowly(&unit, distance),
                    "{distance} {scale} {shift}"
                );
            }
        }
    }

    /// Positions with equal values under a multiply-and-fold hash with known constants.
    fn colliding(count: usize) -> Vec<DVec3> {
        let fold = |hash: u64, word: u64| {
            let product = u128::from(hash ^ word) * 0xd6e8_feb8_6659_fd93;
            (product as u64 ^ (product >> 64) as u64).rotate_left(23)
        };
        let points = (0..).map(|i: u32| {
            let [x, y] = [f64::from(i), 1.0];
            let state = [x, y].into_iter().map(f64::to_bits).fold(0x9e37_79b9_7f4a_7c15, fold);
            DVec3::new(x, y, f64::from_bits(state ^ 0x1234_5678_9abc_def0))
        });
        points.filter(|p| p.is_finite()).take(count).collect()
    }

    #[test]
    fn no_positions_collide_on_purpose() {
        // All pairs would take an hour.
        let positions = colliding(2_000_000);
        assert!(weld_exact(&positions).into_iter().eq(0..2_000_000));
        // For any seeds, vertices rarely collide.
        let mut table = VertexTable::with_room_for(positions.len());
        for (vertex, p) in positions.iter().enumerate() {
            table.find_or_insert(p.to_array().map(f64::to_bits), vertex as u32, |_| false);
        }
        let is_taken = |slot: &[u32; 2]| slot[0] != NONE;
        let longest_run = table.slots.chunk_by(|a, b| is_taken(a) == is_taken(b));
        let longest_run = longest_run.filter(|run| is_taken(&run[0])).map(<[_]>::len).max();
        assert!(longest_run < Some(1000), "{longest_run:?}");
    }

    #[test]
    fn one_vertex_far_away_does_not_put_the_others_into_one_cell() {
        let mut random = SplitMix64::new(2);
        let mut cloud: Vec<DVec3> = (0..300_000)
            .map(|_| DVec3::new(random.uniform(), random.uniform(), random.uniform()))
            .collect();
        cloud.extend([1e30, -1e300, 1e308, f64::MAX].map(DVec3::splat));
        let all = cloud.len() as u32;
        assert!(weld_within(&cloud, 1e-12).into_iter().eq(0..all));
        // Far vertices do not share one cell either.
        let far: Vec<DVec3> = cloud[..300_000].iter().map(|p| 1e300 * p.normalize()).collect();
        assert!(weld_within(&far, 1e-12).into_iter().eq(0..300_000));
        assert!(weld_within(&far, 1e-300).into_iter().eq(0..300_000));
    }

    #[test]
    fn chains_do_not_run_away() {
        let row: Vec<DVec3> = (0..7).map(|i| DVec3::X * f64::from(i)).collect();
        assert_eq!(weld_within(&row, 1.0), [0, 0, 2, 2, 4, 4, 6]);
        assert_eq!(weld_within(&row, 2.5), [0, 0, 0, 3, 3, 3, 6]);
    }

    #[test]
    fn a_million_vertices_in_one_place_merge() {
        let heap = vec![DVec3::ONE; 1_000_000];
        assert!(weld_exact(&heap).iter().all(|&target| target == 0));
        assert!(weld_within(&heap, 1e-3).iter().all(|&target| target == 0));
    }
}
