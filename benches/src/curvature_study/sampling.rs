//! Meshes of surfaces: regular, irregular, graded and stretched grids, and marching cubes.

use clap::ValueEnum;
use glam::DVec3;
use isosurface::MarchingCubes;
use isosurface::distance::Signed;
use isosurface::extractor::IndexedVertices;
use isosurface::math::Vec3;
use isosurface::sampler::Sample;
use mesh_core::{PolygonSoup, SplitMix64};
use spade::{DelaunayTriangulation, Point2, Triangulation};

use super::surfaces::{Exact, Surface};
use xtask_common::Failure;

/// How a surface is meshed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
pub(crate) enum Sampling {
    /// A grid with edges of similar length in both directions.
    Regular,
    /// Moved vertices, random diagonals.
    Irregular,
    /// Random points, one per cell of a grid, with the Delaunay triangulation of their parameters.
    Delaunay,
    /// A vertex in every triangle: valences 3 and 12.
    Split,
    /// Sizes from 1 to 20.
    Graded,
    /// Edges along the first parameter five times longer.
    Along5,
    /// Twelve times longer.
    Along12,
    /// Twenty-five times longer.
    Along25,
    /// Fifty times longer.
    Along50,
    /// Edges along the second parameter twelve times longer.
    Across12,
    /// A grid whose edges leave the surface equally far in both directions, as CAD programs make it.
    Chords,
    /// Marching cubes, on surfaces without a boundary.
    Marching,
}

impl Sampling {
    /// The name, as in the command line.
    #[must_use]
    pub(crate) fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether a surface can be meshed in this way.
    #[must_use]
    pub(crate) fn fits(self, surface: Surface) -> bool {
        self != Self::Marching || surface.implicit().is_some()
    }

    /// How much longer edges along the first parameter are.
    fn aspect(self, surface: Surface) -> f64 {
        match self {
            Self::Chords => chord_aspect(surface),
            Self::Along5 => 5.0,
            Self::Along12 => 12.0,
            Self::Along25 => 25.0,
            Self::Along50 => 50.0,
            Self::Across12 => 1.0 / 12.0,
            _ => 1.0,
        }
    }
}

/// A mesh and the truth at its vertices.
pub(crate) struct Sampled {
    pub(crate) soup: PolygonSoup,
    pub(crate) exact: Vec<Exact>,
}

/// The distance between a chord and its arc grows with the curvature times the square of its length.
fn chord_aspect(surface: Surface) -> f64 {
    const STEPS: u32 = 20;
    const MOST: f64 = 200.0;
    const STEP: f64 = 1e-4;
    let [us, vs] = surface.ranges();
    let at = |[low, high]: [f64; 2], i: u32| low + (high - low) * f64::from(i) / f64::from(STEPS);
    let mut largest = [0.0_f64; 2];
    for (i, j) in (1..STEPS).flat_map(|i| (1..STEPS).map(move |j| (i, j))) {
        let [u, v] = [at(us, i), at(vs, j)];
        let exact = surface.exact([u, v]);
        for (largest, [du, dv]) in largest.iter_mut().zip([[STEP, 0.0], [0.0, STEP]]) {
            let along = (surface.point([u + du, v + dv]) - surface.point([u, v])).normalize();
            let cosine = along.dot(exact.direction).powi(2).min(1.0);
            let [k1, k2] = exact.principal;
            *largest = largest.max((cosine * k1 + (1.0 - cosine) * k2).abs());
        }
    }
    (largest[1] / largest[0]).sqrt().clamp(1.0 / MOST, MOST)
}

/// The length of a surface along each parameter, through the middle.
fn lengths(surface: Surface) -> [f64; 2] {
    const STEPS: u32 = 200;
    let [us, vs] = surface.ranges();
    let at = |[low, high]: [f64; 2], i: u32| low + (high - low) * f64::from(i) / f64::from(STEPS);
    let [u, v] = [us, vs].map(|[low, high]| 0.5 * (low + high));
    let length = |point: &dyn Fn(u32) -> [f64; 2]| {
        (0..STEPS).map(|i| surface.point(point(i)).distance(surface.point(point(i + 1)))).sum()
    };
    [length(&|i| [at(us, i), v]), length(&|i| [u, at(vs, i)])]
}

