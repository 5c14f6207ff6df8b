//! Where a triangle can meet others at all, told without exact arithmetic.
//!
//! Triangles far from each other have boxes that do not meet. Round the tip of a cone that says nothing:
//! all boxes meet there. But two triangles with one common vertex cross exactly when that sees
//! both of them in the same direction, and seen from the tip of a cone each of its faces is a short arc.
//! And the box round a face of a cone, which is as wide as the face is long, is passed by most others
//! beside one of its edges.

use core::cell::OnceCell;

use glam::DVec3;

use crate::measure::BoundingBox;
use crate::measure::crossing::Triangle;
use crate::measure::direction_box::DirectionBox;
use crate::topology::handle::VertexId;

/// A triangle and what tells quickly that it does not meet another.
#[derive(Clone, Debug)]
pub struct TriangleBounds {
    /// The triangle.
    pub triangle: Triangle,
    /// The box round it.
    pub bounds: BoundingBox,
    /// As each of its corners sees it, once that was asked for.
    directions: [OnceCell<DirectionBox>; 3],
}

impl TriangleBounds {
    /// That of a triangle.
    #[must_use]
    pub fn new(triangle: Triangle) -> Self {
        let bounds = BoundingBox::of_triangle(triangle.1);
        Self { triangle, bounds, directions: Default::default() }
    }

    /// Whether two triangles may cross, as [`triangles_cross`](crate::triangles_cross) tells exactly.
    /// Vertices of both must be at one place.
    #[must_use]
    pub fn may_cross(&self, other: &Self) -> bool {
        let same = |i: usize| {
            let v = self.triangle.0[i];
            other.triangle.0.iter().position(|&w| w == v).map(|j| [i, j])
        };
        let mut common = (0..3).filter_map(same);
        match [common.next(), common.next()] {
            [Some([i, j]), None] => self.seen_from_corner(i).meet(other.seen_from_corner(j)),
            [None, _] => self.bounds.meets(other.bounds),
            _ => true,
        }
    }

    /// The directions in which a corner sees the triangle; `None` when the vertex is none of its corners.
    pub(crate) fn seen_from(&self, v: VertexId) -> Option<DirectionBox> {
        let corner = self.triangle.0.iter().position(|&corner| corner == v)?;
        Some(self.seen_from_corner(corner))
    }

    fn seen_from_corner(&self, corner: usize) -> DirectionBox {
        *self.directions[corner].get_or_init(|| DirectionBox::from_corner(self.triangle.1, corner))
    }

    /// The interval of coordinates along x that it takes; or, seen from one of its vertices, of directions.
    #[must_use]
    pub fn along_x(&self, from: Option<VertexId>) -> [f64; 2] {
        match from.and_then(|v| self.seen_from(v)) {
            Some(seen) => [seen.low.x, seen.high.x].map(f64::from),
            None => [self.bounds.min.x, self.bounds.max.x],
        }
    }

    /// Whether the triangle may have a point in common with a box.
    pub(crate) fn may_meet(&self, bounds: BoundingBox) -> bool {
        if !self.bounds.meets(bounds) {
            return false;
        }
        // In a large box there is no way past it.
        let is_inside =
            |own: BoundingBox| bounds.min.cmple(own.min).all() && own.max.cmple(bounds.max).all();
        is_inside(self.bounds) || !self.passes_beside(bounds)
    }

    /// Whether a plane through one of the edges, along one of the axes, has the triangle and a box on
    /// different sides: one of the axes of separation of Gottschalk, Lin, Manocha 1996.
    fn passes_beside(&self, bounds: BoundingBox) -> bool {
        let center = 0.5 * bounds.min + 0.5 * bounds.max;
        let half = 0.5 * bounds.max - 0.5 * bounds.min;
        let largest = |b: BoundingBox| b.min.abs().max(b.max.abs()).max_element();
        let rounding = 1e-14 * largest(bounds).max(largest(self.bounds));
        let corners = self.triangle.1.map(|corner| corner - center);
        let [a, b, c] = corners;
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().any(|[p, q, r]| {
            let side = q - p;
            // The normals are those of the side in the planes x = 0, y = 0 and z = 0.
            let [x, y, z] = side.to_array();
            let normals = [DVec3::new(0.0, -z, y), DVec3::new(z, 0.0, -x), DVec3::new(-y, x, 0.0)];
            normals.into_iter().any(|normal| {
                let size = normal.abs();
                let reach = half.dot(size) + rounding * size.element_sum() + f64::MIN_POSITIVE;
                let [on, off] = [normal.dot(p), normal.dot(r)];
                on.min(off) > reach || on.max(off) < -reach
            })
        })
    }
}
