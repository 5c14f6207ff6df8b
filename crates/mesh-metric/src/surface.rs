//! Surfaces for closest-point queries.

use core::ops::Range;

use glam::DVec3;
use mesh_core::{BoundingBox, FaceId, Handle, Topology, TriMesh, as_u32, parallel};

use crate::bvh::{Bvh, Nearest};
use crate::frame::Frame;

/// Triangles, not necessarily a manifold, with a bounding volume hierarchy for closest-point queries.
///
/// Time: O(n log n) to build; O(log n) per query near the surface.
#[derive(Clone, Debug)]
pub struct Surface {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// The face of each triangle; empty if indices are the same.
    faces: Vec<FaceId>,
    bounding_box: BoundingBox,
    bvh: Bvh,
    /// The same surface at unit size, if products of its coordinates are no numbers. It answers all queries.
    at_unit_size: Option<Box<(Frame, Self)>>,
}

/// Why a surface cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// There are no triangles.
    #[error("the surface has no triangles, so there is no distance to it")]
    Empty,
    /// There are no points.
    #[error("there are no points, so there is no distance from them or to them")]
    NoPoints,
    /// More triangles than 32-bit indices can address.
    #[error("there are {0} triangles, more than 32-bit indices can address; split the surface")]
    TooLarge(usize),
    /// A corner refers to a missing vertex.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are {vertex_count} vertices")]
    IndexOutOfRange {
        /// The triangle.
        triangle: usize,
        /// The index it holds.
        vertex: u32,
        /// The number of vertices.
        vertex_count: usize,
    },
    /// The mesh that a surface should follow has a different number of faces.
    #[error("the mesh has {found} faces but the surface has {count}; make a new surface")]
    OtherFaces {
        /// The number of faces of the surface.
        count: usize,
        /// The number of faces of the mesh.
        found: usize,
    },
    /// A coordinate of a triangle is infinite or not a number.
    #[error("vertex {vertex} is at {position}, which is not finite; remove or correct it")]
    NotFinite {
        /// The vertex.
        vertex: u32,
        /// Its position.
        position: DVec3,
    },
}

/// The closest point of a surface; made by [`Surface::closest`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClosestPoint {
    /// The point on the surface.
    pub point: DVec3,
    /// The vector from the query to the point, with full precision also far from the origin.
    pub offset: DVec3,
    /// The length of the offset.
    pub distance: f64,
    /// A face that the point lies on: the face's handle in the mesh, or the index of the triangle.
    pub face: FaceId,
    /// The index of that face's triangle in [`Surface::triangles`].
    pub triangle: u32,
}

impl ClosestPoint {
    /// The answer for a point, from the answer in a frame.
    fn restored(self, frame: Frame, point: DVec3) -> Self {
        let offset = frame.original_vector(self.offset);
        let distance = frame.original_length(self.distance);
        Self { point: point + offset, offset, distance, ..self }
    }
}

impl Surface {
    /// The surface of a mesh.
    ///
    /// # Errors
    /// The mesh has no faces, or a position is not finite.
    pub fn new(mesh: &TriMesh) -> Result<Self, SurfaceError> {
        let topology = mesh.topology();
        // Exact capacity: with gaps among the faces, iterators do not know their length.
        let mut triangles = Vec::with_capacity(topology.face_count());
        let (positions, faces) = parallel::both(
            || mesh.positions().to_vec(),
            || {
                triangles.extend(topology.triangles());
                faces_of(topology)
            },
        );
        Self::build(positions, triangles, faces)
    }

    /// The surface of triangles that need not form a manifold.
    ///
    /// # Errors
    /// There are no triangles or too many, an index is out of range, or the position of a corner
    /// is not finite.
    pub fn from_triangles<P: Copy + Into<DVec3>>(
        positions: &[P],
        triangles: &[[u32; 3]],
    ) -> Result<Self, SurfaceError> {
        if triangles.len() >= FaceId::LIMIT {
            return Err(SurfaceError::TooLarge(triangles.len()));
        }
        let positions = positions.iter().map(|&p| p.into()).collect();
        Self::build(positions, triangles.to_vec(), Vec::new())
    }

