//! From where a picture shows a mesh.

use glam::{DQuat, DVec3};
use mesh_render::Side;

use crate::Up;

/// The directions from which a mesh is seen.
#[derive(Clone, Debug)]
pub enum Toward {
    /// From the model to the camera, in the axes of the model.
    Given(DVec3),
    /// From the front, a little from the right and from above, whichever axis is up.
    Usual,
    /// Sides, which turn with the axis that is up.
    Sides(Vec<Side>),
}

/// What is up in a picture.
#[derive(Clone, Copy, Debug)]
pub enum Upright {
    /// An axis.
    Axis(Up),
    /// A direction in the axes of the model. Nothing turns with it.
    Vector(DVec3),
}

/// One view of a mesh, in the axes of the model.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// From the model to the camera.
    pub toward: DVec3,
    /// Up in the picture.
    pub up: DVec3,
    /// The name of the side, or empty.
    pub name: &'static str,
}

impl Toward {
    /// The usual direction where y is up.
    pub const USUAL: DVec3 = DVec3::new(0.4, 0.3, 1.0);

    /// One view for each direction.
    #[must_use]
    pub fn sights(&self, up: Upright) -> Vec<Sight> {
        let (turn, up) = match up {
            Upright::Axis(up) => (up.turn(), up.axis()),
            Upright::Vector(up) => (DQuat::IDENTITY, up),
        };
        match self {
            Self::Given(toward) => vec![Sight { toward: *toward, up, name: "" }],
            Self::Usual => vec![Sight { toward: turn * Self::USUAL, up, name: "" }],
            Self::Sides(sides) => sides
                .iter()
                .map(|s| Sight { toward: turn * s.toward(), up: turn * s.up(), name: s.name() })
                .collect(),
        }
    }
}
