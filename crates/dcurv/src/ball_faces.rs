//! The faces of a surface inside a ball around a vertex, cut exactly at the ball.

use glam::{DVec2, DVec3};
use mesh_core::{FaceId, HalfEdgeId, TriMesh, VertexId};

use crate::atan2::atan2;
use crate::principal::TangentFrame;

/// A face that is at least partly inside a ball.
pub(crate) struct FaceInBall {
    pub(crate) face: FaceId,
    pub(crate) corners: [VertexId; 3],
    /// The corners, relative to the centre and in units of the radius.
    pub(crate) points: [DVec3; 3],
    /// The unit normal; zero for faces without area.
    pub(crate) normal: DVec3,
    /// The area inside, in model units.
    pub(crate) area: f64,
    /// The half-edges that are at least partly inside, each with its ends and the length inside in units of the radius.
    pub(crate) edges: [Option<(HalfEdgeId, [DVec3; 2], f64)>; 3],
}

/// Traverses the faces that are connected to a vertex inside a ball.
pub(crate) struct BallFaces<'a> {
    mesh: &'a TriMesh,
    /// One more than the index of the centre of the ball in which a face was visited last.
    faces: Vec<u32>,
    /// Faces to be visited.
    open: Vec<FaceId>,
}

impl<'a> BallFaces<'a> {
    pub(crate) fn new(mesh: &'a TriMesh) -> Self {
        Self { mesh, faces: vec![0; mesh.topology().face_capacity()], open: Vec::new() }
    }

    /// Makes all faces unvisited, so that a ball around the same vertex can be visited again.
    pub(crate) fn clear(&mut self) {
        self.faces.fill(0);
    }

    pub(crate) fn visit(
        &mut self,
        vertex: VertexId,
        radius: f64,
        visitor: &mut dyn FnMut(&FaceInBall),
    ) {
        let mesh = self.mesh;
        let topology = mesh.topology();
        let mark = vertex.get() + 1;
        let center = mesh.position(vertex);
        // In units of the radius, so that squares do not overflow.
        let place = |v: VertexId| (mesh.position(v) - center) / radius;
        self.open.extend(topology.faces_of_vertex(vertex));
        self.open.iter().for_each(|face| self.faces[face.index()] = mark);
        while let Some(face) = self.open.pop() {
            let corners = topology.face_vertices(face);
            let points = corners.map(place);
            let cross = (points[1] - points[0]).cross(points[2] - points[0]);
            let normal = cross.normalize_or_zero();
            let area = radius * radius * area_in_unit_ball(points, normal);
            let edges = topology.face_half_edges(face).map(|h| {
                let ends = [topology.origin(h), topology.target(h)].map(place);
                let inside = part_in_unit_ball(ends)?;
                if let Some(face) = topology.face(h.twin())
                    && is_new(&mut self.faces, face.index(), mark)
                {
                    self.open.push(face);
                }
                Some((h, ends, inside))
            });
            visitor(&FaceInBall { face, corners, points, normal, area, edges });
        }
    }
}

/// Whether an element is new in this ball. Marks it as visited.
pub(crate) fn is_new(visited: &mut [u32], index: usize, mark: u32) -> bool {
    core::mem::replace(&mut visited[index], mark) != mark
}

/// The length of the part of a segment inside the unit ball; `None` if it is outside.
fn part_in_unit_ball([p, q]: [DVec3; 2]) -> Option<f64> {
    let along = q - p;
    let [low, high] = chord(along.length_squared(), p.dot(along), p.length_squared())?;
    Some((high - low) * along.length())
}

/// The parameters in [0, 1] at which the segment `p + t d`, with `dd = d.d`, `pd = p.d` and `pp = p.p`, enters
/// and leaves the unit ball; `None` if it is outside.
fn chord(dd: f64, pd: f64, pp: f64) -> Option<[f64; 2]> {
    if dd == 0.0 {
        return (pp <= 1.0).then_some([0.0, 1.0]);
    }
    let discriminant = pd * pd - dd * (pp - 1.0);
    let root = (discriminant >= 0.0).then(|| discriminant.sqrt())?;
    let [low, high] = [((-pd - root) / dd).max(0.0), ((root - pd) / dd).min(1.0)];
    (low <= high).then_some([low, high])
}

/// The area of the part of a triangle inside the unit ball: its intersection with a disk in its plane.
fn area_in_unit_ball(triangle: [DVec3; 3], normal: DVec3) -> f64 {
    let Some(plane) = TangentFrame::of(normal) else { return 0.0 };
    let height = normal.dot(triangle[0]);
    let radius_squared = 1.0 - height * height;
    if radius_squared <= 0.0 {
        return 0.0;
    }
    let radius = radius_squared.sqrt();
    let [a, b, c] = triangle.map(|p| DVec2::new(p.dot(plane.x), p.dot(plane.y)) / radius);
    let area = area_in_unit_disk(a, b) + area_in_unit_disk(b, c) + area_in_unit_disk(c, a);
    radius_squared * area.max(0.0)
}

/// The signed area of the triangle (origin, `p`, `q`) inside the unit disk: triangles where the side is inside, sectors
/// elsewhere.
fn area_in_unit_disk(p: DVec2, q: DVec2) -> f64 {
    let sector = |p: DVec2, q: DVec2| 0.5 * atan2(p.perp_dot(q), p.dot(q));
    let along = q - p;
    match chord(along.length_squared(), p.dot(along), p.length_squared()) {
        None => sector(p, q),
        Some([low, high]) => {
            let (enter, leave) = (p + low * along, p + high * along);
            let before = if low > 0.0 { sector(p, enter) } else { 0.0 };
            let after = if high < 1.0 { sector(leave, q) } else { 0.0 };
            before + 0.5 * enter.perp_dot(leave) + after
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::SplitMix64;

    #[test]
    fn areas_of_triangles_in_a_ball_agree_with_sampling() {
        let mut random = SplitMix64::new(8);
        for _ in 0..40 {
            let mut point =
                || 1.5 * DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
            let [a, b, c] = [point(), point(), point()];
            let cross = (b - a).cross(c - a);
            let area = 0.5 * cross.length();
            let count = 400;
            let mut inside = 0;
            for i in 0..count {
                for j in 0..count {
                    let [s, t] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(count));
                    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                    inside += u32::from((a + s * (b - a) + t * (c - a)).length() < 1.0);
                }
            }
            let expected = area * f64::from(inside) / f64::from(count * count);
            let found = area_in_unit_ball([a, b, c], cross.normalize());
            assert!((found - expected).abs() < 6e-3 * area, "{found} {expected}");
        }
    }
}
