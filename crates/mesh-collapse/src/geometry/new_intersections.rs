//! Tests whether changed faces of a mesh intersect other faces.

use glam::DVec3;
use mesh_core::crossing::Triangle;
use mesh_core::{FaceId, FaceTree, TriMesh, TriangleBounds, VertexId, triangles_cross};

use crate::geometry::part_contacts::Contacts;

/// A face after a change.
pub struct ChangedFace {
    /// The face that changes.
    pub face: FaceId,
    /// Its corners after the change.
    pub triangle: Triangle,
}

/// A search structure for faces, kept up to date while a mesh is edited.
#[derive(Clone, Debug)]
pub struct NewIntersections {
    tree: FaceTree,
    /// The number of faces when the tree was built.
    faces: usize,
    /// The contacts between parts before the first edit.
    contacts: Option<Contacts>,
}

/// The largest number of faces of a vertex whose move is tested; with more faces, the move counts as crossing.
const MOST_FACES: usize = 512;

impl NewIntersections {
    /// Builds the search tree over the faces of a mesh, and records where its components touch.
    pub fn new(mesh: &TriMesh) -> Self {
        let (tree, faces) = (FaceTree::new(mesh), mesh.topology().face_count());
        Self { tree, faces, contacts: Contacts::new(mesh) }
    }

    /// Whether two triangles cross, unless they belong to parts in contact.
    fn cross(&self, first: Triangle, second: Triangle) -> bool {
        let only_touch = |contacts: &Contacts| contacts.only_touch(first, second);
        triangles_cross(first, second) && !self.contacts.as_ref().is_some_and(only_touch)
    }

    /// The end of an edge that represents both ends after they have merged.
    pub fn merged(&self, removed: VertexId, kept: VertexId) -> VertexId {
        let contacts = self.contacts.as_ref();
        contacts.map_or(kept, |contacts| contacts.merged(removed, kept))
    }

    /// Whether an edit makes faces cross that do not cross now. `changed` are the faces with new corners, `gone` the
    /// vanishing ones. Pairs that cross already do not count.
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

    /// Whether a split makes faces cross: the new faces each other, or other faces that none of `gone` crosses.
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

    /// Whether faces start to cross when a vertex moves to `place`.
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

    /// The faces that cross others; the structure must be up to date.
    pub fn crossing(&self, mesh: &TriMesh) -> Vec<FaceId> {
        let topology = mesh.topology();
        let now = |f: FaceId| (topology.face_vertices(f), mesh.triangle(f));
        let crosses = |&face: &FaceId| {
            let this = now(face);
            let meets = |other| other != face && self.cross(this, now(other));
            self.tree.find_crossing(mesh, &TriangleBounds::new(this), meets).is_some()
        };
        topology.faces().filter(crosses).collect()
    }

    /// Updates the structure after a collapse.
    pub fn collapsed(&mut self, mesh: &TriMesh, removed: VertexId, kept: VertexId) {
        if let Some(contacts) = &mut self.contacts {
            contacts.collapsed(removed, kept);
        }
        self.update(mesh, mesh.topology().faces_of_vertex(kept));
    }

    /// Updates the structure after `faces` were edited.
    pub fn update(&mut self, mesh: &TriMesh, faces: impl IntoIterator<Item = FaceId>) {
        if 2 * mesh.topology().face_count() < self.faces {
            (self.tree, self.faces) = (FaceTree::new(mesh), mesh.topology().face_count());
        } else {
            self.tree.update(mesh, faces);
        }
    }
}

/// Up to this number of triangles, a comparison of all pairs is faster than a sweep.
const FEW: usize = 32;

/// Whether any two triangles that may cross have a property; `has` receives the larger index first.
fn any_pair(extents: &[TriangleBounds], mut has: impl FnMut(usize, usize) -> bool) -> bool {
    if extents.len() <= FEW {
        return (0..extents.len()).any(|i| (0..i).any(|j| has(i, j)));
    }
    // A sweep along x: triangles are sorted by their start, measured from the common vertex if there is one. Each can
    // meet only triangles that start before it ends.
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
