//! The point of a triangle that is closest to a point of space.

use glam::DVec3;

/// The feature of a triangle that a closest point lies on, with corners and sides numbered in the
/// order of the vertices: side i runs from corner i to corner i + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feature {
    Corner(usize),
    Side(usize),
    Inside,
}

/// The closest point of a triangle, and the feature it lies on.
///
/// Which corner, side or inner region of the plane the point projects to follows from six dot
/// products (Ericson 2005, section 5.1.5). A triangle without area is the union of its sides.
pub(crate) fn closest_point(point: DVec3, [a, b, c]: [DVec3; 3]) -> (DVec3, Feature) {
    let (ab, ac) = (b - a, c - a);
    let from_a = point - a;
    let (a1, a2) = (ab.dot(from_a), ac.dot(from_a));
    if a1 <= 0.0 && a2 <= 0.0 {
        return (a, Feature::Corner(0));
    }
    let from_b = point - b;
    let (b1, b2) = (ab.dot(from_b), ac.dot(from_b));
    if b1 >= 0.0 && b2 <= b1 {
        return (b, Feature::Corner(1));
    }
    let weight_c = a1 * b2 - b1 * a2;
    if weight_c <= 0.0 && a1 >= 0.0 && b1 <= 0.0 {
        return (a + share(a1, a1 - b1) * ab, Feature::Side(0));
    }
    let from_c = point - c;
    let (c1, c2) = (ab.dot(from_c), ac.dot(from_c));
    if c2 >= 0.0 && c1 <= c2 {
        return (c, Feature::Corner(2));
    }
    let weight_b = c1 * a2 - a1 * c2;
    if weight_b <= 0.0 && a2 >= 0.0 && c2 <= 0.0 {
        return (a + share(a2, a2 - c2) * ac, Feature::Side(2));
    }
    let weight_a = b1 * c2 - c1 * b2;
    let (to_c, to_b) = (b2 - b1, c1 - c2);
    if weight_a <= 0.0 && to_c >= 0.0 && to_b >= 0.0 {
        return (b + share(to_c, to_c + to_b) * (c - b), Feature::Side(1));
    }
    let sum = weight_a + weight_b + weight_c;
    (a + weight_b / sum * ab + weight_c / sum * ac, Feature::Inside)
}

/// A quotient of non-negative numbers, with 0 / 0 = 0.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beats_a_dense_sampling_of_the_triangle() {
        let triangles = [
            [DVec3::ZERO, DVec3::X, DVec3::Y],
            [DVec3::ZERO, DVec3::new(3.0, 0.1, 0.2), DVec3::new(1.0, 0.0, -0.4)],
            [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X],
        ];
        let mut random = mesh_core::SplitMix64::new(3);
        for corners in triangles {
            for _ in 0..200 {
                let mut draw = || 2.0 * random.symmetric();
                let point = DVec3::new(draw(), draw(), draw());
                let (closest, _) = closest_point(point, corners);
                let best = sampled_distance(point, corners);
                let distance = point.distance(closest);
                assert!(distance <= best + 1e-12 && distance >= best - 0.05, "{distance} {best}");
            }
        }
    }

    fn sampled_distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
        let n = 60;
        let grid = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
        grid.map(|(i, j)| {
            let (v, w) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            point.distance(a + v * (b - a) + w * (c - a))
        })
        .fold(f64::INFINITY, f64::min)
    }
}
