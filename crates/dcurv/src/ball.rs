//! Curvature averaged over balls: smoothed values at a scale that one chooses.
//!
//! Cohen-Steiner and Morvan 2003, Restricted Delaunay triangulations and normal cycle: the curvature
//! *measures* of a mesh. For the part `B` of the surface inside a ball,
//!
//! - Gaussian curvature: the sum of the angle defects of the vertices in `B`;
//! - mean curvature: `1/2 sum of |e ∩ B| beta(e)` over the edges, with signed dihedral angles;
//! - the tensor `sum of |e ∩ B| beta(e) ē ēᵀ`, with the unit vectors `ē` along the edges: in the
//!   tangent plane it has the eigenvalues of the curvature tensor, with the principal directions
//!   swapped, since a surface bends across an edge and not along it.
//!
//! Edges and triangles are cut at the ball exactly. Divided by the area of `B` these are averages
//! over the ball: pointwise values that converge to those of a smooth surface when the radius goes
//! to zero and the edge length goes to zero faster, whatever the triangles look like. At a radius of
//! several edge lengths they hardly depend on noise and on the mesh; details smaller than the radius
//! are gone.
//!
//! `B` is what hangs together with the centre inside the ball of that radius in space: another sheet
//! of the surface that happens to be near does not count. (A geodesic disk of the same radius differs
//! from it by the cube of the radius.)
//!
//! **Boundary.** `B` ends at the boundary; edges on it have no dihedral angle, and the angle defect of
//! vertices on it is left out: it belongs to the boundary, not to the surface. So the values are
//! averages over the part of the ball that there is, off by the first order in the radius.
//!
//! **Cost.** As many steps per vertex as there are faces in the ball: for a radius of `k` edge lengths
//! about `7 k²`. The bits of the results do not depend on the number of threads, but, since they use the
//! sine and arc tangent of the platform, [principal directions](BallCurvature::principal) may depend
//! on that.

use glam::{DMat3, DVec2, DVec3};
use mesh_core::{EdgeId, FaceId, Handle, TriMesh, VertexId, VertexMap, parallel};

use crate::area::VertexArea;
use crate::atan2::atan2;
use crate::edge::edge_dihedral_angle;
use crate::principal::{Axes, PrincipalFrame, TangentFrame};
use crate::quantity::{Area, Integral, Pointwise};
use crate::star::vertex_integrals;

/// What is integrated over the part of a surface inside a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BallCurvature {
    /// The area.
    pub area: Area,
    /// Gaussian curvature, in radians.
    pub gaussian: Integral,
    /// Mean curvature, signed, positive where convex, in model units.
    pub mean: Integral,
    /// Absolute mean curvature, `1/2 sum of |e ∩ B| |beta(e)|`, in model units.
    pub abs_mean: Integral,
    /// The curvature tensor, in model units; its trace is twice `mean`.
    pub tensor: DMat3,
    /// The vector area: the sum of the normals of the faces, times their areas.
    pub normal_area: DVec3,
}

/// Nothing inside. (The default matrix of `glam` is not zero.)
impl Default for BallCurvature {
    fn default() -> Self {
        Self {
            area: Area::default(),
            gaussian: Integral::default(),
            mean: Integral::default(),
            abs_mean: Integral::default(),
            tensor: DMat3::ZERO,
            normal_area: DVec3::ZERO,
        }
    }
}

/// A radius that is no length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvalidRadius(
    /// The radius.
    pub f64,
);

impl core::fmt::Display for InvalidRadius {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "the radius is {}; it must be a positive finite number", self.0)
    }
}

impl core::error::Error for InvalidRadius {}

impl BallCurvature {
    /// The mean of the Gaussian curvature over the ball, per square of the model unit.
    #[must_use]
    pub fn gaussian(&self) -> Pointwise {
        self.gaussian / self.area
    }

    /// The mean of the mean curvature over the ball, positive where convex, per model unit.
    #[must_use]
    pub fn mean(&self) -> Pointwise {
        self.mean / self.area
    }

    /// The mean of the absolute mean curvature over the ball, per model unit.
    #[must_use]
    pub fn abs_mean(&self) -> Pointwise {
        self.abs_mean / self.area
    }

    /// The principal curvatures and directions of the tensor in the plane across the mean normal.
    /// `None` where there is no area, or no mean normal.
    #[must_use]
    pub fn principal(&self) -> Option<PrincipalFrame> {
        let plane = TangentFrame::of(self.normal_area.normalize_or_zero())?;
        let entry = |s: DVec3, t: DVec3| s.dot(self.tensor * t) / self.area.value();
        let form = [entry(plane.x, plane.x), entry(plane.x, plane.y), entry(plane.y, plane.y)];
        let Axes { max, min, cos, sin } = Axes::of(form);
        (max.is_finite() && min.is_finite()).then(|| PrincipalFrame {
            k_max: Pointwise::new(max),
            k_min: Pointwise::new(min),
            // Across the edges that bend most.
            direction_max: cos * plane.y - sin * plane.x,
            direction_min: -(cos * plane.x + sin * plane.y),
            normal: plane.z,
        })
    }
}

