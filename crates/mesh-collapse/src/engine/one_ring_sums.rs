//! Sums over the faces around each vertex.
//!
//! The planes of the faces around a vertex all contain the vertex. So about the position of the vertex, the quadric of
//! the faces has only a matrix, and the plane that keeps the volume has only a normal. The sums over the faces around an
//! edge follow from the sums of its two ends, minus the two faces that both ends share. No walk around the ends is
//! needed.

use core::ops::{AddAssign, SubAssign};

use glam::DVec3;
use mesh_core::{TriMesh, VertexId};

use crate::geometry::edge_patch::{EdgePatch, PatchFace, PatchSum};
use crate::geometry::quadric::Quadric;
use crate::geometry::symmetric::Symmetric3;

/// The sums over some faces with a common corner.
#[derive(Clone, Copy, Debug, Default)]
struct FaceSum {
    /// The matrix of the memoryless quadric about that corner.
    matrix: Symmetric3,
    /// The sum of the doubled vector areas.
    cross: DVec3,
    /// The sum of the squares of their lengths.
    squares: f64,
}

impl FaceSum {
    #[inline]
    fn of_face(cross: DVec3) -> Self {
        let squares = cross.length_squared();
        let double_area = squares.sqrt();
        let weight = if double_area > 0.0 { 0.5 / double_area } else { 0.0 };
        Self { matrix: Symmetric3::square(cross, weight), cross, squares }
    }

    /// The area of the faces: the trace of the matrix.
    #[inline]
    fn area(&self) -> f64 {
        self.matrix.diagonal.element_sum()
    }
}

impl AddAssign for FaceSum {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.matrix += other.matrix;
        self.cross += other.cross;
        self.squares += other.squares;
    }
}

impl SubAssign for FaceSum {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        self.matrix += -1.0 * other.matrix;
        self.cross -= other.cross;
        self.squares -= other.squares;
    }
}

/// The sum over the faces around a vertex.
#[derive(Clone, Copy, Debug, Default)]
struct OneRingSum {
    sum: FaceSum,
    /// The largest area since the last summation from the faces.
    largest: f64,
}

impl OneRingSum {
    fn new(sum: FaceSum) -> Self {
        Self { sum, largest: sum.area() }
    }
}

/// If subtraction has reduced the area around a vertex below this part of its maximum, the sum is computed again from
/// the faces, because rounding errors of the large terms have become too large.
const LEAST_PART: f64 = 1e-2;

/// The sums of all vertices, by index.
#[derive(Clone, Debug)]
pub(super) struct OneRingSums(Vec<OneRingSum>);

