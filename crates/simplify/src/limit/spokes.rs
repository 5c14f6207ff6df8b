//! Whether the edges at a vertex stay within a distance of a surface, at all their points.
//!
//! A piece of an edge holds when both of its ends are close enough to the same triangle, from which the
//! distance is a convex function; and when it is no longer than what its ends together are closer
//! than they need be, for the distance from a surface changes by no more than the way that is gone. The
//! others are halved, all of them in one round, so that their middles are looked up side by side.

use glam::DVec3;
use mesh_metric::{ClosestPoint, Surface, closest_on_triangle};

/// A point, and what of the surface is closest to it.
type Asked = (DVec3, ClosestPoint);

/// Whether the segments from `hub` to each of `rim` are within `distance` of a surface. Between points that
/// are, and that are no more than `least` apart, nothing more is asked.
pub(super) fn are_within(
    hub: DVec3,
    rim: &[DVec3],
    surface: &Surface,
    distance: f64,
    least: f64,
) -> bool {
    let ask = |points: Vec<DVec3>| -> Option<Vec<Asked>> {
        let closest = surface.closest_to_neighbours(&points);
        let is_near = closest.iter().all(|closest| closest.distance <= distance);
        is_near.then(|| points.into_iter().zip(closest).collect())
    };
    let has_both = |[(_, closest), (other, _)]: [&Asked; 2]| {
        let triangle = surface.triangle(closest.triangle as usize);
        closest_on_triangle(*other, &triangle).length_squared() <= distance * distance
    };
    let is_open = |[p, q]: &[Asked; 2]| {
        let spare = 2.0 * distance - p.1.distance - q.1.distance;
        p.0.distance(q.0) > least.max(spare) && !has_both([p, q]) && !has_both([q, p])
    };
    let Some(ends) = ask(core::iter::once(hub).chain(rim.iter().copied()).collect()) else {
        return false;
    };
    let Some((&hub, rim)) = ends.split_first() else { return true };
    let mut open: Vec<[Asked; 2]> = rim.iter().map(|&tip| [hub, tip]).filter(is_open).collect();
    while !open.is_empty() {
        let middles = open.iter().map(|[p, q]| p.0 + 0.5 * (q.0 - p.0)).collect();
        let Some(middles) = ask(middles) else { return false };
        let halves = open.iter().zip(middles).flat_map(|(&[p, q], m)| [[p, m], [m, q]]);
        open = halves.filter(is_open).collect();
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares with a gap between them, 2 wide, in whose middle a point is 1 away from both.
    #[test]
    fn what_is_too_far_is_found_between_ends_that_are_not() {
        let square = |x: f64| [[x, 0.0], [x + 4.0, 0.0], [x + 4.0, 4.0], [x, 4.0]];
        let points: Vec<DVec3> = [square(0.0), square(6.0)]
            .as_flattened()
            .iter()
            .map(|&[x, y]| DVec3::new(x, y, 0.0))
            .collect();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let surface = Surface::from_triangles(&points, &triangles).unwrap();
        let hub = DVec3::new(0.5, 2.0, 0.0);
        let (inside, across) = (DVec3::new(3.5, 1.0, 0.0), DVec3::new(9.0, 2.0, 0.0));
        let holds = |rim: &[DVec3], distance| are_within(hub, rim, &surface, distance, 1e-3);
        assert!(holds(&[inside], 0.01));
        assert!(holds(&[inside, across], 1.001));
        assert!(!holds(&[inside, across], 0.999));
        // An end that is itself too far.
        assert!(!holds(&[DVec3::new(1.0, 1.0, 2.0)], 1.0));
    }
}
