//! Hole filling: closes boundary loops with triangles.
//!
//! Concave and non-planar boundary loops can be closed as well; the mesh stays an oriented 2-manifold.
//! The vertices of the loop do not move. No edge is made that exists elsewhere in the mesh, and no face. Here vertices
//! at equal positions are one vertex: a mesh that was cut at a non-manifold edge has several copies of the edge, and
//! filling must not add to them. The exception is a loop that passes through one position twice: its new faces can
//! have the same corners. Where such a loop runs around several holes that meet in a vertex,
//! [`TriMesh::fill_holes`] fills each hole by itself.
//!
//! 1. **Short loops** ([`FillOptions::optimal_edges`]) get the triangulation of their vertices with the smallest
//!    maximal bend, also towards the faces around the hole, and among equals the shortest edges: Barequet and Sharir
//!    1995, Filling gaps in the boundary of a polyhedron, with the weight of Liepa 2003, Filling holes in meshes. His
//!    minimal area among equal bends, which decides nothing in a plane, is replaced by minimal length. `n³ / 6` steps
//!    for `n` edges.
//! 2. **Longer loops** are triangulated like polygons ([`Triangulator`]), projected along their mean normal, if the
//!    projection does not cross itself.
//! 3. **Other loops** repeatedly lose the vertex whose neighbours are closest to each other, in `n log n` steps.
//! 4. If all remaining edges exist already, **a new vertex** at the mean of the remaining ones is joined to
//!    them. That is always possible.
//!
//! A hole stays open if this gives a face without area: slits between surfaces that touch are such holes. New faces may
//! cross other parts of the surface: this is not checked. Large holes get no inner vertices, other than by step 4;
//! subdivide or smooth the [new faces](FilledHole::faces) for that.

use core::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, HashMap};

use glam::DVec3;

use crate::build::{Triangulation, Triangulator, position_key};
use crate::edit::pinched_holes::boundary_copies;
use crate::edit::{NoRoom, Ring, RingOrder};
use crate::index::as_u32;
use crate::mesh::TriMesh;
use crate::topology::Topology;
use crate::topology::handle::{FaceId, HalfEdgeId, VertexId};

/// How holes are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct FillOptions {
    /// Largest number of edges of a hole that is filled; for example, to keep the outline of an open surface
    /// open. `None` (the default): all holes are filled.
    pub max_edges: Option<usize>,
    /// Loops up to this number of edges get the optimal triangulation, which takes cubic time. At most 512, 64
    /// by default.
    pub optimal_edges: usize,
}

impl Default for FillOptions {
    fn default() -> Self {
        Self { max_edges: None, optimal_edges: 64 }
    }
}

/// Beyond this the tables of the optimal triangulation are too large.
const MOST_OPTIMAL_EDGES: usize = 512;

/// How a hole was filled; see the [module page](self).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FillMethod {
    /// The optimal triangulation of the loop.
    Optimal,
    /// As a polygon, seen along the mean normal.
    Polygon,
    /// The shortest new edge first.
    ShortestEdge,
}

/// A hole that was filled.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FilledHole {
    /// The half-edge that named the hole; now it has a face.
    pub half_edge: HalfEdgeId,
    /// Number of edges of the hole.
    pub edges: usize,
    /// The method that found its triangles.
    pub method: FillMethod,
    /// The new faces.
    pub faces: Vec<FaceId>,
    /// The new vertex, if the vertices of the loop were not enough.
    pub new_vertex: Option<VertexId>,
}

