//! Parametric surfaces with exact curvature, by automatic differentiation of second order.

use core::ops::{Add, Mul, Sub};

use clap::ValueEnum;
use glam::DVec3;

/// A function of two parameters with its derivatives up to the second order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jet2 {
    value: f64,
    first: [f64; 2],
    /// By `uu`, `uv` and `vv`.
    second: [f64; 3],
}

impl Jet2 {
    fn constant(value: f64) -> Self {
        Self { value, first: [0.0; 2], second: [0.0; 3] }
    }

    fn parameter(value: f64, which: usize) -> Self {
        let mut first = [0.0; 2];
        first[which] = 1.0;
        Self { value, first, second: [0.0; 3] }
    }

    /// A function of this one, with its value and two derivatives there.
    fn map(self, [value, slope, bend]: [f64; 3]) -> Self {
        let [u, v] = self.first;
        let products = [u * u, u * v, v * v];
        Self {
            value,
            first: self.first.map(|d| slope * d),
            second: core::array::from_fn(|i| slope * self.second[i] + bend * products[i]),
        }
    }

    fn sin(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.map([sin, cos, -sin])
    }

    fn cos(self) -> Self {
        let (sin, cos) = self.value.sin_cos();
        self.map([cos, -sin, -cos])
    }

    fn cosh(self) -> Self {
        let (cosh, sinh) = (self.value.cosh(), self.value.sinh());
        self.map([cosh, sinh, cosh])
    }

    fn exp(self) -> Self {
        self.map([self.value.exp(); 3])
    }
}

impl Add for Jet2 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: core::array::from_fn(|i| self.first[i] + other.first[i]),
            second: core::array::from_fn(|i| self.second[i] + other.second[i]),
        }
    }
}

impl Sub for Jet2 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + other * Self::constant(-1.0)
    }
}

impl Mul for Jet2 {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let [au, av] = self.first;
        let [bu, bv] = other.first;
        let cross = [2.0 * au * bu, au * bv + av * bu, 2.0 * av * bv];
        Self {
            value: self.value * other.value,
            first: core::array::from_fn(|i| {
                self.first[i] * other.value + self.value * other.first[i]
            }),
            second: core::array::from_fn(|i| {
                self.second[i] * other.value + self.value * other.second[i] + cross[i]
            }),
        }
    }
}

impl Mul<f64> for Jet2 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self * Self::constant(factor)
    }
}

/// The surfaces of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
pub(crate) enum Surface {
    Sphere,
    Ellipsoid,
    Torus,
    Pipe,
    Cylinder,
    Cone,
    Catenoid,
    Enneper,
    MonkeySaddle,
    Bumps,
    /// A box whose edges and corners are parts of cylinders and spheres, without top and bottom unless it is marched.
    RoundedBox,
}

/// Half of the sides of the box that a ball moves through to make the rounded box.
const CORE: DVec3 = DVec3::new(0.8, 0.5, 0.3);
/// The radius of the ball.
const ROUNDING: f64 = 0.4;
/// The part of a quarter circle above and below the walls that belongs to the rounded box.
const RIM: f64 = 0.9;

/// The exact curvature at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exact {
    /// The principal curvatures, the larger one first, positive where convex seen from the side of the normal.
    pub(crate) principal: [f64; 2],
    /// The direction of the larger one.
    pub(crate) direction: DVec3,
    /// The unit normal.
    pub(crate) normal: DVec3,
}

impl Surface {
    /// The name, as in the command line.
    #[must_use]
    pub(crate) fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Ranges of the two parameters.
    #[must_use]
    pub(crate) fn ranges(self) -> [[f64; 2]; 2] {
        use core::f64::consts::{PI, TAU};
        match self {
            // Bands around the poles are left out, because the parameters are singular there.
            Self::Sphere | Self::Ellipsoid => [[0.0, TAU], [-0.4 * PI, 0.4 * PI]],
            Self::Torus | Self::Pipe => [[0.0, TAU], [0.0, TAU]],
            Self::Cylinder => [[0.0, TAU], [-1.5, 1.5]],
            Self::Cone => [[0.0, TAU], [0.5, 2.0]],
            Self::Catenoid => [[0.0, TAU], [-1.0, 1.0]],
            Self::Enneper => [[-1.2, 1.2], [-1.2, 1.2]],
            Self::MonkeySaddle | Self::Bumps => [[-1.0, 1.0], [-1.0, 1.0]],
            // Arc lengths of the outline of the walls, and of a section from bottom to top.
            Self::RoundedBox => {
                let outline = 4.0 * (CORE.x + CORE.y) + TAU * ROUNDING;
                let height = CORE.z + RIM * 0.5 * PI * ROUNDING;
                [[0.0, outline], [-height, height]]
            }
        }
    }

