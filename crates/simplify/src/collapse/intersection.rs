//! Faces of a mesh that change, and whether they run into others.

use glam::DVec3;
use mesh_core::crossing::Triangle;
use mesh_core::{BoundingBox, FaceId, FaceTree, TriMesh, VertexId, triangles_cross};

/// A face as it would be.
pub(crate) struct ChangedFace {
    pub(crate) face: FaceId,
    pub(crate) triangle: Triangle,
}

/// What finds the faces near a place while a mesh is edited.
#[derive(Clone, Debug)]
pub(crate) struct Intersections {
    tree: FaceTree,
    /// How many faces there were when the tree was made.
    faces: usize,
}

impl Intersections {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        Self { tree: FaceTree::new(mesh), faces: mesh.topology().face_count() }
    }

    /// Whether an edit makes faces cross that do not cross now: `changed` are the faces that get
    /// other corners, `gone` those that vanish. Pairs that cross already do not count.
    pub(crate) fn would_arise(
        &self,
        mesh: &TriMesh,
        changed: &[ChangedFace],
        gone: &[FaceId],
    ) -> bool {
        let topology = mesh.topology();
        let now = |f: FaceId| (topology.face_vertices(f), mesh.triangle(f));
        let is_new = |new: &ChangedFace, other: FaceId, triangle: Triangle| {
            triangles_cross(new.triangle, triangle) && !triangles_cross(now(new.face), now(other))
        };
        let among_changed = changed.iter().enumerate().any(|(i, first)| {
            changed[..i].iter().any(|second| is_new(first, second.face, second.triangle))
        });
        among_changed
            || changed.iter().any(|new| {
                let bounds = BoundingBox::of_triangle(new.triangle.1);
                let crossed = self.tree.find(mesh, bounds, |f| {
                    let stays = !gone.contains(&f) && changed.iter().all(|c| c.face != f);
                    stays && is_new(new, f, now(f))
                });
                crossed.is_some()
            })
    }

    /// Whether faces come to cross when a vertex goes to `place`.
    pub(crate) fn would_arise_at(&self, mesh: &TriMesh, vertex: VertexId, place: DVec3) -> bool {
        let topology = mesh.topology();
        let changed: Vec<ChangedFace> = topology
            .faces_of_vertex(vertex)
            .map(|face| {
                let vertices = topology.face_vertices(face);
                let at = |v| if v == vertex { place } else { mesh.position(v) };
                ChangedFace { face, triangle: (vertices, vertices.map(at)) }
            })
            .collect();
        self.would_arise(mesh, &changed, &[])
    }

    /// Follows an edit of these faces.
    pub(crate) fn update(&mut self, mesh: &TriMesh, faces: impl IntoIterator<Item = FaceId>) {
        if 2 * mesh.topology().face_count() < self.faces {
            *self = Self::new(mesh);
        } else {
            self.tree.update(mesh, faces);
        }
    }
}