/// Why a hole cannot be filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FillRefusal {
    /// The half-edge is not in the mesh.
    #[error("{0:?} is not in the mesh")]
    NotInMesh(HalfEdgeId),
    /// The half-edge has a face, so there is no hole.
    #[error("{0:?} has a face, so it is not at a hole")]
    NotAHole(HalfEdgeId),
    /// The loop is the outline of a single face; filling it would make two faces back to back.
    #[error(
        "the hole is the outside of the single {0:?}, filling it would make a pillow of two faces"
    )]
    Pillow(FaceId),
    /// A face elsewhere in the mesh has its corners at the same positions.
    #[error("the hole is where {0:?} is; filling it would double this face")]
    Duplicate(FaceId),
    /// A triangle that closes the hole has no area.
    #[error(
        "the hole has no room for faces: one of them would have no area; join its sides, or remove the faces around it"
    )]
    NoArea,
    /// The hole has more edges than are wanted.
    #[error(
        "the hole has {edges} edges, and holes of more than {limit} stay open; raise this limit to fill it"
    )]
    TooManyEdges {
        /// The edges of the hole.
        edges: usize,
        /// [`FillOptions::max_edges`].
        limit: usize,
    },
    /// The mesh would exceed 32-bit indices.
    #[error("the mesh has as many elements as 32-bit indices can address; compact it first")]
    NoRoom,
}

impl From<NoRoom> for FillRefusal {
    fn from(_: NoRoom) -> Self {
        Self::NoRoom
    }
}

/// The result of filling the holes of a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FillReport {
    /// The holes that were filled.
    pub filled: Vec<FilledHole>,
    /// The holes that stay open, each named by a half-edge, and why.
    pub left: Vec<(HalfEdgeId, FillRefusal)>,
}

impl FillReport {
    /// Names each hole that is left by the first half-edge of its loop. Loops that were divided can be one again.
    fn rename_left(&mut self, topology: &Topology) {
        let mut left: Vec<(HalfEdgeId, FillRefusal)> = Vec::with_capacity(self.left.len());
        let mut reasons: HashMap<HalfEdgeId, FillRefusal> = self.left.drain(..).collect();
        for start in topology.boundary_loops() {
            let why = topology.boundary_loop(start).find_map(|h| reasons.remove(&h));
            left.extend(why.map(|why| (start, why)));
        }
        self.left = left;
    }

    /// The number of new faces.
    #[must_use]
    pub fn new_faces(&self) -> usize {
        self.filled.iter().map(|hole| hole.faces.len()).sum()
    }

    /// The number of new vertices.
    #[must_use]
    pub fn new_vertices(&self) -> usize {
        self.filled.iter().filter(|hole| hole.new_vertex.is_some()).count()
    }
}

/// Filling holes; see [`crate::fill`].
impl TriMesh {
    /// Fills the hole to which an exterior half-edge belongs.
    ///
    /// ```
    /// use mesh_core::TriMesh;
    /// use mesh_core::fill::FillOptions;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// // A pyramid without its base.
    /// let corners = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let sides = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    /// let mut mesh = TriMesh::from_triangles(&corners, &sides)?;
    /// let hole = mesh.topology().boundary_loops()[0];
    /// let filled = mesh.fill_hole(hole, &FillOptions::default())?;
    /// assert_eq!((filled.edges, filled.faces.len()), (4, 2));
    /// assert!(mesh.topology().is_closed());
    /// assert!((mesh.volume() - 4.0 / 3.0).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Vertices at equal positions are found in linearithmic time; [`fill_holes`](Self::fill_holes) does so once for
    /// all holes.
    ///
    /// # Errors
    /// The half-edge does not run along a hole, the hole has more edges than the options allow, or there is a face
    /// with the corners of the hole. The mesh is then as it was.
    pub fn fill_hole(
        &mut self,
        half_edge: HalfEdgeId,
        options: &FillOptions,
    ) -> Result<FilledHole, FillRefusal> {
        self.fill_one(half_edge, options, &mut Copies::new(self))
    }