    /// Whether each parameter is periodic.
    #[must_use]
    pub(crate) fn is_closed(self) -> [bool; 2] {
        match self {
            Self::Torus | Self::Pipe => [true, true],
            Self::Sphere
            | Self::Ellipsoid
            | Self::Cylinder
            | Self::Cone
            | Self::Catenoid
            | Self::RoundedBox => [true, false],
            Self::Enneper | Self::MonkeySaddle | Self::Bumps => [false, false],
        }
    }

    fn jets(self, u: f64, v: f64) -> [Jet2; 3] {
        let (u, v) = (Jet2::parameter(u, 0), Jet2::parameter(v, 1));
        let c = Jet2::constant;
        let torus = |major: f64, minor: f64| {
            let radius = c(major) + v.cos() * minor;
            [radius * u.cos(), radius * u.sin(), v.sin() * minor]
        };
        match self {
            Self::Sphere => [v.cos() * u.cos(), v.cos() * u.sin(), v.sin()],
            Self::Ellipsoid => [v.cos() * u.cos(), v.cos() * u.sin() * 0.8, v.sin() * 0.6],
            Self::Torus => torus(2.0, 0.7),
            Self::Pipe => torus(5.0, 0.4),
            Self::Cylinder => [u.cos(), u.sin(), v],
            Self::Cone => [v * u.cos() * 0.6, v * u.sin() * 0.6, v * -1.0],
            Self::Catenoid => [v.cosh() * u.cos(), v.cosh() * u.sin(), v],
            Self::Enneper => {
                let third = 1.0 / 3.0;
                [
                    u - u * u * u * third + u * v * v,
                    v - v * v * v * third + v * u * u,
                    u * u - v * v,
                ]
            }
            Self::MonkeySaddle => [u, v, (u * u * u - u * v * v * 3.0) * 0.3],
            Self::Bumps => {
                let bump = |x: f64, y: f64, height: f64, width: f64| {
                    let (dx, dy) = (u - c(x), v - c(y));
                    ((dx * dx + dy * dy) * (-0.5 / (width * width))).exp() * height
                };
                let height = bump(-0.4, -0.3, 0.3, 0.25)
                    + bump(0.5, 0.4, -0.25, 0.3)
                    + bump(0.3, -0.5, 0.2, 0.2);
                [u, v, height]
            }
            Self::RoundedBox => {
                let (core, normal) = outline(u);
                let (z, angle) = if v.value.abs() <= CORE.z {
                    (v, c(0.0))
                } else {
                    let end = c(CORE.z.copysign(v.value));
                    (end, (v - end) * (1.0 / ROUNDING))
                };
                let [x, y] = [0, 1].map(|i| core[i] + normal[i] * angle.cos() * ROUNDING);
                [x, y, z + angle.sin() * ROUNDING]
            }
        }
    }

    /// A function that is 0 on the whole surface and negative inside, near a distance. `None` for surfaces with a
    /// boundary.
    #[must_use]
    pub(crate) fn implicit(self) -> Option<fn(DVec3) -> f64> {
        match self {
            Self::Sphere => Some(|p| p.length() - 1.0),
            Self::Ellipsoid => Some(|p| {
                let sides = DVec3::new(1.0, 0.8, 0.6);
                let (q, slope) = ((p / sides).length(), (p / (sides * sides)).length());
                q * (q - 1.0) / slope.max(f64::MIN_POSITIVE)
            }),
            Self::Torus => Some(|p| (p.truncate().length() - 2.0).hypot(p.z) - 0.7),
            Self::Pipe => Some(|p| (p.truncate().length() - 5.0).hypot(p.z) - 0.4),
            Self::RoundedBox => Some(|p| {
                let out = p.abs() - CORE;
                out.max(DVec3::ZERO).length() + out.max_element().min(0.0) - ROUNDING
            }),
            _ => None,
        }
    }

