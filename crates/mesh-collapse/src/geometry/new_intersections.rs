//! Faces of a mesh that change, and whether they run into others.

use glam::DVec3;
use mesh_core::crossing::Triangle;
use mesh_core::{FaceId, FaceTree, TriMesh, TriangleBounds, VertexId, triangles_cross};

use crate::geometry::contact::Contacts;

/// A face as it would be.
pub struct ChangedFace {
    /// The face that changes.
    pub face: FaceId,
    /// Its corners after the change.
    pub triangle: Triangle,
}

/// What finds the faces near a place while a mesh is edited.
#[derive(Clone, Debug)]
pub struct NewIntersections {
    tree: FaceTree,
    /// How many faces there were when the tree was made.
    faces: usize,
    /// Where parts touched before the first edit.
    contacts: Option<Contacts>,
}

/// The most faces of a vertex whose move is looked at; with more it counts as one that crosses.
const MOST_FACES: usize = 512;

impl NewIntersections {
    /// Builds the search tree over the faces of a mesh, and records where its components touch.
    pub fn new(mesh: &TriMesh) -> Self {
        let (tree, faces) = (FaceTree::new(mesh), mesh.topology().face_count());
        Self { tree, faces, contacts: Contacts::new(mesh) }
    }

    /// Whether two triangles cross, parts that go on touching left out.
    fn cross(&self, first: Triangle, second: Triangle) -> bool {
        let only_touch = |contacts: &Contacts| contacts.only_touch(first, second);
        triangles_cross(first, second) && !self.contacts.as_ref().is_some_and(only_touch)
    }

    /// The end of an edge that stands for both once they are one vertex.
    pub fn merged(&self, removed: VertexId, kept: VertexId) -> VertexId {
        let contacts = self.contacts.as_ref();
        contacts.map_or(kept, |contacts| contacts.merged(removed, kept))
    }

    /// Whether an edit makes faces cross that do not cross now: `changed` are the faces that get
    /// other corners, `gone` those that vanish. Pairs that cross already do not count.
    pub fn would_arise(&self, mesh: &TriMesh, changed: &[ChangedFace], gone: &[FaceId]) -> bool {
        let topology = mesh.topology();
        let now = |f: FaceId| (topology.face_vertices(f), mesh.triangle(f));
        let is_new = |face: FaceId, new: Triangle, other: FaceId, triangle: Triangle| {
            self.cross(new, triangle) && !self.cross(now(face), now(other))
        };
        let extents: Vec<TriangleBounds> =
            changed.iter().map(|new| TriangleBounds::new(new.triangle)).collect();
        let among_changed = any_pair(&extents, |i, j| {
            let [first, second] = [i, j].map(|k| &changed[k]);
            is_new(first.face, first.triangle, second.face, second.triangle)
        });
        if among_changed {
            return true;
        }
        let mut edited: Vec<FaceId> =
            changed.iter().map(|new| new.face).chain(gone.iter().copied()).collect();
        edited.sort_unstable();
        changed.iter().zip(&extents).any(|(new, extent)| {
            let crossed = self.tree.find_crossing(mesh, extent, |f| {
                edited.binary_search(&f).is_err() && is_new(new.face, new.triangle, f, now(f))
            });
            crossed.is_some()
        })
    }

    /// Whether a split makes faces cross: those that take the place of `gone` each other, or others
    /// that none of these crosses.
    pub fn would_arise_instead(&self, mesh: &TriMesh, gone: &[FaceId], new: &[Triangle]) -> bool {
        let topology = mesh.topology();
        let now = |f: FaceId| (topology.face_vertices(f), mesh.triangle(f));
        let among_new = new
            .iter()
            .enumerate()
            .any(|(i, first)| new[..i].iter().any(|second| triangles_cross(*first, *second)));
        among_new
            || new.iter().any(|&triangle| {
                let crossed = self.tree.find_crossing(mesh, &TriangleBounds::new(triangle), |f| {
                    !gone.contains(&f)
                        && self.cross(triangle, now(f))
                        && !gone.iter().any(|&before| self.cross(now(before), now(f)))
                });
                crossed.is_some()
            })
    }

    /// Whether faces come to cross when a vertex goes to `place`.
    pub fn would_arise_at(&self, mesh: &TriMesh, vertex: VertexId, place: DVec3) -> bool {
        let topology = mesh.topology();
        if topology.faces_of_vertex(vertex).nth(MOST_FACES).is_some() {
            return true;
        }
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

    /// Follows a collapse.
    pub fn collapsed(&mut self, mesh: &TriMesh, removed: VertexId, kept: VertexId) {
        if let Some(contacts) = &mut self.contacts {
            contacts.collapsed(removed, kept);
        }
        self.update(mesh, mesh.topology().faces_of_vertex(kept));
    }

    /// Follows an edit of these faces.
    pub fn update(&mut self, mesh: &TriMesh, faces: impl IntoIterator<Item = FaceId>) {
        if 2 * mesh.topology().face_count() < self.faces {
            (self.tree, self.faces) = (FaceTree::new(mesh), mesh.topology().face_count());
        } else {
            self.tree.update(mesh, faces);
        }
    }
}

/// To compare so many triangles with each other takes less than to look who may cross.
const FEW: usize = 32;

/// Whether any two triangles that may cross have a property, which is asked for with the larger index
/// first.
fn any_pair(extents: &[TriangleBounds], mut has: impl FnMut(usize, usize) -> bool) -> bool {
    if extents.len() <= FEW {
        return (0..extents.len()).any(|i| (0..i).any(|j| has(i, j)));
    }
    // In the order of where they begin, seen from the vertex that all have in common if there is
    // one, each can meet only those that begin before it ends.
    let hub = extents.first().and_then(|first| {
        first.triangle.0.into_iter().find(|v| extents.iter().all(|e| e.triangle.0.contains(v)))
    });
    let mut order: Vec<([f64; 2], usize)> =
        extents.iter().enumerate().map(|(i, extent)| (extent.along_x(hub), i)).collect();
    order.sort_unstable_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]));
    order.iter().enumerate().any(|(place, &([_, end], i))| {
        let others = order[place + 1..].iter().take_while(|([start, _], _)| *start <= end);
        others
            .map(|&(_, j)| j)
            .any(|j| extents[i].may_cross(&extents[j]) && has(i.max(j), i.min(j)))
    })
}
