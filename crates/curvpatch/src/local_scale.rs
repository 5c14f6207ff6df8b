//! Half-lengths of sections from the edges around a face, different in each direction.

use glam::{DMat2, DVec2, DVec3};
use mesh_core::TriMesh;

use crate::direction::Direction;
use crate::principal_fit::extremes;
use crate::tangent_plane::TangentPlane;

/// An ellipse in the tangent plane whose radii are four edge lengths in each direction.
///
/// Let M be the mean of e eᵀ over the edges e of a face and of its three neighbours, projected to the
/// tangent plane. The half-length in the direction t is 4 √(2 / (tᵀ M⁻¹ t)). For equilateral triangles it is
/// four edge lengths. For triangles that are `a` times longer in one direction, it is `a` times longer in
/// that direction, up to [`MAX_ASPECT`].
///
/// Along the edges the mesh is flat, and the surface is not. Where the long edges are bent, four short edges show one
/// flat facet. [`LocalScale::widened`] makes the ellipse wider there.
pub(crate) struct LocalScale {
    /// M.
    moment: DMat2,
}

/// Half-length of a section in edge lengths.
const EDGES: f64 = 4.0;

/// The least half-length of a section in lengths of the edges along the curvature.
///
/// The middle of an edge of length e is κ e²/8 below the surface. So the depth at the end of a section of two edge
/// lengths, κ (2e)²/2, has an error of at most a sixteenth.
const LEAST_EDGES: f64 = 2.0;

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
        Self { moment: moment + DMat2::from_diagonal(DVec2::splat(least)) }
    }

    /// The ellipse with radii of at least [`LEAST_EDGES`] lengths of the edges along the curvature, from estimates
    /// of the principal curvatures with their directions.
    ///
    /// In a principal direction d, this length counts as √(2 dᵀ M d |κ| / max |κ|).
    pub(crate) fn widened(&self, curvatures: [(f64, DVec2); 2]) -> Self {
        let Self { moment } = self;
        let [first, second] = curvatures.map(|(curvature, _)| curvature.abs());
        let share = |(curvature, direction): (f64, DVec2)| {
            curvature.abs() / first.max(second) * direction.dot(*moment * direction)
        };
        let [first, second] = curvatures.map(share);
        // Where there is no curvature, this is NaN, and all moments stay.
        let least = (LEAST_EDGES / EDGES).powi(2) * first.max(second);
        let [along, across] = [moment.x_axis.x, moment.y_axis.y];
        let form = DVec3::new(0.5 * (along + across), 0.5 * (along - across), moment.x_axis.y);
        let [shorter, longer] = extremes(form).map(|(value, axis)| {
            let axis = value.max(least).sqrt() * axis;
            DMat2::from_cols(axis.x * axis, axis.y * axis)
        });
        Self { moment: shorter + longer }
    }

    /// The half-lengths of the sections in some directions.
    pub(crate) fn half_lengths(&self, directions: &[Direction]) -> impl Iterator<Item = f64> {
        let inverse = self.moment.inverse();
        directions.iter().map(move |direction| {
            let tangent = direction.unit();
            EDGES * (2.0 / tangent.dot(inverse * tangent)).sqrt()
        })
    }
}
