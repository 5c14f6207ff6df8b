//! How densely the faces of a mesh should lie, and in what shape.
//!
//! Over a surface with the second fundamental form H, of Gaussian curvature K = det H, a face of area a
//! has the integrated squared distance E ~ |K| a³ at best: it reaches that where it is equilateral in the
//! metric |H|, which has the absolute values of the principal curvatures. Where K > 0 no other shape does.
//! Where K < 0 a face needs no more than the sum of e·He over its sides e to vanish, and straight lines on
//! the surface let it become as thin as one likes; among all these shapes |H| chooses round ones.
//!
//! A mesh with about the wanted number of faces tells H, as it is at that scale, and by E / a³ how many
//! faces each part should have; see [`Power::faces_per_area`]. From there the distance itself leads on.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use mesh_core::{FaceId, Handle, TriMesh, VertexId, parallel};
use mesh_metric::{Surface, SurfaceError, closest_on_triangle};

use crate::fit::spread::area;
use crate::norm::Power;

/// The density that leads to as many faces per area as there should be, and the metric of their shapes.
///
/// Vertices that go to the mean of the centroids of their faces, weighted by area and by a density, end up
/// denser where the density is larger; how much denser depends on how the surface bends and how the faces
/// are stretched. So the density starts at the wanted number of faces per area, and follows the distance.
#[derive(Clone)]
pub(crate) struct Density {
    told: Arc<Told>,
    /// For each face of the mesh that told it: the logarithm of what the wanted density is multiplied by.
    more: Vec<f64>,
}