/// What is integrated over the part of the surface inside the ball round a vertex.
///
/// All zero for isolated vertices.
///
/// # Errors
/// The radius is not positive and finite.
///
/// # Panics
/// When the vertex is out of range for this mesh.
pub fn ball_curvature(
    mesh: &TriMesh,
    vertex: VertexId,
    radius: f64,
) -> Result<BallCurvature, InvalidRadius> {
    check(radius)?;
    Ok(Ball::new(mesh).integrate(mesh, vertex, radius))
}

/// [`ball_curvature`] of all vertices; zero for removed ones, too.
///
/// ```
/// use mesh_core::{TriMesh, shapes::Sphere};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let sphere = TriMesh::from_soup(&Sphere::UNIT.icosphere(5)?)?;
/// let smoothed = dcurv::ball_curvatures(&sphere, 0.3)?;
/// assert!(smoothed.iter().all(|(_, ball)| (ball.mean().value() - 1.0).abs() < 0.01));
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// The radius is not positive and finite.
pub fn ball_curvatures(
    mesh: &TriMesh,
    radius: f64,
) -> Result<VertexMap<BallCurvature>, InvalidRadius> {
    check(radius)?;
    Ok(all_balls(mesh, radius, &|| false))
}

/// As [`ball_curvatures`], until `stops` says so, which is asked before each vertex by any thread and
/// stays with its answer; `None` then.
///
/// # Errors
/// The radius is not positive and finite.
pub fn ball_curvatures_until(
    mesh: &TriMesh,
    radius: f64,
    stops: &(dyn Fn() -> bool + Sync),
) -> Result<Option<VertexMap<BallCurvature>>, InvalidRadius> {
    check(radius)?;
    let found = all_balls(mesh, radius, stops);
    Ok((!stops()).then_some(found))
}

/// Zero for the vertices that are left once it was stopped.
fn all_balls(
    mesh: &TriMesh,
    radius: f64,
    stops: &(dyn Fn() -> bool + Sync),
) -> VertexMap<BallCurvature> {
    let integrate = |ball: &mut Ball, index| {
        if stops() {
            return BallCurvature::default();
        }
        ball.integrate(mesh, VertexId::from_index(index), radius)
    };
    let count = mesh.topology().vertex_capacity();
    VertexMap::from_vec(parallel::collect_with(count, || Ball::new(mesh), integrate))
}

fn check(radius: f64) -> Result<(), InvalidRadius> {
    if radius.is_finite() && radius > 0.0 { Ok(()) } else { Err(InvalidRadius(radius)) }
}

/// Memory for a walk through a ball: for each element, one more than the index of the centre of the
/// ball that it was met in last.
struct Ball {
    vertices: Vec<u32>,
    edges: Vec<u32>,
    faces: Vec<u32>,
    /// Faces to be visited.
    open: Vec<FaceId>,
}

impl Ball {
    fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        Self {
            vertices: vec![0; topology.vertex_capacity()],
            edges: vec![0; topology.edge_capacity()],
            faces: vec![0; topology.face_capacity()],
            open: Vec::new(),
        }
    }

    fn integrate(&mut self, mesh: &TriMesh, vertex: VertexId, radius: f64) -> BallCurvature {
        let topology = mesh.topology();
        let mark = vertex.get() + 1;
        let center = mesh.position(vertex);
        // In units of the radius, so that no square leaves the range of numbers.
        let place = |v: VertexId| (mesh.position(v) - center) / radius;
        let mut total = BallCurvature::default();
        self.open.extend(topology.faces_of_vertex(vertex));
        self.open.iter().for_each(|face| self.faces[face.index()] = mark);
        while let Some(face) = self.open.pop() {
            let corners = topology.face_vertices(face);
            let points = corners.map(place);
            let cross = (points[1] - points[0]).cross(points[2] - points[0]);
            let normal = cross.normalize_or_zero();
            let area = radius * radius * area_in_unit_ball(points, normal);
            total.area += Area::new(area);
            total.normal_area += area * normal;
            for (v, p) in corners.into_iter().zip(points) {
                if p.length_squared() <= 1.0 && is_new(&mut self.vertices, v.index(), mark) {
                    total.add_vertex(mesh, v);
                }
            }
            for h in topology.face_half_edges(face) {
                let ends = [topology.origin(h), topology.target(h)].map(place);
                let Some(inside) = part_in_unit_ball(ends) else { continue };
                if is_new(&mut self.edges, h.edge().index(), mark) {
                    total.add_edge(mesh, h.edge(), ends, radius * inside);
                }
                if let Some(face) = topology.face(h.twin())
                    && is_new(&mut self.faces, face.index(), mark)
                {
                    self.open.push(face);
                }
            }
        }
        total
    }
}

