//! Steps of the searches over levels. Levels are compared by the ratio of their vertex counts, since errors grow with
//! the size of the faces.

/// Levels whose vertex counts differ by less than this ratio count as equal.
const RESOLUTION: f64 = 1.03;

/// The number of collapses to try between a good and a bad one, for a mesh with this many vertices; `None` when the two
/// are close enough.
pub(super) fn between(vertices: usize, good: usize, bad: usize) -> Option<usize> {
    let [more, fewer] = [good, bad].map(|collapses| (vertices - collapses).max(1) as f64);
    if bad <= good + 1 || more < RESOLUTION * fewer {
        return None;
    }
    let middle = vertices - (more * fewer).sqrt() as usize;
    Some(middle.clamp(good + 1, bad - 1))
}

/// The number of collapses that leaves `factor` times as many of the vertices, at least one more or less.
pub(super) fn scaled(vertices: usize, collapses: usize, factor: f64) -> usize {
    let left = ((vertices - collapses) as f64 * factor) as usize;
    let changed = vertices - left.min(vertices);
    if factor < 1.0 { changed.max(collapses + 1) } else { changed.min(collapses - 1) }
}

#[cfg(test)]
mod tests {
    use super::scaled;

    #[test]
    fn a_number_of_collapses_is_scaled_by_the_vertices_that_it_leaves() {
        // 20 collapses leave 80 vertices, and 80 % of these are 64. 60 collapses leave 40 vertices, and 130 % of these
        // are 52.
        assert_eq!(scaled(100, 20, 0.8), 36);
        assert_eq!(scaled(100, 60, 1.3), 48);
        assert_eq!(scaled(100, 0, 0.8), 20);
        // The result never has more vertices than the mesh.
        assert_eq!(scaled(100, 10, 1.3), 0);
        // With three vertices left the factor changes nothing, so one collapse is undone; 80 % of one vertex are none.
        assert_eq!(scaled(10, 7, 1.3), 6);
        assert_eq!(scaled(10, 9, 0.8), 10);
    }
}