    /// The exact curvature at the point of the whole closed surface that is nearest to a point near it.
    #[must_use]
    pub(crate) fn exact_near(self, p: DVec3) -> Exact {
        use core::f64::consts::FRAC_PI_2;
        match self {
            Self::RoundedBox => of_rounded_box(p),
            Self::Torus | Self::Pipe => {
                let major = if self == Self::Torus { 2.0 } else { 5.0 };
                self.exact([p.y.atan2(p.x), p.z.atan2(p.truncate().length() - major)])
            }
            _ => {
                // Gauss-Newton steps from the parameters of the direction.
                let sides =
                    if self == Self::Sphere { DVec3::ONE } else { DVec3::new(1.0, 0.8, 0.6) };
                let q = p / sides;
                let mut at = [q.y.atan2(q.x), q.z.atan2(q.truncate().length())];
                // Parameters are singular at the poles.
                let limit = FRAC_PI_2 - 1e-6;
                for _ in 0..8 {
                    at[1] = at[1].clamp(-limit, limit);
                    let jets = self.jets(at[0], at[1]);
                    let off = p - DVec3::from_array(jets.map(|jet| jet.value));
                    let [du, dv] = [0, 1].map(|i| DVec3::from_array(jets.map(|jet| jet.first[i])));
                    let [a, b, c] = [du.dot(du), du.dot(dv), dv.dot(dv)];
                    let [e, f] = [off.dot(du), off.dot(dv)];
                    let determinant = a * c - b * b;
                    at[0] += (c * e - b * f) / determinant;
                    at[1] += (a * f - b * e) / determinant;
                }
                self.exact([at[0], at[1].clamp(-limit, limit)])
            }
        }
    }

    /// A point.
    #[must_use]
    pub(crate) fn point(self, [u, v]: [f64; 2]) -> DVec3 {
        DVec3::from_array(self.jets(u, v).map(|jet| jet.value))
    }

    /// The curvature at a point, from the two fundamental forms.
    #[must_use]
    pub(crate) fn exact(self, [u, v]: [f64; 2]) -> Exact {
        let jets = self.jets(u, v);
        let vector = |of: &dyn Fn(&Jet2) -> f64| DVec3::from_array([0, 1, 2].map(|i| of(&jets[i])));
        let [du, dv] = [0, 1].map(|i| vector(&|jet| jet.first[i]));
        let [uu, uv, vv] = [0, 1, 2].map(|i| vector(&|jet| jet.second[i]));
        let normal = du.cross(dv).normalize();
        // An orthonormal basis of the tangent plane, and the second form in it.
        let e = du.normalize();
        let f = normal.cross(e);
        // d/de and d/df in terms of d/du and d/dv.
        let a = 1.0 / du.length();
        let slant = dv.dot(e) / dv.dot(f);
        let (fu, fv) = (-slant * a, 1.0 / dv.dot(f));
        let [l, m, n] = [uu, uv, vv].map(|second| -second.dot(normal));
        let ee = a * a * l;
        let ef = a * (fu * l + fv * m);
        let ff = fu * fu * l + 2.0 * fu * fv * m + fv * fv * n;
        let (mean, half) = (0.5 * (ee + ff), 0.5 * (ee - ff));
        let radius = half.hypot(ef);
        let (sin, cos) = (0.5 * ef.atan2(half)).sin_cos();
        Exact { principal: [mean + radius, mean - radius], direction: cos * e + sin * f, normal }
    }
}

/// A place on the outline of the core of the rounded box, and the normal of the wall there.
fn outline(u: Jet2) -> ([Jet2; 2], [Jet2; 2]) {
    let c = Jet2::constant;
    let corner = core::f64::consts::FRAC_PI_2 * ROUNDING;
    // The walls to +x, +y, -x and -y, each with the corner after it.
    let halves =
        |side: u32| if side.is_multiple_of(2) { [CORE.y, CORE.x] } else { [CORE.x, CORE.y] };
    let length = |side: u32| 2.0 * halves(side)[0] + corner;
    let (mut left, mut side) = (u, 0);
    while side < 3 && left.value >= length(side) {
        left = left - c(length(side));
        side += 1;
    }
    let [half, distance] = halves(side);
    let turn = |x: Jet2, y: Jet2| match side {
        0 => [x, y],
        1 => [y * -1.0, x],
        2 => [x * -1.0, y * -1.0],
        _ => [y, x * -1.0],
    };
    if left.value < 2.0 * half {
        return (turn(c(distance), left - c(half)), turn(c(1.0), c(0.0)));
    }
    let angle = (left - c(2.0 * half)) * (1.0 / ROUNDING);
    (turn(c(distance), c(half)), turn(angle.cos(), angle.sin()))
}

