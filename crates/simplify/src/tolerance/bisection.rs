//! How far apart the levels are that are looked at: by the vertices that they have, as ratios, since errors grow
//! with the size of the faces.

/// Levels whose numbers of faces are closer than this ratio are not told apart.
const RESOLUTION: f64 = 1.03;

/// A number of collapses of so many vertices between two; `None` when they are close enough.
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
        // 80 are left, then 64; 40 are left, then 52.
        assert_eq!(scaled(100, 20, 0.8), 36);
        assert_eq!(scaled(100, 60, 1.3), 48);
        assert_eq!(scaled(100, 0, 0.8), 20);
        // There are no more than all.
        assert_eq!(scaled(100, 10, 1.3), 0);
        // Three are left, which is too few for the factor to matter; four fifths of one are none.
        assert_eq!(scaled(10, 7, 1.3), 6);
        assert_eq!(scaled(10, 9, 0.8), 10);
    }
}
