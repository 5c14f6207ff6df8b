//! Curvature averaged over balls of a given radius.
//!
//! The curvature measures of Cohen-Steiner and Morvan 2003, Restricted Delaunay triangulations and normal
//! cycle. For the part `B` of the surface inside a ball:
//!
//! - Gaussian curvature: the sum of the angle defects of the vertices in `B`;
//! - mean curvature: `1/2 sum of |e ∩ B| beta(e)` over the edges, with signed dihedral angles;
//! - the tensor `sum of |e ∩ B| beta(e) ē ēᵀ`, with the unit vectors `ē` along the edges. In the tangent
//!   plane it has the eigenvalues of the curvature tensor with exchanged principal directions, because a
//!   surface bends across an edge and not along it.
//!
//! Edges and triangles are cut exactly at the ball. Divided by the area of `B`, these are averages over
//! the ball. They converge to the pointwise values of a smooth surface if the radius tends to zero and the
//! edge length tends to zero faster. With a radius of several edge lengths they hardly depend on noise and
//! on the triangulation; details smaller than the radius disappear.
//!
//! `B` is the part that is connected to the centre inside the ball. Another sheet of the surface inside the
//! ball does not count. (A geodesic disc of the same radius differs by the cube of the radius.)
//!
//! **Boundary.** `B` ends at the boundary. Boundary edges have no dihedral angle, and the angle defects of
//! boundary vertices are omitted, because they belong to the boundary curve. The values are averages over
//! the part of the ball that exists; their error is of first order in the radius.
//!
//! **Cost.** The time per vertex is proportional to the number of faces in the ball, about `7 k²` for a
//! radius of `k` edge lengths. [`default_ball_radius`] bounds this number. The results have the same bits
//! for any number of threads. [Principal directions](BallCurvature::principal) use the sine and arc tangent
//! of the platform and can depend on it.

use glam::{DMat3, DVec3};
use mesh_core::{EdgeMap, Handle, TriMesh, VertexId, VertexMap, parallel};

use crate::area::VertexArea;
use crate::ball_faces::{BallFaces, is_new};
use crate::edge::{dihedral_angles, edge_dihedral_angle};
use crate::principal::{Axes, PrincipalFrame, TangentFrame};
use crate::quantity::{Area, Integral, Pointwise};
use crate::star::vertex_integrals;
use crate::vertex_loop::of_vertices;

/// Integrals over the part of a surface inside a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BallCurvature {
    /// The area.
    pub area: Area,
    /// Gaussian curvature, in radians.
    pub gaussian: Integral,
    /// Mean curvature, signed, positive where convex, in model units.
    pub mean: Integral,
    /// Absolute dihedral angles, `1/2 sum of |e ∩ B| |beta(e)|`, in model units.
    pub abs_dihedral: Integral,
    /// The curvature tensor, in model units; its trace is twice `mean`.
    pub tensor: DMat3,
    /// The vector area: the sum of area times normal over the faces, in squared model units.
    pub normal_area: DVec3,
}

/// All zero. (The default matrix of `glam` is the identity.)
impl Default for BallCurvature {
    fn default() -> Self {
        Self {
            area: Area::default(),
            gaussian: Integral::default(),
            mean: Integral::default(),
            abs_dihedral: Integral::default(),
            tensor: DMat3::ZERO,
            normal_area: DVec3::ZERO,
        }
    }
}

/// A radius that is not positive and finite.
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
    /// The average of the Gaussian curvature over the ball, in 1 / length².
    #[must_use]
    pub fn gaussian(&self) -> Pointwise {
        self.gaussian / self.area
    }

    /// The average of the mean curvature over the ball, positive where convex, in 1 / length.
    #[must_use]
    pub fn mean(&self) -> Pointwise {
        self.mean / self.area
    }

    /// `1/2 sum of |e ∩ B| |beta(e)|` per area, per model unit.
    #[must_use]
    pub fn abs_dihedral(&self) -> Pointwise {
        self.abs_dihedral / self.area
    }

    /// The principal curvatures and directions of the tensor in the plane orthogonal to the mean normal. `None` without
    /// area or mean normal.
    #[must_use]
    pub fn principal(&self) -> Option<PrincipalFrame> {
        let plane = TangentFrame::of(self.normal_area.normalize_or_zero())?;
        let entry = |s: DVec3, t: DVec3| s.dot(self.tensor * t) / self.area.value();
        let form = [entry(plane.x, plane.x), entry(plane.x, plane.y), entry(plane.y, plane.y)];
        let axes = Axes::of(form);
        // Across the edges with the largest bend.
        plane.principal(Axes { cos: -axes.sin, sin: axes.cos, ..axes })
    }
}

/// The integrals over the part of the surface inside the ball around a vertex. All zero for isolated
/// vertices.
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
    Ok(Ball::new(mesh, None).integrate(vertex, radius))
}

/// [`ball_curvature`] of all vertices; zero for removed vertices.
///
/// ```
/// use mesh_core::TriMesh;
/// use mesh_shapes::Sphere;
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

/// As [`ball_curvatures`], until `stops` returns true; then `None`. Any thread calls `stops` before each
/// vertex. Once true, it must stay true.
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

/// Zero for the vertices after `stops` has returned true.
fn all_balls(
    mesh: &TriMesh,
    radius: f64,
    stops: &(dyn Fn() -> bool + Sync),
) -> VertexMap<BallCurvature> {
    let angles = Angles::of(mesh);
    let ball = || Ball::new(mesh, Some(&angles));
    of_vertices(mesh, stops, ball, |ball, vertex| ball.integrate(vertex, radius))
}

