//! Total absolute extrinsic curvature of Alboul and van Damme 1996, Polyhedral metrics in surface
//! reconstruction: tight triangulations.
//!
//! Gaussian curvature splits into a positive and a negative part, `K = K+ - K-`:
//!
//! - `K+` is the angle defect of the convex hull of the star, at the vertex; 0 if the vertex is not a
//!   corner of that hull. It is the area of the normals of all planes that support the star at the vertex.
//! - `K- = K+ - K`, with the angle defect `K` of the star.
//!
//! The total absolute extrinsic curvature is the sum of `K+ + K- = 2 K+ - K`, in radians. It is at least
//! `4 pi` for a closed surface, with equality for convex ones. The sum of `|K|` differs from it: at a vertex
//! that is convex in one direction and folded in another, both parts are positive and cancel in `K`.
//!
//! **Computation.** The hull at the vertex is a cone. Its angle defect is `2 pi` minus the perimeter of the
//! spherical convex hull of the edge directions. An incremental hull with exact orientation predicates
//! finds the rays of the cone.
//!
//! **Boundary.** Both parts are 0 at boundary vertices, where this crate has no Gaussian curvature.

use core::f64::consts::{PI, TAU};
use std::collections::VecDeque;

use glam::DVec3;
use mesh_core::{Handle, TriMesh, VertexId, VertexMap, direction, orient3d, parallel, unit_sized};

use crate::angle::corner_angle;
use crate::quantity::Integral;
use crate::star::VertexStar;

/// The positive and the negative part of the Gaussian curvature of a vertex, in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ExtrinsicCurvature {
    /// `K+`: angle defect of the convex hull of the star.
    pub positive: Integral,
    /// `K- = K+ - K`.
    pub negative: Integral,
}

impl ExtrinsicCurvature {
    /// The absolute extrinsic curvature, `K+ + K-`.
    #[must_use]
    pub fn absolute(&self) -> Integral {
        self.positive + self.negative
    }
}

impl VertexStar<'_> {
    /// The extrinsic curvature of the vertex; see the [module page](crate::extrinsic).
    #[must_use]
    pub fn extrinsic(&self) -> ExtrinsicCurvature {
        if !self.closed || self.ring.is_empty() {
            return ExtrinsicCurvature::default();
        }
        let gaussian = self.angle_defect();
        // In exact arithmetic the hull has at least the angle defect of the star.
        let positive = hull_defect(self.center, self.ring).max(gaussian.value());
        let positive = Integral::new(positive);
        ExtrinsicCurvature { positive, negative: positive - gaussian }
    }
}

/// The extrinsic curvature of a vertex of a mesh; 0 for boundary vertices and isolated vertices.
///
/// # Panics
/// When the vertex is out of range for this mesh.
#[must_use]
pub fn extrinsic_curvature(mesh: &TriMesh, vertex: VertexId) -> ExtrinsicCurvature {
    let topology = mesh.topology();
    if topology.is_boundary_vertex(vertex) {
        return ExtrinsicCurvature::default();
    }
    let ring: Vec<DVec3> = topology.one_ring(vertex).map(|v| mesh.position(v)).collect();
    VertexStar { center: mesh.position(vertex), ring: &ring, closed: true }.extrinsic()
}

/// [`extrinsic_curvature`] of all vertices; 0 for removed ones.
#[must_use]
pub fn extrinsic_curvatures(mesh: &TriMesh) -> VertexMap<ExtrinsicCurvature> {
    VertexMap::from_vec(parallel::collect(mesh.topology().vertex_capacity(), |index| {
        extrinsic_curvature(mesh, VertexId::from_index(index))
    }))
}

/// The total absolute extrinsic curvature of a mesh: the sum of `2 K+ - K` over interior vertices.
#[must_use]
pub fn total_extrinsic_curvature(mesh: &TriMesh) -> Integral {
    let all = extrinsic_curvatures(mesh).into_vec();
    Integral::new(parallel::sum(all.len(), |index| all[index].absolute().value()))
}

