//! Bounding box, area, volume and edge lengths of meshes; the same totals of polygon soups.

use glam::DVec3;

use crate::attribute::EdgeMap;
use crate::build::Triangulator;
use crate::build::soup::PolygonSoup;
use crate::measure::any_size::power_of_two;
use crate::measure::bounding_box::{BoundingBox, length};
use crate::mesh::TriMesh;
use crate::parallel;
use crate::topology::handle::{EdgeId, FaceId, Handle};

/// Sizes, in model units.
impl TriMesh {
    /// The bounding box of the vertices that belong to a face; `None` when there are none.
    #[must_use]
    pub fn bounding_box(&self) -> Option<BoundingBox> {
        let topology = self.topology();
        let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
        BoundingBox::of_points(used.map(|v| self.position(v)))
    }

    /// The normal of a face, with twice the area as its length.
    #[inline]
    #[must_use]
    pub fn face_cross(&self, face: FaceId) -> DVec3 {
        let [a, b, c] = self.triangle(face);
        (b - a).cross(c - a)
    }

    /// The area of a face.
    #[inline]
    #[must_use]
    pub fn face_area(&self, face: FaceId) -> f64 {
        triangle_area(self.triangle(face))
    }

    /// The total area of the faces.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.sum_over_faces(|f| self.face_area(f))
    }

    /// The enclosed volume, by the divergence theorem; negative when the faces face inward.
    ///
    /// Only a closed mesh encloses a volume. For an open mesh, this is the volume of the cone from the centre
    /// of the bounding box to the surface.
    #[must_use]
    pub fn volume(&self) -> f64 {
        // Positions relative to the centre avoid cancellation far from the origin.
        let Some(center) = self.bounding_box().map(|b| b.center()) else { return 0.0 };
        let tetrahedron = |f: FaceId| {
            let [a, b, c] = self.triangle(f).map(|p| p - center);
            a.dot(b.cross(c)) / 6.0
        };
        self.sum_over_faces(tetrahedron)
    }

    /// The positions of an edge's two vertices, in the direction of its half-edge `2e`.
    #[inline]
    #[must_use]
    pub fn segment(&self, edge: EdgeId) -> [DVec3; 2] {
        let [a, b] = self.topology().edge_vertices(edge);
        [self.position(a), self.position(b)]
    }

    /// The length of an edge.
    #[inline]
    #[must_use]
    pub fn edge_length(&self, edge: EdgeId) -> f64 {
        let [from, to] = self.segment(edge);
        length(to - from)
    }

    /// The lengths of all edges; 0 for removed ones.
    #[must_use]
    pub fn edge_lengths(&self) -> EdgeMap<f64> {
        EdgeMap::from_vec(parallel::collect(self.topology().edge_capacity(), |index| {
            let edge = EdgeId::from_index(index);
            if self.topology().contains_edge(edge) { self.edge_length(edge) } else { 0.0 }
        }))
    }

    /// The mean length of the edges; `None` when there are none.
    #[must_use]
    pub fn mean_edge_length(&self) -> Option<f64> {
        let lengths = self.edge_lengths();
        let sum = parallel::sum(lengths.len(), |index| lengths.as_slice()[index]);
        let edges = self.topology().edge_count();
        (edges > 0).then(|| sum / edges as f64)
    }

    /// The centroid of a face.
    #[inline]
    #[must_use]
    pub fn face_centroid(&self, face: FaceId) -> DVec3 {
        self.triangle(face).into_iter().sum::<DVec3>() / 3.0
    }

    fn sum_over_faces(&self, value: impl Fn(FaceId) -> f64 + Sync) -> f64 {
        parallel::sum(self.topology().face_capacity(), |index| {
            let face = FaceId::from_index(index);
            if self.topology().contains_face(face) { value(face) } else { 0.0 }
        })
    }
}

/// The area of a triangle of any size.
#[inline]
pub(crate) fn triangle_area([a, b, c]: [DVec3; 3]) -> f64 {
    let area = 0.5 * (b - a).cross(c - a).length();
    if area > 1e-140 && area < 1e140 { area } else { far_area(b - a, c - a) }
}

/// Half of the length of a cross product whose square may overflow or vanish.
#[cold]
fn far_area(u: DVec3, v: DVec3) -> f64 {
    let largest = u.abs().max(v.abs()).max_element();
    if largest > 0.0 && largest.is_finite() {
        let factor = power_of_two(largest);
        0.5 * length((u / factor).cross(v / factor)) * factor * factor
    } else {
        0.0
    }
}

/// The sizes of a polygon soup, in model units; made by [`PolygonSoup::measure`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SoupMeasures {
    /// The smallest box around the faces; `None` without faces.
    pub bounds: Option<BoundingBox>,
    /// The total area of the faces, cut into triangles; infinite or NaN if it is larger or smaller than numbers are.
    pub area: f64,
    /// The enclosed volume; meaningful for closed, oriented surfaces only, see [`TriMesh::volume`]. Infinite or NaN as the
    /// area is.
    pub volume: f64,
}

impl SoupMeasures {
    /// The sizes of a soup, from the sizes of that soup with coordinates divided by a factor. NaN for sizes that are too
    /// small for a number.
    #[must_use]
    pub fn restored(self, factor: f64) -> Self {
        let bounds = self.bounds.map(|b| BoundingBox { min: b.min * factor, max: b.max * factor });
        let number = |unit: f64, product: f64| match product == 0.0 && unit != 0.0 {
            true => f64::NAN,
            false => product,
        };
        Self {
            bounds,
            area: number(self.area, self.area * factor * factor),
            volume: number(self.volume, self.volume * factor * factor * factor),
        }
    }
}

impl PolygonSoup {
    /// Measures the faces of the soup, even with defects. Faces with missing vertices or non-finite positions are left
    /// out.
    #[must_use]
    pub fn measure(&self) -> SoupMeasures {
        if let Some((scaled, factor)) = self.at_unit_size() {
            return scaled.measure().restored(factor);
        }
        let place = |&vertex: &u32| {
            self.positions().get(vertex as usize).copied().filter(|p| p.is_finite())
        };
        let corners = |face: usize| self.face(face).iter().map(place).collect::<Option<Vec<_>>>();
        let sound = || (0..self.face_count()).filter_map(|face| corners(face).map(|c| (face, c)));
        let Some(bounds) = BoundingBox::of_points(sound().flat_map(|(_, corners)| corners)) else {
            return SoupMeasures::default();
        };
        let mut measures = SoupMeasures { bounds: Some(bounds), ..SoupMeasures::default() };
        let center = self.middle(bounds);
        let mut triangulator = Triangulator::default();
        let mut triangles = Vec::new();
        for (face, corners) in sound() {
            triangles.clear();
            triangulator.triangulate(&corners, self.face(face), &mut triangles);
            for triangle in &triangles {
                let [a, b, c] = triangle.map(|i| corners[i as usize] - center);
                measures.area += triangle_area([a, b, c]);
                measures.volume += a.dot(b.cross(c)) / 6.0;
            }
        }
        measures
    }

    /// The centre of the bounding box; the origin if a few points far away pull the centre so far that the digits of
    /// the others would be lost against it.
    fn middle(&self, bounds: BoundingBox) -> DVec3 {
        let center = bounds.center();
        let least = center.abs().max_element() / f64::from(40).exp2();
        let is_small = |p: &&DVec3| p.abs().max_element() < least;
        let small = self.positions().iter().filter(is_small).count();
        if 2 * small > self.vertex_count() { DVec3::ZERO } else { center }
    }
}
