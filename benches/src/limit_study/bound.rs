//! The least distance from a smooth surface that a given number of triangles can have, to first order.
//!
//! A triangle over a piece of area a, with the Gaussian curvature K, has at least the mean distance c |K|^(1/2) a: c is
//! C1 for the sign of K, likewise C2 for the root mean square and C∞ for the largest distance. For K > 0 the bound is
//! reached by a triangle that is equilateral after the affine map that turns the surface into a sphere, with its plane
//! shifted so that the surface lies on both sides (Fejes Tóth 1953, Gruber 1993). For K < 0 the constants belong to the
//! best known shapes (Pottmann, Krasauskas, Hamann, Joy and Seibold 2000).
//!
//! For the largest distance and K < 0, C∞ = √3/8 bounds one class: continuous triangulations made of one triangle and
//! its point reflection, with the same deviation at all vertices (Atariah, Rote and Wintraecken 2018; optimal in this
//! class: Burlacu, Hager and Hildebrand, arXiv 2604.04026, who conjecture it for all continuous triangulations). Without
//! continuity, where deviations may differ from vertex to vertex, the constant is 3√3/32, a quarter less (same paper).
//! Interpolation has √5/10.
//!
//! A Lagrange multiplier gives the distribution of the triangles over the surface.

use mesh_core::TriMesh;

use super::surfaces::Shape;

/// The mean, root mean square and largest distance, each minimised by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Mean distance.
    pub mean: f64,
    /// Root mean square distance.
    pub rms: f64,
    /// Largest distance.
    pub max: f64,
}

impl Distances {
    /// The ratio to a limit.
    pub fn over(self, limit: Self) -> Self {
        let Self { mean, rms, max } = limit;
        Self { mean: self.mean / mean, rms: self.rms / rms, max: self.max / max }
    }
}

/// C1, C2 and C∞ for a positive and a negative Gaussian curvature.
fn constants(curvature: f64) -> Distances {
    if curvature >= 0.0 {
        Distances { mean: 0.05644, rms: 180_f64.sqrt().recip(), max: 27_f64.sqrt().recip() }
    } else {
        Distances { mean: 1.0 / 12.0, rms: 90_f64.sqrt().recip(), max: 3_f64.sqrt() / 8.0 }
    }
}

/// The limit for one triangle; for n triangles, divide by n. The integrals are sums over the faces of a fine mesh.
pub fn of_one_triangle(shape: Shape, fine: &TriMesh) -> Distances {
    let (mut area, mut mean, mut rms, mut max) = (0.0, 0.0, 0.0, 0.0);
    for face in fine.topology().faces() {
        let [a, b, c] = fine.triangle(face);
        let part = 0.5 * (b - a).cross(c - a).length();
        let curvature = shape.gaussian_curvature(shape.closest_point((a + b + c) / 3.0));
        let of = constants(curvature);
        area += part;
        mean += part * of.mean.sqrt() * curvature.abs().powf(0.25);
        rms += part * of.rms.powf(2.0 / 3.0) * curvature.abs().cbrt();
        max += part * of.max * curvature.abs().sqrt();
    }
    Distances { mean: mean * mean / area, rms: rms.powf(1.5) / area.sqrt(), max }
}

#[cfg(test)]
mod tests {
    use super::super::surfaces::{Fineness, Shape};
    use super::{constants, of_one_triangle};
    use core::f64::consts::PI;

    /// On a sphere the integrals are 4π.
    #[test]
    fn the_limit_of_a_sphere_is_its_area_times_the_constants() {
        let fine = Shape::Sphere.mesh(Fineness::Quick).unwrap();
        let limit = of_one_triangle(Shape::Sphere, &fine);
        let of = constants(1.0);
        for (found, constant) in [(limit.mean, of.mean), (limit.rms, of.rms), (limit.max, of.max)] {
            assert!((found / (4.0 * PI * constant) - 1.0).abs() < 2e-3);
        }
    }

