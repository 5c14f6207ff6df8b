//! Clipping of triangles by the prism over another triangle.

use glam::DVec3;

/// The points with `normal · x >= offset`.
#[derive(Clone, Copy)]
pub(crate) struct HalfSpace {
    normal: DVec3,
    offset: f64,
}

impl HalfSpace {
    pub(crate) fn flipped(self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }

    /// Signed distance of a point to the boundary, positive inside.
    fn height(self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// The infinite prism over and under a triangle, widened a little.
pub(crate) struct Prism(pub(crate) [HalfSpace; 3]);

impl Prism {
    /// The prism is widened as far as the height of the piece over the triangle allows. `None` if the piece is
    /// too high.
    pub(crate) fn new(triangle: &[DVec3; 3], piece: &[DVec3; 3], bar: f64) -> Option<Self> {
        let [a, b, c] = *triangle;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let heights = piece.map(|p| normal.dot(p - a).abs());
        let height = heights.into_iter().fold(0.0, f64::max);
        if height > bar {
            return None;
        }
        let beside = 0.5 * (bar * bar - height * height).sqrt();
        Some(Self([[a, b], [b, c], [c, a]].map(|[p, q]| {
            let normal = normal.cross(q - p).normalize_or_zero();
            HalfSpace { normal, offset: normal.dot(p) - beside }
        })))
    }
}

/// Capacity for a triangle clipped by three planes. A plane adds at most half as many corners as there were,
/// even if rounding makes it cross the outline more than twice.
const MOST_CORNERS: usize = 9;

/// A convex polygon: a triangle clipped by up to three planes. Entries beyond `count` are unused.
#[derive(Clone, Copy)]
pub(crate) struct Polygon {
    places: [DVec3; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    pub(crate) fn new(&[a, b, c]: &[DVec3; 3]) -> Self {
        let mut places = [c; MOST_CORNERS];
        (places[0], places[1]) = (a, b);
        Self { places, count: 3 }
    }

    pub(crate) fn corners(&self) -> &[DVec3] {
        &self.places[..self.count]
    }

    pub(crate) fn doubled_area(&self) -> f64 {
        let fan = (2..self.count).map(|i| [self.places[0], self.places[i - 1], self.places[i]]);
        fan.map(|triangle| doubled_area(&triangle)).sum()
    }

    /// The part inside a half-space. The parts for a half-space and its flipped one have bit-identical corners
    /// on the outline and cover the polygon.
    pub(crate) fn beyond(&self, plane: HalfSpace) -> Self {
        let mut part = Self { places: self.places, count: 0 };
        let mut push = |at: DVec3| {
            if let Some(place) = part.places.get_mut(part.count) {
                *place = at;
                part.count += 1;
            }
        };
        for (i, &p) in self.corners().iter().enumerate() {
            let q = self.places[(i + 1) % self.count];
            let [from, to] = [p, q].map(|at| plane.height(at));
            // NaN stays on both sides.
            if from >= 0.0 || from.is_nan() {
                push(p);
            }
            if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                push(p + (q - p) * (from / (from - to)));
            }
        }
        part
    }
}

pub(crate) fn doubled_area([a, b, c]: &[DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length()
}