    fn fill_one(
        &mut self,
        half_edge: HalfEdgeId,
        options: &FillOptions,
        copies: &mut Copies,
    ) -> Result<FilledHole, FillRefusal> {
        let topology = self.topology();
        if !topology.contains_half_edge(half_edge) {
            return Err(FillRefusal::NotInMesh(half_edge));
        }
        if !topology.is_exterior(half_edge) {
            return Err(FillRefusal::NotAHole(half_edge));
        }
        let sides: Vec<HalfEdgeId> = topology.boundary_loop(half_edge).collect();
        let edges = sides.len();
        if let Some(limit) = options.max_edges.filter(|&limit| edges > limit) {
            return Err(FillRefusal::TooManyEdges { edges, limit });
        }
        if let Some(face) = topology.face(half_edge.twin())
            && topology.is_around_face(half_edge)
        {
            return Err(FillRefusal::Pillow(face));
        }
        if let Some(face) = copies.face_at(self, &sides) {
            return Err(FillRefusal::Duplicate(face));
        }
        topology.check_ring(edges)?;
        let outline = Outline::new(self, &sides, copies);
        let Plan { method, tips, left } = outline.plan(options.optimal_edges);
        let centre = left.map(|left| copies.free_position(left, outline.origin));
        if !outline.has_area(&tips, centre) {
            return Err(FillRefusal::NoArea);
        }
        let mut ring = Ring::new(sides);
        let mut faces: Vec<FaceId> =
            tips.into_iter().map(|tip| self.cut_off(&mut ring, tip)).collect();
        let mut new_vertex = None;
        if let Some(centre) = centre {
            copies.added.insert(position_key(centre));
            let (vertex, fan) = self.close_with_fan(&mut ring, centre);
            new_vertex = Some(vertex);
            faces.extend(fan);
        }
        Ok(FilledHole { half_edge, edges, method, faces, new_vertex })
    }

    /// Fills all holes that the options allow, each as [`fill_hole`](Self::fill_hole) does.
    ///
    /// Holes that meet in a vertex are filled each by itself. Building a mesh cuts such a vertex, so that one loop runs
    /// around both holes. Here the copies of the vertex are joined first; the mesh has gaps at the copies that are gone,
    /// see [`compact`](Self::compact). Edges and faces keep their handles.
    ///
    /// ```
    /// use mesh_core::fill::FillOptions;
    /// use mesh_core::{PolygonSoup, Repair, build};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// // An octahedron without two faces that share a corner.
    /// let corners = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
    /// let faces = [[2, 1, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    /// let soup = PolygonSoup::from_triangles(&corners.map(|p| p.map(f64::from)), &faces)?;
    /// let mut mesh = build(&soup, &Repair::lenient())?.mesh;
    /// assert_eq!(mesh.topology().boundary_loops().len(), 1);
    /// let report = mesh.fill_holes(&FillOptions::default());
    /// assert_eq!((report.filled.len(), report.new_faces()), (2, 2));
    /// assert!((mesh.volume() - 4.0 / 3.0).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    pub fn fill_holes(&mut self, options: &FillOptions) -> FillReport {
        let mut report = FillReport::default();
        let joined = self.join_pinched_holes(boundary_copies(self));
        let mut copies = Copies::new(self);
        for hole in self.topology().boundary_loops() {
            match self.fill_one(hole, options, &mut copies) {
                Ok(filled) => report.filled.push(filled),
                Err(refusal) => report.left.push((hole, refusal)),
            }
        }
        if !joined.is_empty() {
            self.cut_open_fans(&joined);
            report.rename_left(self.topology());
        }
        report
    }
}

/// The vertices by position.
struct Copies {
    /// Ascending by position.
    vertices: Vec<([u64; 3], VertexId)>,
    /// The positions of the vertices that were added since.
    added: BTreeSet<[u64; 3]>,
}

impl Copies {
    fn new(mesh: &TriMesh) -> Self {
        let vertices = mesh.topology().vertices().map(|v| (position_key(mesh.position(v)), v));
        let mut vertices: Vec<_> = vertices.collect();
        vertices.sort_unstable();
        Self { vertices, added: BTreeSet::new() }
    }

