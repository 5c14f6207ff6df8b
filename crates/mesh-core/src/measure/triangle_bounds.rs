//! Conservative bounds of a triangle that rule out most intersections without exact arithmetic.
//!
//! Bounding boxes separate triangles that are far apart. At the apex of a cone all boxes overlap. There, two
//! triangles with one common vertex cross if and only if there is a direction from that vertex towards both;
//! the directions to a face of a cone are a short arc, bounded by a `DirectionBox`. For other triangles near
//! a cone, a plane along an edge of a face separates most of them from its box.

use core::cell::OnceCell;

use glam::DVec3;

use crate::measure::BoundingBox;
use crate::measure::crossing::Triangle;
use crate::measure::direction_box::DirectionBox;
use crate::topology::handle::VertexId;

/// A triangle with its bounding box and its direction boxes.
#[derive(Clone, Debug)]
pub struct TriangleBounds {
    /// The triangle.
    pub triangle: Triangle,
    /// Its bounding box.
    pub bounds: BoundingBox,
    /// Directions from each corner, computed on demand.
    directions: [OnceCell<DirectionBox>; 3],
}

impl TriangleBounds {
    /// The bounds of a triangle.
    #[must_use]
    pub fn new(triangle: Triangle) -> Self {
        let bounds = BoundingBox::of_triangle(triangle.1);
        Self { triangle, bounds, directions: Default::default() }
    }

    /// Whether two triangles may cross; `false` is certain, [`triangles_cross`](crate::triangles_cross) decides
    /// exactly. A common vertex must have the same position in both.
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

    /// The directions from a corner to the triangle; `None` if the vertex is no corner.
    pub(crate) fn seen_from(&self, v: VertexId) -> Option<DirectionBox> {
        let corner = self.triangle.0.iter().position(|&corner| corner == v)?;
        Some(self.seen_from_corner(corner))
    }

    fn seen_from_corner(&self, corner: usize) -> DirectionBox {
        *self.directions[corner].get_or_init(|| DirectionBox::from_corner(self.triangle.1, corner))
    }

    /// The interval of its x coordinates; or, with a corner of the triangle, of the x coordinates of directions
    /// from it.
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
        // A box that contains the triangle's box cannot be beside it.
        let is_inside =
            |own: BoundingBox| bounds.min.cmple(own.min).all() && own.max.cmple(bounds.max).all();
        is_inside(self.bounds) || !self.passes_beside(bounds)
    }

    /// Whether a plane through an edge and parallel to an axis separates the triangle from a box: one of the
    /// separating axes of Gottschalk, Lin, Manocha 1996.
    fn passes_beside(&self, bounds: BoundingBox) -> bool {
        let center = 0.5 * bounds.min + 0.5 * bounds.max;
        let half = 0.5 * bounds.max - 0.5 * bounds.min;
        let largest = |b: BoundingBox| b.min.abs().max(b.max.abs()).max_element();
        let rounding = 1e-14 * largest(bounds).max(largest(self.bounds));
        let corners = self.triangle.1.map(|corner| corner - center);
        let [a, b, c] = corners;
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().any(|[p, q, r]| {
            let side = q - p;
            // Normals of the side's projections onto the planes x = 0, y = 0 and z = 0.
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