    /// Points as a surface without area: the closest point of it is the nearest of the points.
    ///
    /// # Errors
    /// There are no points or too many, or a position is not finite.
    pub fn of_points<P: Copy + Into<DVec3>>(positions: &[P]) -> Result<Self, SurfaceError> {
        match positions.len() {
            0 => return Err(SurfaceError::NoPoints),
            count if count >= FaceId::LIMIT => return Err(SurfaceError::TooLarge(count)),
            _ => {}
        }
        let triangles: Vec<[u32; 3]> = (0..as_u32(positions.len())).map(|v| [v; 3]).collect();
        Self::from_triangles(positions, &triangles)
    }

    fn build(
        positions: Vec<DVec3>,
        triangles: Vec<[u32; 3]>,
        faces: Vec<FaceId>,
    ) -> Result<Self, SurfaceError> {
        if triangles.is_empty() {
            return Err(SurfaceError::Empty);
        }
        check(&positions, &triangles)?;
        let corners = |t: usize| triangles[t].map(|v| positions[v as usize]);
        let (bvh, bounding_box) = parallel::both(
            || Bvh::new(corners, triangles.len()),
            || bounding_box(&positions, &triangles),
        );
        let mut surface =
            Self { positions, triangles, faces, bounding_box, bvh, at_unit_size: None };
        surface.at_unit_size = surface.scaled();
        Ok(surface)
    }

    /// The number of triangles, at least one.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The positions, indexed by vertex; some may belong to no triangle.
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The triangles as vertex indices.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of a triangle.
    ///
    /// # Panics
    /// When `triangle` is not below [`Surface::triangle_count`].
    #[must_use]
    pub fn triangle(&self, triangle: usize) -> [DVec3; 3] {
        // `map` is not always inlined here, and a call costs more than three loads.
        let [a, b, c] = self.triangles[triangle];
        [self.positions[a as usize], self.positions[b as usize], self.positions[c as usize]]
    }

    /// The vertices that belong to a triangle, in the order of their indices.
    #[must_use]
    pub fn used_vertices(&self) -> Vec<u32> {
        let mut is_used = vec![false; self.positions.len()];
        for &vertex in self.triangles.as_flattened() {
            is_used[vertex as usize] = true;
        }
        let mut used = Vec::with_capacity(is_used.iter().filter(|&&is_used| is_used).count());
        used.extend((0..as_u32(self.positions.len())).filter(|&v| is_used[v as usize]));
        used
    }

    /// The box around the triangles.
    #[must_use]
    pub fn bounding_box(&self) -> BoundingBox {
        self.bounding_box
    }

    /// The point of the surface that is closest to `point`.
    ///
    /// If several faces are equally close, the order of the faces alone decides which one is named. The
    /// distance from a non-finite point is NaN.
    #[must_use]
    pub fn closest(&self, point: DVec3) -> ClosestPoint {
        if let Some((frame, scaled)) = self.at_unit_size.as_deref() {
            return scaled.closest(frame.point(point)).restored(*frame, point);
        }
        self.answer(point, self.nearest(point, 0))
    }

    /// The distance from `point` to the surface, never negative.
    #[must_use]
    pub fn distance(&self, point: DVec3) -> f64 {
        if let Some((frame, scaled)) = self.at_unit_size.as_deref() {
            return frame.original_length(scaled.distance(frame.point(point)));
        }
        self.nearest(point, 0).squared.sqrt()
    }

    /// The distances of many points. Faster than single queries if consecutive points are close together.
    #[must_use]
    pub fn distances(&self, points: &[DVec3]) -> Vec<f64> {
        self.distances_until(points, &|| false).unwrap_or_default()
    }

