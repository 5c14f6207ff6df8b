//! Merging vertices by position.

use glam::DVec3;

use crate::build::edges::NONE;

/// Which vertex every vertex merges into: the first one with equal coordinates, where `-0.0`
/// equals `0.0`. Vertices that stay map to themselves. Takes linear time.
///
/// Coordinates that are not a number merge with nothing.
#[must_use]
pub fn weld_exact(positions: &[DVec3]) -> Vec<u32> {
    let mut table = VertexTable::with_room_for(positions.len());
    positions
        .iter()
        .enumerate()
        .map(|(vertex, &position)| {
            // Adding zero turns -0.0 into 0.0 and changes nothing else.
            let key = (position + DVec3::ZERO).to_array().map(f64::to_bits);
            table.find_or_insert(key, vertex as u32, |other| positions[other as usize] == position)
        })
        .collect()
}

/// Which vertex every vertex merges into: in order of their index, each merges into the first
/// vertex within `distance` that did not itself merge.
///
/// Merging is not transitive: along a row of vertices less than `distance` apart, the first absorbs
/// those within `distance` of itself, the next one left over starts anew. So no vertex moves by
/// more than `distance`, and those that stay are more than `distance` apart from each other, which
/// also bounds how many share a cell of the hash grid and keeps the time linear. (The exception are
/// distances below about 1e-15 of the largest coordinate, for which cells are kept larger.)
///
/// A `distance` of zero merges what [`weld_exact`] merges; positions that are not finite merge with
/// nothing. `distance` must be finite and not negative.
#[must_use]
pub fn weld_within(positions: &[DVec3], distance: f64) -> Vec<u32> {
    let largest = positions
        .iter()
        .filter(|p| p.is_finite())
        .fold(0.0, |largest: f64, p| largest.max(p.abs().max_element()));
    // Cell numbers stay below 2^50, where every one is exact.
    let cell_size = (4.0 * distance).max(largest * 2.0_f64.powi(-50));
    if distance == 0.0 || !cell_size.is_normal() || !cell_size.is_finite() {
        return weld_exact(positions);
    }
    let mut grid = Grid {
        positions,
        cells: VertexTable::with_room_for(positions.len()),
        cell_size,
        previous_in_cell: vec![NONE; positions.len()],
        last_in_cell: vec![NONE; positions.len()],
    };
    let mut target: Vec<u32> = (0..positions.len() as u32).collect();
    for (vertex, &position) in positions.iter().enumerate() {
        if !position.is_finite() {
            continue;
        }
        match grid.first_within(position, distance) {
            Some(earlier) => target[vertex] = earlier,
            None => grid.insert(vertex as u32),
        }
    }
    target
}

/// A hash grid of the vertices that stay. A cell is named by the first vertex in it.
struct Grid<'a> {
    positions: &'a [DVec3],
    cells: VertexTable,
    cell_size: f64,
    /// Per vertex, the one that was put into the same cell before it.
    previous_in_cell: Vec<u32>,
    /// Per vertex that names a cell, the one that was put into the cell last.
    last_in_cell: Vec<u32>,
}

impl Grid<'_> {
    /// The vertex with the smallest index within `distance` of a position.
    fn first_within(&self, position: DVec3, distance: f64) -> Option<u32> {
        let reach = DVec3::splat(distance);
        let low = cell_of(position - reach, self.cell_size);
        let high = cell_of(position + reach, self.cell_size);
        // A cell is larger than the reach, so these two cover all between.
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

/// The numbers of the grid cell that holds a position, along the three axes.
fn cell_of(position: DVec3, cell_size: f64) -> [u64; 3] {
    (position / cell_size).to_array().map(|quotient| {
        // Rounds down; calling `floor` is slow on targets that have no instruction for it.
        let towards_zero = quotient as i64;
        let is_above = towards_zero as f64 > quotient;
        (towards_zero - i64::from(is_above)).cast_unsigned()
    })
}

/// A hash table of vertices by keys that the vertices themselves tell.
///
/// Open addressing with linear probing; a slot holds a vertex and half of its hash, so that other
/// vertices in the way are rarely looked at.
struct VertexTable {
    slots: Vec<[u32; 2]>,
}

impl VertexTable {
    /// A table for at most so many vertices, at most half full.
    fn with_room_for(vertices: usize) -> Self {
        Self { slots: vec![[NONE; 2]; (2 * vertices.max(1)).next_power_of_two()] }
    }

    /// The vertex with this key, or where to put it: the slot and what to put into it beside the
    /// vertex.
    fn probe(&self, key: [u64; 3], is_same: impl Fn(u32) -> bool) -> Result<u32, (usize, u32)> {
        let hash = mix(key);
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

    /// The vertex with this key, after putting in `vertex` if there is none yet.
    fn find_or_insert(&mut self, key: [u64; 3], vertex: u32, is_same: impl Fn(u32) -> bool) -> u32 {
        self.probe(key, is_same).unwrap_or_else(|(slot, tag)| {
            self.slots[slot] = [vertex, tag];
            vertex
        })
    }
}

/// Spreads a key over 64 bits: multiply and fold, once for each word.
fn mix(key: [u64; 3]) -> u64 {
    key.into_iter().fold(0x9e37_79b9_7f4a_7c15, |hash: u64, word| {
        let product = u128::from(hash ^ word) * 0xd6e8_feb8_6659_fd93;
        (product as u64 ^ (product >> 64) as u64).rotate_left(23)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
            for (scale, shift) in [(1.0, 0.0), (1e-200, 0.0), (1e200, 0.0), (1.0, 1e6)] {
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
