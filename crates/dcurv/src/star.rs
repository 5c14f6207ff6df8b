//! The star of a vertex and its integrated curvature.
//!
//! All integrals of the papers at a vertex depend only on the vertex and its ordered neighbours.
//! [`VertexStar`] holds these points: the star of a mesh vertex, or of a vertex after a flip, collapse or
//! move. All evaluations of this crate use the same code, so an evaluation before an edit and an
//! evaluation of the edited mesh give the same bits.

use core::f64::consts::PI;

use glam::{DVec2, DVec3};
use mesh_core::{TriMesh, VertexId};

use crate::angle::{AngleSum, corner_direction, unit_scale, unit_scaled};
use crate::area::{VertexArea, corner_share};
use crate::dihedral::hinge_angle;
use crate::quantity::{Area, Integral};

/// A vertex and its neighbours in order.
#[derive(Clone, Copy, Debug)]
pub struct VertexStar<'a> {
    /// The vertex.
    pub center: DVec3,
    /// Its neighbours, clockwise seen from outside: the order of
    /// [`one_ring`](mesh_core::Topology::one_ring). Two consecutive neighbours and the centre form a
    /// face.
    pub ring: &'a [DVec3],
    /// Whether the last and the first neighbour form a face as well. If not, the centre is a boundary
    /// vertex between the first and the last neighbour.
    pub closed: bool,
}

/// Integrated curvatures and area of a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VertexIntegrals {
    /// Gaussian curvature: `2 pi - sum of angles` (DHKL01 eq. 1). At a boundary vertex, the
    /// geodesic curvature of the boundary: `pi - sum of angles`. In radians.
    pub angle_defect: Integral,
    /// Mean curvature: `1/4 sum of |e| beta` over the edges between two faces, with signed
    /// dihedral angles, positive where convex (KKL02 sec. 3.1). In model units.
    pub mean: Integral,
    /// `1/4 sum of |e| |beta|`: the absolute mean curvature of DHKL01 (eq. 1). At least the absolute
    /// value of `mean`. In model units.
    pub abs_dihedral: Integral,
    /// Area of the vertex.
    pub area: Area,
}

/// A face of the star: the edge vectors from the centre to its other two corners, clockwise, and
/// their cross product, which points outwards.
#[derive(Clone, Copy)]
struct StarFace {
    from: DVec3,
    to: DVec3,
    normal: DVec3,
}

impl StarFace {
    #[inline]
    fn new(from: DVec3, to: DVec3) -> Self {
        Self { from, to, normal: to.cross(from) }
    }

    #[inline]
    fn add_to(&self, totals: &mut StarTotals, kind: VertexArea) {
        let twice_area = self.normal.length();
        let corner = corner_direction(self.from, self.to, twice_area);
        totals.add_face(unit_scaled(corner), corner_share(kind, self.from, self.to, twice_area));
    }

    /// Length times dihedral angle of the edge between this face and the next one clockwise.
    #[inline]
    fn bend(&self, following: &Self) -> f64 {
        let length = self.to.length();
        length * hinge_angle(length, self.normal, following.normal, following.to)
    }
}

impl VertexStar<'_> {
    /// All integrals of the vertex.
    ///
    /// A star without faces has no curvature and no area. A boundary vertex whose faces have no area
    /// still has an angle defect. Never NaN for finite positions. Valid for edge lengths between 1e-70
    /// and 1e70, if the lengths at one vertex differ by at most a factor of 1e50. If products would
    /// overflow, the star is first scaled by a power of two, which changes no bits.
    #[inline]
    #[must_use]
    pub fn integrals(&self, area: VertexArea) -> VertexIntegrals {
        integrals(self.center, self.ring.iter().copied(), self.closed, area)
    }

    /// The integral of Gaussian curvature; see [`VertexIntegrals::angle_defect`].
    #[must_use]
    pub fn angle_defect(&self) -> Integral {
        self.integrals(VertexArea::Barycentric).angle_defect
    }

    /// The integral of mean curvature; see [`VertexIntegrals::mean`].
    #[must_use]
    pub fn mean(&self) -> Integral {
        self.integrals(VertexArea::Barycentric).mean
    }

    /// The integral of the absolute dihedral angles; see [`VertexIntegrals::abs_dihedral`].
    #[must_use]
    pub fn abs_dihedral(&self) -> Integral {
        self.integrals(VertexArea::Barycentric).abs_dihedral
    }

    /// Area of the vertex.
    #[must_use]
    pub fn area(&self, kind: VertexArea) -> Area {
        self.integrals(kind).area
    }
}

/// [`VertexStar::integrals`] from an iterator over the neighbours.
#[inline]
pub(crate) fn integrals(
    center: DVec3,
    ring: impl Iterator<Item = DVec3> + Clone,
    closed: bool,
    area: VertexArea,
) -> VertexIntegrals {
    let found =
        incident_edge_integrals(ring.clone().map(|neighbour| neighbour - center), closed, area);
    if found.is_in_range() { found } else { scaled_integrals(center, ring, closed, area) }
}