/// `2 pi` minus the perimeter of the spherical convex hull of the directions to these points; 0 if the
/// cone over them contains a line.
fn hull_defect(center: DVec3, points: &[DVec3]) -> f64 {
    let Some(rays) = cone_hull(center, points) else { return 0.0 };
    let next = rays.iter().cycle().skip(1);
    let perimeter: f64 = rays.iter().zip(next).map(|(&p, &q)| corner_angle(center, p, q)).sum();
    (TAU - perimeter).max(0.0)
}

/// Points on the extreme rays of the cone over `points` from `center`, in cyclic order. Two points if all
/// rays are coplanar, one or none if all are equal. `None` if the cone contains a line.
fn cone_hull(center: DVec3, points: &[DVec3]) -> Option<Vec<DVec3>> {
    let mut rays = points.iter().copied().filter(|&p| p != center);
    let Some(first) = rays.next() else { return Some(Vec::new()) };
    let [along] = unit_sized([first - center]);
    let width = |p: &DVec3| direction(*p - center).cross(along).length();
    let widest = rays.clone().max_by(|p, q| width(p).total_cmp(&width(q)));
    let Some(second) = widest else { return Some(vec![first]) };
    let Some(third) = rays.clone().find(|&p| side(center, first, second, p) != 0.0) else {
        return planar_cone_hull(center, first, second, rays);
    };
    let mut hull = VecDeque::from(if side(center, first, second, third) > 0.0 {
        [first, second, third]
    } else {
        [first, third, second]
    });
    for point in rays {
        if !extend_end(&mut hull, center, point)
            && let Some(larger) = insert(hull.make_contiguous(), center, point)?
        {
            hull = larger;
        }
    }
    Some(hull.into())
}

/// Adds a ray to a convex cone with at least three rays, if it lies outside the face between the last ray and the first.
/// Fast for rays that go round the cone in order, as the neighbours of a vertex do. Returns false if the cone has to be
/// searched, or contains a line.
fn extend_end(hull: &mut VecDeque<DVec3>, center: DVec3, point: DVec3) -> bool {
    let of_face = |i: usize| side(center, hull[i], hull[(i + 1) % hull.len()], point);
    let is_outside = |i: &usize| of_face(*i) < 0.0;
    let last = hull.len() - 1;
    if !is_outside(&last) {
        return false;
    }
    // The faces beside it that the ray lies outside of as well.
    let before = (0..last).rev().take_while(is_outside).count();
    let after = (0..last - before).take_while(is_outside).count();
    let ends = [after, (last - 1).saturating_sub(before)];
    // If there is no face that it lies inside of, the opposite ray may be in the cone.
    if before + after >= last || !ends.into_iter().any(|i| of_face(i) > 0.0) {
        return false;
    }
    hull.truncate(hull.len() - before);
    hull.drain(..after);
    hull.push_back(point);
    true
}

/// Adds a ray to a convex cone with at least three rays: the new cone, or nothing if the ray lies in it. `None` if the
/// new cone contains a line.
fn insert(hull: &[DVec3], center: DVec3, point: DVec3) -> Option<Option<VecDeque<DVec3>>> {
    let count = hull.len();
    let sides: Vec<f64> =
        (0..count).map(|i| side(center, hull[i], hull[(i + 1) % count], point)).collect();
    // The opposite ray is in the cone.
    if sides.iter().all(|&side| side <= 0.0) {
        return None;
    }
    // The first of the faces of the cone that the ray lies outside of.
    let is_outside = |i: usize| sides[i % count] < 0.0;
    let Some(start) = (0..count).find(|&i| is_outside(i) && !is_outside(i + count - 1)) else {
        return Some(None);
    };
    let outside = (start..).take_while(|&i| is_outside(i)).count();
    // Keeps the rays from the end of the last such face, cyclically, to the start of the first.
    let kept = (start + outside..=start + count).map(|i| hull[i % count]);
    Some(Some(kept.chain([point]).collect()))
}

/// [`cone_hull`] of coplanar rays.
fn planar_cone_hull(
    center: DVec3,
    first: DVec3,
    second: DVec3,
    rays: impl Iterator<Item = DVec3>,
) -> Option<Vec<DVec3>> {
    let x = direction(first - center);
    let y = direction((second - center).reject_from_normalized(x));
    let (mut low, mut high) = ((0.0, first), (0.0, first));
    for point in rays {
        let angle = (point - center).dot(y).atan2((point - center).dot(x));
        if angle < low.0 {
            low = (angle, point);
        }
        if angle > high.0 {
            high = (angle, point);
        }
    }
    (high.0 - low.0 < PI).then(|| vec![low.1, high.1])
}

