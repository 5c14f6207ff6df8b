//! How densely the faces of a mesh should lie, as the distance itself says.
//!
//! Over a surface of Gaussian curvature K a face of area a has the integrated squared distance E ~ |K| a³.
//! So a mesh with about the wanted number of faces tells |K|, as it is at that scale, and with it how many
//! faces each part should have; see [`Power::faces_per_area`].

use glam::DVec3;
use mesh_core::{FaceId, Handle, TriMesh, VertexId, parallel};
use mesh_metric::{Surface, SurfaceError, closest_on_triangle};

use crate::finish::fit::spread::area;
use crate::finish::norm::Power;

/// How many faces there should be per area, up to a factor, and the density that leads to it.
///
/// Vertices that go to the mean of the centroids of their faces, weighted by area and by a density, end up
/// denser where the density is larger; how much denser depends on how the surface bends and how the faces
/// are stretched. So the density starts at what is wanted, and follows what is missing.
pub(crate) struct Density {
    mesh: TriMesh,
    surface: Surface,
    /// For each face of the mesh: what is wanted, and the logarithm of what is added to it.
    wanted: Vec<f64>,
    more: Vec<f64>,
}

/// Points of a face at which it is measured: the centroids of the parts when its sides are cut in three.
pub(crate) const PLACES: usize = 9;

/// These points.
pub(crate) fn places([a, b, c]: [DVec3; 3]) -> [DVec3; PLACES] {
    const NINTHS: [[f64; 3]; PLACES] = [
        [7.0, 1.0, 1.0],
        [1.0, 7.0, 1.0],
        [1.0, 1.0, 7.0],
        [4.0, 4.0, 1.0],
        [4.0, 1.0, 4.0],
        [1.0, 4.0, 4.0],
        [5.0, 2.0, 2.0],
        [2.0, 5.0, 2.0],
        [2.0, 2.0, 5.0],
    ];
    NINTHS.map(|[x, y, z]| (a * x + b * y + c * z) / 9.0)
}

impl Density {
    /// As a mesh tells it that has about the wanted number of faces.
    pub(crate) fn new(
        mesh: &TriMesh,
        original: &Surface,
        power: Power,
    ) -> Result<Self, SurfaceError> {
        let topology = mesh.topology();
        let faces: Vec<FaceId> = topology.faces().collect();
        let measured = parallel::collect(faces.len(), |i| {
            let triangle = mesh.triangle(faces[i]);
            let feet = original.closest_to_neighbours(&places(triangle));
            let squared = |foot: DVec3| closest_on_triangle(foot, &triangle).length_squared();
            let area = area(&triangle);
            let mean = feet.iter().map(|foot| squared(foot.point)).sum::<f64>() / PLACES as f64;
            [mean * area, area * area * area]
        });
        let mut sums = vec![[0.0; 2]; topology.face_capacity()];
        faces.iter().zip(measured).for_each(|(face, sum)| sums[face.index()] = sum);
        // What a few faces have in common does not depend on their shapes so much.
        gather(mesh, &mut sums);
        let wanted = sums.into_iter().map(|[squares, cubes]| power.faces_per_area(squares / cubes));
        let more = vec![0.0; topology.face_capacity()];
        let surface = Surface::new(mesh)?;
        Ok(Self { mesh: mesh.clone(), surface, wanted: wanted.collect(), more })
    }

    /// The faces closest to points that are neighbours among each other.
    pub(crate) fn places(&self, points: &[DVec3]) -> impl Iterator<Item = FaceId> + '_ {
        self.surface.closest_to_neighbours(points).into_iter().map(|closest| closest.face)
    }

    /// How many faces are wanted there.
    pub(crate) fn wanted(&self, place: FaceId) -> f64 {
        self.wanted[place.index()]
    }

    /// The density there.
    pub(crate) fn at(&self, place: FaceId) -> f64 {
        self.wanted[place.index()] * self.more[place.index()].exp()
    }

    /// Raises the density where there are fewer faces than wanted: `found` has places and the logarithms
    /// of the areas of faces there, relative to what is wanted.
    pub(crate) fn follow(&mut self, found: impl Iterator<Item = (FaceId, f64)>) {
        let mut sums = vec![[0.0; 2]; self.more.len()];
        let mut all = [0.0; 2];
        for (place, excess) in found.filter(|(_, excess)| excess.is_finite()) {
            sums[place.index()] = [sums[place.index()][0] + excess, sums[place.index()][1] + 1.0];
            all = [all[0] + excess, all[1] + 1.0];
        }
        gather(&self.mesh, &mut sums);
        let mean = all[0] / all[1];
        for (more, [sum, count]) in self.more.iter_mut().zip(sums).filter(|(_, s)| s[1] > 0.0) {
            *more = (*more + GAIN * (sum / count - mean)).clamp(-MOST, MOST);
        }
    }
}

/// How fast the density follows, and how far.
const GAIN: f64 = 0.1;
const MOST: f64 = 3.0;

/// Gives each face the sums of those round about.
fn gather(mesh: &TriMesh, sums: &mut [[f64; 2]]) {
    let topology = mesh.topology();
    for _ in 0..ROUNDS {
        let of_vertex: Vec<[f64; 2]> = parallel::collect(topology.vertex_capacity(), |index| {
            let v = VertexId::from_index(index);
            let has_faces = topology.contains_vertex(v) && !topology.is_isolated_vertex(v);
            let around = has_faces.then(|| topology.faces_of_vertex(v));
            add(around.into_iter().flatten().map(|face| sums[face.index()]))
        });
        for face in topology.faces() {
            let corners = topology.face_vertices(face);
            sums[face.index()] = add(corners.into_iter().map(|v| of_vertex[v.index()]));
        }
    }
}

/// How far faces go together.
const ROUNDS: usize = 2;

fn add(terms: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    terms.fold([0.0; 2], |[p, q], [r, s]| [p + r, q + s])
}
