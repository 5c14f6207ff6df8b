//! Whether the edges at a vertex stay within a distance of a surface, at all their points.
//!
//! A piece of an edge holds when both of its ends are close enough to the same triangle, from which the
//! distance is a convex function; and when it is no longer than what its ends together are closer
//! than they need be, for the distance from a surface changes by no more than the way that is gone. The
//! others are halved. Middles that are close enough to neither triangle of the ends are looked up, all
//! those of one round side by side.

use glam::DVec3;
use mesh_metric::{ClosestPoint, Surface, closest_on_triangle};

/// A point, and a triangle of the surface that is close enough to it.
#[derive(Clone, Copy)]
struct Held {
    at: DVec3,
    triangle: u32,
    distance: f64,
}

/// Whether the segments from `hub` to each of `rim` are within `distance` of a surface. Between points that
/// are, and that are no more than `least` apart, nothing more is asked.
pub(super) fn are_within(
    hub: DVec3,
    rim: &[DVec3],
    surface: &Surface,
    distance: f64,
    least: f64,
) -> bool {
    let ask = |points: &[DVec3]| -> Option<Vec<Held>> {
        let closest = surface.closest_to_neighbours(points);
        let is_near = closest.iter().all(|closest| closest.distance <= distance);
        let held = |(&at, closest): (&DVec3, &ClosestPoint)| Held {
            at,
            triangle: closest.triangle,
            distance: closest.distance,
        };
        is_near.then(|| points.iter().zip(&closest).map(held).collect())
    };
    let by = |at: DVec3, triangle: u32| {
        let corners = surface.triangle(triangle as usize);
        let squared = closest_on_triangle(at, &corners).length_squared();
        (squared <= distance * distance).then(|| Held { at, triangle, distance: squared.sqrt() })
    };
    let is_open = |[p, q]: &[Held; 2]| {
        let spare = 2.0 * distance - p.distance - q.distance;
        p.at.distance(q.at) > least.max(spare)
            && by(q.at, p.triangle).is_none()
            && by(p.at, q.triangle).is_none()
    };
    let Some(ends) = ask(&[&[hub], rim].concat()) else { return false };
    let Some((&hub, rim)) = ends.split_first() else { return true };
    let mut open: Vec<[Held; 2]> = rim.iter().map(|&tip| [hub, tip]).filter(is_open).collect();
    while !open.is_empty() {
        let middle = |[p, q]: &[Held; 2]| p.at + 0.5 * (q.at - p.at);
        let (mut next, mut unheld) = (Vec::new(), Vec::new());
        for piece in open {
            let ([p, q], at) = (piece, middle(&piece));
            // What one of the ends holds at its middle as well is half done.
            if let Some(m) = by(at, p.triangle) {
                next.push([m, q]);
            } else if let Some(m) = by(at, q.triangle) {
                next.push([p, m]);
            } else {
                unheld.push(piece);
            }
        }
        let Some(middles) = ask(&unheld.iter().map(middle).collect::<Vec<_>>()) else {
            return false;
        };
        next.extend(unheld.into_iter().zip(middles).flat_map(|([p, q], m)| [[p, m], [m, q]]));
        next.retain(is_open);
        open = next;
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
