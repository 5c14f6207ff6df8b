//! Exact intersection tests of triangles.
//!
//! All decisions are signs of determinants, computed by adaptive exact arithmetic (Shewchuk 1997). There is no
//! tolerance.

use glam::{DVec2, DVec3};

use crate::measure::any_size::{orient2d, orient3d};
use crate::measure::bounding_box::BoundingBox;
use crate::topology::handle::VertexId;

/// A triangle of a mesh: its vertices and their positions.
pub type Triangle = ([VertexId; 3], [DVec3; 3]);

/// Whether two triangles have a common point outside their common vertex or edge.
///
/// Triangles that touch do cross. Two triangles with a common edge cross when they lie in one plane on the same
/// side of it; two with the same three vertices always do. A triangle without area crosses nothing: its points
/// belong to its edges, which its neighbours share.
#[must_use]
pub fn triangles_cross(first: Triangle, second: Triangle) -> bool {
    let shared = |v: &VertexId| second.0.contains(v);
    let common = first.0.iter().filter(|v| shared(v)).count();
    let may_cross = match common {
        0 => !are_apart(first.1, second.1),
        1 => opposite_sides_may_meet(first, second),
        _ => true,
    };
    if !may_cross || is_degenerate(first.1) || is_degenerate(second.1) {
        return false;
    }
    match common {
        0 => {
            sides(first.1).any(|side| side_meets(side, second.1))
                || sides(second.1).any(|side| side_meets(side, first.1))
        }
        1 => {
            side_meets(opposite_side(first, second), second.1)
                || side_meets(opposite_side(second, first), first.1)
        }
        2 => cross_at_edge(first, second),
        _ => true,
    }
}

/// Whether the box or the plane of a triangle with area certainly separates it from another one. Rules out most pairs
/// in a strip of long thin triangles, whose boxes overlap.
fn are_apart(first: [DVec3; 3], second: [DVec3; 3]) -> bool {
    let meet = BoundingBox::of_triangle(first).meets(BoundingBox::of_triangle(second));
    let is_beside = |[a, b, c]: [DVec3; 3], [p, q, r]: [DVec3; 3]| {
        let above = orientation(a, b, c, p);
        let is_same = |point| match above > 0.0 {
            true => orientation(a, b, c, point) > 0.0,
            false => orientation(a, b, c, point) < 0.0,
        };
        above != 0.0 && is_same(q) && is_same(r)
    };
    !meet || is_beside(first, second) || is_beside(second, first)
}

/// The side opposite to the only common vertex. Any other common points of the triangles reach this side of one of them.
fn opposite_side(of: Triangle, other: Triangle) -> [DVec3; 2] {
    let common = (0..3).find(|&i| other.0.contains(&of.0[i])).unwrap_or(0);
    [of.1[(common + 1) % 3], of.1[(common + 2) % 3]]
}

/// Rules out most pairs in a fan.
fn opposite_sides_may_meet(first: Triangle, second: Triangle) -> bool {
    boxes_meet(opposite_side(first, second), second.1)
        || boxes_meet(opposite_side(second, first), first.1)
}

