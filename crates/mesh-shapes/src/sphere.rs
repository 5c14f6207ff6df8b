//! The sphere, meshed by longitude and latitude, from the icosahedron, or at random points.

use crate::analytic::{AnalyticSurface, PrincipalCurvatures, SignedDistance};
use crate::error::{ShapeError, at_least, fits, positive};
use crate::irregular::Irregular;
use crate::noise::mean_edge_length;
use crate::polyhedra::{ICOSAHEDRON_FACES, icosahedron_corners};
use core::f64::consts::{PI, TAU};
use glam::DVec3;
use mesh_core::{PolygonSoup, as_u32};
use std::collections::HashMap;

/// The sphere around the origin.
///
/// `point(u, v)` has longitude u and latitude v: r (cos v cos u, cos v sin u, sin v).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The radius.
    pub radius: f64,
}

impl Sphere {
    /// The sphere of radius one.
    pub const UNIT: Self = Self { radius: 1.0 };

    /// Mesh of `bands` bands of latitude and `sectors` sectors of longitude, with a vertex at
    /// each pole: the north pole first, then the circles of latitude southwards, then the south
    /// pole.
    ///
    /// # Errors
    /// A bad radius; fewer than two bands or three sectors.
    pub fn uv_mesh(&self, bands: usize, sectors: usize) -> Result<PolygonSoup, ShapeError> {
        positive("the radius of the sphere", self.radius)?;
        at_least("bands of a sphere", bands, 2)?;
        at_least("sectors of a sphere", sectors, 3)?;
        let triangles = fits((bands - 1).checked_mul(sectors).and_then(|n| n.checked_mul(2)))?;
        let mut soup = PolygonSoup::with_capacity(triangles / 2 + 2, triangles, 3 * triangles);

        soup.push_vertex(self.radius * DVec3::Z);
        for band in 1..bands {
            let (sin, cos) = (PI * band as f64 / bands as f64).sin_cos();
            for sector in 0..sectors {
                let longitude = TAU * sector as f64 / sectors as f64;
                let at = DVec3::new(sin * longitude.cos(), sin * longitude.sin(), cos);
                soup.push_vertex(self.radius * at);
            }
        }
        soup.push_vertex(-self.radius * DVec3::Z);

        let vertex = |band: usize, i: usize| as_u32(1 + (band - 1) * sectors + i % sectors);
        for i in 0..sectors {
            soup.push_face(&[0, vertex(1, i), vertex(1, i + 1)])?;
        }
        for band in 1..bands - 1 {
            for i in 0..sectors {
                let (a, b) = (vertex(band, i), vertex(band + 1, i));
                let (c, d) = (vertex(band + 1, i + 1), vertex(band, i + 1));
                soup.push_face(&[a, b, c])?;
                soup.push_face(&[a, c, d])?;
            }
        }
        let south = as_u32(soup.vertex_count() - 1);
        for i in 0..sectors {
            soup.push_face(&[south, vertex(bands - 1, i + 1), vertex(bands - 1, i)])?;
        }
        Ok(soup)
    }

    /// The icosahedron after `level` steps that cut every triangle into four at its edges' midpoints, projected onto
    /// the sphere: 20 · 4^level triangles. The vertices of a level keep their indices in the next.
    ///
    /// # Errors
    /// A bad radius; a level whose mesh exceeds 32-bit indices (above 13).
    pub fn icosphere(&self, level: u32) -> Result<PolygonSoup, ShapeError> {
        positive("the radius of the sphere", self.radius)?;
        fits(4_usize.checked_pow(level).and_then(|n| n.checked_mul(20)))?;
        let mut points = icosahedron_corners().to_vec();
        let mut faces = ICOSAHEDRON_FACES.to_vec();
        for _ in 0..level {
            faces = split_in_four(&mut points, &faces);
        }
        self.scaled(&points, &faces)
    }

    /// The icosahedron with each triangle cut into `frequency`² by lines parallel to its sides, projected onto the
    /// sphere: 20 · frequency² triangles. The steps between numbers of triangles are finer than the factor of four of
    /// [`Sphere::icosphere`].
    ///
    /// # Errors
    /// A bad radius; a frequency of zero, or one whose mesh exceeds 32-bit indices.
    pub fn geodesic(&self, frequency: usize) -> Result<PolygonSoup, ShapeError> {
        positive("the radius of the sphere", self.radius)?;
        at_least("parts of an edge", frequency, 1)?;
        let triangles = fits(frequency.checked_pow(2).and_then(|n| n.checked_mul(20)))?;
        let mut points = icosahedron_corners().to_vec();
        let mut faces = Vec::with_capacity(triangles);
        let mut edges = HashMap::new();
        for corners in ICOSAHEDRON_FACES {
            split_by_frequency(&mut points, &mut faces, &mut edges, corners, frequency);
        }
        self.scaled(&points, &faces)
    }

    /// The icosphere with every vertex moved randomly and projected back onto the sphere; connectivity as
    /// [`Sphere::icosphere`].
    ///
    /// # Errors
    /// As [`Sphere::icosphere`]; a jitter out of range.
    pub fn irregular_icosphere(
        &self,
        level: u32,
        irregular: Irregular,
    ) -> Result<PolygonSoup, ShapeError> {
        let irregular = irregular.checked()?;
        let mut soup = self.icosphere(level)?;
        let amplitude = irregular.jitter * mean_edge_length(&soup);
        let mut random = irregular.random();
        for point in soup.positions_mut() {
            let shift = DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
            *point = self.closest_point(*point + amplitude * shift);
        }
        Ok(soup)
    }

