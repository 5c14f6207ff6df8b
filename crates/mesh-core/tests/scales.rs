//! Very small and very large meshes: a scale by a power of two changes no decision.
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::crossing::Triangle;
use mesh_core::{
    PolygonSoup, Repair, SplitMix64, TriMesh, VertexId, Weld, WindingNumbers, build, diagnose,
    triangles_cross, unit_sized_points,
};
use mesh_shapes::{Irregular, Torus};

const EXPONENTS: [i32; 12] = [-1000, -700, -500, -400, -250, -120, 120, 250, 400, 500, 700, 1000];

/// Two cubes with an edge in common and one inside the other, inside out; a polygon with corners that turn back, and a
/// quadrilateral. Edges have four faces, and a component faces inward.
fn soup(scale: f64) -> PolygonSoup {
    let mut soup = PolygonSoup::new();
    let mut cube = |low: DVec3, size: f64, is_turned: bool| {
        let first = soup.vertex_count() as u32;
        for i in 0..8 {
            let corner = DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
            soup.push_vertex((low + size * corner) * scale);
        }
        for mut quad in
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
        {
            if is_turned {
                quad.reverse();
            }
            soup.push_face(&quad.map(|v| v + first)).unwrap();
        }
    };
    cube(DVec3::ZERO, 1.0, false);
    cube(DVec3::new(1.0, 1.0, 0.0), 1.0, false);
    cube(DVec3::splat(4.0), 0.7, true);
    let first = soup.vertex_count() as u32;
    for (x, y) in [(0.0, 0.0), (3.0, 0.1), (3.0, 2.0), (1.5, 0.5), (0.3, 2.5), (0.1, 1.2)] {
        soup.push_vertex(DVec3::new(x, y, 7.0 + 0.1 * x * y) * scale);
    }
    soup.push_face(&[0, 1, 2, 3, 4, 5].map(|v| v + first)).unwrap();
    soup
}

fn torus(scale: f64) -> TriMesh {
    let soup =
        Torus { major: 1.0, minor: 0.4 }.irregular_mesh(12, 8, Irregular::default()).unwrap();
    let mut mesh = TriMesh::from_soup(&soup).unwrap();
    mesh.positions_mut().iter_mut().for_each(|p| *p *= scale);
    mesh
}

#[test]
fn repairs_and_counts_do_not_depend_on_the_size() {
    let measure = |scale: f64| {
        let soup = soup(scale);
        let built = [Weld::None, Weld::Exact, Weld::Distance(0.01 * scale)].map(|weld| {
            let mut repair = Repair::lenient();
            repair.weld = weld;
            let found = build(&soup, &repair).unwrap();
            let places = found.mesh.positions().iter().map(|&p| (p / scale).to_array());
            let triangles: Vec<_> = found.mesh.topology().triangles().collect();
            (places.collect::<Vec<_>>(), triangles, found.report, found.mesh.facings())
        });
        (built, diagnose(&soup).unwrap())
    };
    let unit = measure(1.0);
    assert_eq!((unit.1.zero_area_faces, unit.1.slivers, unit.1.inside_out), (0, 0, Some(1)));
    assert!(unit.0[1].2.cut_edges.count() > 0 && unit.0[0].2.flipped_faces.count() > 0);
    for exponent in EXPONENTS {
        let scale = f64::from(exponent).exp2();
        let found = measure(scale);
        assert_eq!(found.0, unit.0, "2^{exponent}");
        assert_eq!(found.1, unit.1, "2^{exponent}");
    }
}

