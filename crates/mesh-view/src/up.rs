//! The axis that points up.

use glam::DVec3;

use crate::exhibit::Exhibit;

/// The axis of the model that points up at first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Up {
    /// The x axis.
    #[cfg_attr(feature = "serde", serde(rename = "x"))]
    X,
    /// The y axis, as in glTF.
    #[default]
    #[cfg_attr(feature = "serde", serde(rename = "y"))]
    Y,
    /// The z axis, as in CAD, 3D printing and surveying.
    #[cfg_attr(feature = "serde", serde(rename = "z"))]
    Z,
    /// Against the x axis.
    #[cfg_attr(feature = "serde", serde(rename = "-x"))]
    MinusX,
    /// Against the y axis.
    #[cfg_attr(feature = "serde", serde(rename = "-y"))]
    MinusY,
    /// Against the z axis.
    #[cfg_attr(feature = "serde", serde(rename = "-z"))]
    MinusZ,
}

impl Up {
    /// All directions: the three axes, and against them.
    pub const ALL: [Self; 6] =
        [Self::X, Self::Y, Self::Z, Self::MinusX, Self::MinusY, Self::MinusZ];

    /// The name: `x`, `y`, `z`, `-x`, `-y` or `-z`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::MinusX => "-x",
            Self::MinusY => "-y",
            Self::MinusZ => "-z",
        }
    }

    /// The upper side of a mesh, as far as its shape and place tell.
    ///
    /// Terrain and other sheets that are seen from one side lie flat, with this side up. The coordinates of surveys are
    /// large, and have their z axis up. `None` for all other meshes.
    #[must_use]
    pub fn of_shape(exhibit: &Exhibit) -> Option<Self> {
        /// The share of the area over a plane that must be on one side.
        const MOST: f64 = 0.98;
        let point = |v: u32| exhibit.positions.get(v as usize).copied().unwrap_or(DVec3::NAN);
        let (mut sum, mut absolute, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corners in &exhibit.triangles {
            let [a, b, c] = corners.map(point);
            let normal = (b - a).cross(c - a);
            if !normal.is_finite() {
                continue;
            }
            sum += normal;
            absolute += normal.abs();
            area += normal.length();
            low = low.min(a).min(b).min(c);
            high = high.max(a).max(b).max(c);
        }
        // A sheet is seen from one side: along an axis, the projected areas of its faces have one sign.
        let sides = [(Self::X, Self::MinusX), (Self::Y, Self::MinusY), (Self::Z, Self::MinusZ)];
        let axis = |k: usize| (sum[k].abs() >= (2.0 * MOST - 1.0) * absolute[k], absolute[k]);
        let flat = (0..3).filter(|&k| axis(k).0 && 2.0 * absolute[k] > area);
        if let Some(k) = flat.max_by(|&a, &b| axis(a).1.total_cmp(&axis(b).1)) {
            let (up, down) = sides[k];
            return Some(if sum[k] > 0.0 { up } else { down });
        }
        let is_survey =
            low.is_finite() && (0.5 * (low + high)).length() > 10.0 * low.distance(high);
        is_survey.then_some(Self::Z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::PolygonSoup;
    use mesh_shapes::{Diagonals, Saddle, Sphere};

    fn exhibit(soup: &PolygonSoup, place: impl Fn(DVec3) -> DVec3) -> Exhibit {
        let triangle = |face: &[u32]| [face[0], face[1], face[2]];
        Exhibit {
            positions: soup.positions().iter().map(|&p| place(p)).collect(),
            triangles: soup.faces().map(triangle).collect(),
            ..Exhibit::default()
        }
    }

    #[test]
    fn sheets_lie_flat_and_surveys_have_z_up() {
        let saddle = Saddle { coefficient: 0.2, half_width: 1.0 };
        let sheet = saddle.mesh(8, Diagonals::Uniform).unwrap();
        type Turn = fn(DVec3) -> DVec3;
        let turns: [(Turn, Up); 3] = [
            (|p| p, Up::Z),
            (|p| DVec3::new(p.z, p.x, p.y), Up::X),
            (|p| DVec3::new(p.x, -p.y, -p.z), Up::MinusZ),
        ];
        for (turn, up) in turns {
            assert_eq!(Up::of_shape(&exhibit(&sheet, turn)), Some(up));
        }
        let ball = Sphere::UNIT.icosphere(2).unwrap();
        assert_eq!(Up::of_shape(&exhibit(&ball, |p| p)), None);
        let far = DVec3::new(680_000.0, 246_000.0, 400.0);
        assert_eq!(Up::of_shape(&exhibit(&ball, |p| 30.0 * p + far)), Some(Up::Z));
        assert_eq!(Up::of_shape(&Exhibit::default()), None);
    }
}
