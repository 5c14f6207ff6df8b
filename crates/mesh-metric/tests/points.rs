//! Point clouds and signed distances, compared with closed forms and brute force.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::{PolygonSoup, SplitMix64, TriMesh};
use mesh_metric::{
    CompareOptions, SignRule, SignedDistance, Surface, SurfaceError, compare, compare_one_way,
    compare_signed_until, face_distances,
};
use mesh_shapes::{Plane, Sphere};
use proptest::prelude::*;

fn random_points(count: usize, size: f64, seed: u64) -> Vec<DVec3> {
    let mut random = SplitMix64::new(seed);
    let mut coordinate = || size * random.symmetric();
    (0..count).map(|_| DVec3::new(coordinate(), coordinate(), coordinate())).collect()
}

fn mesh(soup: &PolygonSoup) -> TriMesh {
    TriMesh::from_soup(soup).unwrap()
}

/// A box between two corners; its faces point outwards unless it is reversed.
fn cuboid(low: DVec3, high: DVec3, is_reversed: bool) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let corner = |i: u32| {
        let pick = |axis: usize| if i & (1 << axis) == 0 { low[axis] } else { high[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let turned = |[a, b, c]: [u32; 3]| if is_reversed { [b, a, c] } else { [a, b, c] };
    ((0..8).map(corner).collect(), faces.map(turned).collect())
}

fn joined(parts: &[(Vec<DVec3>, Vec<[u32; 3]>)]) -> TriMesh {
    let (mut points, mut faces): (Vec<DVec3>, Vec<[u32; 3]>) = Default::default();
    for (more, triangles) in parts {
        let shift = points.len() as u32;
        points.extend(more);
        faces.extend(triangles.iter().map(|t| t.map(|v| v + shift)));
    }
    TriMesh::from_triangles(&points, &faces).unwrap()
}

/// The distance from the surface of a box, negative inside.
fn from_box(p: DVec3, low: DVec3, high: DVec3) -> f64 {
    let q = (p - 0.5 * (low + high)).abs() - 0.5 * (high - low);
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn distances_between_clouds_are_those_of_brute_force(
        counts in (1_usize..60, 1_usize..60), seed in 0_u64..1000, flat in prop::bool::ANY,
        size in prop::sample::select(vec![1e-180, 1.0, 1e180]),
    ) {
        let squash = |p: DVec3| if flat { p.with_z(0.0) } else { p };
        let cloud = |count, seed| random_points(count, size, seed).into_iter().map(squash).collect();
        let (mut a, b): (Vec<DVec3>, Vec<DVec3>) = (cloud(counts.0, seed), cloud(counts.1, seed + 7));
        // A point that both have, twice.
        a.extend([b[0]; 2]);
        let [from, to] = [&a, &b].map(|points| Surface::of_points(points).unwrap());
        let found = compare_one_way(&from, &to, &CompareOptions::for_points());
        let nearest = |p: &DVec3| {
            let distances = b.iter().map(|q| ((*p - *q) / size).length() * size);
            distances.fold(f64::INFINITY, f64::min)
        };
        let expected: Vec<f64> = a.iter().map(nearest).collect();
        let mean = expected.iter().map(|d| d / a.len() as f64).sum::<f64>();
        let rms = (expected.iter().map(|d| (d / size).powi(2)).sum::<f64>() / a.len() as f64).sqrt() * size;
        let max = expected.iter().copied().fold(0.0, f64::max);
        for (found, expected) in [(found.mean, mean), (found.rms, rms), (found.max, max)] {
            prop_assert!((found - expected).abs() <= 1e-12 * size, "{found} {expected}");
        }
        prop_assert_eq!(found.samples, a.len());
    }

    /// Boxes that overlap or are nested, whichever way their faces point.
    #[test]
    fn signs_in_boxes_are_exact(
        seed in 0_u64..1000, is_reversed in prop::bool::ANY, shift in 0.1_f64..0.9,
    ) {
        let boxes = [(DVec3::ZERO, DVec3::ONE), (DVec3::splat(shift), DVec3::splat(1.0 + shift))];
        let mesh = joined(&boxes.map(|(low, high)| cuboid(low, high, is_reversed)));
        let signed = SignedDistance::negative_inside(&mesh).unwrap();
        prop_assert_eq!(signed.rule(), SignRule::WindingNumber);
        let points = random_points(200, 2.0, seed);
        for (point, distance) in points.iter().zip(signed.distances(&points)) {
            let [one, other] = boxes.map(|(low, high)| from_box(*point, low, high));
            prop_assert_eq!(distance < 0.0, one < 0.0 || other < 0.0, "{}", point);
            prop_assert!((distance.abs() - one.abs().min(other.abs())).abs() < 1e-12);
        }
    }
}

#[test]
fn points_are_measured_to_a_plane_and_not_back() {
    let plane =
        Surface::new(&mesh(&Plane { half_width: 1.0 }.mesh(4, Default::default()).unwrap()));
    let plane = plane.unwrap();
    let points = [[0.3, 0.3, 0.1], [0.5, 0.5, -0.05], [0.7, 0.2, 0.02], [2.0, 0.5, 0.0]];
    let cloud = Surface::of_points(&points).unwrap();
    let found = compare_one_way(&cloud, &plane, &CompareOptions::for_points());
    let expected = [0.1, 0.05, 0.02, 1.0];
    assert!((found.mean - expected.iter().sum::<f64>() / 4.0).abs() < 1e-15);
    let squares: f64 = expected.iter().map(|d| d * d).sum();
    assert!((found.rms - (squares / 4.0).sqrt()).abs() < 1e-15);
    assert!((found.max - 1.0).abs() < 1e-15 && found.worst.from == DVec3::new(2.0, 0.5, 0.0));
    assert!(matches!(Surface::of_points::<DVec3>(&[]), Err(SurfaceError::NoPoints)));
    let nowhere = Surface::of_points(&[DVec3::NAN]);
    assert!(matches!(nowhere, Err(SurfaceError::NotFinite { .. })));
}

/// A hollow ball: outside, wall, hollow.
#[test]
fn a_shell_in_a_shell_is_a_hollow() {
    let sphere = |radius: f64| {
        let soup = Sphere { radius }.icosphere(4).unwrap();
        let faces: Vec<[u32; 3]> = soup.faces().map(|f| f.try_into().unwrap()).collect();
        (soup.positions().to_vec(), faces)
    };
    let (outer, mut inner) = (sphere(1.0), sphere(0.5));
    inner.1.iter_mut().for_each(|face| face.swap(0, 1));
    let ball = joined(&[outer, inner]);
    let signed = SignedDistance::negative_inside(&ball).unwrap();
    for (radius, expected) in [(0.0, 0.5), (0.3, 0.2), (0.7, -0.2), (0.9, -0.1), (1.4, 0.4)] {
        let direction = DVec3::new(0.36, 0.48, 0.8);
        let distance = signed.distance(radius * direction);
        assert!((distance - expected).abs() < 5e-3, "{radius} {distance}");
        assert_eq!(distance.to_bits(), signed.distances(&[radius * direction])[0].to_bits());
    }
}

#[test]
fn an_open_surface_has_signs_by_its_normals() {
    let plane = mesh(&Plane { half_width: 1.0 }.mesh(4, Default::default()).unwrap());
    let signed = SignedDistance::negative_inside(&plane).unwrap();
    assert_eq!(signed.rule(), SignRule::Pseudonormal);
    let up = plane.face_normal(plane.topology().faces().next().unwrap()).z;
    for height in [0.3, 0.01, -0.2] {
        let distance = signed.distance(DVec3::new(0.1, 0.2, height));
        assert!((distance - up * height).abs() < 1e-15);
    }
}

/// Mean and extremes of the signed distances of a sphere from one with a bump and a dent.
#[test]
fn signed_statistics_of_concentric_spheres_are_known() {
    let ball = |radius: f64| mesh(&Sphere { radius }.icosphere(5).unwrap());
    let (reference, larger, smaller) = (ball(1.0), ball(1.05), ball(0.95));
    let to = SignedDistance::negative_inside(&reference).unwrap();
    let options = CompareOptions { samples: 20_000, ..CompareOptions::default() };
    for (other, expected, inside) in [(&larger, 0.05, 0.0), (&smaller, -0.05, 1.0)] {
        let from = Surface::new(other).unwrap();
        let found = compare_signed_until(&from, &to, &options, &|| false).unwrap();
        for value in [found.mean, found.min, found.max] {
            assert!((value - expected).abs() < 2e-3, "{found:?}");
        }
        assert!((found.inside - inside).abs() < 1e-15);
        // The sizes are those without a sign.
        let plain = compare(&from, &Surface::new(&reference).unwrap(), &options).forward;
        assert!((plain.mean - found.mean.abs()).abs() < 1e-12);
        assert!((plain.max - found.min.abs().max(found.max.abs())).abs() < 1e-12);
        assert!(compare_signed_until(&from, &to, &options, &|| true).is_none());
    }
}

/// A large face over a dent: its corners touch, its middle does not.
#[test]
fn an_error_in_the_middle_of_a_face_is_found() {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let flat = Surface::from_triangles(&corners.map(DVec3::from), &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let mut dented = mesh(&Plane { half_width: 1.0 }.mesh(40, Default::default()).unwrap());
    let centre = DVec3::new(0.4, -0.3, 0.0);
    for p in dented.positions_mut() {
        p.z = -0.2 * (1.0 - p.distance(centre) / 0.2).max(0.0);
    }
    let dented = Surface::new(&dented).unwrap();
    assert!(flat.positions().iter().all(|&p| dented.distance(p) < 1e-12));
    let found = face_distances(&flat, &dented, 20_000);
    assert!(found[0] > 0.1 && found[0] < 0.2 && found[1] < 1e-12, "{found:?}");
    // A face without area is measured at its corners.
    let line =
        Surface::from_triangles(&[DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y], &[[0, 0, 2]]).unwrap();
    let to = Surface::of_points(&[DVec3::ZERO]).unwrap();
    assert!((face_distances(&line, &to, 100)[0] - 2.0).abs() < 1e-15);
}
