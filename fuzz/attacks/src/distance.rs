//! Distances between surfaces: samples, bounds, and a brute-force search.

use arbitrary::{Result, Unstructured};
use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_metric::{CertifyOptions, CompareOptions, Surface, compare, hausdorff_bounds};

use crate::shape::point;

/// Largest error of an exact distance; coordinates are small.
const ROUNDING: f64 = 1e-12;

/// Compares two surfaces: samples and bounds must agree with each other and with a search of all triangles.
pub fn attack(data: &[u8]) {
    // Too few bytes are not an error.
    let _ = run(&mut Unstructured::new(data));
}

fn run(u: &mut Unstructured<'_>) -> Result<()> {
    let [(Ok(a), of_a), (Ok(b), of_b)] = [surface(u)?, surface(u)?] else { return Ok(()) };
    let samples = u.int_in_range(0..=50)?;
    let tolerance = f64::from(u.int_in_range(0..=20)?) / 20.0;
    let limit = if u.ratio(1, 4)? { Some(f64::from(u.int_in_range(0..=40)?) / 8.0) } else { None };
    let sampled = compare(&a, &b, &CompareOptions { samples, ..CompareOptions::default() });
    let options = CertifyOptions { tolerance, limit, max_pieces: 20_000, max_pieces_per_face: 0 };
    let bounds = hausdorff_bounds(&a, &b, &options);
    assert!(bounds.lower <= bounds.upper, "{bounds:?}");
    assert!(
        sampled.hausdorff() <= bounds.upper + ROUNDING,
        "{} and {bounds:?}",
        sampled.hausdorff()
    );
    assert!(sampled.mean() <= sampled.rms() * (1.0 + 1e-12), "{sampled:?}");
    for (points, to) in [(&of_a, &of_b), (&of_b, &of_a)] {
        for &point in points.iter().flatten() {
            let distance = search(point, to);
            assert!(distance <= bounds.upper + ROUNDING, "{point} is {distance} away: {bounds:?}");
        }
    }
    // The point of the lower bound must prove it; the point lies on one of the two surfaces.
    let proof = search(bounds.at, &of_a).max(search(bounds.at, &of_b));
    assert!(bounds.lower <= proof + ROUNDING, "{} is {proof} away: {bounds:?}", bounds.at);
    let place = point(u)?;
    let found = a.closest(place);
    assert!((found.distance - search(place, &of_a)).abs() < ROUNDING, "{found:?}");
    Ok(())
}

type Made = (core::result::Result<Surface, mesh_metric::SurfaceError>, Vec<[DVec3; 3]>);

fn surface(u: &mut Unstructured<'_>) -> Result<Made> {
    let mut soup = PolygonSoup::new();
    for _ in 0..u.int_in_range(3..=12)? {
        soup.push_vertex(point(u)?);
    }
    let count = soup.vertex_count();
    let triangles: Vec<[u32; 3]> = (0..u.int_in_range(1..=12)?)
        .map(|_| -> Result<[u32; 3]> {
            let mut corner = || u.choose_index(count).map(|vertex| vertex as u32);
            Ok([corner()?, corner()?, corner()?])
        })
        .collect::<Result<_>>()?;
    let at = |vertex: u32| soup.positions()[vertex as usize];
    let corners = triangles.iter().map(|triangle| triangle.map(at)).collect();
    Ok((Surface::from_triangles(soup.positions(), &triangles), corners))
}

/// The distance of a point from triangles: the minimum over the planes where the foot lies inside, and over the sides.
fn search(point: DVec3, triangles: &[[DVec3; 3]]) -> f64 {
    triangles.iter().map(|triangle| to_triangle(point, *triangle)).fold(f64::INFINITY, f64::min)
}

fn to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let sides = [[a, b], [b, c], [c, a]];
    let nearest = sides.iter().map(|&[p, q]| {
        let (along, to) = (q - p, point - p);
        let length = along.length_squared();
        let t = if length > 0.0 { (to.dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        (to - t * along).length()
    });
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    let normal = (b - a).cross(c - a);
    let is_over = |&[p, q]: &[DVec3; 2]| (q - p).cross(point - p).dot(normal) >= 0.0;
    if normal != DVec3::ZERO && sides.iter().all(is_over) {
        return nearest.min((point - a).dot(normal).abs() / normal.length());
    }
    nearest
}