/// Whether the boxes of a segment and a triangle meet.
fn boxes_meet([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let below = p.min(q).cmple(a.max(b).max(c));
    let above = p.max(q).cmpge(a.min(b).min(c));
    (below & above).all()
}

/// As [`segment_meets_triangle`], with boxes first: most triangles in one plane have no common point.
fn side_meets(side: [DVec3; 2], triangle: [DVec3; 3]) -> bool {
    boxes_meet(side, triangle) && segment_meets_triangle(side, triangle)
}

fn cross_at_edge(first: Triangle, second: Triangle) -> bool {
    let apex =
        |of: Triangle, other: Triangle| (0..3).find(|&i| !other.0.contains(&of.0[i])).unwrap_or(0);
    let i = apex(first, second);
    let (a, s, t) = (first.1[i], first.1[(i + 1) % 3], first.1[(i + 2) % 3]);
    let b = second.1[apex(second, first)];
    if orientation(s, t, a, b) != 0.0 {
        return false;
    }
    let plane = Projection::of([s, t, a]);
    plane.orientation(s, t, a).signum() == plane.orientation(s, t, b).signum()
        && plane.orientation(s, t, b) != 0.0
}

fn sides([a, b, c]: [DVec3; 3]) -> impl Iterator<Item = [DVec3; 2]> {
    [[a, b], [b, c], [c, a]].into_iter()
}

/// Whether a segment and a triangle with area have a point in common.
#[must_use]
pub fn segment_meets_triangle([p, q]: [DVec3; 2], triangle: [DVec3; 3]) -> bool {
    let [a, b, c] = triangle;
    let (above_p, above_q) = (orientation(a, b, c, p), orientation(a, b, c, q));
    if above_p == 0.0 && above_q == 0.0 {
        return segment_meets_triangle_in_plane([p, q], triangle);
    }
    if (above_p > 0.0 && above_q > 0.0) || (above_p < 0.0 && above_q < 0.0) {
        return false;
    }
    // The line meets the plane in one point. It is inside if it passes all sides in the same sense.
    let passes = [orientation(p, q, a, b), orientation(p, q, b, c), orientation(p, q, c, a)];
    passes.iter().all(|&o| o >= 0.0) || passes.iter().all(|&o| o <= 0.0)
}

fn segment_meets_triangle_in_plane(segment: [DVec3; 2], triangle: [DVec3; 3]) -> bool {
    let plane = Projection::of(triangle);
    plane.contains(triangle, segment[0])
        || plane.contains(triangle, segment[1])
        || sides(triangle).any(|side| plane.segments_meet(segment, side))
}

fn is_degenerate([a, b, c]: [DVec3; 3]) -> bool {
    Projection::ALL.iter().all(|plane| plane.orientation(a, b, c) == 0.0)
}

fn orientation(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    // In a plane parallel to a coordinate plane, adaptive arithmetic would go through all stages to find zero.
    if (a.cmpeq(b) & b.cmpeq(c) & c.cmpeq(d)).any() {
        return 0.0;
    }
    orient3d([a, b, c, d])
}

/// A projection along a coordinate axis.
#[derive(Clone, Copy)]
enum Projection {
    AlongX,
    AlongY,
    AlongZ,
}

impl Projection {
    const ALL: [Self; 3] = [Self::AlongX, Self::AlongY, Self::AlongZ];

    /// A projection that keeps the triangle's area positive.
    fn of([a, b, c]: [DVec3; 3]) -> Self {
        let good = Self::ALL.into_iter().find(|plane| plane.orientation(a, b, c) != 0.0);
        good.unwrap_or(Self::AlongZ)
    }

    fn point(self, p: DVec3) -> DVec2 {
        match self {
            Self::AlongX => DVec2::new(p.y, p.z),
            Self::AlongY => DVec2::new(p.z, p.x),
            Self::AlongZ => DVec2::new(p.x, p.y),
        }
    }

    fn orientation(self, a: DVec3, b: DVec3, c: DVec3) -> f64 {
        orient2d([a, b, c].map(|p| self.point(p)))
    }

    fn contains(self, [a, b, c]: [DVec3; 3], p: DVec3) -> bool {
        let turns =
            [self.orientation(a, b, p), self.orientation(b, c, p), self.orientation(c, a, p)];
        turns.iter().all(|&o| o >= 0.0) || turns.iter().all(|&o| o <= 0.0)
    }

    fn segments_meet(self, [p, q]: [DVec3; 2], [r, s]: [DVec3; 2]) -> bool {
        let (r_side, s_side) = (self.orientation(p, q, r), self.orientation(p, q, s));
        let (p_side, q_side) = (self.orientation(r, s, p), self.orientation(r, s, q));
        let apart = |u: f64, v: f64| (u > 0.0 && v > 0.0) || (u < 0.0 && v < 0.0);
        if apart(r_side, s_side) || apart(p_side, q_side) {
            return false;
        }
        if r_side == 0.0 && s_side == 0.0 && p_side == 0.0 && q_side == 0.0 {
            return self.ranges_meet([p, q], [r, s]);
        }
        true
    }

    /// For segments on one line.
    fn ranges_meet(self, [p, q]: [DVec3; 2], [r, s]: [DVec3; 2]) -> bool {
        let [p, q, r, s] = [p, q, r, s].map(|point| self.point(point));
        let meet = |p: f64, q: f64, r: f64, s: f64| p.min(q) <= r.max(s) && r.min(s) <= p.max(q);
        meet(p.x, q.x, r.x, s.x) && meet(p.y, q.y, r.y, s.y)
    }
}
