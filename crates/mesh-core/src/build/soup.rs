//! Positions and polygons as a file holds them, without adjacency and unchecked.

use std::borrow::Cow;

use glam::DVec3;

use crate::index::as_u32;
use crate::measure::any_size::unit_sized_points;
use crate::position::{Position, VertexIndex};
use crate::topology::handle::{HalfEdgeId, Handle};

/// A polygon soup: vertex positions, and faces of three or more corners that index them.
///
/// This is what readers produce and what [`crate::build()`] turns into a half-edge mesh. Faces lie
/// one after another in one flat array of *corners*; the position of a corner in that array is
/// its *corner index*, by which callers key data that differs between the faces at a vertex
/// (texture coordinates, normals across a crease).
///
/// A soup may contain anything that a file may: indices out of range, repeated corners, infinite coordinates. Building
/// a mesh refuses or repairs them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonSoup {
    positions: Vec<DVec3>,
    corners: Vec<u32>,
    /// `face_ends[f]` is one past the last corner of face `f`.
    face_ends: Vec<u32>,
}

/// The number of corners or faces from which on there are too many.
const MOST: usize = HalfEdgeId::LIMIT;

/// More corners or faces than a `u32` can count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the mesh has more than 4,294,967,293 corners, which is more than 32-bit indices can address; split it into parts"
)]
pub struct TooManyCorners;

/// Why arrays are not a soup; see [`PolygonSoup::from_parts`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SoupError {
    /// A face ends before it starts.
    #[error("face {face} ends before it starts")]
    FaceEndsEarly {
        /// The face.
        face: usize,
    },
    /// The last face does not end at the last corner.
    #[error("the last face ends at corner {end}, but there are {corners} corners")]
    CornerCount {
        /// Where the last face ends.
        end: u32,
        /// The number of corners.
        corners: usize,
    },
    /// More corners than a `u32` can count.
    #[error(transparent)]
    TooManyCorners(#[from] TooManyCorners),
}

impl PolygonSoup {
    /// An empty soup.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty soup with reserved capacity for vertices, faces and corners.
    #[must_use]
    pub fn with_capacity(vertices: usize, faces: usize, corners: usize) -> Self {
        Self {
            positions: Vec::with_capacity(vertices),
            corners: Vec::with_capacity(corners),
            face_ends: Vec::with_capacity(faces),
        }
    }

    /// A soup of triangles. [Positions](Position) may be of `f32` or `f64`, indices of any
    /// [integer type](VertexIndex).
    ///
    /// # Errors
    /// [`TooManyCorners`] when three times the number of triangles exceeds 32-bit indices.
    pub fn from_triangles<P: Position, I: VertexIndex>(
        positions: &[P],
        triangles: &[[I; 3]],
    ) -> Result<Self, TooManyCorners> {
        let mut soup = Self::with_capacity(positions.len(), triangles.len(), 3 * triangles.len());
        soup.positions.extend(positions.iter().map(Position::to_dvec3));
        for triangle in triangles {
            soup.push_face(triangle)?;
        }
        Ok(soup)
    }

    /// A soup of triangles that are known to be few enough.
    pub(crate) fn of_triangles(
        positions: Vec<DVec3>,
        triangles: impl Iterator<Item = [u32; 3]>,
    ) -> Self {
        let corners = triangles.collect::<Vec<_>>().into_flattened();
        let face_ends = (1..=as_u32(corners.len()) / 3).map(|face| 3 * face).collect();
        Self { positions, corners, face_ends }
    }

    /// A soup from its parts: the positions, the vertex index of every corner, face after face, and for each face one
    /// past its last corner, as returned by [`PolygonSoup::corners`] and [`PolygonSoup::face_ends`].
    ///
    /// # Errors
    /// [`SoupError`] when the ends do not ascend to the number of corners.
    pub fn from_parts(
        positions: Vec<DVec3>,
        corners: Vec<u32>,
        face_ends: Vec<u32>,
    ) -> Result<Self, SoupError> {
        if corners.len().max(face_ends.len()) >= MOST {
            return Err(SoupError::TooManyCorners(TooManyCorners));
        }
        let starts = core::iter::once(&0).chain(&face_ends);
        if let Some(face) = starts.zip(&face_ends).position(|(start, end)| start > end) {
            return Err(SoupError::FaceEndsEarly { face });
        }
        let end = face_ends.last().copied().unwrap_or(0);
        if end as usize != corners.len() {
            return Err(SoupError::CornerCount { end, corners: corners.len() });
        }
        Ok(Self { positions, corners, face_ends })
    }