/// Whether an element was not met in this ball before; from now on it was.
fn is_new(met: &mut [u32], index: usize, mark: u32) -> bool {
    core::mem::replace(&mut met[index], mark) != mark
}

impl BallCurvature {
    fn add_vertex(&mut self, mesh: &TriMesh, vertex: VertexId) {
        if !mesh.topology().is_boundary_vertex(vertex) {
            self.gaussian += vertex_integrals(mesh, vertex, VertexArea::Barycentric).angle_defect;
        }
    }

    /// Adds an edge of which so much is inside.
    fn add_edge(&mut self, mesh: &TriMesh, edge: EdgeId, [from, to]: [DVec3; 2], length: f64) {
        let Some(beta) = edge_dihedral_angle(mesh, edge) else { return };
        let along = (to - from).normalize_or_zero();
        self.mean += Integral::new(0.5 * length * beta);
        self.abs_mean += Integral::new(0.5 * length * beta.abs());
        let column = |coordinate: f64| length * beta * coordinate * along;
        self.tensor += DMat3::from_cols(column(along.x), column(along.y), column(along.z));
    }
}

/// The length of the part of a segment inside the unit ball; `None` where it stays outside.
fn part_in_unit_ball([p, q]: [DVec3; 2]) -> Option<f64> {
    let along = q - p;
    let [low, high] = chord(along.length_squared(), p.dot(along), p.length_squared())?;
    Some((high - low) * along.length())
}

/// Where a segment `p + t d` with `dd = d.d`, `pd = p.d`, `pp = p.p` enters the unit ball and leaves
/// it, in parameters from 0 to 1; `None` where it stays outside.
fn chord(dd: f64, pd: f64, pp: f64) -> Option<[f64; 2]> {
    if dd == 0.0 {
        return (pp <= 1.0).then_some([0.0, 1.0]);
    }
    let discriminant = pd * pd - dd * (pp - 1.0);
    let root = (discriminant >= 0.0).then(|| discriminant.sqrt())?;
    let [low, high] = [((-pd - root) / dd).max(0.0), ((root - pd) / dd).min(1.0)];
    (low <= high).then_some([low, high])
}

/// The area of the part of a triangle inside the unit ball: that of its meet with a disk in its
/// plane.
fn area_in_unit_ball(triangle: [DVec3; 3], normal: DVec3) -> f64 {
    let Some(plane) = TangentFrame::of(normal) else { return 0.0 };
    let height = normal.dot(triangle[0]);
    let radius_squared = 1.0 - height * height;
    if radius_squared <= 0.0 {
        return 0.0;
    }
    let radius = radius_squared.sqrt();
    let [a, b, c] = triangle.map(|p| DVec2::new(p.dot(plane.x), p.dot(plane.y)) / radius);
    let area = area_in_unit_disk(a, b) + area_in_unit_disk(b, c) + area_in_unit_disk(c, a);
    radius_squared * area.max(0.0)
}

/// The signed area of the part of the triangle from the origin over `p` and `q` inside the unit
/// disk: triangles where the side is inside, sectors where it is outside.
fn area_in_unit_disk(p: DVec2, q: DVec2) -> f64 {
    let sector = |p: DVec2, q: DVec2| 0.5 * atan2(p.perp_dot(q), p.dot(q));
    let along = q - p;
    match chord(along.length_squared(), p.dot(along), p.length_squared()) {
        None => sector(p, q),
        Some([low, high]) => {
            let (enter, leave) = (p + low * along, p + high * along);
            let before = if low > 0.0 { sector(p, enter) } else { 0.0 };
            let after = if high < 1.0 { sector(leave, q) } else { 0.0 };
            before + 0.5 * enter.perp_dot(leave) + after
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::shapes::SplitMix64;

    #[test]
    fn areas_of_triangles_in_a_ball_agree_with_counting() {
        let mut random = SplitMix64::new(8);
        for _ in 0..40 {
            let mut point =
                || 1.5 * DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
            let [a, b, c] = [point(), point(), point()];
            let cross = (b - a).cross(c - a);
            let area = 0.5 * cross.length();
            let count = 400;
            let mut inside = 0;
            for i in 0..count {
                for j in 0..count {
                    let [s, t] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(count));
                    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                    inside += u32::from((a + s * (b - a) + t * (c - a)).length() < 1.0);
                }
            }
            let expected = area * f64::from(inside) / f64::from(count * count);
            let found = area_in_unit_ball([a, b, c], cross.normalize());
            assert!((found - expected).abs() < 6e-3 * area, "{found} {expected}");
        }
    }
}