    /// The largest distance of the best triangle of unit area from z = xy, whose K is -1. There are three classes of
    /// triangles: with any plane, with the same deviation at the three corners, and with corners on the surface. The
    /// best triangle of each class is found by random descent, from several starts.
    #[test]
    fn the_largest_distances_from_a_saddle_are_those_of_the_three_classes() {
        let mut random = mesh_core::SplitMix64::new(11);
        // Corners in the plane, scaled to area 1, and deviations there: all different, one, or none.
        let mut least = |deviations: usize| {
            let free = 6 + deviations;
            let distance = |x: &[f64; 9]| {
                let corners = [[x[0], x[1]], [x[2], x[3]], [x[4], x[5]]];
                let at = |i: usize| match deviations {
                    3 => x[6 + i],
                    1 => x[6],
                    _ => 0.0,
                };
                largest_distance(corners, [at(0), at(1), at(2)])
            };
            let mut best = f64::INFINITY;
            for _ in 0..12 {
                let mut x = [0.0; 9];
                x[..free].fill_with(|| random.symmetric());
                let (mut value, mut step) = (distance(&x), 0.5);
                while step > 1e-5 {
                    let mut failures = 0;
                    while failures < 60 {
                        let mut y = x;
                        y[..free].iter_mut().for_each(|y| *y += step * random.symmetric());
                        let other = distance(&y);
                        (x, value, failures) =
                            if other < value { (y, other, 0) } else { (x, value, failures + 1) };
                    }
                    step *= 0.7;
                }
                best = value.min(best);
            }
            best
        };
        let root3 = 3_f64.sqrt();
        for (deviations, expected) in
            [(3, 3.0 * root3 / 32.0), (1, constants(-1.0).max), (0, 5_f64.sqrt() / 10.0)]
        {
            let found = least(deviations);
            assert!((found / expected - 1.0).abs() < 5e-3, "{deviations}: {found}, not {expected}");
            assert!(found > expected * (1.0 - 1e-9), "{deviations}: {found} below {expected}");
        }
        assert!((0.75 * constants(-1.0).max / (3.0 * root3 / 32.0) - 1.0).abs() < 1e-12);
    }

    /// The largest distance over the area of the triangle: deviations are relative to the area. A saddle has its
    /// largest and smallest distances from a plane on the sides.
    fn largest_distance(corners: [[f64; 2]; 3], deviations: [f64; 3]) -> f64 {
        let [a, b, c] = corners;
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        let mut largest = 0.0_f64;
        for i in 0..3 {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            let (from, to) = (deviations[i], deviations[(i + 1) % 3]);
            // Along the side the difference of plane and saddle is from + t (to - from) + bend t (1 - t).
            let bend = (q[0] - p[0]) * (q[1] - p[1]) / area;
            let at = |t: f64| from + t * (to - from) + bend * t * (1.0 - t);
            let extreme = 0.5 + 0.5 * (to - from) / bend;
            largest = largest.max(from.abs()).max(to.abs());
            if (0.0..=1.0).contains(&extreme) {
                largest = largest.max(at(extreme).abs());
            }
        }
        if largest.is_nan() { f64::INFINITY } else { largest }
    }

    /// C1, C2 and C∞ by integration over one equilateral triangle over a unit paraboloid: the
    /// difference of plane and surface is |x|²/2 less a constant, the best one for each norm.
    #[test]
    fn the_constants_are_those_of_the_equilateral_triangle() {
        let steps = 600;
        let side = (4.0 / 3_f64.sqrt()).sqrt();
        let mut heights = Vec::new();
        for i in 0..steps {
            for j in 0..steps - i {
                for (u, v) in
                    [(1.0, 1.0), (2.0, 2.0)].iter().take(if i + j + 1 < steps { 2 } else { 1 })
                {
                    let [s, t] =
                        [(i as f64 + u / 3.0), (j as f64 + v / 3.0)].map(|x| x / steps as f64);
                    let [s, t] = [s - 1.0 / 3.0, t - 1.0 / 3.0];
                    heights.push(0.5 * side * side * (s * s + s * t + t * t));
                }
            }
        }
        heights.sort_by(f64::total_cmp);
        let count = heights.len() as f64;
        let median = heights[heights.len() / 2];
        let mean = heights.iter().sum::<f64>() / count;
        let range = heights[heights.len() - 1] - heights[0];
        let l1 = heights.iter().map(|h| (h - median).abs()).sum::<f64>() / count;
        let l2 = (heights.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / count).sqrt();
        let of = constants(1.0);
        assert!((l1 / of.mean - 1.0).abs() < 2e-3, "{l1}");
        assert!((l2 / of.rms - 1.0).abs() < 2e-3, "{l2}");
        assert!((0.5 * range / of.max - 1.0).abs() < 1e-2, "{range}");
    }
}
