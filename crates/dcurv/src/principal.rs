//! Principal directions from a fitted quadratic surface.
//!
//! Angles and dihedral angles give the sizes of the principal curvatures, but no directions. The directions come from
//! the 2-jet of Cazals and Pouget 2005, Estimating differential quantities using polynomial fitting of osculating jets:
//! the quadratic height function through the vertex that best fits the points around it. Its curvatures converge at
//! every vertex with first order in the edge length, for triangles of any shape, and with second order on symmetric
//! stars. The error of averages of a curvature tensor over the star (Cohen-Steiner and Morvan 2003, Rusinkiewicz 2004),
//! by contrast, falls with refinement only on symmetric stars.
//!
//! The points are the neighbours of the vertex and, across each edge opposite to it, the apex of the face on the other
//! side: about twelve, for five unknowns. Their number is at most twice the valence, so the whole mesh takes linear
//! time, even with vertices of very high valence. For noisy surfaces, [`fit`](crate::fit) uses more points.

use glam::DVec3;
use mesh_core::{Handle, Topology, TriMesh, VertexId, VertexMap, parallel};

use crate::quantity::Pointwise;

/// Principal curvatures and directions of a fitted surface at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PrincipalFrame {
    /// The larger principal curvature, positive where convex, per model unit.
    pub k_max: Pointwise,
    /// The smaller principal curvature, per model unit.
    pub k_min: Pointwise,
    /// The unit tangent, up to sign, along which the normal curvature is `k_max`. If both curvatures are equal, every
    /// tangent is principal, and this is one of them.
    pub direction_max: DVec3,
    /// The unit tangent `normal x direction_max`.
    pub direction_min: DVec3,
    /// The unit normal of the fitted surface.
    pub normal: DVec3,
}

impl PrincipalFrame {
    /// The mean curvature, `(k_max + k_min) / 2`, positive where convex, per model unit.
    #[must_use]
    pub fn mean(&self) -> Pointwise {
        Pointwise::new(0.5 * (self.k_max.value() + self.k_min.value()))
    }

    /// The Gaussian curvature, `k_max k_min`, per square of the model unit.
    #[must_use]
    pub fn gaussian(&self) -> Pointwise {
        Pointwise::new(self.k_max.value() * self.k_min.value())
    }
}

/// The principal curvatures and directions of a vertex.
///
/// `None` where the points around the vertex do not determine a quadratic surface, or where the vertex has no normal:
/// at isolated vertices, at corners with fewer than five points around them, in degenerate triangles.
///
/// # Panics
/// When the vertex is out of range for this mesh.
#[must_use]
pub fn principal_frame(mesh: &TriMesh, vertex: VertexId) -> Option<PrincipalFrame> {
    let origin = mesh.position(vertex);
    let spread = mesh.topology().one_ring(vertex).map(|v| mesh.position(v).distance(origin));
    let scale = spread.fold(0.0, f64::max);
    fit_frame(mesh, vertex, scale, |add| visit_fit_points(mesh.topology(), vertex, add))
}

/// The frame of the quadratic height function over the tangent plane of a vertex that best fits the visited vertices.
/// `scale` is a length similar to their distances.
pub(crate) fn fit_frame(
    mesh: &TriMesh,
    vertex: VertexId,
    scale: f64,
    visit: impl FnOnce(&mut dyn FnMut(VertexId)),
) -> Option<PrincipalFrame> {
    let tangent = TangentFrame::of(mesh.vertex_normal(vertex))?;
    let origin = mesh.position(vertex);
    let mut fit = EqualFit::default();
    visit(&mut |v| fit.add(tangent.coordinates(mesh.position(v) - origin) / scale));
    fit.solve().map(|jet| jet.frame(&tangent, scale))
}

/// [`principal_frame`] of all vertices; `None` for removed ones, too.
#[must_use]
pub fn principal_frames(mesh: &TriMesh) -> VertexMap<Option<PrincipalFrame>> {
    VertexMap::from_vec(parallel::collect(mesh.topology().vertex_capacity(), |index| {
        principal_frame(mesh, VertexId::from_index(index))
    }))
}

/// Visits the neighbours of a vertex and the apexes across the edges opposite to it. An apex may be visited more than
/// once, which increases its weight.
fn visit_fit_points(topology: &Topology, vertex: VertexId, visit: &mut dyn FnMut(VertexId)) {
    for h in topology.outgoing(vertex) {
        visit(topology.target(h));
        let beyond = topology.apex(topology.next(h).twin());
        if let Some(apex) = beyond.filter(|_| !topology.is_exterior(h)) {
            visit(apex);
        }
    }
}

/// An orthonormal frame whose z-axis is the normal.
#[derive(Clone, Copy)]
pub(crate) struct TangentFrame {
    pub(crate) x: DVec3,
    pub(crate) y: DVec3,
    pub(crate) z: DVec3,
}

impl TangentFrame {
    pub(crate) fn of(normal: DVec3) -> Option<Self> {
        let x = (normal != DVec3::ZERO).then(|| normal.any_orthonormal_vector())?;
        Some(Self { x, y: normal.cross(x), z: normal })
    }

    /// The principal curvatures and directions of a form in this plane. `None` if they are not finite.
    pub(crate) fn principal(&self, Axes { max, min, cos, sin }: Axes) -> Option<PrincipalFrame> {
        (max.is_finite() && min.is_finite()).then(|| PrincipalFrame {
            k_max: Pointwise::new(max),
            k_min: Pointwise::new(min),
            direction_max: cos * self.x + sin * self.y,
            direction_min: cos * self.y - sin * self.x,
            normal: self.z,
        })
    }