    /// All vertices at the position of a vertex.
    fn of(&self, mesh: &TriMesh, vertex: VertexId) -> impl Iterator<Item = VertexId> {
        let group = equal_range(&self.vertices, position_key(mesh.position(vertex)));
        group.iter().map(|copy| copy.1)
    }

    /// The first position from a point towards another one, each time by half, that no vertex has. Two holes at one
    /// place would have the same new vertex, and so the same new faces.
    fn free_position(&self, mut point: DVec3, towards: DVec3) -> DVec3 {
        // Halving ends at the other point.
        for _ in 0..64 {
            let key = position_key(point);
            if equal_range(&self.vertices, key).is_empty() && !self.added.contains(&key) {
                break;
            }
            point = point.midpoint(towards);
        }
        point
    }

    /// A face with its corners at the positions of a loop of three edges.
    fn face_at(&self, mesh: &TriMesh, sides: &[HalfEdgeId]) -> Option<FaceId> {
        let &[a, b, c] = sides else { return None };
        let topology = mesh.topology();
        let corners = |vertices: [VertexId; 3]| {
            let mut keys = vertices.map(|v| position_key(mesh.position(v)));
            keys.sort_unstable();
            keys
        };
        let wanted = [a, b, c].map(|h| topology.origin(h));
        let keys = corners(wanted);
        let faces = self.of(mesh, wanted[0]).flat_map(|v| topology.faces_of_vertex(v));
        faces.into_iter().find(|&face| corners(topology.face_vertices(face)) == keys)
    }
}

/// The entries with a key, in a list that ascends by key.
fn equal_range<K: Ord, T>(sorted: &[(K, T)], key: K) -> &[(K, T)] {
    let start = sorted.partition_point(|entry| entry.0 < key);
    let count = sorted[start..].iter().take_while(|entry| entry.0 == key).count();
    &sorted[start..start + count]
}

/// The loop around a hole, by place in the loop.
struct Outline {
    /// Where the loop starts, in model units, and how large it is.
    origin: DVec3,
    scale: f64,
    /// The vertices, from the origin and in units of the scale.
    points: Vec<DVec3>,
    /// The unit normal of the face beyond the edge from each vertex to the next.
    normals: Vec<DVec3>,
    /// Pairs of places at one position or joined by an edge of the mesh, smaller first, ascending.
    joined: Vec<[u32; 2]>,
    /// A triangle of this height has no area: the height is a rounding error of the coordinates.
    resolution: f64,
}

/// The triangles that close a loop.
struct Plan {
    method: FillMethod,
    /// The vertices in the order in which triangles cut them off.
    tips: Vec<u32>,
    /// If vertices are left then, their mean.
    left: Option<DVec3>,
}

impl Outline {
    fn new(mesh: &TriMesh, sides: &[HalfEdgeId], copies: &Copies) -> Self {
        let topology = mesh.topology();
        let vertices: Vec<VertexId> = sides.iter().map(|&h| topology.origin(h)).collect();
        let origin = mesh.position(vertices[0]);
        let offsets = vertices.iter().map(|&v| mesh.position(v) - origin);
        let size = offsets.clone().fold(0.0, |size: f64, p| size.max(p.abs().max_element()));
        let scale = if size > 0.0 && size.is_finite() { size } else { 1.0 };
        let normal = |&h: &HalfEdgeId| {
            topology.face(h.twin()).map_or(DVec3::ZERO, |face| mesh.face_normal(face))
        };
        let mut places: Vec<([u64; 3], u32)> =
            vertices.iter().zip(0..).map(|(&v, i)| (position_key(mesh.position(v)), i)).collect();
        places.sort_unstable();
        let mut joined = Vec::new();
        for (&vertex, i) in vertices.iter().zip(0..) {
            for copy in copies.of(mesh, vertex) {
                for v in topology.one_ring(copy).chain([copy]) {
                    let at_v = equal_range(&places, position_key(mesh.position(v)));
                    joined.extend(at_v.iter().map(|place| [i, place.1]).filter(|[i, j]| i < j));
                }
            }
        }
        joined.sort_unstable();
        let points = offsets.map(|p| p / scale).collect();
        let largest = vertices.iter().map(|&v| mesh.position(v).abs().max_element());
        let resolution = 64.0 * f64::EPSILON * (largest.fold(0.0, f64::max) / scale);
        let normals = sides.iter().map(normal).collect();
        Self { origin, scale, points, normals, joined, resolution }
    }

