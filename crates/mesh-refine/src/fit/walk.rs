//! Walks over the mesh to the face under a point.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};
use mesh_metric::{NoFoot, foot_inside};

/// A foot is accepted if its squared distance is at most this factor times twice the area of the face. Farther away, a
/// face of another sheet or component may be the closest one.
const NEAR: f64 = 1e-3;

/// After this many steps, a search in a tree is faster.
const MOST_STEPS: usize = 8;

/// The end of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// A face on which the foot of the point lies inside, and the squared distance.
    Foot(FaceId, f64),
    /// The walk could not leave this face: it met the boundary, came back to the previous face, or took too many steps.
    Face(FaceId),
    /// The face is far from the point, or its normal points the other way, as on the far side of a thin sheet.
    Elsewhere,
}

/// Walks from a face towards a point near the mesh. Each step crosses the side beyond which the foot of the point lies
/// farthest, until the foot is inside. A walk never crosses the boundary or steps back. If the normal of the last face
/// opposes `normal`, the walk has failed.
#[inline]
pub(super) fn walk_to(mesh: &TriMesh, start: FaceId, point: DVec3, normal: DVec3) -> End {
    let topology = mesh.topology();
    let (mut face, mut before) = (start, None);
    for _ in 0..MOST_STEPS {
        let corner = match foot_inside(point, &mesh.triangle(face)) {
            Ok(foot) => {
                let squared = foot.offset.length_squared();
                let is_near = squared <= NEAR * foot.double_area && foot.normal.dot(normal) > 0.0;
                return if is_near { End::Foot(face, squared) } else { End::Elsewhere };
            }
            Err(NoFoot::Far) => return End::Elsewhere,
            Err(NoFoot::Beyond(corner)) => corner,
        };
        let side = topology.face_half_edges(face)[(corner + 1) % 3];
        match topology.face(side.twin()) {
            Some(next) if before != Some(next) => (before, face) = (Some(face), next),
            _ => break,
        }
    }
    End::Face(face)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_metric::Surface;
    use mesh_shapes::{Plane, Sphere};

    /// If a walk ends with a foot, other faces are closer at most by an amount that the curvature of the surface
    /// explains.
    #[test]
    fn walks_end_at_the_closest_faces() {
        let sphere = |cuts| {
            let soup = Sphere { radius: 1.0 }.icosphere(cuts).unwrap();
            TriMesh::from_soup(&soup).unwrap()
        };
        let (mesh, fine) = (sphere(4), sphere(5));
        let surface = Surface::new(&mesh).unwrap();
        let (mut ended, mut asked) = (0, 0);
        for face in fine.topology().faces() {
            let point = fine.triangle(face).iter().sum::<DVec3>() / 3.0;
            let closest = surface.closest(point);
            // The walk starts from a face a few steps away.
            let start = surface.closest(point + DVec3::new(0.03, -0.05, 0.03)).face;
            asked += 1;
            if let End::Foot(_, squared) = walk_to(&mesh, start, point, point) {
                assert!(
                    (squared.sqrt() - closest.distance).abs() < 1e-3 * closest.distance + 1e-12
                );
                ended += 1;
            }
        }
        assert!(20 * ended > 19 * asked, "{ended} of {asked}");
    }

    #[test]
    fn walks_end_at_boundaries_and_on_no_face_that_looks_the_other_way() {
        let soup = Plane { half_width: 1.0 }.mesh(4, Default::default()).unwrap();
        let mesh = TriMesh::from_soup(&soup).unwrap();
        let start = mesh.topology().faces().next().unwrap();
        let to =
            |x: f64, z: f64, normal: DVec3| walk_to(&mesh, start, DVec3::new(x, -0.9, z), normal);
        // The limit of the distance is 0.0158.
        let End::Foot(_, squared) = to(-0.3, 0.015, DVec3::Z) else { panic!("no foot") };
        assert!((squared - 0.015 * 0.015).abs() < 1e-15);
        assert!(matches!(to(-1.2, 0.0, DVec3::Z), End::Face(_)));
        // From below, and at a distance too large for the size of the faces.
        assert_eq!([to(-0.3, 0.015, -DVec3::Z), to(-0.3, 0.016, DVec3::Z)], [End::Elsewhere; 2]);
    }
}
