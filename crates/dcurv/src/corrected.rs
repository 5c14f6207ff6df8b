//! Curvature averaged over balls, with normals that are interpolated between vertices.
//!
//! The interpolated corrected curvature measures of Lachaud, Romon, Thibert and Coeurjolly 2020, Interpolated corrected
//! curvature measures for polygonal surfaces. On a triangle with corners `x_i` and unit normals `u_i` there, with
//! `ū = (u_0 + u_1 + u_2) / 3`:
//!
//! - area: `mu_0 = 1/2 <ū, (x_1 - x_0) x (x_2 - x_0)>`;
//! - mean curvature, `2 H` per area: `mu_1 = 1/2 <ū, (u_2 - u_1) x x_0 + (u_0 - u_2) x x_1 + (u_1 - u_0) x x_2>`;
//! - Gaussian curvature: `mu_2 = 1/2 <u_0, u_1 x u_2>`;
//! - the tensor `1/2 ((u_2 - u_0) ⊗ ((x_1 - x_0) x ū) - (u_1 - u_0) ⊗ ((x_2 - x_0) x ū))`, with the principal
//!   curvatures and directions in the tangent plane.
//!
//! The measures of a ball around a vertex are the sums over its triangles, each in proportion to the part of the
//! triangle inside. Divided by the area, they are averages over the ball.
//!
//! The normals are the angle-weighted normals of vertices. In contrast to [`ball`](crate::ball), curvature is spread
//! over the faces and not concentrated at edges and vertices, so averages depend less on where the ball ends.
//!
//! **Convergence.** As for [`ball`](crate::ball): with the radius, if the edge length falls faster than the radius.
//! **Boundary.** Faces end there, and nothing is added: averages over the part of the ball that exists.
//! **Cost.** As for [`ball`](crate::ball). Bit-identical for any number of threads, except for principal directions, which
//! use the sine and arc tangent of the platform.

use glam::{DMat3, DVec3};
use mesh_core::{TriMesh, VertexId, VertexMap};

use crate::ball::{InvalidRadius, check};
use crate::ball_faces::BallFaces;
use crate::principal::{Axes, PrincipalFrame, TangentFrame};
use crate::quantity::{Area, Integral, Pointwise};
use crate::vertex_loop::of_vertices;

/// Corrected measures of the part of a surface inside a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CorrectedCurvature {
    /// The area with respect to the interpolated normals, `mu_0`.
    pub area: Area,
    /// Gaussian curvature, `mu_2`, in radians.
    pub gaussian: Integral,
    /// Mean curvature, half of `mu_1`, positive where convex, in model units.
    pub mean: Integral,
    /// The curvature tensor, in model units.
    pub tensor: DMat3,
    /// The integral of the normal, in squared model units.
    pub normal_area: DVec3,
}

/// All zero. (The default matrix of `glam` is the identity.)
impl Default for CorrectedCurvature {
    fn default() -> Self {
        Self {
            area: Area::default(),
            gaussian: Integral::default(),
            mean: Integral::default(),
            tensor: DMat3::ZERO,
            normal_area: DVec3::ZERO,
        }
    }
}

impl CorrectedCurvature {
    /// The average of the Gaussian curvature, in 1 / length².
    #[must_use]
    pub fn gaussian(&self) -> Pointwise {
        self.gaussian / self.area
    }

    /// The average of the mean curvature, positive where convex, in 1 / length.
    #[must_use]
    pub fn mean(&self) -> Pointwise {
        self.mean / self.area
    }

    /// The principal curvatures and directions of the tensor in the plane orthogonal to the mean normal. `None` without
    /// area or mean normal.
    #[must_use]
    pub fn principal(&self) -> Option<PrincipalFrame> {
        let plane = TangentFrame::of(self.normal_area.normalize_or_zero())?;
        let entry = |s: DVec3, t: DVec3| {
            0.5 * (s.dot(self.tensor * t) + t.dot(self.tensor * s)) / self.area.value()
        };
        let form = [entry(plane.x, plane.x), entry(plane.x, plane.y), entry(plane.y, plane.y)];
        plane.principal(Axes::of(form))
    }

