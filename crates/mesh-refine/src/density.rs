//! The density that the faces of a mesh should have, and their shape.
//!
//! Let a surface have the second fundamental form H and the Gaussian curvature K = det H. For a face of area a, the
//! least possible integrated squared distance is E ~ |K| a³. It is reached by faces that are equilateral in the metric
//! |H|, which has the absolute values of the principal curvatures. Where K > 0, no other shape reaches it. Where K < 0,
//! it is enough that the sum of e·He over the sides e of a face vanishes. Straight lines on the surface then allow
//! arbitrarily thin faces; of all these shapes, |H| selects round ones.
//!
//! H is measured on a mesh with about the wanted number of faces, so that it fits that scale. The ratio E / a³
//! determines the number of faces for each part; see [`Power::faces_per_area`]. After that, the density follows the
//! measured distances.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use mesh_core::{FaceId, Handle, TriMesh, VertexId, parallel};
use mesh_metric::{Surface, SurfaceError, closest_on_triangle};

use crate::fit::spread::area;
use crate::norm::Power;

/// The density that leads to the wanted number of faces per area, and the metric of their shapes.
///
/// Smoothing moves each vertex to the mean of the centroids of its faces, weighted by area and by a density. The result
/// is denser where the density is larger. The factor depends on the curvature of the surface and on the stretch of the
/// faces. So the density starts at the wanted number of faces per area, and is then adapted to the measured distances.
#[derive(Clone)]
pub(crate) struct Density {
    told: Arc<Told>,
    /// For each face of the measured mesh, the logarithm of the factor on the wanted density.
    more: Vec<f64>,
}

/// The measured part, which does not change when the density is adapted.
struct Told {
    power: Power,
    mesh: TriMesh,
    surface: Surface,
    /// The initial density for each face of the mesh.
    wanted: Vec<f64>,
    metrics: Vec<DMat3>,
}

/// The number of sample points of a face: the centroids of the parts when each side is divided in three.
pub(crate) const PLACES: usize = 9;

/// The sample points of a triangle.
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
    /// Measures the density on a mesh with about the wanted number of faces.
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
        // The mean over a few faces depends less on their shapes.
        gather(mesh, &mut sums);
        let wanted = sums.into_iter().map(|[squares, cubes]| power.faces_per_area(squares / cubes));
        let more = vec![0.0; topology.face_capacity()];
        let (wanted, surface) = (wanted.collect(), Surface::new(mesh)?);
        let told = Arc::new(Told { power, mesh: mesh.clone(), surface, wanted, metrics });
        Ok(Self { told, more })
    }

    /// The faces closest to some points. Consecutive points should be close to each other.
    pub(crate) fn places(&self, points: &[DVec3]) -> impl Iterator<Item = FaceId> + '_ {
        self.told.surface.closest_to_neighbours(points).into_iter().map(|closest| closest.face)
    }

    /// The density at a face.
    pub(crate) fn at(&self, place: FaceId) -> f64 {
        self.told.wanted[place.index()] * self.more[place.index()].exp()
    }

    /// The metric in which faces should be equilateral at a face. Its trace is 1 or slightly more.
    pub(crate) fn metric(&self, place: FaceId) -> DMat3 {
        self.told.metrics[place.index()]
    }

    /// The number of faces, up to a factor, that should replace a face with this area and mean squared distance.
    pub(crate) fn faces_for(&self, area: f64, squared: f64) -> f64 {
        area * self.told.power.faces_per_area(squared / (area * area))
    }

    /// Raises the density where there are too few faces. `found` holds faces of the measured mesh, each with the number
    /// of faces that should replace one face there.
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

/// Speed and limit of the adaptation.
const GAIN: f64 = 0.1;
const MOST: f64 = 3.0;

/// Replaces the sums of each face by the sums over its neighbourhood.
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

/// The number of rings in this neighbourhood.
const ROUNDS: usize = 1;

fn add(terms: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    terms.fold([0.0; 2], |[p, q], [r, s]| [p + r, q + s])
}

/// The second derivatives of the height of a surface over a triangle; `feet` are the closest points of the surface to
/// the [`places`] of the triangle. `None` for a triangle without area.
///
/// For each side e, three of the places lie on a line parallel to it, a third of its length apart. Their second
/// difference is a ninth of q = e·He. With the gradients g of the barycentric coordinates, `H = -½ Σ q_i (g_j g_kᵀ +
/// g_k g_jᵀ)`.
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

/// |H|, scaled to trace 1, plus a small isotropic part. Where K changes its sign, |H| alone would ask for faces that
/// are longer than the faces it was measured on.
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

/// The isotropic part of the metric.
const ROUNDER: f64 = 0.05;

/// The matrix a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(b.x * a, b.y * a, b.z * a)
}

#[cfg(test)]
mod tests {
    use super::{ROUNDER, metric, places, second_form};
    use glam::{DMat3, DVec3};

    /// On a saddle the metric has the absolute values of the principal curvatures, for any triangle.
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
        // The metric rotates with the saddle.
        let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(0.4);
        let turned = turn * DMat3::from_diagonal(expected) * turn.transpose();
        assert!(metric(on_saddle(turn)).abs_diff_eq(turned, 1e-12));
        // Without curvature the metric is isotropic; a triangle without area has no metric.
        let flat = metric(second_form(triangle, places(triangle).into_iter()));
        assert!(flat.abs_diff_eq(DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0)), 1e-12));
        assert!(second_form([DVec3::X; 3], places([DVec3::X; 3]).into_iter()).is_none());
    }
}
