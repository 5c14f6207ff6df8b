//! The surfaces of the study: fine meshes and exact formulas.

use glam::{DVec2, DVec3};
use mesh_core::{PolygonSoup, TriMesh};
use mesh_shapes::{AnalyticSurface, Ellipsoid, Irregular, Saddle, SignedDistance, Sphere, Torus};

use xtask_common::Failure;

/// A surface whose distance to any point nearby is known by formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum)]
pub enum Shape {
    /// Of radius 1.
    Sphere,
    /// R = 2, r = 1.
    Torus,
    /// Half axes 1, 0.6 and 0.35.
    Ellipsoid,
    /// z = (x² - y²) / 2 over the square of half width 1, with its boundary.
    Saddle,
    /// All points at the distance 0.3 from a square of half width 1: flat faces, cylindrical rims, and
    /// only the corners are curved both ways.
    Plate,
}

const SPHERE: Sphere = Sphere { radius: 1.0 };
const TORUS: Torus = Torus { major: 2.0, minor: 1.0 };
const ELLIPSOID: Ellipsoid = Ellipsoid { semi_axes: DVec3::new(1.0, 0.6, 0.35) };
const SADDLE: Saddle = Saddle { half_width: 1.0, coefficient: 0.5 };
const PLATE_HALF_WIDTH: f64 = 1.0;
const PLATE_RADIUS: f64 = 0.3;

/// How fine the meshes are that are simplified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fineness {
    /// 300,000 to 500,000 faces.
    Full,
    /// About 20,000 faces.
    Quick,
}

impl Shape {
    /// The name in the table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Torus => "torus",
            Self::Ellipsoid => "ellipsoid",
            Self::Saddle => "saddle patch",
            Self::Plate => "rounded plate",
        }
    }

    /// Whether the limit says something: nowhere a Gaussian curvature of zero on a whole region.
    pub fn has_limit(self) -> bool {
        self != Self::Plate
    }

    /// A fine mesh with its vertices on the surface.
    pub fn mesh(self, fineness: Fineness) -> Result<TriMesh, Failure> {
        let irregular = Irregular { jitter: 0.2, seed: 1 };
        let is_full = fineness == Fineness::Full;
        let level = if is_full { 7 } else { 5 };
        let soup = match self {
            Self::Sphere => SPHERE.irregular_icosphere(level, irregular),
            Self::Torus => {
                let (rings, sides) = if is_full { (600, 300) } else { (140, 70) };
                TORUS.irregular_mesh(rings, sides, irregular)
            }
            Self::Ellipsoid => ELLIPSOID.irregular_icosphere(level, irregular),
            Self::Saddle => {
                let cells = if is_full { 400 } else { 100 };
                SADDLE.irregular_mesh(cells, irregular)
            }
            Self::Plate => SPHERE.irregular_icosphere(level, irregular).map(plate),
        };
        let soup = soup.map_err(Failure::mesh)?;
        TriMesh::from_soup(&soup).map_err(Failure::mesh)
    }

    /// The closest point of the surface, for points near it.
    pub fn closest_point(self, p: DVec3) -> DVec3 {
        match self {
            Self::Sphere => SPHERE.closest_point(p),
            Self::Torus => TORUS.closest_point(p),
            Self::Ellipsoid => closest_on_ellipsoid(ELLIPSOID.semi_axes, p),
            Self::Saddle => closest_on_saddle(p),
            Self::Plate => {
                let core = core_of_plate(p);
                core + PLATE_RADIUS * (p - core).normalize_or(DVec3::Z)
            }
        }
    }

    /// The distance to the surface, for points near it.
    pub fn distance(self, p: DVec3) -> f64 {
        match self {
            Self::Sphere => SPHERE.signed_distance(p).abs(),
            Self::Torus => TORUS.signed_distance(p).abs(),
            Self::Plate => (p.distance(core_of_plate(p)) - PLATE_RADIUS).abs(),
            Self::Ellipsoid | Self::Saddle => p.distance(self.closest_point(p)),
        }
    }

    /// The Gaussian curvature at a point of the surface.
    pub fn gaussian_curvature(self, p: DVec3) -> f64 {
        match self {
            Self::Sphere => SPHERE.gaussian_curvature(p),
            Self::Torus => TORUS.gaussian_curvature(p),
            Self::Ellipsoid => ELLIPSOID.gaussian_curvature(p),
            Self::Saddle => SADDLE.gaussian_curvature(p),
            Self::Plate => {
                let beyond = |x: f64| x.abs() > PLATE_HALF_WIDTH;
                let is_corner = beyond(p.x) && beyond(p.y);
                if is_corner { PLATE_RADIUS.powi(-2) } else { 0.0 }
            }
        }
    }
}

impl std::fmt::Display for Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// The closest point of the square at the core of the plate.
fn core_of_plate(p: DVec3) -> DVec3 {
    let w = PLATE_HALF_WIDTH;
    DVec3::new(p.x.clamp(-w, w), p.y.clamp(-w, w), 0.0)
}