    /// The convex hull of `points` random points of the sphere, which is their Delaunay
    /// triangulation on it: 2 · points - 4 triangles.
    ///
    /// The points are uniformly distributed: per point, a height z = 2u - 1 and then a longitude
    /// 2πv, with u and v from [`SplitMix64`](mesh_core::SplitMix64). Each triangle starts with its
    /// smallest index, and the triangles are sorted.
    ///
    /// # Errors
    /// A bad radius; fewer than four points; a point too close to others to be a corner of the
    /// hull in double precision (expected from about ten million points on).
    pub fn random_hull(&self, points: usize, seed: u64) -> Result<PolygonSoup, ShapeError> {
        positive("the radius of the sphere", self.radius)?;
        at_least("points on a sphere", points, 4)?;
        fits(points.checked_mul(2))?;
        let mut random = mesh_core::SplitMix64::new(seed);
        let points: Vec<DVec3> = (0..points)
            .map(|_| {
                let z = random.symmetric();
                let longitude = TAU * random.uniform();
                let distance = (1.0 - z * z).sqrt();
                DVec3::new(distance * longitude.cos(), distance * longitude.sin(), z)
            })
            .collect();
        let faces = crate::hull::convex_hull(&points)?;

        let mut used = vec![false; points.len()];
        for &vertex in faces.as_flattened() {
            used[vertex as usize] = true;
        }
        if let Some(vertex) = used.iter().position(|&used| !used) {
            return Err(ShapeError::NotOnHull { vertex: as_u32(vertex) });
        }
        self.scaled(&points, &faces)
    }

    fn scaled(&self, unit: &[DVec3], faces: &[[u32; 3]]) -> Result<PolygonSoup, ShapeError> {
        let mut soup = PolygonSoup::from_triangles(unit, faces)?;
        for point in soup.positions_mut() {
            *point *= self.radius;
        }
        Ok(soup)
    }
}

/// Cuts every face into four; midpoints go to the unit sphere.
fn split_in_four(points: &mut Vec<DVec3>, faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut midpoints = HashMap::with_capacity(3 * faces.len() / 2);
    let mut midpoint = |a: u32, b: u32| {
        *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            as_u32(points.len() - 1)
        })
    };
    let mut split = Vec::with_capacity(4 * faces.len());
    for &[a, b, c] in faces {
        let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
        split.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    split
}

/// Cuts one face into `n`² and appends the vertices that it does not share with the faces before it. `edges` maps an
/// edge (smaller corner first) to the first of its inner vertices, which are numbered from the smaller corner.
fn split_by_frequency(
    points: &mut Vec<DVec3>,
    faces: &mut Vec<[u32; 3]>,
    edges: &mut HashMap<(u32, u32), u32>,
    corners: [u32; 3],
    n: usize,
) {
    let [a, b, c] = corners.map(|corner| points[corner as usize]);
    let mut inner_vertex = |from: u32, to: u32, step: usize| {
        let (low, high, step) = if from < to { (from, to, step) } else { (to, from, n - step) };
        let first = *edges.entry((low, high)).or_insert_with(|| {
            let (p, q) = (points[low as usize], points[high as usize]);
            let first = as_u32(points.len());
            points.extend((1..n).map(|i| (p * (n - i) as f64 + q * i as f64).normalize()));
            first
        });
        first + as_u32(step) - 1
    };
    // Row i is parallel to bc, and has i + 1 vertices; rows are numbered away from a.
    let mut rows: Vec<Vec<u32>> = vec![vec![corners[0]]];
    for i in 1..n {
        let ends =
            [inner_vertex(corners[0], corners[1], i), inner_vertex(corners[0], corners[2], i)];
        rows.push(vec![ends[0], ends[1]]);
    }
    let mut last = vec![corners[1]];
    last.extend((1..n).map(|j| inner_vertex(corners[1], corners[2], j)));
    last.push(corners[2]);
    rows.push(last);
    for (i, row) in rows.iter_mut().enumerate().take(n).skip(2) {
        let first = as_u32(points.len());
        let weights = (1..i).map(|j| [n - i, i - j, j].map(|weight| weight as f64));
        points.extend(weights.map(|[x, y, z]| (a * x + b * y + c * z).normalize()));
        row.splice(1..1, first..first + as_u32(i) - 1);
    }
    for (upper, lower) in rows.iter().zip(&rows[1..]) {
        for (j, &top) in upper.iter().enumerate() {
            faces.push([top, lower[j], lower[j + 1]]);
            if let Some(&right) = upper.get(j + 1) {
                faces.push([top, lower[j + 1], right]);
            }
        }
    }
}

impl AnalyticSurface for Sphere {
    fn point(&self, u: f64, v: f64) -> DVec3 {
        self.radius * DVec3::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin())
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        p.normalize_or(DVec3::Z)
    }

    /// K = 1 / r².
    fn gaussian_curvature(&self, _: DVec3) -> f64 {
        self.radius.powi(-2)
    }

    /// H = 1 / r.
    fn mean_curvature(&self, _: DVec3) -> f64 {
        self.radius.recip()
    }

    fn principal_curvatures(&self, _: DVec3) -> PrincipalCurvatures {
        PrincipalCurvatures::umbilic(self.radius.recip())
    }
}

impl SignedDistance for Sphere {
    fn signed_distance(&self, p: DVec3) -> f64 {
        p.length() - self.radius
    }

    fn closest_point(&self, p: DVec3) -> DVec3 {
        self.radius * self.normal(p)
    }
}