/// A mesh with about this number of vertices.
pub(crate) fn sample(
    surface: Surface,
    sampling: Sampling,
    vertices: usize,
) -> Result<Sampled, Failure> {
    const JITTER: f64 = 0.2;
    if let (Sampling::Marching, Some(implicit)) = (sampling, surface.implicit()) {
        return march(surface, implicit, vertices);
    }
    let [length_u, length_v] = lengths(surface);
    let is_split = sampling == Sampling::Split;
    let cells = vertices as f64 / if is_split { 3.0 } else { 1.0 };
    let ratio = length_u / (length_v * sampling.aspect(surface));
    let closed = surface.is_closed();
    // At least eight cells around, four along an open direction.
    let count =
        |wanted: f64, is_closed: bool| (wanted.round() as usize).max(if is_closed { 8 } else { 4 });
    let nu = count((cells * ratio).sqrt(), closed[0]);
    let nv = count(cells / nu as f64, closed[1]);
    let mut random = SplitMix64::new(5);
    if sampling == Sampling::Delaunay {
        let (places, triangles) = delaunay([nu, nv], closed, &mut random)?;
        return at_places(surface, sampling, [nu, nv], &places, &triangles);
    }
    let columns = if closed[0] { nu } else { nu + 1 };
    let rows = if closed[1] { nv } else { nv + 1 };
    let is_irregular = sampling == Sampling::Irregular;
    let mut places = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let mut place = [column as f64, row as f64];
            if is_irregular {
                let shift = [random.symmetric(), random.symmetric()].map(|s| JITTER * s);
                let is_border = [
                    !closed[0] && (column == 0 || column == nu),
                    !closed[1] && (row == 0 || row == nv),
                ];
                for axis in 0..2 {
                    if !is_border[axis] {
                        place[axis] += shift[axis];
                    }
                }
            }
            places.push(place);
        }
    }
    let mut triangles = Vec::new();
    for row in 0..nv {
        for column in 0..nu {
            let at = |c: usize, r: usize| (r % rows) * columns + c % columns;
            let [a, b] = [at(column, row), at(column + 1, row)];
            let [d, c] = [at(column, row + 1), at(column + 1, row + 1)];
            let is_first = !is_irregular || random.uniform() < 0.5;
            triangles.extend(if is_first {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            });
        }
    }
    if is_split {
        let period = [nu as f64, nv as f64];
        for corners in core::mem::take(&mut triangles) {
            let first = places[corners[0]];
            let mut middle = [0.0; 2];
            for corner in corners {
                for axis in 0..2 {
                    let mut place = places[corner][axis];
                    // Over the seam of a closed direction.
                    if closed[axis] && place - first[axis] < -0.5 * period[axis] {
                        place += period[axis];
                    }
                    if closed[axis] && place - first[axis] > 0.5 * period[axis] {
                        place -= period[axis];
                    }
                    middle[axis] += place / 3.0;
                }
            }
            let new = places.len();
            places.push(middle);
            triangles.extend([0, 1, 2].map(|i| [corners[i], corners[(i + 1) % 3], new]));
        }
    }
    at_places(surface, sampling, [nu, nv], &places, &triangles)
}

/// The mesh with these triangles. Places are in a grid of `counts` cells, which covers the parameters.
fn at_places(
    surface: Surface,
    sampling: Sampling,
    counts: [usize; 2],
    places: &[[f64; 2]],
    triangles: &[[usize; 3]],
) -> Result<Sampled, Failure> {
    let [nu, nv] = counts;
    let ranges = surface.ranges();
    let grade = |t: f64| {
        let rate = 20.0_f64.ln();
        if sampling == Sampling::Graded { (t * rate).exp_m1() / rate.exp_m1() } else { t }
    };
    let parameter = |place: f64, count: usize, [low, high]: [f64; 2]| {
        low + (high - low) * grade(place / count as f64)
    };
    let parameters: Vec<[f64; 2]> = places
        .iter()
        .map(|&[u, v]| [parameter(u, nu, ranges[0]), parameter(v, nv, ranges[1])])
        .collect();
    let mut soup = PolygonSoup::default();
    parameters.iter().for_each(|&at| soup.push_vertex(surface.point(at)));
    for corners in triangles {
        soup.push_face(&corners.map(|corner| corner as u32)).map_err(Failure::mesh)?;
    }
    Ok(Sampled { soup, exact: parameters.into_iter().map(|at| surface.exact(at)).collect() })
}