/// Maps the vertices of a sphere to the plate. The sphere is flattened first, so that its top and bottom become the
/// faces; the other parts are spread around the rim.
fn plate(mut sphere: PolygonSoup) -> PolygonSoup {
    for p in sphere.positions_mut() {
        let flat = DVec2::new(p.x, p.y);
        // Maps the disc to the square, along rays.
        let stretch = flat.length() / flat.abs().max_element().max(f64::MIN_POSITIVE);
        let reach = (PLATE_HALF_WIDTH + PLATE_RADIUS) * stretch * flat;
        let above = PLATE_RADIUS * p.z / (1.0 - flat.length_squared().min(0.99)).sqrt().max(0.3);
        *p = Shape::Plate.closest_point(DVec3::new(reach.x, reach.y, above));
    }
    sphere
}

/// The closest point has `x + λ ∇f = p`, so `x_i = a_i² p_i / (a_i² + λ)`, where λ solves
/// `Σ (a_i p_i / (a_i² + λ))² = 1`. Newton's method from the left of the root of this convex, falling
/// function.
fn closest_on_ellipsoid(axes: DVec3, p: DVec3) -> DVec3 {
    let squares = axes * axes;
    let mut lambda = -squares.min_element() + (axes * p).abs().dot(least_axis(axes));
    for _ in 0..60 {
        let ratio = axes * p / (squares + DVec3::splat(lambda));
        let value = ratio.length_squared() - 1.0;
        let slope = -2.0 * (ratio * ratio / (squares + DVec3::splat(lambda))).element_sum();
        let step = value / slope;
        if !step.is_finite() {
            break;
        }
        lambda -= step;
        if step.abs() <= 1e-16 {
            break;
        }
    }
    squares * p / (squares + DVec3::splat(lambda))
}

fn least_axis(axes: DVec3) -> DVec3 {
    let least = axes.min_element();
    DVec3::select(axes.cmple(DVec3::splat(least)), DVec3::ONE, DVec3::ZERO)
}

/// Newton's method for the foot point, from the point below or above.
fn closest_on_saddle(p: DVec3) -> DVec3 {
    let c = SADDLE.coefficient;
    let mut at = DVec2::new(p.x, p.y);
    for _ in 0..30 {
        let height = c * (at.x * at.x - at.y * at.y) - p.z;
        let slope = DVec2::new(2.0 * c * at.x, -2.0 * c * at.y);
        let gradient = at - DVec2::new(p.x, p.y) + height * slope;
        let (xx, yy) = (
            1.0 + slope.x * slope.x + 2.0 * c * height,
            1.0 + slope.y * slope.y - 2.0 * c * height,
        );
        let xy = slope.x * slope.y;
        let step = DVec2::new(yy * gradient.x - xy * gradient.y, xx * gradient.y - xy * gradient.x)
            / (xx * yy - xy * xy);
        if !step.is_finite() {
            break;
        }
        at -= step;
        if step.length() <= 1e-16 {
            break;
        }
    }
    DVec3::new(at.x, at.y, c * (at.x * at.x - at.y * at.y))
}

#[cfg(test)]
mod tests {
    use super::{Fineness, Shape};
    use clap::ValueEnum;
    use glam::DVec3;
    use mesh_core::SplitMix64;

    #[test]
    fn fine_meshes_lie_on_their_surfaces() {
        for &shape in Shape::value_variants() {
            let mesh = shape.mesh(Fineness::Quick).unwrap();
            assert!((15_000..45_000).contains(&mesh.topology().face_count()), "{shape}");
            for v in mesh.topology().vertices() {
                assert!(shape.distance(mesh.position(v)) < 1e-12, "{shape}");
            }
            let longest = mesh.topology().edges().map(|e| {
                let [a, b] = mesh.topology().edge_vertices(e).map(|v| mesh.position(v));
                a.distance(b)
            });
            assert!(longest.fold(0.0, f64::max) < 0.25, "{shape}");
        }
    }

    /// No point of a fine sample is nearer than the closest point, which is at a right angle.
    #[test]
    fn closest_points_are_closest() {
        let mut random = SplitMix64::new(3);
        for &shape in Shape::value_variants() {
            let mesh = shape.mesh(Fineness::Quick).unwrap();
            for _ in 0..40 {
                let index = (random.uniform() * mesh.positions().len() as f64) as usize;
                let shift = DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
                let p = mesh.positions()[index] + 0.05 * shift;
                let closest = shape.closest_point(p);
                assert!(shape.distance(closest) < 1e-12, "{shape}");
                assert!((p.distance(closest) - shape.distance(p)).abs() < 1e-12, "{shape}");
                let nearest = mesh.positions().iter().map(|q| q.distance(p));
                assert!(p.distance(closest) <= nearest.fold(f64::MAX, f64::min) + 1e-12, "{shape}");
            }
        }
    }
}
