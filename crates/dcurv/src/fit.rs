//! Curvature of quadratic surfaces fitted to the rings around each vertex.
//!
//! The estimator for values at points. As in [`principal`](crate::principal), the height function over the tangent
//! plane
//!
//! `z = px x + py y + xx x²/2 + xy x y + yy y²/2`
//!
//! through the vertex is fitted to points around it by least squares (the 2-jet of Cazals and Pouget 2005, Estimating
//! differential quantities using polynomial fitting of osculating jets). The principal curvatures and directions are
//! the eigenvalues and eigenvectors of its shape operator at the vertex. Here the points are all vertices of a number
//! of rings. Two rings, about eighteen points for five unknowns, partly average out noise of the positions. More rings
//! reduce noise further, but smooth details that are not larger than the rings.
//!
//! **Convergence.** With points no farther than `h`, the error of the curvatures is `O(h)` at every vertex, for
//! triangles of any shape, and `O(h²)` where the rings tend to point-symmetric ones. The tangent plane may be off by
//! `O(h)` and more: the slopes `px`, `py` are fitted as well.
//!
//! **Boundary.** Rings at the boundary are cut off, and the fit is one-sided: still `O(h)`, with a larger constant.
//! Where two rings have fewer than [`LEAST_POINTS`] points, as at corners, further rings are added until there are
//! enough points or the connected component has no more.
//!
//! **Cost.** The time is proportional to the number of points, about 18 for two rings, 36 for three. At vertices with
//! very many edges the number of points is limited to [`FitOptions::most_points`], so that no mesh takes quadratic
//! time.

use mesh_core::{Handle, TriMesh, VertexId, VertexMap, parallel};

use crate::principal::{PrincipalFrame, fit_frame};

/// The smallest number of points of a fit, if the surface has enough: slightly more than the five unknowns.
pub const LEAST_POINTS: usize = 8;

/// Which points are fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct FitOptions {
    /// The number of rings around the vertex, at least 1. 2 by default.
    pub rings: usize,
    /// No further points are added beyond the first ring once this number is reached. 128 by default.
    pub most_points: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { rings: 2, most_points: 128 }
    }
}

/// The curvatures and principal directions of the quadratic surface fitted at a vertex; see the
/// [module page](self).
///
/// `None` where the points do not determine a quadratic surface, or where the vertex has no normal:
/// at isolated vertices, in pieces of fewer than six vertices, in degenerate triangles.
///
/// # Panics
/// When the vertex is out of range for this mesh.
#[must_use]
pub fn fitted_frame(
    mesh: &TriMesh,
    vertex: VertexId,
    options: &FitOptions,
) -> Option<PrincipalFrame> {
    Rings::new(mesh).fit(mesh, vertex, options)
}

/// [`fitted_frame`] of all vertices; `None` for removed ones, too.
///
/// ```
/// use dcurv::{FitOptions, fitted_frames};
/// use mesh_core::TriMesh;
/// use mesh_shapes::Sphere;
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let sphere = TriMesh::from_soup(&Sphere { radius: 2.0 }.icosphere(4)?)?;
/// for (_, frame) in fitted_frames(&sphere, &FitOptions::default()).iter() {
///     let frame = frame.ok_or("no fit")?;
///     assert!((frame.mean().value() - 0.5).abs() < 0.01);
///     assert!((frame.gaussian().value() - 0.25).abs() < 0.01);
/// }
/// # Ok(())
/// # }
/// ```
#[must_use]
pub fn fitted_frames(mesh: &TriMesh, options: &FitOptions) -> VertexMap<Option<PrincipalFrame>> {
    all_frames(mesh, options, &|| false)
}

/// As [`fitted_frames`], until `stops` returns true; then `None`. Any thread calls `stops` before each vertex. Once
/// true, it must stay true.
#[must_use]
pub fn fitted_frames_until(
    mesh: &TriMesh,
    options: &FitOptions,
    stops: &(dyn Fn() -> bool + Sync),
) -> Option<VertexMap<Option<PrincipalFrame>>> {
    let found = all_frames(mesh, options, stops);
    (!stops()).then_some(found)
}

/// `None` for the vertices after `stops` has returned true.
fn all_frames(
    mesh: &TriMesh,
    options: &FitOptions,
    stops: &(dyn Fn() -> bool + Sync),
) -> VertexMap<Option<PrincipalFrame>> {
    let fit = |rings: &mut Rings, index| {
        if stops() {
            return None;
        }
        rings.fit(mesh, VertexId::from_index(index), options)
    };
    let count = mesh.topology().vertex_capacity();
    VertexMap::from_vec(parallel::collect_with(count, || Rings::new(mesh), fit))
}

/// Memory for the rings around a vertex.
struct Rings {
    /// One more than the index of the last vertex whose rings contained this vertex.
    seen_from: Vec<u32>,
    /// The points, ring after ring.
    points: Vec<VertexId>,
}

impl Rings {
    fn new(mesh: &TriMesh) -> Self {
        Self { seen_from: vec![0; mesh.topology().vertex_capacity()], points: Vec::new() }
    }

    fn fit(
        &mut self,
        mesh: &TriMesh,
        vertex: VertexId,
        options: &FitOptions,
    ) -> Option<PrincipalFrame> {
        self.collect(mesh, vertex, options);
        let origin = mesh.position(vertex);
        let distances = self.points.iter().map(|&v| mesh.position(v).distance(origin));
        let scale = distances.fold(0.0, f64::max);
        fit_frame(mesh, vertex, scale, |add| self.points.iter().for_each(|&v| add(v)))
    }

    /// Collects the vertices of the rings around a vertex.
    fn collect(&mut self, mesh: &TriMesh, vertex: VertexId, options: &FitOptions) {
        let topology = mesh.topology();
        let mark = vertex.get() + 1;
        self.seen_from[vertex.index()] = mark;
        self.points.clear();
        self.points.extend(topology.one_ring(vertex));
        self.points.iter().for_each(|v| self.seen_from[v.index()] = mark);
        let (mut ring, mut start) = (1, 0);
        while ring < options.rings || self.points.len() < LEAST_POINTS {
            let end = self.points.len();
            for i in start..end {
                for neighbour in topology.one_ring(self.points[i]) {
                    if self.points.len() >= options.most_points.max(LEAST_POINTS) {
                        return;
                    }
                    let seen = &mut self.seen_from[neighbour.index()];
                    if *seen != mark {
                        *seen = mark;
                        self.points.push(neighbour);
                    }
                }
            }
            if self.points.len() == end {
                return;
            }
            (ring, start) = (ring + 1, end);
        }
    }
}
