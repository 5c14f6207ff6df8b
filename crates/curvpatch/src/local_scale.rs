//! Half-lengths of sections from the edges around a face, different in each direction.

use glam::{DMat2, DVec2};
use mesh_core::TriMesh;

use crate::direction::Direction;
use crate::tangent_plane::TangentPlane;

/// An ellipse in the tangent plane whose radii are four edge lengths in each direction.
///
/// Let M be the mean of e eᵀ over the edges e of a face and of its three neighbours, projected to the
/// tangent plane. The half-length in the direction t is 4 √(2 / (tᵀ M⁻¹ t)). For equilateral triangles it is
/// four edge lengths. For triangles that are `a` times longer in one direction, it is `a` times longer in
/// that direction, up to [`MAX_ASPECT`].
pub(crate) struct LocalScale {
    inverse: DMat2,
}

/// Half-length of a section in edge lengths.
const EDGES: f64 = 4.0;

/// The largest ratio of the half-lengths in two directions.
const MAX_ASPECT: f64 = 300.0;

impl LocalScale {
    pub(crate) fn new(mesh: &TriMesh, plane: &TangentPlane) -> Self {
        let topology = mesh.topology();
        let sides = topology.face_half_edges(plane.face);
        let neighbors = sides.iter().filter_map(|side| topology.face(side.twin()));
        let (mut moment, mut count) = (DMat2::ZERO, 0.0);
        for face in neighbors.chain([plane.face]) {
            let [a, b, c] = mesh.triangle(face);
            for edge in [b - a, c - b, a - c] {
                let edge = DVec2::from_array(plane.tangents.map(|tangent| tangent.dot(edge)));
                moment += DMat2::from_cols(edge.x * edge, edge.y * edge);
                count += 1.0;
            }
        }
        let moment = moment * (1.0 / count);
        let trace = moment.x_axis.x + moment.y_axis.y;
        let least = trace / (MAX_ASPECT * MAX_ASPECT);
        Self { inverse: (moment + DMat2::from_diagonal(DVec2::splat(least))).inverse() }
    }

    /// The half-length of the section in a direction.
    pub(crate) fn half_length(&self, direction: &Direction) -> f64 {
        let tangent = DVec2::new(direction.cos, direction.sin);
        EDGES * (2.0 / tangent.dot(self.inverse * tangent)).sqrt()
    }
}
