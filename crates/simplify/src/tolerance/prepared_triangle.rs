//! A triangle prepared for many distance queries.

use glam::DVec3;
use mesh_metric::closest_on_triangle;

pub(super) type Triangle = [DVec3; 3];

/// Below this sine of the angle at its first corner, a triangle counts as degenerate and gets no plane.
const THIN: f64 = 1e-6;

/// A triangle with its plane, and the perpendicular planes along its sides. For most points these planes decide the
/// query: the point is far above the triangle, far beside it, or clearly above its inside.
#[derive(Clone)]
pub(super) struct Prepared {
    corners: Triangle,
    normal: DVec3,
    /// For each side, from the first corner on: the unit vector in the plane that points inwards.
    inward: [DVec3; 3],
}

impl Prepared {
    pub(super) fn new(corners: Triangle) -> Self {
        let [a, b, c] = corners;
        let (ab, ac) = (b - a, c - a);
        let cross = ab.cross(ac);
        let is_thin =
            cross.length_squared() <= THIN * THIN * ab.length_squared() * ac.length_squared();
        let normal = if is_thin { DVec3::ZERO } else { cross.normalize_or_zero() };
        let inward = [b - a, c - b, a - c].map(|along| normal.cross(along).normalize_or_zero());
        Self { corners, normal, inward }
    }

    /// The squared distance of a point, if it is at most `most`.
    #[inline]
    pub(super) fn squared_distance(&self, point: DVec3, most: f64) -> Option<f64> {
        let [a, b, c] = self.corners;
        let height = self.normal.dot(point - a);
        let over = height * height;
        if over > most {
            return None;
        }
        let [of_a, of_b, of_c] = self.inward;
        let inside = of_a.dot(point - a).min(of_b.dot(point - b)).min(of_c.dot(point - c));
        // A triangle without a plane has no inside.
        if inside > 0.0 {
            return Some(over);
        }
        if over + inside * inside > most {
            return None;
        }
        Some(closest_on_triangle(point, &self.corners).length_squared()).filter(|&d| d <= most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;

    #[test]
    fn points_over_it_and_beside_it_are_as_far_away_as_from_the_triangle_itself() {
        let mut random = SplitMix64::new(3);
        let mut point = || DVec3::from_array([(); 3].map(|()| 2.0 * random.uniform() - 1.0));
        let mut near = 0;
        for round in 0..20_000 {
            let [a, b, mut c] = [(); 3].map(|()| point());
            match round % 10 {
                0 => c = a + 0.3 * (b - a),
                1 => c = b,
                _ => {}
            }
            let (x, triangle) = (point(), [a, b, c]);
            let squared = closest_on_triangle(x, &triangle).length_squared();
            let most = 0.2;
            let found = Prepared::new(triangle).squared_distance(x, most);
            near += usize::from(found.is_some());
            if (squared - most).abs() > 1e-9 {
                assert_eq!(found.is_some(), squared < most, "{x} {triangle:?}");
            }
            if let Some(found) = found {
                assert!((found - squared).abs() < 1e-9, "{found} {squared}");
            }
        }
        assert!((4_000..16_000).contains(&near), "{near}");
    }
}
