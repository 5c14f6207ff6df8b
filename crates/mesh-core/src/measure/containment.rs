//! Which closed components of a mesh contain a point, decided exactly.
//!
//! A ray from the point along a coordinate axis crosses the faces of a component; the signed number of crossings
//! is the winding number of the component about the point. Whether the ray crosses a face is the sign of
//! determinants, computed by adaptive exact arithmetic (Shewchuk 1997). A ray through an edge or a vertex is moved
//! sideways by infinitesimals of two orders (simulation of simplicity; Edelsbrunner, Muecke 1990).

use glam::{DVec2, DVec3};

use crate::measure::any_size::{orient2d, orient3d};
use crate::measure::bounding_box::BoundingBox;
use crate::measure::crossing::segment_meets_triangle;
use crate::measure::face_tree::FaceTree;
use crate::mesh::TriMesh;
use crate::topology::handle::FaceId;

/// Where a point is, relative to a closed component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Location {
    Outside,
    Inside,
    /// On a face.
    On,
}

/// Point location in the components of a mesh.
pub(crate) struct Containment<'m> {
    mesh: &'m TriMesh,
    tree: &'m FaceTree,
    /// The axis of the rays: the shortest one of the mesh, so that rays cross a row of parts instead of following it.
    axis: usize,
}

impl<'m> Containment<'m> {
    pub(crate) fn new(mesh: &'m TriMesh, tree: &'m FaceTree, bounds: BoundingBox) -> Self {
        Self { mesh, tree, axis: bounds.extent().min_position() }
    }

    /// Winding numbers of components about a point, as pairs of component and number. `component` returns the component
    /// of a face, or `None` for faces to ignore.
    pub(crate) fn winding_numbers(
        &self,
        point: DVec3,
        component: impl Fn(FaceId) -> Option<u32>,
    ) -> Vec<(u32, i32)> {
        let mut found: Vec<(u32, i32)> = Vec::new();
        let (u, v) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let may_cross = |b: &BoundingBox| {
            let spans = |axis: usize| b.min[axis] <= point[axis] && point[axis] <= b.max[axis];
            spans(u) && spans(v) && point[self.axis] <= b.max[self.axis]
        };
        self.tree.find_where(self.mesh, may_cross, |face| {
            let Some(component) = component(face) else { return false };
            let crossing = self.crossing(point, face);
            if crossing != 0 {
                match found.iter_mut().find(|(other, _)| *other == component) {
                    Some((_, number)) => *number += crossing,
                    None => found.push((component, crossing)),
                }
            }
            false
        });
        found.retain(|&(_, number)| number != 0);
        found
    }

    /// The components that contain a point or that it touches.
    pub(crate) fn containers(
        &self,
        point: DVec3,
        component: impl Fn(FaceId) -> Option<u32>,
    ) -> Vec<u32> {
        let around = self.winding_numbers(point, &component);
        let mut found: Vec<u32> = around.into_iter().map(|(component, _)| component).collect();
        let here = BoundingBox { min: point, max: point };
        self.tree.find(self.mesh, here, |face| {
            if let Some(component) = component(face).filter(|_| self.is_on(point, face)) {
                found.push(component);
            }
            false
        });
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The location of a point relative to the closed component whose faces satisfy `is_part`.
    pub(crate) fn locate(&self, point: DVec3, is_part: impl Fn(FaceId) -> bool) -> Location {
        let here = BoundingBox { min: point, max: point };
        let touches = |face| is_part(face) && self.is_on(point, face);
        if self.tree.find(self.mesh, here, touches).is_some() {
            return Location::On;
        }
        match self.winding_numbers(point, |face| is_part(face).then_some(0)).is_empty() {
            true => Location::Outside,
            false => Location::Inside,
        }
    }

    fn is_on(&self, point: DVec3, face: FaceId) -> bool {
        let triangle = self.mesh.triangle(face);
        let has_area = (0..3).any(|axis| orient2d(triangle.map(|p| flat(p, axis))) != 0.0);
        has_area && segment_meets_triangle([point; 2], triangle)
    }

    /// 1 if the ray from the point leaves through the front of a face, -1 if it enters through the front, 0 if it
    /// misses the face.
    fn crossing(&self, point: DVec3, face: FaceId) -> i32 {
        let corners = self.mesh.triangle(face);
        let [a, b, c] = corners.map(|p| flat(p, self.axis));
        let at = flat(point, self.axis);
        let turn = side(a, b, at);
        if turn == 0 || side(b, c, at) != turn || side(c, a, at) != turn {
            return 0;
        }
        let [p, q, r] = corners;
        // Positive where the point is behind the face.
        let behind = orient3d([p, q, r, point]);
        let is_ahead = if turn > 0 { behind > 0.0 } else { behind < 0.0 };
        if is_ahead { turn } else { 0 }
    }
}

/// The projection along an axis; it keeps the sense of rotation as seen against the axis.
fn flat(p: DVec3, axis: usize) -> DVec2 {
    DVec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3])
}

/// The side of the line from `a` to `b` on which the point `at`, moved by (e, e^2) for an infinitesimal e, lies: 1
/// left, -1 right, 0 only where `a` equals `b`.
fn side(a: DVec2, b: DVec2, at: DVec2) -> i32 {
    let sign = |x: f64| i32::from(x > 0.0) - i32::from(x < 0.0);
    let exact = sign(orient2d([a, b, at]));
    let compare = |p: f64, q: f64| i32::from(p > q) - i32::from(p < q);
    match (exact, compare(a.y, b.y)) {
        (0, 0) => compare(b.x, a.x),
        (0, by_first) => by_first,
        _ => exact,
    }
}
