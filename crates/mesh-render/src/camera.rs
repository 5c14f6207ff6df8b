//! The camera and the projection into the picture.

use glam::{DMat3, DQuat, DVec3};
use mesh_core::{BoundingBox, TriMesh};

/// The direction of the camera and the region in the picture. The projection is orthographic: the same view of two
/// meshes shows them at the same scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// From the model to the camera; of any length.
    pub toward: DVec3,
    /// The upward direction of the picture; need not be at right angles to `toward`.
    pub up: DVec3,
    /// The box that has to fit into the picture.
    pub bounds: BoundingBox,
    /// The tighter extent as seen from one direction; used if it is the current direction.
    frame: Option<Frame>,
}

/// The extent of a mesh as seen from a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Frame {
    toward: DVec3,
    up: DVec3,
    center: DVec3,
    /// Half the extent to the right, up, and towards the camera.
    half: DVec3,
}

/// Right, up and towards the camera, at right angles.
fn axes(toward: DVec3, up: DVec3) -> [DVec3; 3] {
    let toward = toward.normalize_or(DVec3::Z);
    let right = up.cross(toward).normalize_or(toward.any_orthonormal_vector());
    [right, toward.cross(right), toward]
}

impl View {
    /// A view that frames a box.
    #[must_use]
    pub fn of_bounds(bounds: BoundingBox, toward: DVec3, up: DVec3) -> Self {
        Self { toward, up, bounds, frame: None }
    }

    /// A view that frames a mesh tightly from a direction; `None` if the mesh has no vertices.
    #[must_use]
    pub fn of(mesh: &TriMesh, toward: DVec3, up: DVec3) -> Option<Self> {
        let bounds = mesh.bounding_box()?;
        let axes = axes(toward, up);
        let seen = mesh.topology().vertices().map(|v| {
            let p = mesh.position(v) - bounds.center();
            DVec3::from_array(axes.map(|axis| axis.dot(p)))
        });
        let seen = BoundingBox::of_points(seen)?;
        let offset = seen.center();
        let center = bounds.center() + offset.x * axes[0] + offset.y * axes[1] + offset.z * axes[2];
        let frame = Frame { toward, up, center, half: 0.5 * seen.extent() };
        Some(Self { toward, up, bounds, frame: Some(frame) })
    }

    /// The rotation that turns the model so that the camera looks along -z and up is y.
    #[must_use]
    pub fn rotation(&self) -> DQuat {
        let [right, up, toward] = axes(self.toward, self.up);
        DQuat::from_mat3(&DMat3::from_cols(right, up, toward)).inverse()
    }

    /// The same box from another direction.
    #[must_use]
    pub fn from_direction(self, toward: DVec3, up: DVec3) -> Self {
        Self { toward, up, ..self }
    }

    /// A view of a mesh from one of its sides, with y up (z for the top and the bottom).
    #[must_use]
    pub fn of_side(mesh: &TriMesh, side: Side) -> Option<Self> {
        Self::of(mesh, side.toward(), side.up())
    }
}

/// A side of a model whose y axis is up and whose front looks along z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Side {
    /// From +z.
    #[default]
    Front,
    /// From -z.
    Back,
    /// From -x.
    Left,
    /// From +x.
    Right,
    /// From +y.
    Top,
    /// From -y.
    Bottom,
    /// From the corner of all three axes.
    Corner,
}

impl Side {
    /// All sides.
    pub const ALL: &'static [Self] =
        &[Self::Front, Self::Back, Self::Left, Self::Right, Self::Top, Self::Bottom, Self::Corner];

    /// The name, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Back => "back",
            Self::Left => "left",
            Self::Right => "right",
            Self::Top => "top",
            Self::Bottom => "bottom",
            Self::Corner => "corner",
        }
    }

    /// From the model to the camera.
    #[must_use]
    pub fn toward(self) -> DVec3 {
        match self {
            Self::Front => DVec3::Z,
            Self::Back => DVec3::NEG_Z,
            Self::Left => DVec3::NEG_X,
            Self::Right => DVec3::X,
            Self::Top => DVec3::Y,
            Self::Bottom => DVec3::NEG_Y,
            Self::Corner => DVec3::ONE,
        }
    }

    /// The upward direction of the picture.
    #[must_use]
    pub fn up(self) -> DVec3 {
        match self {
            Self::Top => DVec3::NEG_Z,
            Self::Bottom => DVec3::Z,
            _ => DVec3::Y,
        }
    }
}

/// Model coordinates to samples of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) toward: DVec3,
    center: DVec3,
    /// Half the depth, in model units.
    pub(crate) half_depth: f64,
    /// Samples per model unit.
    pub(crate) resolution: f64,
    /// The middle of the picture, in samples.
    middle: [f64; 2],
}

impl Camera {
    /// The camera for a picture with this number of samples. The view fills it except for a margin, given as a share of
    /// the view.
    pub(crate) fn new(view: &View, [width, height]: [u32; 2], margin: f64) -> Self {
        let [right, up, toward] = axes(view.toward, view.up);
        let (center, half) = match view.frame {
            Some(frame) if (frame.toward, frame.up) == (view.toward, view.up) => {
                (frame.center, frame.half)
            }
            _ => {
                let extent = view.bounds.extent();
                let reach = |axis: DVec3| 0.5 * axis.abs().dot(extent);
                (view.bounds.center(), DVec3::new(reach(right), reach(up), reach(toward)))
            }
        };
        let (width, height) = (f64::from(width), f64::from(height));
        let room = 1.0 + margin;
        let half_height = (room * half.y.max(half.x * height / width)).max(f64::MIN_POSITIVE);
        Self {
            right,
            up,
            toward,
            center,
            half_depth: (room * half.z).max(f64::MIN_POSITIVE),
            resolution: (0.5 * height / half_height).min(1e300),
            middle: [0.5 * width, 0.5 * height],
        }
    }

    /// The point in samples from the upper left, and its depth, which is smaller for nearer points.
    pub(crate) fn project(&self, point: DVec3) -> [f64; 3] {
        let p = point - self.center;
        let x = self.middle[0] + self.resolution * p.dot(self.right);
        let y = self.middle[1] - self.resolution * p.dot(self.up);
        [x, y, -p.dot(self.toward) / self.half_depth]
    }

    /// The brightness of a surface with this normal: light from the upper left of the camera and a weaker light from
    /// the right. Both sides of the surface are lit in the same way.
    pub(crate) fn brightness(&self, normal: DVec3) -> f32 {
        let n = if normal.dot(self.toward) < 0.0 { -normal } else { normal };
        let key = (self.toward + 0.6 * self.up - 0.7 * self.right).normalize_or(self.toward);
        let fill = (self.toward + 0.9 * self.right).normalize_or(self.toward);
        (0.22 + 0.62 * n.dot(key).max(0.0) + 0.22 * n.dot(fill).max(0.0)) as f32
    }
}