impl OneRingSums {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let mut sums = vec![OneRingSum::default(); topology.vertex_capacity()];
        for face in topology.faces() {
            let sum = FaceSum::of_face(mesh.face_cross(face));
            for vertex in topology.face_vertices(face) {
                sums[vertex.index()].sum += sum;
            }
        }
        sums.iter_mut().for_each(|star| *star = OneRingSum::new(star.sum));
        Self(sums)
    }

    /// The sums over the faces around both ends of an edge.
    #[inline]
    pub(super) fn of_edge(&self, patch: &EdgePatch<'_>) -> PatchSum {
        let removed = self.0[patch.removed().index()].sum;
        let mut kept = self.0[patch.kept().index()].sum;
        for face in patch.vanishing_faces().into_iter().flatten() {
            kept -= FaceSum::of_face(face.cross);
        }
        let [_, half] = patch.ends();
        let (mut matrix, mut difference) = (removed.matrix, removed.matrix);
        matrix += kept.matrix;
        difference += -1.0 * kept.matrix;
        PatchSum {
            quadric: Quadric {
                matrix,
                linear: difference.times(half),
                constant: half.dot(matrix.times(half)),
            },
            cross: removed.cross + kept.cross,
            offset: (kept.cross - removed.cross).dot(half),
            squares: removed.squares + kept.squares,
        }
    }

    /// Updates the sums for a collapse to `x`, relative to the midpoint of the edge, that is about to be carried out.
    /// The patch must have its faces.
    pub(super) fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3) {
        let topology = patch.mesh().topology();
        let target = |face: &PatchFace| topology.target(topology.next(face.side)).index();
        let mut merged = FaceSum::default();
        for face in patch.remaining_faces() {
            let (old, new) = (FaceSum::of_face(face.cross), FaceSum::of_face(face.cross_with(x)));
            for v in [topology.target(face.side).index(), target(face)] {
                self.0[v].sum -= old;
                self.0[v].sum += new;
            }
            merged += new;
        }
        for face in patch.vanishing_faces().into_iter().flatten() {
            self.0[target(&face)].sum -= FaceSum::of_face(face.cross);
        }
        self.0[patch.kept().index()] = OneRingSum::new(merged);
    }

    /// Computes the sums of neighbours of the remaining vertex again where needed, after a collapse.
    pub(super) fn collapsed(&mut self, mesh: &TriMesh, kept: VertexId) {
        let topology = mesh.topology();
        for v in topology.one_ring(kept) {
            let star = &mut self.0[v.index()];
            let area = star.sum.area();
            star.largest = star.largest.max(area);
            if area < LEAST_PART * star.largest {
                let mut sum = FaceSum::default();
                for face in topology.faces_of_vertex(v) {
                    sum += FaceSum::of_face(mesh.face_cross(face));
                }
                *star = OneRingSum::new(sum);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::edge_patch::Place;
    use mesh_shapes::{Irregular, Plane, Sphere};

    /// In the interior and at the boundary, before and after each of many collapses.
    #[test]
    fn sums_of_edges_are_those_over_the_faces_of_their_patches() {
        let sphere =
            Sphere { radius: 1.0 }.irregular_icosphere(2, Irregular { jitter: 0.2, seed: 3 });
        let plane = Plane { half_width: 1.0 }.mesh(6, Default::default());
        for soup in [sphere.unwrap(), plane.unwrap()] {
            let mut mesh = TriMesh::from_soup(&soup).unwrap();
            for (i, p) in mesh.positions_mut().iter_mut().enumerate() {
                p.z += 0.05 * (i as f64).sin();
            }
            let mut sums = OneRingSums::new(&mesh);
            let mut collapses = 0;
            while mesh.topology().face_count() > 20 {
                let mut faces = Vec::new();
                for edge in mesh.topology().edges() {
                    let patch = EdgePatch::gather(&mesh, edge.half_edge(), &mut faces);
                    let with_sum = patch.with_sum(sums.of_edge(&patch));
                    let (sum, expected) = (with_sum.face_quadric(), patch.face_quadric());
                    for x in [DVec3::ZERO, DVec3::new(0.1, -0.2, 0.3)] {
                        assert!((sum.value(x) - expected.value(x)).abs() < 1e-13, "{edge:?}");
                    }
                    let planes =
                        [with_sum.volume_plane(), patch.volume_plane()].map(Option::unwrap);
                    let [(normal, offset), (expected, at)] = planes;
                    assert!(normal.distance(expected) < 1e-13 && (offset - at).abs() < 1e-13);
                }
                let legal = {
                    let mut sides = mesh.topology().half_edges().skip(7 * collapses % 41);
                    sides.find_map(|h| mesh.topology().check_collapse(h).ok())
                };
                let Some(legal) = legal else { break };
                let patch = EdgePatch::gather(&mesh, legal.half_edge(), &mut faces);
                let x = DVec3::new(0.01, 0.02, -0.01);
                let (kept, place) = (patch.kept(), patch.position(Place::At(x)));
                sums.collapsing(&patch, x);
                mesh.collapse(legal, place);
                sums.collapsed(&mesh, kept);
                collapses += 1;
            }
            assert!(collapses > 20, "{collapses}");
        }
    }

    /// After a vertex has lost a face a million times as large as the rest, its sum is as precise as the sum over the
    /// rest.
    #[test]
    fn small_faces_are_added_up_anew_once_large_ones_are_gone() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0], [-1.0, 0.4, 0.1]];
        let far = [[-1e3, -1e3, 10.0], [1e3, -1e3, 0.0]];
        let points: Vec<[f64; 3]> = points.into_iter().chain(far).collect();
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1]];
        let mut mesh = TriMesh::from_triangles(&points, &faces).unwrap();
        let mut sums = OneRingSums::new(&mesh);
        let find = |mesh: &TriMesh, ends: [u32; 2]| {
            let [a, b] = ends.map(VertexId::new);
            let mut sides = mesh.topology().half_edges();
            sides.find(|&h| mesh.topology().origin(h) == a && mesh.topology().target(h) == b)
        };
        let mut faces = Vec::new();
        for ends in [[4, 3], [5, 1]] {
            let h = find(&mesh, ends).unwrap();
            let legal = mesh.topology().check_collapse(h).unwrap();
            let patch = EdgePatch::gather(&mesh, h, &mut faces);
            let (kept, place) = (patch.kept(), patch.position(Place::Kept));
            sums.collapsing(&patch, patch.offset(Place::Kept));
            mesh.collapse(legal, place);
            sums.collapsed(&mesh, kept);
        }
        let expected = OneRingSums::new(&mesh);
        let (found, expected) = (sums.0[0].sum, expected.0[0].sum);
        assert!((found.area() - expected.area()).abs() < 1e-15, "{found:?} {expected:?}");
        assert!(found.cross.distance(expected.cross) < 1e-15);
    }
}