/// The sign of the determinant of the vectors from `center` to three points, by an exact predicate.
fn side(center: DVec3, p: DVec3, q: DVec3, r: DVec3) -> f64 {
    -orient3d([center, p, q, r])
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;

    /// The angle defect of a convex cone by sampling: the share of directions that support it.
    fn sampled_defect(rays: &[DVec3], random: &mut SplitMix64) -> f64 {
        let count = 200_000;
        let mut supporting = 0;
        for _ in 0..count {
            let normal = loop {
                let p = DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
                if p.length_squared() <= 1.0 {
                    break p;
                }
            };
            supporting += u32::from(rays.iter().all(|ray| normal.dot(*ray) < 0.0));
        }
        2.0 * TAU * f64::from(supporting) / f64::from(count)
    }

    #[test]
    fn hull_defect_is_the_area_of_the_supporting_normals() {
        let mut random = SplitMix64::new(3);
        let center = DVec3::new(0.3, -2.0, 0.7);
        for count in 3..9 {
            for spread in [0.5, 1.0, 3.0] {
                let mut ray =
                    || DVec3::new(spread * random.symmetric(), spread * random.symmetric(), 1.0);
                let rays: Vec<DVec3> = (0..count).map(|_| ray()).collect();
                let points: Vec<DVec3> = rays.iter().map(|&ray| center + ray).collect();
                let expected = sampled_defect(&rays, &mut random);
                let found = hull_defect(center, &points);
                assert!((found - expected).abs() < 0.05, "{found} {expected}");
            }
        }
    }

    #[test]
    fn rays_in_order_give_the_same_cone_as_a_search() {
        let mut random = SplitMix64::new(5);
        for round in 0..400 {
            let (count, rough) = (3 + round % 40, [0.0, 0.01, 0.5, 2.0][round / 40 % 4]);
            let on_rim = |i: usize, random: &mut SplitMix64| {
                let angle = TAU * i as f64 / count as f64;
                DVec3::new(angle.cos(), angle.sin(), 1.0 + rough * random.symmetric())
            };
            let rays: Vec<DVec3> = (0..count).map(|i| on_rim(i, &mut random)).collect();
            let mut hull = VecDeque::from([rays[0], rays[1], rays[2]]);
            if side(DVec3::ZERO, rays[0], rays[1], rays[2]) <= 0.0 {
                hull.swap(1, 2);
            }
            let mut shortcuts = 0;
            for &ray in rays.iter().chain(&rays) {
                let searched = insert(hull.make_contiguous(), DVec3::ZERO, ray);
                let mut extended = hull.clone();
                if extend_end(&mut extended, DVec3::ZERO, ray) {
                    shortcuts += 1;
                    assert_eq!(searched, Some(Some(extended)), "{round}");
                }
                match searched {
                    Some(Some(larger)) => hull = larger,
                    Some(None) => {}
                    None => break,
                }
            }
            assert!(rough > 0.0 || shortcuts + 3 == count, "{shortcuts} {count}");
        }
    }

    #[test]
    fn a_cone_with_a_line_has_no_defect() {
        let center = DVec3::ZERO;
        let axes = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y];
        assert_eq!(hull_defect(center, &axes), 0.0);
        assert_eq!(hull_defect(center, &[DVec3::X, DVec3::Y, DVec3::Z, -DVec3::ONE]), 0.0);
        // A wedge: two half-planes through a line.
        assert_eq!(hull_defect(center, &[DVec3::X, DVec3::Y, -DVec3::X, DVec3::Z]), 0.0);
    }

    #[test]
    fn flat_and_needle_cones_have_the_defect_of_their_limit() {
        let center = DVec3::ZERO;
        let quarter = hull_defect(center, &[DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]);
        assert!((quarter - PI).abs() < 1e-15);
        assert_eq!(hull_defect(center, &[DVec3::X, 2.0 * DVec3::X]), TAU);
        let octant = hull_defect(center, &[DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE]);
        assert!((octant - 0.5 * PI).abs() < 1e-15);
    }
}