    /// The frame of the tangent plane of a jet over this plane. `None` if the normal overflows.
    pub(crate) fn tilted(&self, jet: &Jet) -> Option<Self> {
        Self::of(self.vector(jet.normal()).normalize_or_zero())
    }

    pub(crate) fn coordinates(&self, vector: DVec3) -> DVec3 {
        DVec3::new(vector.dot(self.x), vector.dot(self.y), vector.dot(self.z))
    }

    fn vector(&self, coordinates: DVec3) -> DVec3 {
        coordinates.x * self.x + coordinates.y * self.y + coordinates.z * self.z
    }
}

/// Unknowns of a height function without a constant term.
const UNKNOWNS: usize = 5;

/// Least-squares fit of a [`Jet`] with equal weights: the normal equations.
#[derive(Default)]
struct EqualFit {
    matrix: [[f64; UNKNOWNS]; UNKNOWNS],
    right_side: [f64; UNKNOWNS],
}

/// The height function `z = px x + py y + xx x²/2 + xy x y + yy y²/2`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jet {
    pub(crate) px: f64,
    pub(crate) py: f64,
    pub(crate) xx: f64,
    pub(crate) xy: f64,
    pub(crate) yy: f64,
}

impl EqualFit {
    fn add(&mut self, point: DVec3) {
        let DVec3 { x, y, z } = point;
        let row = [x, y, 0.5 * x * x, x * y, 0.5 * y * y];
        for (i, equation) in self.matrix.iter_mut().enumerate() {
            for (entry, value) in equation.iter_mut().zip(row) {
                *entry += row[i] * value;
            }
            self.right_side[i] += row[i] * z;
        }
    }

    /// Cholesky's factorisation; `None` when the matrix is singular or nearly so.
    fn solve(&self) -> Option<Jet> {
        let mut factor = [[0.0; UNKNOWNS]; UNKNOWNS];
        let mut values = [0.0; UNKNOWNS];
        for i in 0..UNKNOWNS {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let rest = self.matrix[i][j] - known;
                if i != j {
                    factor[i][j] = rest / factor[j][j];
                } else if rest > 1e-12 * self.matrix[i][i] {
                    factor[i][i] = rest.sqrt();
                } else {
                    return None;
                }
            }
            let known: f64 = (0..i).map(|k| factor[i][k] * values[k]).sum();
            values[i] = (self.right_side[i] - known) / factor[i][i];
        }
        for i in (0..UNKNOWNS).rev() {
            let known: f64 = (i + 1..UNKNOWNS).map(|k| factor[k][i] * values[k]).sum();
            values[i] = (values[i] - known) / factor[i][i];
        }
        let [px, py, xx, xy, yy] = values;
        values.iter().all(|v| v.is_finite()).then_some(Jet { px, py, xx, xy, yy })
    }
}

impl Jet {
    /// The normal, with height 1.
    fn normal(&self) -> DVec3 {
        DVec3::new(-self.px, -self.py, 1.0)
    }

    /// Orthonormal tangents of the graph, the first above the x-axis, and the length of [`Jet::normal`].
    pub(crate) fn tangent_basis(&self) -> (DVec3, DVec3, f64) {
        let normal = self.normal();
        let stretch = normal.length();
        let e = DVec3::new(1.0, 0.0, self.px).normalize();
        (e, (normal / stretch).cross(e), stretch)
    }

    /// The second fundamental form, positive where convex, in the [tangent basis](Jet::tangent_basis) and with lengths
    /// times `scale`: entries 11, 12 and 22.
    pub(crate) fn second_form(&self, scale: f64) -> [f64; 3] {
        let (e, f, stretch) = self.tangent_basis();
        let second = |s: DVec3, t: DVec3| {
            let bend = self.xx * s.x * t.x + self.yy * s.y * t.y;
            -(bend + self.xy * (s.x * t.y + s.y * t.x)) / (stretch * scale)
        };
        [second(e, e), second(e, f), second(f, f)]
    }

    /// The principal frame of the height function at the origin, with lengths times `scale`.
    pub(crate) fn frame(&self, tangent: &TangentFrame, scale: f64) -> PrincipalFrame {
        let (e, f, stretch) = self.tangent_basis();
        let normal = self.normal() / stretch;
        let Axes { max, min, cos, sin } = Axes::of(self.second_form(scale));
        PrincipalFrame {
            k_max: Pointwise::new(max),
            k_min: Pointwise::new(min),
            direction_max: tangent.vector(cos * e + sin * f),
            direction_min: tangent.vector(cos * f - sin * e),
            normal: tangent.vector(normal),
        }
    }
}

/// The eigenvalues of a symmetric matrix of two rows, and the direction of the larger one.
pub(crate) struct Axes {
    pub(crate) max: f64,
    pub(crate) min: f64,
    pub(crate) cos: f64,
    pub(crate) sin: f64,
}

impl Axes {
    /// The axes of the matrix with the rows `(ee, ef)` and `(ef, ff)`.
    pub(crate) fn of([ee, ef, ff]: [f64; 3]) -> Self {
        let (mean, half_difference) = (0.5 * (ee + ff), 0.5 * (ee - ff));
        let radius = half_difference.hypot(ef);
        let (sin, cos) = (0.5 * ef.atan2(half_difference)).sin_cos();
        Self { max: mean + radius, min: mean - radius, cos, sin }
    }
}