/// The integrals of a vertex of a mesh.
#[inline]
pub(crate) fn vertex_integrals(
    mesh: &TriMesh,
    vertex: VertexId,
    area: VertexArea,
) -> VertexIntegrals {
    let topology = mesh.topology();
    let ring = topology.one_ring(vertex).map(|v| mesh.position(v));
    integrals(mesh.position(vertex), ring, !topology.is_boundary_vertex(vertex), area)
}

/// [`integrals`] of a star that is very large, very small or without area.
#[cold]
fn scaled_integrals(
    center: DVec3,
    ring: impl Iterator<Item = DVec3> + Clone,
    closed: bool,
    area: VertexArea,
) -> VertexIntegrals {
    let incident_edges = ring.map(|neighbour| neighbour - center);
    let longest = incident_edges
        .clone()
        .map(|incident_edge| incident_edge.abs().max_element())
        .fold(0.0, f64::max);
    // Without any length there is nothing to scale.
    let scale = if longest > 0.0 { unit_scale(longest.min(f64::MAX)) } else { 1.0 };
    let found = incident_edge_integrals(
        incident_edges.map(|incident_edge| incident_edge * scale),
        closed,
        area,
    );
    VertexIntegrals {
        angle_defect: found.angle_defect,
        mean: Integral::new(found.mean.value() / scale),
        abs_dihedral: Integral::new(found.abs_dihedral.value() / scale),
        area: Area::new(found.area.value() / scale / scale),
    }
}

impl VertexIntegrals {
    /// Whether no product on the way to these values overflowed or underflowed. Products have up to six
    /// lengths. Overflow shows as a value that is not finite; underflow is negligible against such an area.
    #[inline]
    pub(crate) fn is_in_range(&self) -> bool {
        let area = self.area.value();
        area > 1e-60 && area < 1e60 && self.abs_dihedral.value() < 1e100
    }
}

/// The integrals of a star with these edge vectors from the centre.
#[inline]
fn incident_edge_integrals(
    mut incident_edges: impl Iterator<Item = DVec3>,
    closed: bool,
    area: VertexArea,
) -> VertexIntegrals {
    let mut totals = StarTotals::ZERO;
    let (Some(first), Some(second)) = (incident_edges.next(), incident_edges.next()) else {
        return VertexIntegrals::default();
    };
    let first_face = StarFace::new(first, second);
    first_face.add_to(&mut totals, area);
    let mut face = first_face;
    for incident_edge in incident_edges {
        let following = StarFace::new(face.to, incident_edge);
        following.add_to(&mut totals, area);
        totals.add_edge(face.bend(&following));
        face = following;
    }
    if closed {
        let last_face = StarFace::new(face.to, first);
        last_face.add_to(&mut totals, area);
        totals.add_edge(face.bend(&last_face));
        totals.add_edge(last_face.bend(&first_face));
    }
    totals.integrals(totals.angle_defect(full_angle(closed)))
}

/// Running sums over a star.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StarTotals {
    angle: AngleSum,
    area: f64,
    mean: f64,
    abs_dihedral: f64,
}

impl StarTotals {
    pub(crate) const ZERO: Self =
        Self { angle: AngleSum::ZERO, area: 0.0, mean: 0.0, abs_dihedral: 0.0 };

    /// Adds a face: a unit-scaled vector with the angle of its corner, and its share of area.
    #[inline(always)]
    pub(crate) fn add_face(&mut self, corner: DVec2, share: f64) {
        self.angle.add(corner);
        self.area += share;
    }

    /// Adds an edge: its length times its dihedral angle.
    #[inline(always)]
    pub(crate) fn add_edge(&mut self, bend: f64) {
        self.mean += bend;
        self.abs_dihedral += bend.abs();
    }

    /// Full angle minus the sum of the corner angles.
    #[inline]
    pub(crate) fn angle_defect(&self, full_angle: f64) -> f64 {
        full_angle - self.angle.radians()
    }

    #[inline]
    pub(crate) fn integrals(&self, angle_defect: f64) -> VertexIntegrals {
        VertexIntegrals {
            angle_defect: Integral::new(angle_defect),
            mean: Integral::new(0.25 * self.mean),
            abs_dihedral: Integral::new(0.25 * self.abs_dihedral),
            area: Area::new(self.area),
        }
    }
}