    /// The triangles by the best method that finds some.
    fn plan(&self, optimal_edges: usize) -> Plan {
        let whole = |method| move |tips| Plan { method, tips, left: None };
        self.best_triangles(optimal_edges)
            .map(whole(FillMethod::Optimal))
            .or_else(|| self.polygon().map(whole(FillMethod::Polygon)))
            .unwrap_or_else(|| self.shortest_first())
    }

    /// Repeatedly cuts off the vertex whose neighbours are closest to each other, until the loop is closed or
    /// all needed edges exist.
    fn shortest_first(&self) -> Plan {
        let mut order = RingOrder::new(self.points.len());
        let mut tips = Vec::with_capacity(self.points.len());
        // The bits of non-negative lengths have the same order as the lengths.
        let candidate = |order: &RingOrder, tip: u32| {
            let [before, after] = order.neighbours(tip);
            let length = self.points[before as usize].distance(self.points[after as usize]);
            Reverse((length.to_bits(), tip, [before, after]))
        };
        let mut queue: BinaryHeap<_> = order.places().map(|tip| candidate(&order, tip)).collect();
        let mut is_cut = vec![false; self.points.len()];
        while let Some(Reverse((_, tip, around))) = queue.pop() {
            let is_current = !is_cut[tip as usize] && order.neighbours(tip) == around;
            if !is_current || (order.left() > 3 && self.is_edge(around)) {
                continue;
            }
            tips.push(tip);
            order.cut(tip);
            is_cut[tip as usize] = true;
            if order.left() == 0 {
                break;
            }
            queue.extend(around.map(|neighbour| candidate(&order, neighbour)));
        }
        let left = (order.left() > 0).then(|| {
            let share = 1.0 / order.left() as f64;
            order.places().map(|i| self.position(i) * share).sum()
        });
        Plan { method: FillMethod::ShortestEdge, tips, left }
    }

    /// Whether all triangles have an area.
    fn has_area(&self, tips: &[u32], centre: Option<DVec3>) -> bool {
        let at = |place: u32| self.points[place as usize];
        let mut order = RingOrder::new(self.points.len());
        for &tip in tips {
            let [before, after] = order.neighbours(tip);
            if self.normal([at(before), at(tip), at(after)]) == DVec3::ZERO {
                return false;
            }
            order.cut(tip);
        }
        let Some(centre) = centre else { return true };
        let centre = (centre - self.origin) / self.scale;
        let next = |place: u32| order.neighbours(place)[1];
        order.places().all(|place| self.normal([at(place), at(next(place)), centre]) != DVec3::ZERO)
    }

    /// The unit normal of a triangle; zero if it has no area.
    fn normal(&self, [a, b, c]: [DVec3; 3]) -> DVec3 {
        let cross = (b - a).cross(c - a);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        if cross.length_squared() <= self.resolution * self.resolution * longest {
            return DVec3::ZERO;
        }
        cross.normalize_or_zero()
    }

    fn position(&self, place: u32) -> DVec3 {
        self.origin + self.scale * self.points[place as usize]
    }

    fn is_edge(&self, [i, j]: [u32; 2]) -> bool {
        self.joined.binary_search(&[i.min(j), i.max(j)]).is_ok()
    }

