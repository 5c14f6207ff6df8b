//! Meshes that deform: the shapes of a mesh in several poses, and a cost that counts its errors in all of them.
//!
//! **Input:** for each pose and vertex, the map that moves the surroundings of the vertex.
//! **Output:** a cost for the run.
//!
//! Invariants:
//!
//! - A pose that moves nothing changes no position.
//! - A vertex that remains after a collapse moves as the surface did at its new place.

use glam::{DAffine3, DMat3, DVec3};
use mesh_collapse::{Collapse, Cost, EdgePatch, Needs, Policy, Quadric, Reach, Scratch};
use mesh_core::{Handle, Remap, RemapOf, TriMesh, UnitScale, VertexId};
use mesh_metric::{closest_on_triangle, weights_of_closest};

/// The shapes of a mesh in several poses. In each pose, an affine map moves the surroundings of each vertex: the mean
/// of the transforms of its joints, weighted as in the skin, after the moves of morph targets. Between vertices the
/// maps are interpolated.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Poses {
    count: usize,
    /// For each vertex, the map of each pose.
    maps: Vec<DAffine3>,
}

impl Poses {
    /// `count` poses of a mesh. `map` moves the surroundings of a vertex to a pose. Numbers that are not finite move
    /// nothing.
    #[must_use]
    pub fn new(mesh: &TriMesh, count: usize, map: impl Fn(VertexId, usize) -> DAffine3) -> Self {
        let vertices = mesh.topology().vertex_capacity();
        let mut maps = vec![DAffine3::IDENTITY; count * vertices];
        for v in mesh.topology().vertices() {
            for pose in 0..count {
                let found = Some(map(v, pose)).filter(DAffine3::is_finite);
                if let (Some(slot), Some(found)) = (maps.get_mut(v.index() * count + pose), found) {
                    *slot = found;
                }
            }
        }
        Self { count, maps }
    }

    /// The number of poses.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The poses of a scaled mesh.
    #[must_use]
    pub fn scaled(&self, scale: UnitScale) -> Self {
        let mut scaled = self.clone();
        for map in &mut scaled.maps {
            map.translation = map.translation.to_array().map(|x| scale.length(x)).into();
        }
        scaled
    }

    fn map(&self, v: VertexId, pose: usize) -> DAffine3 {
        self.maps[v.index() * self.count + pose]
    }

    /// The mean of the maps of three vertices.
    fn blended(&self, vertices: [VertexId; 3], weights: [f64; 3], pose: usize) -> DAffine3 {
        let mut sum = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
        for (v, weight) in vertices.into_iter().zip(weights) {
            let map = self.map(v, pose);
            sum.matrix3 += weight * map.matrix3;
            sum.translation += weight * map.translation;
        }
        sum
    }
}

/// A cost that counts the errors of all poses.
///
/// The cost of a collapse is the largest of its cost as the mesh is, and of the memoryless quadrics of the poses at the
/// place to which each moves the remaining vertex. The quadric that places this vertex is the sum over all poses, with
/// the planes of their faces moved back by the map at the edge.
#[derive(Clone, Debug)]
pub struct Posed<C> {
    cost: C,
    poses: Poses,
}

impl<C: Cost> Posed<C> {
    /// A cost, and the poses in which errors count too.
    #[must_use]
    pub fn new(cost: C, poses: Poses) -> Self {
        Self { cost, poses }
    }

    /// The corners of the faces of a patch in a pose, with the doubled vector areas.
    fn faces<'p>(
        &'p self,
        patch: &'p EdgePatch<'_>,
        pose: usize,
    ) -> impl Iterator<Item = (DVec3, DVec3)> + 'p {
        let topology = patch.mesh().topology();
        let mut known: Option<(VertexId, DVec3)> = None;
        patch.faces().iter().filter_map(move |face| {
            let second = topology.next(face.side);
            let corners = [face.side, second, topology.next(second)].map(|h| topology.origin(h));
            let moved = |v: VertexId, at: DVec3| {
                self.poses.map(v, pose).transform_point3(patch.origin() + at)
            };
            let first = match known {
                Some((v, at)) if v == corners[0] => at,
                _ => moved(corners[0], face.corners[0]),
            };
            known = Some((corners[0], first));
            let [b, c] = [1, 2].map(|k| moved(corners[k], face.corners[k]));
            let cross = (b - first).cross(c - first);
            (cross != DVec3::ZERO && cross.is_finite()).then_some((first, cross))
        })
    }

    /// The three vertices between which a position lies, with their weights.
    fn place(patch: &EdgePatch<'_>, x: DVec3) -> ([VertexId; 3], [f64; 3]) {
        let ends = patch.ends();
        let mut best = ([patch.removed(), patch.kept(), patch.kept()], [0.5, 0.5, 0.0]);
        if ends.contains(&x) {
            best.1 = if x == ends[0] { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
            return best;
        }
        let mut least = f64::INFINITY;
        let topology = patch.mesh().topology();
        for face in patch.faces() {
            let distance = closest_on_triangle(x, &face.corners).length_squared();
            if distance < least {
                least = distance;
                let second = topology.next(face.side);
                let corners = [face.side, second, topology.next(second)];
                let weights = weights_of_closest(x, &face.corners).to_array();
                best = (corners.map(|h| topology.origin(h)), weights);
            }
        }
        best
    }
}

impl<C: Cost> Policy for Posed<C> {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.cost.prepare(mesh);
    }

    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        self.cost.collapsed(mesh, collapse);
    }

    fn compacted(&mut self, mesh: &TriMesh, remap: &Remap) {
        self.cost.compacted(mesh, remap);
        let count = self.poses.count;
        let mut place = 0;
        self.poses.maps.retain(|_| {
            let vertex = VertexId::from_index(place / count);
            place += 1;
            remap.new_handle(vertex).is_some()
        });
    }
}

impl<C: Cost> Cost for Posed<C> {
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        let mut sum = self.cost.quadric(patch)?;
        let ends = [patch.removed(), patch.kept(), patch.kept()];
        for pose in 0..self.poses.count {
            let map = self.poses.blended(ends, [0.5, 0.5, 0.0], pose);
            let middle = map.transform_point3(patch.origin());
            for (corner, cross) in self.faces(patch, pose) {
                let normal = map.matrix3.transpose() * cross;
                let offset = cross.dot(corner - middle);
                sum += Quadric::plane(normal, offset, 0.5 / cross.length());
            }
        }
        Some(sum)
    }

    fn cost(
        &self,
        patch: &EdgePatch<'_>,
        _: Option<&Quadric>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> f64 {
        let quadric = self.cost.quadric(patch);
        let mut largest = self.cost.cost(patch, quadric.as_ref(), x, scratch);
        let (vertices, weights) = Self::place(patch, x);
        for pose in 0..self.poses.count {
            let map = self.poses.blended(vertices, weights, pose);
            let at = map.transform_point3(patch.origin() + x);
            let squares = self.faces(patch, pose).map(|(corner, cross)| {
                let height = cross.dot(at - corner);
                0.5 / cross.length() * height * height
            });
            largest = largest.max(squares.sum());
        }
        largest
    }

    fn needs(&self) -> Needs {
        Needs::Faces
    }

    fn reach(&self) -> Reach {
        self.cost.reach().max(Reach::OneRing)
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        self.cost.collapsing(patch, x, scratch);
        let (vertices, weights) = Self::place(patch, x);
        for pose in 0..self.poses.count {
            let map = self.poses.blended(vertices, weights, pose);
            self.poses.maps[patch.kept().index() * self.poses.count + pose] = map;
        }
    }
}
