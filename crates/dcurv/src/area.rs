//! Area of a vertex.

use glam::DVec3;

use crate::quantity::Area;

/// Distribution of the area of a triangle to its corners. The shares are never negative and add up to the
/// area of the triangle. Triangles without area contribute 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum VertexArea {
    /// Voronoi area: the points of the triangle nearest to the corner (DHKL01 sec. 5).
    #[default]
    Voronoi,
    /// One third of the triangle per corner.
    Barycentric,
}

/// The share of corner `a` in the triangle `(a, b, c)`. Valid for edge lengths between 1e-45 and 1e45;
/// [stars](crate::star) scale other lengths first.
#[inline]
#[must_use]
pub fn corner_area(kind: VertexArea, a: DVec3, b: DVec3, c: DVec3) -> Area {
    let (u, w) = (b - a, c - a);
    Area::new(corner_share(kind, u, w, u.cross(w).length()))
}

/// The share of the corner between the edge vectors `u` and `w`, given twice the area of the
/// triangle.
#[inline]
pub(crate) fn corner_share(kind: VertexArea, u: DVec3, w: DVec3, twice_area: f64) -> f64 {
    match kind {
        VertexArea::Voronoi => voronoi_share(u, w, twice_area),
        VertexArea::Barycentric => barycentric_share(u, w, twice_area),
    }
}

#[inline]
pub(crate) fn barycentric_share(_: DVec3, _: DVec3, twice_area: f64) -> f64 {
    twice_area / 6.0
}

/// DHKL01 sec. 5, for the corner A between `u` to B and `w` to C:
///
/// - no angle is obtuse: `(|w|² cot B + |u|² cot C) / 8`;
/// - A is obtuse: the area without the shares of B and C;
/// - B is obtuse: `|u|² tan A / 8`; C is obtuse: `|w|² tan A / 8`.
///
/// Cotangents and tangents are quotients of a scalar product and twice the area. No difference cancels:
/// an obtuse corner has at least half of the triangle.
#[inline]
pub(crate) fn voronoi_share(u: DVec3, w: DVec3, twice_area: f64) -> f64 {
    let across = w - u;
    let (at_a, at_b, at_c) = (u.dot(w), -u.dot(across), w.dot(across));
    let (uu, ww) = (u.length_squared(), w.length_squared());
    let crossed = ww * at_b + uu * at_c;
    // The share is `offset + numerator / denominator / 8`. All selections compile without branches,
    // because the obtuse corner is unpredictable.
    let (acute, obtuse_b, obtuse_c) = (crossed, uu * twice_area, ww * twice_area);
    let numerator = if at_b < 0.0 { obtuse_b } else { acute };
    let numerator = if at_c < 0.0 { obtuse_c } else { numerator };
    let numerator = if at_a < 0.0 { -twice_area * crossed } else { numerator };
    let nearest_to_right = if at_b < at_c { at_b } else { at_c };
    let denominator = if nearest_to_right < 0.0 { at_a } else { twice_area };
    let denominator = if at_a < 0.0 { at_b * at_c } else { denominator };
    let offset = if at_a < 0.0 { 0.5 * twice_area } else { 0.0 };
    let share = offset + 0.125 * numerator / denominator;
    if twice_area > 0.0 { share } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;

    fn shares(kind: VertexArea, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
        [[a, b, c], [b, c, a], [c, a, b]].map(|[a, b, c]| corner_area(kind, a, b, c).value())
    }

    fn area([a, b, c]: [DVec3; 3]) -> f64 {
        0.5 * (b - a).cross(c - a).length()
    }

    #[test]
    fn shares_are_nowhere_negative_and_add_up() {
        let mut random = SplitMix64::new(11);
        for _ in 0..20_000 {
            let mut point = || DVec3::new(random.uniform(), random.uniform(), random.uniform());
            let triangle = [point(), point(), point()];
            for kind in [VertexArea::Voronoi, VertexArea::Barycentric] {
                let shares = shares(kind, triangle);
                assert!(shares.iter().all(|&s| s >= 0.0), "{triangle:?}");
                let error = shares.iter().sum::<f64>() - area(triangle);
                assert!(error.abs() < 1e-14, "{triangle:?} {error}");
            }
        }
    }

    #[test]
    fn voronoi_share_is_what_lies_nearest() {
        // Points of a fine lattice, counted by nearest corner.
        let triangles = [
            [[0.0, 0.0], [1.0, 0.0], [0.4, 0.9]],
            [[0.0, 0.0], [1.0, 0.0], [0.3, 0.2]],
            [[0.0, 0.0], [1.0, 0.0], [-0.7, 0.4]],
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        ];
        for triangle in triangles {
            let corners = triangle.map(|[x, y]| DVec3::new(x, y, 0.0));
            let count = 1000;
            let mut nearest = [0_u32; 3];
            for i in 0..count {
                for j in 0..count - i {
                    let [s, t] = [i, j].map(|k| (f64::from(k) + 1.0 / 3.0) / f64::from(count));
                    let point = corners[0] * (1.0 - s - t) + corners[1] * s + corners[2] * t;
                    let distance = corners.map(|c| c.distance_squared(point));
                    let best = (0..3).min_by(|&x, &y| distance[x].total_cmp(&distance[y]));
                    nearest[best.unwrap()] += 1;
                }
            }
            let total: u32 = nearest.iter().sum();
            let found = shares(VertexArea::Voronoi, corners);
            for (found, nearest) in found.into_iter().zip(nearest) {
                let expected = area(corners) * f64::from(nearest) / f64::from(total);
                assert!((found - expected).abs() < 2e-3 * area(corners), "{triangle:?}");
            }
        }
    }

    #[test]
    fn degenerate_triangles_share_nothing() {
        let [p, q] = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(3.0, 2.0, 1.0)];
        for triangle in [[p, p, p], [p, p, q], [p, q, p], [q, p, p], [p, 0.5 * (p + q), q]] {
            for kind in [VertexArea::Voronoi, VertexArea::Barycentric] {
                assert_eq!(shares(kind, triangle), [0.0; 3]);
            }
        }
    }
}
