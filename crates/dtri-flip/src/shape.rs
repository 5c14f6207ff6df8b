//! Shape constraints on the two new faces of a flip: convexity, turn, slivers.

use core::f64::consts::FRAC_PI_2;
use core::fmt;
use core::str::FromStr;

use glam::{DVec2, DVec3};
use mesh_core::diagnose::SLIVER_HEIGHT;
use mesh_core::{TriMesh, VertexId, VertexMap};
use robust::{Coord, Coord3D, orient2d, orient3d};

use crate::fold::{folds, turn_of, twice_vector_area};
use crate::quad::Quad;

/// Constraint on the shape of the two new faces of a flip.
///
/// Each cost has a default, [`FlipCost::shape_constraint`](crate::FlipCost::shape_constraint). The option
/// [`FlipOptions::shape`](crate::FlipOptions::shape) overrides it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum ShapeConstraint {
    /// Only degenerate faces are rejected, as in DHKL01 and BAR06. A flip may fold a face back.
    Unrestricted,
    /// New faces are not worse than the old ones. A flip is rejected
    ///
    /// - if a new normal makes more than a right angle with the vector area of the quadrilateral, and
    ///   more than the old normals do;
    /// - if there are more reversed faces than before, or one that is turned further;
    /// - if there are more slivers than before, or one that is thinner.
    ///
    /// A face is reversed if its normal makes a right angle or more with the normal that one of its
    /// vertices has in the input mesh. So many flips with small turns can neither reverse a face nor set it
    /// upright across the inside.
    /// A sliver is a triangle with a height below a thousandth of its longest side.
    ///
    /// In the plane the first rule rejects exactly the flips of quadrilaterals that are not convex, so the
    /// area of a flat sheet never grows.
    #[default]
    KeepShape,
    /// As `KeepShape`, and the quadrilateral must be convex, with the two faces unfolded into a plane. The
    /// intrinsic Delaunay criterion is defined for such quadrilaterals only: in any other one, the second
    /// diagonal is outside, and the flip would overlap neighbours.
    Convex,
}

impl ShapeConstraint {
    /// All constraints.
    pub const ALL: &'static [Self] = &[Self::Unrestricted, Self::KeepShape, Self::Convex];

    /// The name.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Unrestricted => "unrestricted",
            Self::KeepShape => "keep-shape",
            Self::Convex => "convex",
        }
    }
}

impl fmt::Display for ShapeConstraint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// An unknown name of a shape constraint.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown shape constraint {0:?}; the constraints are unrestricted, keep-shape, convex")]
pub struct UnknownShapeConstraint(String);

impl FromStr for ShapeConstraint {
    type Err = UnknownShapeConstraint;

    fn from_str(name: &str) -> Result<Self, UnknownShapeConstraint> {
        let found = Self::ALL.iter().copied().find(|constraint| constraint.as_str() == name);
        found.ok_or_else(|| UnknownShapeConstraint(name.to_owned()))
    }
}

/// Angles that differ by less, in radians, are equal.
const ROUNDING: f64 = 1e-6;

/// A violated shape constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShapeViolation {
    NotConvex,
    Fold,
    Sliver,
}

/// A shape constraint, with the normals of the input mesh.
pub(crate) struct ShapeCheck {
    constraint: ShapeConstraint,
    /// Unit normals of the vertices of the input mesh. Empty if faces may turn.
    normals: VertexMap<DVec3>,
}

impl ShapeCheck {
    pub(crate) fn new(mesh: &TriMesh, constraint: ShapeConstraint) -> Self {
        let is_limited = constraint != ShapeConstraint::Unrestricted;
        let normals = if is_limited { mesh.vertex_normals() } else { VertexMap::default() };
        Self { constraint, normals }
    }

    fn is_limited(&self) -> bool {
        self.constraint != ShapeConstraint::Unrestricted
    }

    /// The largest turn that is always allowed, if turns are limited.
    pub(crate) fn max_turn(&self) -> Option<f64> {
        self.is_limited().then_some(FRAC_PI_2)
    }

    /// Checks the flip of a quadrilateral.
    pub(crate) fn check(&self, mesh: &TriMesh, quad: &Quad) -> Result<(), ShapeViolation> {
        if self.constraint == ShapeConstraint::Convex && !is_convex(mesh, quad) {
            return Err(ShapeViolation::NotConvex);
        }
        if self.max_turn().is_some_and(|limit| folds(mesh, quad, limit)) {
            return Err(ShapeViolation::Fold);
        }
        self.defects(mesh, quad.flipped_triangles())
            .check_against(|| self.defects(mesh, quad.triangles()))
    }

    /// The defects of some triangles; none without constraint.
    pub(crate) fn defects(
        &self,
        mesh: &TriMesh,
        triangles: impl IntoIterator<Item = [VertexId; 3]>,
    ) -> Defects {
        let reversed = Excess::over(FRAC_PI_2 - ROUNDING);
        let mut found = Defects { reversed, slivers: Excess::over(-SLIVER_HEIGHT) };
        if self.is_limited() {
            for triangle in triangles {
                found.reversed.add(self.turn_from_input(mesh, triangle));
                found.slivers.add(-relative_height(mesh, triangle));
            }
        }
        found
    }