/// What a mesh tells, the same however the density goes on from there.
struct Told {
    power: Power,
    mesh: TriMesh,
    surface: Surface,
    /// For each face of the mesh: the density that is wanted at first, and the metric.
    wanted: Vec<f64>,
    metrics: Vec<DMat3>,
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
            let metric = metric(second_form(triangle, feet.iter().map(|foot| foot.point)));
            ([mean * area, area * area * area], metric)
        });
        let mut sums = vec![[0.0; 2]; topology.face_capacity()];
        let mut metrics = vec![DMat3::ZERO; topology.face_capacity()];
        for (face, (sum, metric)) in faces.iter().zip(measured) {
            (sums[face.index()], metrics[face.index()]) = (sum, metric);
        }
        // What a few faces have in common does not depend on their shapes so much.
        gather(mesh, &mut sums);
        let wanted = sums.into_iter().map(|[squares, cubes]| power.faces_per_area(squares / cubes));
        let more = vec![0.0; topology.face_capacity()];
        let (wanted, surface) = (wanted.collect(), Surface::new(mesh)?);
        let told = Arc::new(Told { power, mesh: mesh.clone(), surface, wanted, metrics });
        Ok(Self { told, more })
    }

    /// The faces closest to points that are neighbours among each other.
    pub(crate) fn places(&self, points: &[DVec3]) -> impl Iterator<Item = FaceId> + '_ {
        self.told.surface.closest_to_neighbours(points).into_iter().map(|closest| closest.face)
    }

    /// The density there.
    pub(crate) fn at(&self, place: FaceId) -> f64 {
        self.told.wanted[place.index()] * self.more[place.index()].exp()
    }

    /// The metric in which faces should be equilateral there, its trace 1 or a little more.
    pub(crate) fn metric(&self, place: FaceId) -> DMat3 {
        self.told.metrics[place.index()]
    }

    /// How many faces there should be in place of one with an area and a mean squared distance, up to a
    /// factor.
    pub(crate) fn faces_for(&self, area: f64, squared: f64) -> f64 {
        area * self.told.power.faces_per_area(squared / (area * area))
    }

    /// Raises the density where there are fewer faces than there should be: `found` has places, and how
    /// many there should be in place of one.
    pub(crate) fn follow(&mut self, found: impl Iterator<Item = (FaceId, f64)>) {
        let mut sums = vec![[0.0; 2]; self.more.len()];
        let mut all = [0.0; 2];
        for (place, faces) in found.filter(|(_, faces)| faces.is_finite()) {
            let sum = &mut sums[place.index()];
            *sum = [sum[0] + faces, sum[1] + 1.0];
            all = [all[0] + faces, all[1] + 1.0];
        }
        gather(&self.told.mesh, &mut sums);
        let mean = all[0] / all[1];
        for (more, [sum, count]) in self.more.iter_mut().zip(sums).filter(|(_, s)| s[0] > 0.0) {
            *more = (*more + GAIN * (sum / count / mean).ln()).clamp(-MOST, MOST);
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
const ROUNDS: usize = 1;

fn add(terms: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    terms.fold([0.0; 2], |[p, q], [r, s]| [p + r, q + s])
}

/// The second derivatives of the height of a surface over a triangle, of which the [`places`] have these
/// feet; `None` over a triangle without area.
///
/// Three of the places each lie on a line along a side, a third of its length apart: their second
/// difference is a ninth of q = e·He along that side e. With the gradients g of the barycentric
/// coordinates, `H = -½ Σ q_i (g_j g_kᵀ + g_k g_jᵀ)`.
fn second_form([a, b, c]: [DVec3; 3], feet: impl Iterator<Item = DVec3>) -> Option<SecondForm> {
    let cross = (b - a).cross(c - a);
    let normal = cross.try_normalize()?;
    let mut heights = [0.0; PLACES];
    heights.iter_mut().zip(feet).for_each(|(height, foot)| *height = normal.dot(foot - a));
    let along = |[p, q, r]: [usize; 3]| 9.0 * (heights[p] - 2.0 * heights[q] + heights[r]);
    let [qa, qb, qc] = [[1, 5, 2], [0, 4, 2], [0, 3, 1]].map(along);
    let [ga, gb, gc] = [c - b, a - c, b - a].map(|side| normal.cross(side) / cross.length());
    let term = |q: f64, g: DVec3, h: DVec3| -0.5 * q * (outer(g, h) + outer(h, g));
    let derivatives = term(qa, gb, gc) + term(qb, gc, ga) + term(qc, ga, gb);
    Some(SecondForm { derivatives, tangential: DMat3::IDENTITY - outer(normal, normal) })
}

/// Second derivatives in a plane, and the projection onto that plane.
#[derive(Clone, Copy)]
struct SecondForm {
    derivatives: DMat3,
    tangential: DMat3,
}

/// |H|, scaled to the trace 1, and a little rounder: where K changes its sign, it alone would want faces
/// that are longer than what it was measured on.
fn metric(form: Option<SecondForm>) -> DMat3 {
    let Some(SecondForm { derivatives, tangential }) = form else { return DMat3::ZERO };
    let trace = |m: DMat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
    let square = derivatives * derivatives;
    let determinant = (0.5 * (trace(derivatives).powi(2) - trace(square))).abs();
    // |H|² - tr |H| |H| + |det H| = 0 (Cayley and Hamilton), and tr² |H| = tr H² + 2 |det H|.
    let scale = (trace(square) + 2.0 * determinant).recip();
    let absolute = scale * (square + determinant * tangential);
    if absolute.is_finite() { absolute + ROUNDER * tangential } else { tangential }
}

/// The part of the metric that is the same in all directions.
const ROUNDER: f64 = 0.05;

/// The matrix a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(b.x * a, b.y * a, b.z * a)
}

#[cfg(test)]
mod tests {
    use super::{ROUNDER, metric, places, second_form};
    use glam::{DMat3, DVec3};

    /// On a saddle the metric has the absolute values of the principal curvatures, whatever the triangle.
    #[test]
    fn the_metric_is_the_absolute_value_of_the_second_derivatives() {
        let curvatures = DVec3::new(3.0, -1.0, 0.0);
        let height = |p: DVec3| 0.5 * p.dot(curvatures * p);
        let triangle = [DVec3::ZERO, DVec3::new(0.4, 0.1, 0.0), DVec3::new(-0.1, 0.7, 0.0)];
        let on_saddle = |turn: DMat3| {
            let feet = places(triangle).into_iter().map(|p| turn * (p + height(p) * DVec3::Z));
            second_form(triangle.map(|p| turn * p), feet)
        };
        let form = on_saddle(DMat3::IDENTITY);
        let derivatives = form.as_ref().map(|form| form.derivatives).unwrap();
        assert!((derivatives - DMat3::from_diagonal(curvatures)).abs_diff_eq(DMat3::ZERO, 1e-12));
        let expected = DVec3::new(0.75 + ROUNDER, 0.25 + ROUNDER, 0.0);
        assert!(metric(form).abs_diff_eq(DMat3::from_diagonal(expected), 1e-12));
        // And it turns with the saddle.
        let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(0.4);
        let turned = turn * DMat3::from_diagonal(expected) * turn.transpose();
        assert!(metric(on_saddle(turn)).abs_diff_eq(turned, 1e-12));
        // Without curvature all directions are alike, and without area there are none.
        let flat = metric(second_form(triangle, places(triangle).into_iter()));
        assert!(flat.abs_diff_eq(DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0)), 1e-12));
        assert!(second_form([DVec3::X; 3], places([DVec3::X; 3]).into_iter()).is_none());
    }
}