/// The angle sum of a flat star: 2 pi inside, pi at the boundary.
#[inline]
pub(crate) fn full_angle(closed: bool) -> f64 {
    if closed { 2.0 * PI } else { PI }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dihedral::dihedral_angle;

    /// The apex of a pyramid over a regular polygon, clockwise seen from above.
    fn pyramid(sides: u32, height: f64) -> (DVec3, Vec<DVec3>) {
        let at = |i: u32| {
            let turn = -2.0 * PI * f64::from(i) / f64::from(sides);
            DVec3::new(turn.cos(), turn.sin(), 0.0)
        };
        (DVec3::new(0.0, 0.0, height), (0..sides).map(at).collect())
    }

    #[test]
    fn cube_corner_has_the_curvature_of_an_eighth_of_a_cube() {
        let ring = [DVec3::X, DVec3::Y, DVec3::Z];
        // The corner at the origin of the cube in the positive octant: outside is below.
        let star = VertexStar { center: DVec3::ZERO, ring: &ring, closed: true };
        let found = star.integrals(VertexArea::Voronoi);
        assert!((found.angle_defect.value() - 0.5 * PI).abs() < 1e-15);
        assert!((found.mean.value() - 3.0 / 4.0 * 0.5 * PI).abs() < 1e-15);
        assert_eq!(found.mean, found.abs_dihedral);
        assert!((found.area.value() - 0.75).abs() < 1e-15);
    }

    #[test]
    fn mean_is_the_sum_of_dihedral_angles() {
        for height in [1.0, -0.5, 1e-6] {
            let (center, ring) = pyramid(7, height);
            let star = VertexStar { center, ring: &ring, closed: true };
            let mut mean = 0.0;
            for i in 0..7 {
                let [before, at, after] = [i + 6, i, i + 1].map(|k| ring[k % 7]);
                mean += 0.25 * center.distance(at) * dihedral_angle(center, at, before, after);
            }
            assert!((star.mean().value() - mean).abs() < 1e-13 * mean.abs());
            assert!((star.abs_dihedral().value() - mean.abs()).abs() < 1e-13 * mean.abs());
            assert!(mean * height > 0.0);
        }
    }

    #[test]
    fn boundary_star_has_the_turn_of_the_boundary() {
        let ring = [DVec3::X, DVec3::Y];
        let star = VertexStar { center: DVec3::ZERO, ring: &ring, closed: false };
        let found = star.integrals(VertexArea::Barycentric);
        assert!((found.angle_defect.value() - 0.5 * PI).abs() < 1e-15);
        assert_eq!((found.mean, found.abs_dihedral), (Integral::default(), Integral::default()));
        assert_eq!(found.area, Area::new(1.0 / 6.0));
    }

    #[test]
    fn values_are_right_for_edge_lengths_from_1e_minus_70_to_1e70() {
        // Obtuse at the centre, obtuse at the rim, and a boundary.
        let stars = [(pyramid(3, 0.2), true), (pyramid(9, 4.0), true), (pyramid(4, 0.5), false)];
        for ((center, ring), closed) in stars {
            for kind in [VertexArea::Voronoi, VertexArea::Barycentric] {
                let at = |scale: f64| {
                    let ring: Vec<DVec3> = ring.iter().map(|&p| p * scale).collect();
                    VertexStar { center: center * scale, ring: &ring, closed }.integrals(kind)
                };
                let unit = at(1.0);
                let is_close = |found: f64, expected: f64| {
                    (found - expected).abs() <= 1e-12 * expected.abs() + 1e-15
                };
                for exponent in -70..=70 {
                    let scale = 10.0_f64.powi(exponent);
                    let found = at(scale);
                    let message = format!("1e{exponent}: {found:?}");
                    let defect = found.angle_defect.value();
                    assert!(is_close(defect, unit.angle_defect.value()), "{message}");
                    assert!(is_close(found.mean.value() / scale, unit.mean.value()), "{message}");
                    let area = found.area.value() / scale / scale;
                    assert!(is_close(area, unit.area.value()), "{message}");
                }
                // Powers of two change no bits.
                for exponent in [-220, -190, -100, 100, 190, 220] {
                    let scale = 2.0_f64.powi(exponent);
                    let found = at(scale);
                    assert_eq!(found.angle_defect, unit.angle_defect);
                    assert_eq!(found.mean.value() / scale, unit.mean.value());
                    assert_eq!(found.area.value() / scale / scale, unit.area.value());
                }
            }
        }
    }

    #[test]
    fn degenerate_stars_have_values() {
        let p = DVec3::new(1.0, 2.0, 3.0);
        let zero = VertexIntegrals::default();
        for ring in [&[][..], &[p]] {
            let star = VertexStar { center: p, ring, closed: false };
            assert_eq!(star.integrals(VertexArea::Voronoi), zero);
        }
        let star = VertexStar { center: p, ring: &[p; 6], closed: true };
        let found = star.integrals(VertexArea::Voronoi);
        assert!(found.angle_defect.value().abs() < 1e-15);
        assert_eq!((found.mean, found.area), (zero.mean, zero.area));
    }
}