/// The curvature of the rounded box at the point nearest to `p`: flat, part of a cylinder or of a sphere.
fn of_rounded_box(p: DVec3) -> Exact {
    let out = p - p.clamp(-CORE, CORE);
    let normal = out.normalize();
    let bend = 1.0 / ROUNDING;
    let straight = (0..3).filter(|&axis| out[axis] == 0.0);
    let axes: Vec<DVec3> = straight.map(|axis| DVec3::AXES[axis]).collect();
    match axes[..] {
        [] => Exact { principal: [bend, bend], direction: normal.any_orthonormal_vector(), normal },
        [axis] => Exact { principal: [bend, 0.0], direction: axis.cross(normal), normal },
        [first, ..] => Exact { principal: [0.0, 0.0], direction: first, normal },
    }
}

#[cfg(test)]
mod tests {
    use super::Surface;
    use clap::ValueEnum;
    use mesh_shapes::{AnalyticSurface, Catenoid, Cylinder, Sphere, Torus};

    /// The exact values agree with those of the analytic shapes, and minimal surfaces have no mean curvature.
    #[test]
    fn curvatures_are_exact() {
        let shapes: [(Surface, &dyn AnalyticSurface); 3] = [
            (Surface::Sphere, &Sphere::UNIT),
            (Surface::Torus, &Torus { major: 2.0, minor: 0.7 }),
            (Surface::Cylinder, &Cylinder { radius: 1.0, height: 3.0 }),
        ];
        for &surface in Surface::value_variants() {
            let [[u0, u1], [v0, v1]] = surface.ranges();
            for i in 1..20 {
                let t = f64::from(i) / 20.0;
                let at = [u0 + t * (u1 - u0), v0 + (1.0 - t) * (v1 - v0)];
                let (p, exact) = (surface.point(at), surface.exact(at));
                assert!(exact.direction.dot(exact.normal).abs() < 1e-12);
                if matches!(surface, Surface::Catenoid | Surface::Enneper) {
                    let [k1, k2] = exact.principal;
                    assert!((k1 + k2).abs() < 1e-12 && k1 > 0.0, "{surface:?} {k1} {k2}");
                }
                for (_, shape) in shapes.iter().filter(|(other, _)| *other == surface) {
                    let truth = shape.principal_curvatures(p);
                    let [k1, k2] = exact.principal;
                    assert!((k1 - truth.max).abs() + (k2 - truth.min).abs() < 1e-12);
                    assert!(exact.normal.distance(shape.normal(p)) < 1e-12);
                }
            }
        }
        // Marched surfaces: the values at a place agree with the values at its parameters.
        for &surface in Surface::value_variants() {
            let Some(implicit) = surface.implicit() else { continue };
            let [[u0, u1], [v0, v1]] = surface.ranges();
            for i in 1..40 {
                let t = f64::from(i) / 40.0;
                let at = [u0 + t * (u1 - u0), v0 + (0.37 * f64::from(i)).fract() * (v1 - v0)];
                let (p, exact) = (surface.point(at), surface.exact(at));
                assert!(implicit(p).abs() < 1e-12, "{surface:?}: {}", implicit(p));
                let near = surface.exact_near(p + 1e-3 * exact.normal);
                for (k, truth) in near.principal.into_iter().zip(exact.principal) {
                    assert!((k - truth).abs() < 1e-6, "{surface:?} at {at:?}: {k} {truth}");
                }
                assert!(near.normal.distance(exact.normal) < 1e-6);
            }
        }
        let catenoid = Catenoid { waist: 1.0, half_height: 1.0 };
        let p = Surface::Catenoid.point([0.3, 0.4]);
        let [k1, _] = Surface::Catenoid.exact([0.3, 0.4]).principal;
        assert!((k1 - catenoid.principal_curvatures(p).max).abs() < 1e-12);
    }
}