    /// Appends a vertex; its index is the number of vertices before the call.
    pub fn push_vertex(&mut self, position: impl Position) {
        self.positions.push(position.to_dvec3());
    }

    /// Appends a face with these vertex indices, counter-clockwise seen from outside.
    ///
    /// # Errors
    /// [`TooManyCorners`] when the number of corners or faces would exceed 32-bit indices.
    pub fn push_face<I: VertexIndex>(&mut self, vertices: &[I]) -> Result<(), TooManyCorners> {
        let end = self.corners.len() + vertices.len();
        // Faces without corners count as well.
        if end.max(self.face_ends.len() + 1) >= MOST {
            return Err(TooManyCorners);
        }
        self.corners.extend(vertices.iter().map(|&vertex| vertex.to_u32()));
        self.face_ends.push(as_u32(end));
        Ok(())
    }

    /// The vertex positions.
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// A soup whose coordinates are so large or small that products of them are no numbers, divided by a power of two,
    /// and this power. `None` at ordinary sizes, and if a coordinate has no exact quotient.
    pub(crate) fn at_unit_size(&self) -> Option<(Self, f64)> {
        match unit_sized_points(&self.positions) {
            (Cow::Owned(positions), factor) => Some((Self { positions, ..self.clone() }, factor)),
            (Cow::Borrowed(_), _) => None,
        }
    }

    /// Mutable access to the vertex positions.
    pub fn positions_mut(&mut self) -> &mut Vec<DVec3> {
        &mut self.positions
    }

    /// The vertex index of every corner, face after face.
    #[must_use]
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// For each face, one past its last corner.
    #[must_use]
    pub fn face_ends(&self) -> &[u32] {
        &self.face_ends
    }

    /// The number of vertices, referenced by a face or not.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// The number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.face_ends.len()
    }

    /// The corner indices of a face.
    ///
    /// # Panics
    /// When `face` is not below [`PolygonSoup::face_count`].
    #[must_use]
    pub fn corner_range(&self, face: usize) -> core::ops::Range<usize> {
        let start = if face == 0 { 0 } else { self.face_ends[face - 1] as usize };
        start..self.face_ends[face] as usize
    }

    /// The vertex indices of a face.
    ///
    /// # Panics
    /// When `face` is not below [`PolygonSoup::face_count`].
    #[must_use]
    pub fn face(&self, face: usize) -> &[u32] {
        &self.corners[self.corner_range(face)]
    }

    /// The vertex indices of every face, in order.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = &[u32]> + '_ {
        (0..self.face_count()).map(|face| self.face(face))
    }

    /// The soup with vertices merged: vertex `v` becomes `target[v]`, which must not itself be merged into another
    /// ([`weld_exact`](crate::build::weld_exact) and [`weld_within`](crate::build::weld_within) return such a list).
    /// Faces and corners keep their order, merged vertices are left out, and vertices that `target` does not cover
    /// stay.
    #[must_use]
    pub fn merged(&self, target: &[u32]) -> Self {
        let stays = |v: usize| target.get(v).is_none_or(|&t| t as usize == v);
        let mut renumbered = Vec::with_capacity(self.positions.len());
        let mut positions = Vec::with_capacity(self.positions.len());
        for (v, &position) in self.positions.iter().enumerate() {
            renumbered.push(as_u32(positions.len()));
            if stays(v) {
                positions.push(position);
            }
        }
        let merge = |&v: &u32| {
            let kept = target.get(v as usize).copied().unwrap_or(v);
            // Indices out of range stay out of range.
            renumbered.get(kept as usize).copied().unwrap_or(v)
        };
        Self {
            positions,
            corners: self.corners.iter().map(merge).collect(),
            face_ends: self.face_ends.clone(),
        }
    }
}
