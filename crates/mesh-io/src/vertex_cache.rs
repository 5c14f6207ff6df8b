//! The order of triangles for the vertex cache of a graphics card.
//!
//! Tom Forsyth: Linear-Speed Vertex Cache Optimisation, 2006. The next triangle is the one whose corners were used most
//! recently and have the fewest triangles left. The scores are those, of eight that were tried, with the fewest misses
//! and the shortest compressed indices on three models.

use mesh_core::as_u32;

/// The vertices that count as recently used.
const CACHE: usize = 16;
/// At most so many triangles of a vertex are compared, so that the time does not grow with the square of a valence.
const COMPARED: usize = 32;

/// The triangles in an order in which they share recently used vertices. All corners are below `vertices`.
pub(crate) fn cache_order(triangles: &[[u32; 3]], vertices: usize) -> Vec<[u32; 3]> {
    let mut left = Left::of(triangles, vertices);
    let mut cache: Vec<u32> = Vec::with_capacity(CACHE + 3);
    let mut ordered = Vec::with_capacity(triangles.len());
    let mut unused = 0..as_u32(triangles.len());
    loop {
        let next = left.best(&cache, triangles).or_else(|| unused.find(|&t| !left.is_done(t)));
        let Some(triangle) = next else { return ordered };
        let Some(&corners) = triangles.get(triangle as usize) else { return ordered };
        ordered.push(corners);
        left.remove(triangle, corners);
        cache.retain(|vertex| !corners.contains(vertex));
        cache.splice(0..0, corners);
        cache.truncate(CACHE);
    }
}

/// The triangles that are left, by vertex.
struct Left {
    /// The corners of each vertex; corners of triangles that are left come first.
    corners: Vec<u32>,
    /// For each corner, its place among `corners`.
    places: Vec<u32>,
    /// For each vertex, the start of its corners.
    starts: Vec<u32>,
    counts: Vec<u32>,
    done: Vec<bool>,
}

impl Left {
    fn of(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let all = triangles.as_flattened();
        let mut counts = vec![0_u32; vertices];
        for &vertex in all {
            if let Some(count) = counts.get_mut(vertex as usize) {
                *count += 1;
            }
        }
        let start = |sum: &mut u32, &count: &u32| {
            let start = *sum;
            *sum += count;
            Some(start)
        };
        let starts: Vec<u32> = counts.iter().scan(0, start).collect();
        let mut ends = starts.clone();
        let (mut corners, mut places) = (vec![0; all.len()], vec![0; all.len()]);
        for ((corner, vertex), place) in (0..).zip(all).zip(&mut places) {
            let Some(end) = ends.get_mut(*vertex as usize) else { continue };
            if let Some(slot) = corners.get_mut(*end as usize) {
                (*slot, *place) = (corner, *end);
            }
            *end += 1;
        }
        Self { corners, places, starts, counts, done: vec![false; triangles.len()] }
    }

    fn is_done(&self, triangle: u32) -> bool {
        self.done.get(triangle as usize).copied().unwrap_or(true)
    }

    /// The triangles that a vertex has left.
    fn triangles(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let vertex = vertex as usize;
        let start = self.starts.get(vertex).copied().unwrap_or_default() as usize;
        let count = self.counts.get(vertex).copied().unwrap_or_default() as usize;
        let corners = self.corners.get(start..start + count).unwrap_or_default();
        corners.iter().take(COMPARED).map(|corner| corner / 3)
    }

    fn remove(&mut self, triangle: u32, vertices: [u32; 3]) {
        if let Some(done) = self.done.get_mut(triangle as usize) {
            *done = true;
        }
        for (corner, vertex) in (3 * triangle as usize..).zip(vertices) {
            let start = self.starts.get(vertex as usize).copied();
            let count = self.counts.get_mut(vertex as usize);
            let (Some(start), Some(count)) = (start, count) else { continue };
            *count -= 1;
            // The last corner that is left takes the place of the one that is not.
            let (last, place) = ((start + *count) as usize, self.places.get(corner).copied());
            let Some(place) = place.map(|place| place as usize) else { continue };
            let Some(&moved) = self.corners.get(last) else { continue };
            self.corners.swap(place, last);
            self.places.swap(corner, moved as usize);
        }
    }

    /// The best triangle that has a vertex of the cache.
    fn best(&self, cache: &[u32], triangles: &[[u32; 3]]) -> Option<u32> {
        let mut best = (0.0, None);
        for &vertex in cache {
            for triangle in self.triangles(vertex) {
                let corners = triangles.get(triangle as usize)?;
                let score: f32 = corners.iter().map(|&corner| self.score(corner, cache)).sum();
                if score > best.0 {
                    best = (score, Some(triangle));
                }
            }
        }
        best.1
    }

    fn score(&self, vertex: u32, cache: &[u32]) -> f32 {
        let recent = match cache.iter().position(|&other| other == vertex) {
            // The last triangle: others that share an edge with it should not all come at once.
            Some(0..3) => 0.8,
            Some(place) => 0.9 * (1.0 - (place - 3) as f32 / (CACHE - 3) as f32).sqrt(),
            None => 0.0,
        };
        // A vertex with few triangles left should not be left over.
        let count = self.counts.get(vertex as usize).copied().unwrap_or(1).max(1);
        recent + 1.0 / (count as f32).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vertices that a first-in-first-out cache of 16 misses.
    fn misses(triangles: &[[u32; 3]]) -> usize {
        let mut cache = std::collections::VecDeque::new();
        let mut misses = 0;
        for vertex in triangles.as_flattened() {
            if !cache.contains(vertex) {
                misses += 1;
                cache.push_front(*vertex);
                cache.truncate(16);
            }
        }
        misses
    }

    #[test]
    fn all_triangles_are_there_and_share_vertices() {
        let mut grid = Vec::new();
        for y in 0..50 {
            for x in 0..50 {
                let a = 51 * y + x;
                grid.extend([[a, a + 1, a + 51], [a + 51, a + 1, a + 52]]);
            }
        }
        let (sorted, mut shuffled) = (grid.clone(), grid);
        fastrand::Rng::with_seed(1).shuffle(&mut shuffled);
        let mut ordered = cache_order(&shuffled, 51 * 51);
        // 5,000 triangles with 2,601 vertices; in rows, they miss about as many as there are triangles.
        let misses = misses(&ordered);
        assert!(misses < 3800, "{misses}");
        ordered.sort_unstable();
        let mut sorted = sorted;
        sorted.sort_unstable();
        assert_eq!(ordered, sorted);
    }

    /// Repeated corners, repeated triangles and a vertex with many triangles.
    #[test]
    fn any_triangles_can_be_ordered() {
        let mut random = fastrand::Rng::with_seed(2);
        let fan = (1..20_000).map(|i| [0, i, i + 1]);
        let noise: Vec<[u32; 3]> = (0..500).map(|_| [(); 3].map(|()| random.u32(..40))).collect();
        for triangles in [Vec::new(), noise, fan.collect()] {
            let mut ordered = cache_order(&triangles, 20_001);
            let mut expected = triangles;
            ordered.sort_unstable();
            expected.sort_unstable();
            assert_eq!(ordered, expected);
        }
    }
}