    /// The order in which ear clipping removes the vertices, if the polygon is simple in its mean plane and
    /// needs no edge that exists.
    fn polygon(&self) -> Option<Vec<u32>> {
        let places: Vec<u32> = (0..as_u32(self.points.len())).collect();
        let mut triangles = Vec::new();
        let quality = Triangulator::default().triangulate(&self.points, &places, &mut triangles);
        let (_, diagonals) = triangles.split_last()?;
        let is_new = |&[before, _, after]: &[u32; 3]| !self.is_edge([before, after]);
        (quality == Triangulation::Proper && diagonals.iter().all(is_new))
            .then(|| triangles.iter().map(|triangle| triangle[1]).collect())
    }

    /// An order of the vertices in which cutting them off gives the optimal triangulation.
    fn best_triangles(&self, most_edges: usize) -> Option<Vec<u32>> {
        let n = self.points.len();
        // Four corners are split along a diagonal, which is not ear clipping.
        if n > most_edges.clamp(4, MOST_OPTIMAL_EDGES) {
            return None;
        }
        let mut best: Vec<Option<Part>> = vec![None; n * n];
        for i in 0..n - 1 {
            best[i * n + i + 1] = Some(Part { normal: self.normals[i], ..Part::default() });
        }
        for length in 2..n {
            for i in 0..n - length {
                let j = i + length;
                let closes = length == n - 1;
                if !closes && self.is_edge([as_u32(i), as_u32(j)]) {
                    continue;
                }
                let parts = (i + 1..j).filter_map(|m| {
                    let (before, after) = (best[i * n + m]?, best[m * n + j]?);
                    let beyond = closes.then(|| self.normals[n - 1]);
                    Some(self.part([i, m, j], before, after, beyond))
                });
                best[i * n + j] = parts.min_by(Part::compare);
            }
        }
        best[n - 1]?;
        let mut tips = Vec::with_capacity(n - 2);
        let mut open = vec![[0, n - 1]];
        while let Some([i, j]) = open.pop() {
            if let Some(part) = best[i * n + j].filter(|_| j > i + 1) {
                tips.push(as_u32(part.tip));
                open.extend([[i, part.tip], [part.tip, j]]);
            }
        }
        tips.reverse();
        Some(tips)
    }

    /// The cost of a triangle together with the parts beyond two of its sides.
    fn part(
        &self,
        [i, m, j]: [usize; 3],
        before: Part,
        after: Part,
        beyond: Option<DVec3>,
    ) -> Part {
        let [a, b, c] = [i, m, j].map(|place| self.points[place]);
        let normal = self.normal([a, b, c]);
        let sharpest = [Some(before.normal), Some(after.normal), beyond]
            .into_iter()
            .flatten()
            .map(|other| bend(normal, other))
            .fold(before.bend.max(after.bend), f64::max);
        let length = before.length + after.length + a.distance(c);
        Part { bend: sharpest, length, normal, tip: m }
    }
}

/// The optimal triangulation of a part of the loop.
#[derive(Clone, Copy, Default)]
struct Part {
    /// The sharpest bend.
    bend: f64,
    /// The sum of the lengths of the new edges.
    length: f64,
    /// The unit normal of the triangle at the edge that ends the part.
    normal: DVec3,
    /// The third corner of that triangle.
    tip: usize,
}

impl Part {
    fn compare(&self, other: &Self) -> core::cmp::Ordering {
        self.bend.total_cmp(&other.bend).then(self.length.total_cmp(&other.length))
    }
}

/// How sharp the bend between two unit normals is: one minus its cosine, from 0 to 2, in steps of 1/1024 (2.5 degrees
/// from flat), so that it does not decide between triangles that are all flat. A triangle without a normal counts as a
/// fold.
fn bend(normal: DVec3, other: DVec3) -> f64 {
    if normal == DVec3::ZERO {
        return 2.0;
    }
    (1024.0 * (1.0 - normal.dot(other))).floor() / 1024.0
}
