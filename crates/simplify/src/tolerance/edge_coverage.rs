//! Tests whether the edges at a vertex stay within a distance of a surface, at all their points.
//!
//! A piece of an edge passes if both ends are close enough to the same triangle, because the distance from a triangle
//! is a convex function. It also passes if its length is at most the sum of the margins of its two ends, because the
//! distance from a surface changes by no more than the distance travelled. Other pieces are halved. Each middle is
//! first tested against the triangles of the two ends. If both fail, the surface is searched, for all such middles of a
//! round together.

use glam::DVec3;
use mesh_metric::{ClosestPoint, Surface, closest_on_triangle};

/// A point, and a triangle of the surface that is close enough to it.
#[derive(Clone, Copy)]
struct Held {
    at: DVec3,
    triangle: u32,
    distance: f64,
}

/// Whether the segments from `hub` to each point of `rim` are within `distance` of a surface. Pieces of length `least`
/// or less pass if both ends do.
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
            // If the triangle of one end also covers the middle, that half is done.
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

    /// Two squares with a gap of width 2. The middle of the gap is at distance 1 from both.
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
        // An end that is itself too far away.
        assert!(!holds(&[DVec3::new(1.0, 1.0, 2.0)], 1.0));
    }
}