#[test]
fn normals_angles_and_winding_numbers_do_not_depend_on_the_size() {
    let measure = |scale: f64| {
        let mesh = torus(scale);
        let numbers = WindingNumbers::new(&mesh).unwrap();
        let mut random = SplitMix64::new(1);
        let mut point =
            || DVec3::new(random.symmetric(), random.symmetric(), 0.4 * random.symmetric());
        let around: Vec<i32> = (0..200).map(|_| numbers.about(1.4 * scale * point())).collect();
        let topology = mesh.topology();
        let normals =
            mesh.face_normals().into_vec().into_iter().chain(mesh.vertex_normals().into_vec());
        let angles = topology.half_edges().map(|h| mesh.corner_angle(h).to_bits());
        let normals = normals.flat_map(|n| n.to_array().map(f64::to_bits));
        (around, normals.chain(angles).collect::<Vec<u64>>())
    };
    let unit = measure(1.0);
    assert!(unit.0.contains(&0) && unit.0.contains(&1));
    for exponent in EXPONENTS {
        assert!(measure(f64::from(exponent).exp2()) == unit, "2^{exponent}");
    }
}

#[test]
fn crossings_do_not_depend_on_the_size() {
    let mut random = SplitMix64::new(2);
    let mut found = [0; 2];
    for round in 0..3000 {
        let mut triangle = |from: u32| -> Triangle {
            let mut point = || {
                let p = DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
                // On a coarse grid much touches and lies in one plane.
                if round % 2 == 0 { (2.0 * p).round() } else { p }
            };
            ([0, 1, 2].map(|i| VertexId::new(from + i)), [point(), point(), point()])
        };
        let (a, b) = (triangle(0), triangle(3));
        let unit = triangles_cross(a, b);
        found[usize::from(unit)] += 1;
        for exponent in EXPONENTS {
            let scaled = |t: Triangle| (t.0, t.1.map(|p| p * f64::from(exponent).exp2()));
            assert_eq!(triangles_cross(scaled(a), scaled(b)), unit, "2^{exponent}: {a:?} {b:?}");
        }
    }
    assert!(found.iter().all(|&count| count > 300), "{found:?}");
}

/// Areas and volumes are scaled, or are no numbers: they are never 0.
#[test]
fn areas_that_are_no_numbers_are_not_zero() {
    let unit = soup(1.0).measure();
    for exponent in EXPONENTS {
        let found = soup(f64::from(exponent).exp2()).measure();
        let scaled = |power: i32, value: f64| match exponent * power {
            -1000..=1000 => value * f64::from(exponent * power).exp2(),
            1001.. => f64::INFINITY * value,
            _ => f64::NAN,
        };
        let same = |a: f64, b: f64| a == b || a.is_nan() && b.is_nan();
        assert!(same(found.area, scaled(2, unit.area)), "2^{exponent}: {}", found.area);
        assert!(same(found.volume, scaled(3, unit.volume)), "2^{exponent}: {}", found.volume);
    }
}

/// One vertex far away takes no digits from the areas of the others.
#[test]
fn a_vertex_far_away_leaves_the_areas_of_the_others() {
    let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [-1.7e38, 0., 0.]];
    let area =
        |faces: &[[u32; 3]]| PolygonSoup::from_triangles(&corners, faces).unwrap().measure().area;
    assert_eq!(area(&[[0, 1, 2], [0, 2, 3]]), 1.0);
    assert!((area(&[[0, 1, 2], [0, 2, 4]]) / 8.5e37 - 1.0).abs() < 1e-12);
}

/// A point far away must not take the digits of the others, and neither must points that are no numbers.
#[test]
fn points_are_scaled_by_their_median_if_that_is_exact() {
    let points = |scale: f64, far: f64| [scale, 1.5 * scale, -1.2 * scale, far].map(DVec3::splat);
    for (scale, far, is_scaled) in [
        (1.0, 1e200, false),
        (1e200, 1e200, true),
        (1e-200, f64::NAN, true),
        (1e-200, 1e250, false),
    ] {
        let original = points(scale, far);
        let (scaled, factor) = unit_sized_points(&original);
        assert_eq!(factor != 1.0, is_scaled, "{scale:e} {far:e}");
        assert_eq!(scaled[0] * factor, original[0]);
    }
}
