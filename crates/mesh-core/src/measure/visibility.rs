//! How much of each side of a component is visible from far outside the mesh.
//!
//! For a sample of points on the component and a fixed set of directions, the half-line from the point along the
//! direction leaves on the front or on the back of the face. Where it meets no other face, that side is visible
//! from the direction. The visible area of a side is the sum over points and directions of the cosine to the
//! normal: the mean area of the side in pictures taken from all directions.

use glam::DVec3;

use crate::measure::bounding_box::BoundingBox;
use crate::measure::face_tree::FaceTree;
use crate::mesh::TriMesh;
use crate::random::SplitMix64;
use crate::topology::handle::FaceId;

/// Directions per half-space; each has its opposite, so that both sides of a plane are seen alike.
pub(crate) const DIRECTIONS: usize = 12;

/// Most faces that a half-line is tested against, on average over a component. It is about ten on usual meshes, and
/// grows with the mesh where boxes overlap, as around a hub of long faces; such a component stays undecided.
const MOST_TESTS: usize = 64;

/// Visible area of both sides, up to a common factor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct VisibleArea {
    pub(crate) front: f64,
    pub(crate) back: f64,
}

/// Visible areas of faces of a mesh.
pub(crate) struct Visibility<'m> {
    mesh: &'m TriMesh,
    tree: &'m FaceTree,
    directions: [DVec3; DIRECTIONS],
    /// Hits nearer than this are on the face itself or its neighbours.
    least: f64,
}

impl<'m> Visibility<'m> {
    pub(crate) fn new(mesh: &'m TriMesh, tree: &'m FaceTree, bounds: BoundingBox) -> Self {
        // Points of a spiral on the half sphere (Saff, Kuijlaars 1997), turned out of the coordinate planes.
        let golden_angle = core::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let directions = core::array::from_fn(|i| {
            let z = (i as f64 + 0.5) / DIRECTIONS as f64;
            let (sin, cos) = (0.7 + golden_angle * i as f64).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            DVec3::new(radius * cos, radius * sin, z)
        });
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let least = 1e-9 * bounds.diagonal() + 1e-15 * largest;
        Self { mesh, tree, directions, least }
    }

    /// The visible area of some faces, from `samples` points spread by area, and the number of tests against faces. Only
    /// faces that `hides` accepts stand in the way.
    pub(crate) fn of_faces(
        &self,
        faces: &[FaceId],
        samples: usize,
        hides: impl Fn(FaceId) -> bool,
    ) -> (VisibleArea, usize) {
        let areas = faces.iter().map(|&f| self.mesh.face_area(f));
        let total: f64 = areas.clone().sum();
        let mut visible = VisibleArea::default();
        if !(total > 0.0 && total.is_finite()) {
            return (visible, 0);
        }
        let mut random = SplitMix64::new(1);
        // A quarter at the start and the rest point by point: a component among far too many faces is left early.
        let most = samples * 2 * DIRECTIONS * MOST_TESTS;
        let (mut tests, mut given) = (most / 4, most / 4);
        let (mut covered, mut next) = (0.0, 0);
        for (&face, area) in faces.iter().zip(areas) {
            covered += area;
            while next < samples && (next as f64 + 0.5) * total <= covered * samples as f64 {
                tests += (most - most / 4) / samples;
                given += (most - most / 4) / samples;
                let point = point_of(self.mesh.triangle(face), &mut random);
                if self.add(face, point, &hides, &mut visible, &mut tests).is_none() {
                    return (VisibleArea::default(), given);
                }
                next += 1;
            }
        }
        (visible, given - tests)
    }

    /// Adds what is visible of a point; `None` if that takes more tests than there are.
    fn add(
        &self,
        face: FaceId,
        point: DVec3,
        hides: &impl Fn(FaceId) -> bool,
        visible: &mut VisibleArea,
        tests: &mut usize,
    ) -> Option<()> {
        let normal = self.mesh.face_normal(face);
        for direction in self.directions.into_iter().flat_map(|d| [d, -d]) {
            let cosine = normal.dot(direction);
            if cosine.abs() > 0.05 && self.escapes(face, point, direction, hides, tests)? {
                let side = if cosine > 0.0 { &mut visible.front } else { &mut visible.back };
                *side += cosine.abs();
            }
        }
        Some(())
    }

    /// Whether the half-line meets no other face; `None` if that takes more tests than there are.
    fn escapes(
        &self,
        from: FaceId,
        point: DVec3,
        direction: DVec3,
        hides: &impl Fn(FaceId) -> bool,
        tests: &mut usize,
    ) -> Option<bool> {
        let inverse = direction.recip();
        let may_hit = |b: &BoundingBox| {
            let (low, high) = ((b.min - point) * inverse, (b.max - point) * inverse);
            let enter = low.min(high).max_element();
            let leave = low.max(high).min_element();
            leave >= 0.0 && enter <= leave + self.least
        };
        let ends = |f: FaceId| {
            *tests = tests.saturating_sub(1);
            let may_end = f != from && hides(f);
            *tests == 0 || may_end && self.is_hit(self.mesh.triangle(f), point, direction)
        };
        let found = self.tree.find_where(self.mesh, may_hit, ends);
        (*tests > 0).then_some(found.is_none())
    }

    /// Whether a half-line meets a triangle (Moeller, Trumbore 1997).
    fn is_hit(&self, [a, b, c]: [DVec3; 3], point: DVec3, direction: DVec3) -> bool {
        let (ab, ac, from_a) = (b - a, c - a, point - a);
        let across = direction.cross(ac);
        let determinant = ab.dot(across);
        let around = from_a.cross(ab);
        let (u, v) = (from_a.dot(across) / determinant, direction.dot(around) / determinant);
        let distance = ac.dot(around) / determinant;
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > self.least
    }
}

/// A random point of a triangle, not close to its sides.
fn point_of([a, b, c]: [DVec3; 3], random: &mut SplitMix64) -> DVec3 {
    let [u, v] = [random.uniform(), random.uniform()];
    let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
    let inner = |share: f64| 0.05 + 0.85 * share;
    a + (b - a) * inner(u) + (c - a) * inner(v)
}
