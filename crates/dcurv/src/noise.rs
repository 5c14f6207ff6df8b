//! The noise of the positions of a mesh, estimated from the mesh itself.

use glam::DVec2;
use mesh_core::{Handle, TriMesh, VertexId, parallel};

use crate::height_points::{HeightPoint, Neighbourhood};
use crate::jet_fit::{JetFit, JetSolver, near_weight};
use crate::principal::TangentFrame;

/// The number of vertices that are looked at.
const SAMPLES: usize = 500;

/// The fitted surfaces.
const FITS: [Surface; 4] = [
    Surface { degree: 2, rings: 2, is_projected: false },
    Surface { degree: 4, rings: 3, is_projected: false },
    Surface { degree: 4, rings: 3, is_projected: true },
    Surface { degree: 6, rings: 4, is_projected: true },
];

/// A surface that is fitted to the neighbours of a vertex.
#[derive(Clone, Copy)]
struct Surface {
    degree: i32,
    /// Rings of neighbours.
    rings: usize,
    /// Whether the height is a polynomial of the projection, or of the [place](HeightPoint::at) that makes circles exact.
    /// The former has less error in smooth surfaces at degrees above 2.
    is_projected: bool,
}

/// The median of the absolute value of a normally distributed variable with standard deviation 1.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_081_7;

/// The standard deviation of the noise of vertices along the normal, in model units. 0 if the mesh is too small to
/// tell.
///
/// For each of some 500 vertices, evenly spaced by index, surfaces of degree 2, 4 and 6 are fitted to two, three and
/// four rings of neighbours without the vertex. The vertex differs from a fitted surface by its own noise and by a known
/// share of the noise of its neighbours. Each difference is divided by the standard deviation that it has for noise 1.
/// The median of the quotients is robust against features. The smallest result of the three degrees is returned,
/// because the error of a fitted surface can only increase a result.
///
/// On meshes of triangles of similar size with noise of 1 % and 5 % of the edge length, the result is within 20 % of
/// the truth. On coarse smooth meshes it is the remaining error of the fits, typically below 0.1 % of the edge length.
#[must_use]
pub fn estimate_noise(mesh: &TriMesh) -> f64 {
    let normals = mesh.vertex_normals();
    let by_degree = FITS.map(|surface| {
        let count = mesh.topology().vertex_capacity();
        let stride = (count / SAMPLES).max(1);
        let mut errors = parallel::collect_with(
            count / stride,
            || (Neighbourhood::new(mesh, Some(normals.as_slice())), JetSolver::default()),
            |(near, solver), index| {
                let vertex = VertexId::from_index(index * stride);
                error_at(mesh, near, solver, vertex, surface).unwrap_or(f64::NAN)
            },
        );
        errors.retain(|error| !error.is_nan());
        let middle = errors.len() / 2;
        if errors.is_empty() {
            return f64::INFINITY;
        }
        *errors.select_nth_unstable_by(middle, f64::total_cmp).1 / NORMAL_MEDIAN
    });
    let least = by_degree.into_iter().fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// How much an interior vertex differs from the surface fitted to its neighbours, in units of noise 1.
fn error_at(
    mesh: &TriMesh,
    near: &mut Neighbourhood<'_>,
    solver: &mut JetSolver,
    vertex: VertexId,
    Surface { degree, rings, is_projected }: Surface,
) -> Option<f64> {
    const MOST: usize = 128;
    let topology = mesh.topology();
    let is_inside = topology.contains_vertex(vertex)
        && !topology.is_isolated_vertex(vertex)
        && !topology.is_boundary_vertex(vertex);
    let mut tangent = TangentFrame::of(mesh.vertex_normal(vertex)).filter(|_| is_inside)?;
    near.collect(vertex, rings, monomials(degree) + 5, 0.0, MOST);
    near.heights(&tangent);
    let mut fits: Vec<JetFit> = Vec::new();
    solver.smoothing(&near.points, near.reach(), &mut fits);
    if let Some(fit) = fits.first() {
        tangent = tangent.tilted(&fit.jet)?;
    }
    if is_projected {
        near.projected_heights(&tangent);
    } else {
        near.heights(&tangent);
    }
    straighten(&mut near.points);
    prediction_error(&near.points, degree)
}

/// Moves points that are almost on the line through the vertex and its nearest point to this line.
///
/// In a column of vertices, noise moves the places to the sides a little, and the heights. So the places foretell the
/// heights, and without this step the result is too small, by a factor of a thousand on a prism of eight sides.
fn straighten(points: &mut [HeightPoint]) {
    /// The largest sine of the angle to the line.
    const ALMOST: f64 = 0.02;
    let Some(axis) = points.first().and_then(|nearest| nearest.at.try_normalize()) else { return };
    for point in points {
        let length = point.at.length();
        if axis.perp_dot(point.at).abs() < ALMOST * length {
            point.at = axis * length.copysign(axis.dot(point.at));
        }
    }
}

/// The number of monomials up to a degree.
fn monomials(degree: i32) -> usize {
    ((degree + 1) * (degree + 2) / 2) as usize
}

/// The difference between the vertex and the surface fitted to the points around it, with weights `1/distance^8`, in
/// standard deviations of noise 1. `None` where there are too few points.
///
/// The height of the fitted surface at the vertex is its constant. In a factorisation by Gram and Schmidt with the
/// constant as the last column, only what this column leaves is needed.
fn prediction_error(points: &[HeightPoint], degree: i32) -> Option<f64> {
    /// Columns of which a smaller share is left are dependent on the others but for the noise of places, which is
    /// related to the noise of heights.
    const LEAST_REST: f64 = 1e-3;
    /// Above this variance, the neighbours do not determine the height at the vertex.
    const MOST_VARIANCE: f64 = 100.0;
    let scale = points.last()?.at.length();
    if points.len() < monomials(degree) + 2 {
        return None;
    }
    let exponents = (0..=degree).rev().flat_map(|sum| (0..=sum).map(move |j| (sum - j, j)));
    let weights: Vec<f64> = points.iter().map(|point| near_weight(point, scale)).collect();
    let mut columns: Vec<Vec<f64>> = Vec::with_capacity(monomials(degree));
    for (i, j) in exponents {
        let entry = |(point, weight): (&HeightPoint, &f64)| {
            let DVec2 { x, y } = point.at / scale;
            weight * x.powi(i) * y.powi(j)
        };
        let mut column: Vec<f64> = points.iter().zip(&weights).map(entry).collect();
        let length = dot(&column, &column).sqrt();
        // Once more, because the first projections are rounded.
        for _ in 0..2 {
            for known in &columns {
                let share = dot(known, &column);
                column.iter_mut().zip(known).for_each(|(entry, known)| *entry -= share * known);
            }
        }
        let rest = dot(&column, &column).sqrt();
        let is_constant = i + j == 0;
        if is_constant || rest > LEAST_REST * length {
            // The length of the constant is needed.
            let divisor = if is_constant { 1.0 } else { rest };
            column.iter_mut().for_each(|entry| *entry /= divisor);
            columns.push(column);
        }
    }
    let rest = columns.last()?;
    let square = dot(rest, rest);
    let of_heights = || rest.iter().zip(&weights).map(|(rest, weight)| rest * weight / square);
    let constant: f64 = of_heights().zip(points).map(|(l, point)| l * point.z).sum();
    let variance: f64 = of_heights().map(|l| l * l).sum();
    let error = constant.abs() / (1.0 + variance).sqrt();
    (variance < MOST_VARIANCE).then_some(error)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