    /// Adds a part of a triangle.
    fn add(&mut self, part: f64, [x0, x1, x2]: [DVec3; 3], [u0, u1, u2]: [DVec3; 3]) {
        let mean = (u0 + u1 + u2) / 3.0;
        let (a, b) = (x1 - x0, x2 - x0);
        let (p, q) = (u1 - u0, u2 - u0);
        let half = 0.5 * part;
        let area = half * mean.dot(a.cross(b));
        self.area += Area::new(area);
        self.normal_area += area * mean;
        // The sum of mu_1 with the corners relative to x0.
        self.mean += Integral::new(0.5 * half * mean.dot((u0 - u2).cross(a) + p.cross(b)));
        self.gaussian += Integral::new(half * u0.dot(u1.cross(u2)));
        let (s, t) = (b.cross(mean), a.cross(mean));
        let column = |i: usize| half * (s * p[i] - t * q[i]);
        self.tensor += DMat3::from_cols(column(0), column(1), column(2));
    }
}

/// The measures of the part of the surface inside the ball around a vertex. All zero for isolated vertices.
///
/// # Errors
/// The radius is not positive and finite.
///
/// # Panics
/// When the vertex is out of range for this mesh.
pub fn corrected_curvature(
    mesh: &TriMesh,
    vertex: VertexId,
    radius: f64,
) -> Result<CorrectedCurvature, InvalidRadius> {
    check(radius)?;
    let normal = |v: VertexId| mesh.vertex_normal(v);
    Ok(integrate(mesh, &normal, &mut BallFaces::new(mesh), vertex, radius))
}

/// [`corrected_curvature`] of all vertices; zero for removed vertices.
///
/// ```
/// use mesh_core::TriMesh;
/// use mesh_shapes::Sphere;
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let sphere = TriMesh::from_soup(&Sphere { radius: 2.0 }.icosphere(4)?)?;
/// let smoothed = dcurv::corrected_curvatures(&sphere, 0.5)?;
/// assert!(smoothed.iter().all(|(_, ball)| (ball.mean().value() - 0.5).abs() < 0.002));
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// The radius is not positive and finite.
pub fn corrected_curvatures(
    mesh: &TriMesh,
    radius: f64,
) -> Result<VertexMap<CorrectedCurvature>, InvalidRadius> {
    check(radius)?;
    Ok(all(mesh, radius, &|| false))
}

/// As [`corrected_curvatures`], until `stops` returns true; then `None`. Any thread calls `stops` before each vertex.
/// Once true, it must stay true.
///
/// # Errors
/// The radius is not positive and finite.
pub fn corrected_curvatures_until(
    mesh: &TriMesh,
    radius: f64,
    stops: &(dyn Fn() -> bool + Sync),
) -> Result<Option<VertexMap<CorrectedCurvature>>, InvalidRadius> {
    check(radius)?;
    let found = all(mesh, radius, stops);
    Ok((!stops()).then_some(found))
}

/// Zero for the vertices after `stops` has returned true.
fn all(
    mesh: &TriMesh,
    radius: f64,
    stops: &(dyn Fn() -> bool + Sync),
) -> VertexMap<CorrectedCurvature> {
    let normals = mesh.vertex_normals();
    let normal = |v: VertexId| normals[v];
    let faces = || BallFaces::new(mesh);
    of_vertices(mesh, stops, faces, |faces, vertex| integrate(mesh, &normal, faces, vertex, radius))
}

fn integrate(
    mesh: &TriMesh,
    normal: &dyn Fn(VertexId) -> DVec3,
    faces: &mut BallFaces<'_>,
    vertex: VertexId,
    radius: f64,
) -> CorrectedCurvature {
    let mut total = CorrectedCurvature::default();
    faces.visit(vertex, radius, &mut |face| {
        let whole = mesh.face_area(face.face);
        if whole > 0.0 {
            total.add(face.area / whole, mesh.triangle(face.face), face.corners.map(normal));
        }
    });
    total
}