/// Four mean edge lengths, or less where balls of that radius contain very many faces. 0 without edges.
///
/// The radius is halved until balls around 64 vertices, evenly spaced by index, contain at most 1,000 faces
/// on average. A mesh with edges of similar length has about 110 faces per ball, and its radius is not
/// reduced. Long edges beside small faces, as in triangulated CAD parts, would otherwise make the time
/// quadratic in the number of faces. In a mesh with a vertex of 1,024 edges or more, balls contain at most 400 faces
/// on average, because a ball cuts through most of the faces around such a vertex.
#[must_use]
pub fn default_ball_radius(mesh: &TriMesh) -> f64 {
    const EDGES: f64 = 4.0;
    const MAX_HALVINGS: usize = 20;
    const CROWDED: usize = 1024;
    let mut radius = EDGES * mesh.mean_edge_length().unwrap_or(0.0);
    let mut ball = Ball::new(mesh, None);
    let topology = mesh.topology();
    let is_crowded = |v| topology.outgoing(v).nth(CROWDED - 1).is_some();
    let most = if topology.vertices().any(is_crowded) { 400 } else { 1000 };
    for _ in 0..MAX_HALVINGS {
        if check(radius).is_err() || ball.has_few_faces(radius, most) {
            break;
        }
        radius *= 0.5;
    }
    radius
}

pub(crate) fn check(radius: f64) -> Result<(), InvalidRadius> {
    if radius.is_finite() && radius > 0.0 { Ok(()) } else { Err(InvalidRadius(radius)) }
}

/// Angles of all edges and vertices. A ball needs many of them, and a vertex is in many balls.
struct Angles {
    dihedral: EdgeMap<Option<f64>>,
    defects: VertexMap<Integral>,
}

impl Angles {
    fn of(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let defects = parallel::collect(topology.vertex_capacity(), |index| {
            let vertex = VertexId::from_index(index);
            if topology.contains_vertex(vertex) {
                angle_defect(mesh, vertex)
            } else {
                Integral::default()
            }
        });
        Self { dihedral: dihedral_angles(mesh), defects: VertexMap::from_vec(defects) }
    }
}

fn angle_defect(mesh: &TriMesh, vertex: VertexId) -> Integral {
    vertex_integrals(mesh, vertex, VertexArea::Barycentric).angle_defect
}

/// Integrates over balls. Its arrays contain, for each element, one more than the index of the centre of the ball in
/// which the element was visited last.
struct Ball<'a> {
    mesh: &'a TriMesh,
    angles: Option<&'a Angles>,
    vertices: Vec<u32>,
    edges: Vec<u32>,
    faces: BallFaces<'a>,
    /// Number of faces visited so far, in all balls.
    visited: usize,
}

impl<'a> Ball<'a> {
    fn new(mesh: &'a TriMesh, angles: Option<&'a Angles>) -> Self {
        let topology = mesh.topology();
        Self {
            mesh,
            angles,
            vertices: vec![0; topology.vertex_capacity()],
            edges: vec![0; topology.edge_capacity()],
            faces: BallFaces::new(mesh),
            visited: 0,
        }
    }

    /// Whether balls around 64 vertices contain at most `most` faces on average.
    fn has_few_faces(&mut self, radius: f64, most: usize) -> bool {
        const SAMPLES: usize = 64;
        let topology = self.mesh.topology();
        let stride = (topology.vertex_capacity() / SAMPLES).max(1);
        let vertices = (0..topology.vertex_capacity()).step_by(stride).map(VertexId::from_index);
        let (before, mut samples) = (self.visited, 0);
        // Marks of an earlier radius must not hide faces.
        self.clear();
        for vertex in vertices.filter(|&vertex| topology.contains_vertex(vertex)) {
            self.integrate(vertex, radius);
            samples += 1;
            if self.visited - before > most * SAMPLES {
                return false;
            }
        }
        self.visited - before <= most * samples
    }

    fn clear(&mut self) {
        self.vertices.fill(0);
        self.edges.fill(0);
        self.faces.clear();
    }

    fn integrate(&mut self, vertex: VertexId, radius: f64) -> BallCurvature {
        let Self { mesh, angles, ref mut vertices, ref mut edges, .. } = *self;
        let topology = mesh.topology();
        let mark = vertex.get() + 1;
        let mut total = BallCurvature::default();
        let mut visited = 0;
        self.faces.visit(vertex, radius, &mut |face| {
            visited += 1;
            total.area += Area::new(face.area);
            total.normal_area += face.area * face.normal;
            for (v, p) in face.corners.into_iter().zip(face.points) {
                if p.length_squared() <= 1.0
                    && is_new(vertices, v.index(), mark)
                    && !topology.is_boundary_vertex(v)
                {
                    total.gaussian +=
                        angles.map_or_else(|| angle_defect(mesh, v), |angles| angles.defects[v]);
                }
            }
            for &(h, ends, inside) in face.edges.iter().flatten() {
                let edge = h.edge();
                if is_new(edges, edge.index(), mark) {
                    let angle = match angles {
                        Some(angles) => angles.dihedral[edge],
                        None => edge_dihedral_angle(mesh, edge),
                    };
                    total.add_edge(angle, ends, radius * inside);
                }
            }
        });
        self.visited += visited;
        total
    }
}

impl BallCurvature {
    /// Adds an edge with a dihedral angle; `length` is the length of its part inside. Boundary edges have no angle.
    fn add_edge(&mut self, angle: Option<f64>, [from, to]: [DVec3; 2], length: f64) {
        let Some(beta) = angle else { return };
        let along = (to - from).normalize_or_zero();
        self.mean += Integral::new(0.5 * length * beta);
        self.abs_dihedral += Integral::new(0.5 * length * beta.abs());
        let column = |coordinate: f64| length * beta * coordinate * along;
        self.tensor += DMat3::from_cols(column(along.x), column(along.y), column(along.z));
    }
}