/// Marching cubes of the cube around the origin that holds the surface, with at least so many vertices.
fn march(
    surface: Surface,
    implicit: fn(DVec3) -> f64,
    vertices: usize,
) -> Result<Sampled, Failure> {
    struct Field(fn(DVec3) -> f64, f64);
    impl Field {
        /// A place in the unit cube, turned so that no plane of the lattice is a plane of symmetry.
        fn place(&self, [x, y, z]: [f64; 3]) -> DVec3 {
            let turn = glam::DQuat::from_axis_angle(DVec3::new(2.0, 3.0, 6.0) / 7.0, 1.0);
            turn * (self.1 * (2.0 * DVec3::new(x, y, z) - 1.0))
        }
    }
    impl Sample<Signed> for Field {
        fn sample(&self, p: Vec3) -> Signed {
            Signed(self.0(self.place([p.x, p.y, p.z].map(f64::from))) as f32)
        }
    }
    let [us, vs] = surface.ranges();
    let places = (0..=40).flat_map(|i| (0..=40).map(move |j| [i, j].map(|k| f64::from(k) / 40.0)));
    let at = |t: f64, [low, high]: [f64; 2]| low + t * (high - low);
    let radius = places.map(|[u, v]| surface.point([at(u, us), at(v, vs)]).length());
    // Half of the side: no part of a surface reaches further than a twentieth beyond these places.
    let field = Field(implicit, 1.05 * radius.fold(0.0, f64::max));
    let (mut numbers, mut corners) = (Vec::new(), Vec::new());
    for size in 4.. {
        (numbers, corners) = (Vec::new(), Vec::new());
        let mut extractor = IndexedVertices::new(&mut numbers, &mut corners);
        MarchingCubes::new(size).extract(&field, &mut extractor);
        if numbers.len() >= 3 * vertices {
            break;
        }
    }
    let mut soup = PolygonSoup::default();
    for p in numbers.chunks_exact(3) {
        soup.push_vertex(field.place([p[0], p[1], p[2]].map(f64::from)));
    }
    for face in corners.chunks_exact(3) {
        // The values grow outward, and faces are seen from inside in the order of the library.
        soup.push_face(&[face[0], face[2], face[1]]).map_err(Failure::mesh)?;
    }
    let exact = soup.positions().iter().map(|&p| surface.exact_near(p)).collect();
    Ok(Sampled { soup, exact })
}

type Places = (Vec<[f64; 2]>, Vec<[usize; 3]>);

/// A random point in every cell, more points on the open sides, and their Delaunay triangulation.
fn delaunay(
    counts: [usize; 2],
    closed: [bool; 2],
    random: &mut SplitMix64,
) -> Result<Places, Failure> {
    /// The part of a cell in which its point lies.
    const PART: f64 = 0.8;
    let sizes = counts.map(|count| count as f64);
    let mut places = Vec::new();
    for row in 0..counts[1] {
        for column in 0..counts[0] {
            let shift = [random.symmetric(), random.symmetric()].map(|s| 0.5 + 0.5 * PART * s);
            places.push([column as f64 + shift[0], row as f64 + shift[1]]);
        }
    }
    for axis in 0..2 {
        if closed[axis] {
            continue;
        }
        let along = 1 - axis;
        // Corners belong to the sides along the first axis.
        let ends = if closed[along] || axis == 0 { 0..counts[along] } else { 0..counts[along] + 1 };
        let starts = if axis == 0 && !closed[along] { 1 } else { 0 };
        for step in ends.skip(starts) {
            for side in [0.0, sizes[axis]] {
                let mut place = [0.0; 2];
                (place[axis], place[along]) = (side, step as f64);
                places.push(place);
            }
        }
    }
    // Over the seams of closed directions, with copies of all points on both sides.
    let shifts = |is_closed: bool| if is_closed { -1..=1 } else { 0..=0 };
    let mut copies = Vec::new();
    for i in shifts(closed[0]) {
        for j in shifts(closed[1]) {
            let shift = [f64::from(i) * sizes[0], f64::from(j) * sizes[1]];
            copies.extend(places.iter().map(|[u, v]| Point2::new(u + shift[0], v + shift[1])));
        }
    }
    let count = places.len();
    let all =
        DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(copies).map_err(Failure::mesh)?;
    let mut triangles = Vec::new();
    for face in all.inner_faces() {
        let corners = face.vertices();
        let center = face.center();
        let is_here = (0.0..sizes[0]).contains(&center.x) && (0.0..sizes[1]).contains(&center.y);
        if is_here {
            triangles.push(corners.map(|corner| corner.index() % count));
        }
    }
    Ok((places, triangles))
}