    /// As [`Surface::distances`], but `None` as soon as `stops` returns true. Any thread calls it about every
    /// thousand points; once true, it must stay true.
    #[must_use]
    pub fn distances_until(
        &self,
        points: &[DVec3],
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Option<Vec<f64>> {
        if let Some(frame) = Frame::of(self.bounding_box(), self.bounding_box())
            && let Some(placed) = self.placed(frame)
        {
            let found = placed.distances_until(&frame.points(points), stops)?;
            return Some(found.into_iter().map(|d| frame.original_length(d)).collect());
        }
        let distances = parallel::concat_blocks(points.len(), |range| {
            if stops() {
                return Vec::new();
            }
            let nearest = self.nearest_to_each(&points[range]).into_iter();
            nearest.map(|nearest| nearest.squared.sqrt()).collect::<Vec<_>>()
        });
        (!stops()).then_some(distances)
    }

    /// Whether no point is farther from the surface than `distance`. Faster than [`Surface::distances`],
    /// because exact distances do not matter and the search ends at the first failure. A non-finite point
    /// counts as farther.
    #[must_use]
    pub fn are_within(&self, points: &[DVec3], distance: f64) -> bool {
        if let Some((frame, scaled)) = self.at_unit_size.as_deref() {
            return scaled.are_within(&frame.points(points), frame.length(distance));
        }
        // Keeps the sign; nothing is within NaN.
        let distance = distance.max(-1.0);
        let squared = distance * distance.abs();
        parallel::holds_in_blocks(points.len(), |range| {
            let points = &points[range];
            let are_finite = points.iter().all(|point| point.is_finite());
            are_finite && self.bvh.are_within(points, squared)
        })
    }

    /// The closest points of many points; any of them if several are equally close. Faster than single queries
    /// if consecutive points are close together.
    #[must_use]
    pub fn closest_points(&self, points: &[DVec3]) -> Vec<ClosestPoint> {
        if let Some((frame, scaled)) = self.at_unit_size.as_deref() {
            let found = scaled.closest_points(&frame.points(points)).into_iter();
            return points.iter().zip(found).map(|(&p, found)| found.restored(*frame, p)).collect();
        }
        self.of_each(points, |point, nearest| self.answer(point, nearest))
    }

    /// As [`Surface::closest_points`], for points that are already in spatial order: each eight consecutive
    /// ones are close together.
    #[must_use]
    pub fn closest_to_neighbours(&self, points: &[DVec3]) -> Vec<ClosestPoint> {
        if let Some((frame, scaled)) = self.at_unit_size.as_deref() {
            let found = scaled.closest_to_neighbours(&frame.points(points)).into_iter();
            return points.iter().zip(found).map(|(&p, found)| found.restored(*frame, p)).collect();
        }
        parallel::concat_blocks(points.len(), |range| {
            let points = &points[range];
            let nearest = self.bvh.nearest_to_neighbours(points).into_iter();
            points.iter().zip(nearest).map(|(&p, n)| self.answer(p, n)).collect::<Vec<_>>()
        })
    }

    /// For each point its closest point, if that is closer than the distance given for it. Faster for small
    /// distances and for consecutive points that are close together. Give one distance per point.
    #[must_use]
    pub fn closer_points(&self, points: &[DVec3], than: &[f64]) -> Vec<Option<ClosestPoint>> {
        if let Some((frame, scaled)) = self.at_unit_size.as_deref() {
            let than: Vec<f64> = than.iter().map(|&length| frame.length(length)).collect();
            let found = scaled.closer_points(&frame.points(points), &than).into_iter();
            return points
                .iter()
                .zip(found)
                .map(|(&p, found)| Some(found?.restored(*frame, p)))
                .collect();
        }
        parallel::concat_blocks(points.len().min(than.len()), |range| {
            let (points, than) = (&points[range.clone()], &than[range]);
            let nearer = self.bvh.nearer_than_each(points, than).into_iter();
            points.iter().zip(nearer).map(|(&p, n)| Some(self.answer(p, n?))).collect::<Vec<_>>()
        })
    }

    /// Whether a triangle is no farther from a point than a distance, up to rounding, and is accepted. Where surfaces lie
    /// on each other, this asks all of them.
    #[must_use]
    pub fn has_within(
        &self,
        point: DVec3,
        distance: f64,
        mut accepts: impl FnMut(usize) -> bool,
    ) -> bool {
        let (point, distance, asked) = match self.at_unit_size.as_deref() {
            Some((frame, scaled)) => (frame.point(point), frame.length(distance), scaled),
            None => (point, distance, self),
        };
        let bvh = &asked.bvh;
        bvh.has_within(point, distance, |slot| accepts(bvh.original(slot) as usize))
    }

    /// The indices of the triangles in spatial order.
    #[must_use]
    pub fn in_space(&self) -> &[u32] {
        self.bvh.in_space()
    }

    /// Refits the surface to a mesh with the same number of faces after vertices moved and edges were flipped.
    /// Time: O(n). Queries get slower the farther faces have moved.
    ///
    /// # Errors
    /// The mesh has a different number of faces, or a position is not finite. The surface is then unchanged.
    pub fn follow(&mut self, mesh: &TriMesh) -> Result<(), SurfaceError> {
        let topology = mesh.topology();
        let (count, found) = (self.triangles.len(), topology.face_count());
        if count != found {
            return Err(SurfaceError::OtherFaces { count, found });
        }
        let triangles: Vec<[u32; 3]> = topology.triangles().collect();
        check(mesh.positions(), &triangles)?;
        self.positions.clear();
        self.positions.extend_from_slice(mesh.positions());
        self.triangles = triangles;
        self.faces = faces_of(topology);
        let (positions, triangles) = (&self.positions, &self.triangles);
        let corners = |t: usize| triangles[t].map(|v| positions[v as usize]);
        self.bvh.follow(corners);
        self.bounding_box = bounding_box(positions, triangles);
        self.at_unit_size = self.scaled();
        Ok(())
    }

    fn of_each<T: Copy + Send>(
        &self,
        points: &[DVec3],
        value: impl Fn(DVec3, Nearest) -> T + Sync,
    ) -> Vec<T> {
        parallel::concat_blocks(points.len(), |range| {
            let points = &points[range];
            let nearest = self.nearest_to_each(points).into_iter();
            points.iter().zip(nearest).map(|(&p, nearest)| value(p, nearest)).collect::<Vec<_>>()
        })
    }

    pub(crate) fn nearest(&self, point: DVec3, hint: u32) -> Nearest {
        self.bvh.nearest(point, hint)
    }

    pub(crate) fn nearest_to_each(&self, points: &[DVec3]) -> Vec<Nearest> {
        self.bvh.nearest_to_each(points)
    }

    /// The surface at unit size, unless it has an ordinary size.
    fn scaled(&self) -> Option<Box<(Frame, Self)>> {
        let frame = Frame::of_size(self.bounding_box)?;
        Some(Box::new((frame, self.placed(frame)?)))
    }

    /// The surface in a frame; `None` if a position is not finite there.
    pub(crate) fn placed(&self, frame: Frame) -> Option<Self> {
        let positions = self.positions.iter().map(|&p| frame.point(p)).collect();
        Self::build(positions, self.triangles.clone(), self.faces.clone()).ok()
    }

    pub(crate) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    fn answer(&self, point: DVec3, nearest: Nearest) -> ClosestPoint {
        let triangle = self.bvh.original(nearest.slot);
        ClosestPoint {
            point: point + nearest.offset,
            offset: nearest.offset,
            distance: nearest.squared.sqrt(),
            face: self.faces.get(triangle as usize).copied().unwrap_or(FaceId::new(triangle)),
            triangle,
        }
    }
}

/// The faces of a mesh with gaps; empty without gaps.
fn faces_of(topology: &Topology) -> Vec<FaceId> {
    let count = topology.face_count();
    let mut faces = Vec::new();
    if count < topology.face_capacity() {
        faces.reserve_exact(count);
        faces.extend(topology.faces());
    }
    faces
}

/// Checks that all corners exist and are finite.
fn check(positions: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), SurfaceError> {
    let check_block = |range: Range<usize>| {
        for triangle in range {
            for vertex in triangles[triangle] {
                let Some(&position) = positions.get(vertex as usize) else {
                    let vertex_count = positions.len();
                    return Err(SurfaceError::IndexOutOfRange { triangle, vertex, vertex_count });
                };
                if !position.is_finite() {
                    return Err(SurfaceError::NotFinite { vertex, position });
                }
            }
        }
        Ok(())
    };
    parallel::per_block(triangles.len(), check_block).into_iter().collect()
}

fn bounding_box(positions: &[DVec3], triangles: &[[u32; 3]]) -> BoundingBox {
    let corners = triangles.as_flattened().iter().map(|&v| positions[v as usize]);
    let empty = BoundingBox { min: DVec3::ZERO, max: DVec3::ZERO };
    BoundingBox::of_points(corners).unwrap_or(empty)
}