    /// The largest angle between the normal of a triangle and the input normals of its vertices; 0 if
    /// all angles are below a right angle.
    fn turn_from_input(&self, mesh: &TriMesh, triangle: [VertexId; 3]) -> f64 {
        let normal = twice_vector_area(mesh, triangle);
        let input = triangle.map(|v| self.normals[v]);
        let least = ROUNDING * normal.length();
        if input.iter().all(|input| normal.dot(*input) > least) {
            return 0.0;
        }
        let turns = input.iter().filter(|&&input| input != DVec3::ZERO);
        turns.map(|&input| turn_of(normal, input)).fold(0.0, f64::max)
    }
}

/// Reversed faces and slivers among some triangles; see [`ShapeConstraint::KeepShape`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Defects {
    reversed: Excess,
    slivers: Excess,
}

impl Defects {
    /// Whether there are no more defects than in another set, and none is worse.
    pub(crate) fn check_against(self, old: impl FnOnce() -> Self) -> Result<(), ShapeViolation> {
        if self.reversed.count + self.slivers.count == 0 {
            return Ok(());
        }
        let old = old();
        if !self.reversed.is_at_most(old.reversed) {
            return Err(ShapeViolation::Fold);
        }
        if !self.slivers.is_at_most(old.slivers) {
            return Err(ShapeViolation::Sliver);
        }
        Ok(())
    }
}

/// The values above a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Excess {
    count: usize,
    /// The largest value, at least the limit.
    worst: f64,
    limit: f64,
}

impl Excess {
    fn over(limit: f64) -> Self {
        Self { count: 0, worst: limit, limit }
    }

    fn add(&mut self, value: f64) {
        self.count += usize::from(value > self.limit);
        self.worst = self.worst.max(value);
    }

    fn is_at_most(self, other: Self) -> bool {
        self.count <= other.count && self.worst <= other.worst
    }
}

/// The smallest height of a triangle divided by its longest side; 0 if all corners coincide.
fn relative_height(mesh: &TriMesh, triangle: [VertexId; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| mesh.position(v));
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    let ratio = twice_vector_area(mesh, triangle).length() / longest;
    if ratio.is_finite() { ratio } else { 0.0 }
}

/// Whether the quadrilateral is strictly convex, with its two faces unfolded into a plane: the diagonals
/// cross inside it.
///
/// If the four corners are coplanar, which an exact predicate decides, exact predicates in a coordinate
/// plane decide. If not, the angles at both ends of the edge must be below pi.
fn is_convex(mesh: &TriMesh, quad: &Quad) -> bool {
    let corners = quad.corners.map(|v| mesh.position(v));
    if orient3d_of(corners) == 0.0 {
        return is_convex_in_plane(corners, vector_area(mesh, quad));
    }
    let [a, b, c, d] = corners;
    has_angle_below_pi(a, b, c, d) && has_angle_below_pi(b, a, c, d)
}

fn vector_area(mesh: &TriMesh, quad: &Quad) -> DVec3 {
    let [first, second] = quad.triangles().map(|t| twice_vector_area(mesh, t));
    first + second
}

fn orient3d_of(corners: [DVec3; 4]) -> f64 {
    let [a, b, c, d] = corners.map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
    orient3d(a, b, c, d)
}

/// Whether the segment from c to d crosses the line through a and b strictly between them. The corners are
/// projected along the largest coordinate of the normal, which keeps convexity.
fn is_convex_in_plane(corners: [DVec3; 4], normal: DVec3) -> bool {
    let size = normal.abs();
    let project = |p: DVec3| -> DVec2 {
        if size.z >= size.x && size.z >= size.y {
            p.truncate()
        } else if size.x >= size.y {
            DVec2::new(p.y, p.z)
        } else {
            DVec2::new(p.z, p.x)
        }
    };
    let [a, b, c, d] = corners.map(project).map(|p| Coord { x: p.x, y: p.y });
    let (at_a, at_b) = (orient2d(c, d, a), orient2d(c, d, b));
    (at_a > 0.0 && at_b < 0.0) || (at_a < 0.0 && at_b > 0.0)
}

/// Whether the angles of both faces at `end` add up to less than pi: the sine of their sum is positive.
fn has_angle_below_pi(end: DVec3, other: DVec3, c: DVec3, d: DVec3) -> bool {
    let (edge, left, right) = (other - end, c - end, d - end);
    let sine = |side: DVec3| edge.cross(side).length();
    sine(left) * edge.dot(right) + sine(right) * edge.dot(left) > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_across_the_inside_of_a_beam_is_reversed() {
        // Three square outlines along x; the normals of the middle one have no part along x.
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let points: Vec<[i32; 3]> = (0..3).flat_map(|x| corners.map(|[y, z]| [x, y, z])).collect();
        let at = |x: u32, corner: u32| 4 * x + corner % 4;
        let wall = |x: u32, corner: u32| {
            let [a, b] = [at(x, corner), at(x, corner + 1)];
            let [c, d] = [at(x + 1, corner), at(x + 1, corner + 1)];
            [[a, c, b], [b, c, d]]
        };
        let walls = (0..2).flat_map(|x| (0..4).flat_map(move |corner| wall(x, corner)));
        let ends = [[0, 1, 2], [0, 2, 3], [8, 10, 9], [8, 11, 10]];
        let faces: Vec<[u32; 3]> = walls.chain(ends).collect();
        let mesh = TriMesh::from_triangles(&points, &faces).unwrap();
        let check = ShapeCheck::new(&mesh, ShapeConstraint::KeepShape);
        let reversed =
            |triangle: [u32; 3]| check.defects(&mesh, [triangle.map(VertexId::new)]).reversed.count;
        assert!(faces.iter().all(|&face| reversed(face) == 0));
        assert_eq!([reversed([4, 5, 6]), reversed([6, 5, 4])], [1, 1]);
    }
}
