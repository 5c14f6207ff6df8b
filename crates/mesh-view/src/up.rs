//! The axis that points up.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec2, DVec3};
use mesh_core::unit_sized_points;

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

    /// The unit vector that points up.
    #[must_use]
    pub fn axis(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
            Self::MinusX => DVec3::NEG_X,
            Self::MinusY => DVec3::NEG_Y,
            Self::MinusZ => DVec3::NEG_Z,
        }
    }

    /// The rotation that turns the y axis to this one, and with it directions that are named for a y axis that points up.
    #[must_use]
    pub fn turn(self) -> DQuat {
        match self {
            Self::X => DQuat::from_rotation_z(-FRAC_PI_2),
            Self::Y => DQuat::IDENTITY,
            Self::Z => DQuat::from_rotation_x(FRAC_PI_2),
            Self::MinusX => DQuat::from_rotation_z(FRAC_PI_2),
            Self::MinusY => DQuat::from_rotation_z(PI),
            Self::MinusZ => DQuat::from_rotation_x(-FRAC_PI_2),
        }
    }

    /// The upper side of a mesh, as far as its shape and place tell.
    ///
    /// Terrain and other sheets that are seen from one side lie flat, with this side up. The coordinates of surveys are
    /// large, and have their z axis up. An animal or a chair stands on one of its six sides only. `None` for all other
    /// meshes.
    #[must_use]
    pub fn of_shape(positions: &[DVec3], triangles: &[[u32; 3]]) -> Option<Self> {
        /// The share of the area over a plane that must be on one side.
        const MOST: f64 = 0.98;
        let (positions, _) = unit_sized_points(positions);
        let point = |v: u32| positions.get(v as usize).copied().unwrap_or(DVec3::NAN);
        let (mut sum, mut absolute, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corners in triangles {
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
        let axis = |k: usize| (sum[k].abs() >= (2.0 * MOST - 1.0) * absolute[k], absolute[k]);
        let flat = (0..3).filter(|&k| axis(k).0 && 2.0 * absolute[k] > area);
        if let Some(k) = flat.max_by(|&a, &b| axis(a).1.total_cmp(&axis(b).1)) {
            let [up, down] = SIDES[k];
            return Some(if sum[k] > 0.0 { up } else { down });
        }
        let is_survey =
            low.is_finite() && (0.5 * (low + high)).length() > 10.0 * low.distance(high);
        if is_survey {
            return Some(Self::Z);
        }
        let step = triangles.len().div_ceil(MOST_FACES).max(1);
        let some = triangles.iter().step_by(step).map(|corners| corners.map(point));
        standing(&some.filter(|[a, b, c]| (*a + *b + *c).is_finite()).collect::<Vec<_>>())
    }
}

/// Each axis, and against it.
const SIDES: [[Up; 2]; 3] = [[Up::X, Up::MinusX], [Up::Y, Up::MinusY], [Up::Z, Up::MinusZ]];

/// About this number of faces tells how a mesh stands.
const MOST_FACES: usize = 50_000;

/// The upper side of a mesh that stands: its lowest points surround the middle of its surface, and there is no other
/// side on which it would stand half as firmly.
fn standing(triangles: &[[DVec3; 3]]) -> Option<Up> {
    /// Points up to this share of the height above the lowest one touch the ground.
    const GROUND: f64 = 0.03;
    /// The least area between the points that touch the ground, as a share of the area of the shadow from above.
    const LEAST_AREA: f64 = 0.4;
    /// The least distance of the middle from the rim of this area, in side lengths of a square as large as the shadow.
    const LEAST_MARGIN: f64 = 0.1;
    let corners = triangles.as_flattened();
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &[a, b, c] in triangles {
        let size = (b - a).cross(c - a).length();
        sum += size * (a + b + c) / 3.0;
        area += size;
        low = low.min(a).min(b).min(c);
        high = high.max(a).max(b).max(c);
    }
    let middle = sum / area;
    let mut found: Vec<(f64, Option<Up>)> = Vec::new();
    for (k, sides) in SIDES.into_iter().enumerate() {
        // Seen along the axis.
        let plan = |p: DVec3| match k {
            0 => DVec2::new(p.y, p.z),
            1 => DVec2::new(p.z, p.x),
            _ => DVec2::new(p.x, p.y),
        };
        let shadow = doubled_area(&hull(corners.iter().map(|&p| plan(p)).collect()));
        let tall = high[k] - low[k];
        for (side, is_against) in sides.into_iter().zip([false, true]) {
            let height = |p: &&DVec3| if is_against { high[k] - p[k] } else { p[k] - low[k] };
            let lowest = corners.iter().filter(|p| height(p) <= GROUND * tall);
            let base = hull(lowest.map(|&p| plan(p)).collect());
            let margin = margin(&base, plan(middle)) / (0.5 * shadow).sqrt();
            let is_broad = doubled_area(&base) >= LEAST_AREA * shadow;
            if margin.is_finite() {
                found.push((margin, is_broad.then_some(side)));
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let broad = found.iter().position(|(_, side)| side.is_some())?;
    let (margin, side) = found.remove(broad);
    let is_alone = found.first().is_none_or(|(other, _)| *other < 0.5 * margin);
    side.filter(|_| is_alone && margin >= LEAST_MARGIN)
}

/// The convex hull of points in a plane, counter-clockwise.
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull: Vec<DVec2> = Vec::new();
    // The lower half from left to right, then the upper half back.
    let back = points.iter().rev().skip(1);
    let (mut fixed, forth) = (1, points.len());
    for (at, &p) in points.iter().chain(back).enumerate() {
        if at == forth {
            fixed = hull.len();
        }
        while let [.., a, b] = hull[..]
            && hull.len() > fixed
            && (b - a).perp_dot(p - b) <= 0.0
        {
            hull.pop();
        }
        hull.push(p);
    }
    hull.pop();
    hull
}

/// The sides of a polygon.
fn sides(polygon: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(&a, &b)| [a, b])
}

fn doubled_area(polygon: &[DVec2]) -> f64 {
    sides(polygon).map(|[a, b]| a.perp_dot(b)).sum()
}

/// The distance of a point from the nearest side of a convex polygon, negative outside of it.
fn margin(polygon: &[DVec2], point: DVec2) -> f64 {
    if polygon.len() < 3 {
        return f64::NEG_INFINITY;
    }
    let distance = |[a, b]: [DVec2; 2]| (b - a).normalize_or_zero().perp_dot(point - a);
    sides(polygon).map(distance).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::PolygonSoup;
    use mesh_shapes::{Diagonals, Saddle, Sphere};

    fn up(soup: &PolygonSoup, place: impl Fn(DVec3) -> DVec3) -> Option<Up> {
        let positions: Vec<DVec3> = soup.positions().iter().map(|&p| place(p)).collect();
        let triangles: Vec<[u32; 3]> =
            soup.faces().map(|face| [face[0], face[1], face[2]]).collect();
        Up::of_shape(&positions, &triangles)
    }

    /// A table with a lamp: a board on four legs, and a post, each a box.
    fn table() -> PolygonSoup {
        let boxes = [
            ([-1.0, 1.0, -0.7], [1.0, 1.1, 0.7]),
            ([-0.9, 0.0, -0.6], [-0.8, 1.0, -0.5]),
            ([0.8, 0.0, -0.6], [0.9, 1.0, -0.5]),
            ([-0.9, 0.0, 0.5], [-0.8, 1.0, 0.6]),
            ([0.8, 0.0, 0.5], [0.9, 1.0, 0.6]),
            ([-0.05, 1.1, -0.05], [0.05, 1.8, 0.05]),
        ];
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for (low, high) in boxes {
            let first = u32::try_from(positions.len()).unwrap();
            let corner =
                |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] });
            positions.extend((0..8).map(|i| DVec3::from_array(corner(i))));
            let quads = [
                [0, 2, 3, 1],
                [4, 5, 7, 6],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 4, 6, 2],
                [1, 3, 7, 5],
            ];
            for [a, b, c, d] in quads.map(|quad: [u32; 4]| quad.map(|v| first + v)) {
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        PolygonSoup::from_triangles(&positions, &triangles).unwrap()
    }

    #[test]
    fn what_stands_on_one_side_only_stands_upright() {
        let table = table();
        for side in Up::ALL {
            for size in [1.0, 1e-300, 1e-100, 1e100, 1e300] {
                assert_eq!(up(&table, |p| size * (side.turn() * p)), Some(side), "{side:?}");
            }
            assert!((side.turn() * DVec3::Y - side.axis()).length() < 1e-15);
        }
        // A cube stands on each side.
        let cube = Sphere::UNIT.icosphere(0).unwrap();
        assert_eq!(up(&cube, DVec3::signum), None);
    }

    #[test]
    fn a_hull_holds_its_points() {
        let points = |list: &[[f64; 2]]| list.iter().map(|&p| DVec2::from_array(p)).collect();
        let square =
            hull(points(&[[0.5, 0.5], [1.0, 1.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0]]));
        assert_eq!(square, points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) as Vec<DVec2>);
        assert_eq!(doubled_area(&square), 2.0);
        assert_eq!(margin(&square, DVec2::new(0.5, 0.75)), 0.25);
        assert!(margin(&square, DVec2::new(2.0, 0.5)) < 0.0);
        for flat in [&[][..], &[[1.0, 2.0]], &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]] {
            assert_eq!(doubled_area(&hull(points(flat))), 0.0);
            assert_eq!(margin(&hull(points(flat)), DVec2::ZERO), f64::NEG_INFINITY);
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
        for (turn, side) in turns {
            assert_eq!(up(&sheet, turn), Some(side));
        }
        let ball = Sphere::UNIT.icosphere(2).unwrap();
        assert_eq!(up(&ball, |p| p), None);
        let far = DVec3::new(680_000.0, 246_000.0, 400.0);
        assert_eq!(up(&ball, |p| 30.0 * p + far), Some(Up::Z));
        assert_eq!(Up::of_shape(&[], &[]), None);
    }
}
