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
}

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
        }
    }

    /// Whether each parameter is periodic.
    #[must_use]
    pub(crate) fn is_closed(self) -> [bool; 2] {
        match self {
            Self::Torus | Self::Pipe => [true, true],
            Self::Sphere | Self::Ellipsoid | Self::Cylinder | Self::Cone | Self::Catenoid => {
                [true, false]
            }
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
        let catenoid = Catenoid { waist: 1.0, half_height: 1.0 };
        let p = Surface::Catenoid.point([0.3, 0.4]);
        let [k1, _] = Surface::Catenoid.exact([0.3, 0.4]).principal;
        assert!((k1 - catenoid.principal_curvatures(p).max).abs() < 1e-12);
    }
}
