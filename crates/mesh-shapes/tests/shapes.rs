//! The analytic shapes compared with finite differences, counting, brute force and published values.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use glam::DVec3;
use mesh_core::{PolygonSoup, SplitMix64};
use mesh_shapes::*;
use std::collections::{HashMap, HashSet};

fn triangles(soup: &PolygonSoup) -> Vec<[DVec3; 3]> {
    let point = |i: u32| soup.positions()[i as usize];
    soup.faces().map(|face| [point(face[0]), point(face[1]), point(face[2])]).collect()
}

fn area(soup: &PolygonSoup) -> f64 {
    triangles(soup).iter().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
}

fn volume(soup: &PolygonSoup) -> f64 {
    triangles(soup).iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum()
}

/// Checks that the soup is a connected, oriented manifold in which every vertex is used, and
/// returns (Euler characteristic, boundary edges).
fn topology(soup: &PolygonSoup) -> (i64, usize) {
    let mut sides = HashSet::new();
    let mut reached: Vec<usize> = (0..soup.vertex_count()).collect();
    fn root(reached: &mut [usize], mut i: usize) -> usize {
        while reached[i] != i {
            reached[i] = reached[reached[i]];
            i = reached[i];
        }
        i
    }
    for face in soup.faces() {
        assert_eq!(face.len(), 3);
        for i in 0..3 {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            assert!(a != b && sides.insert((a, b)), "side {a} {b} twice");
            let (a, b) = (root(&mut reached, a as usize), root(&mut reached, b as usize));
            reached[a] = b;
        }
    }
    let roots = (0..reached.len()).filter(|&i| reached[i] == i).count();
    assert_eq!(roots, 1, "not connected, or a vertex without faces");
    let border = sides.iter().filter(|&&(a, b)| !sides.contains(&(b, a))).count();
    let edges = (sides.len() + border) / 2;
    (soup.vertex_count() as i64 - edges as i64 + soup.face_count() as i64, border)
}

fn faces(soup: &PolygonSoup) -> Vec<[u32; 3]> {
    soup.faces().map(|face| face.try_into().unwrap()).collect()
}

/// Checks that the normal of every triangle points to the side of the surface normal at all three corners.
fn assert_facing(soup: &PolygonSoup, surface: &dyn AnalyticSurface) {
    for (f, [a, b, c]) in triangles(soup).into_iter().enumerate() {
        let normal = (b - a).cross(c - a);
        for p in [a, b, c] {
            assert!(normal.dot(surface.normal(p)) > 0.0, "face {f} is turned over");
        }
    }
}

/// Compares normal and curvatures with central differences of the parametrisation.
fn assert_curvature(surface: &dyn AnalyticSurface, parameters: &[(f64, f64)]) {
    let h = 1e-4;
    for &(u, v) in parameters {
        let at = |i: f64, j: f64| surface.point(u + i * h, v + j * h);
        let p = at(0.0, 0.0);
        let du = (at(1.0, 0.0) - at(-1.0, 0.0)) / (2.0 * h);
        let dv = (at(0.0, 1.0) - at(0.0, -1.0)) / (2.0 * h);
        let duu = (at(1.0, 0.0) + at(-1.0, 0.0) - 2.0 * p) / (h * h);
        let dvv = (at(0.0, 1.0) + at(0.0, -1.0) - 2.0 * p) / (h * h);
        let duv = (at(1.0, 1.0) + at(-1.0, -1.0) - at(1.0, -1.0) - at(-1.0, 1.0)) / (4.0 * h * h);
        let normal = du.cross(dv).normalize();
        assert!((normal - surface.normal(p)).length() < 1e-6, "normal at {u} {v}");

        // First fundamental form, and the second one, positive where the surface is convex.
        let (e, f, g) = (du.dot(du), du.dot(dv), dv.dot(dv));
        let (l, m, n) = (-duu.dot(normal), -duv.dot(normal), -dvv.dot(normal));
        let determinant = e * g - f * f;
        let gaussian = (l * n - m * m) / determinant;
        let mean = (e * n - 2.0 * f * m + g * l) / (2.0 * determinant);
        let principal = surface.principal_curvatures(p);
        let size = principal.max.abs().max(principal.min.abs()).max(1e-3);
        let close = |a: f64, b: f64, scale: f64| (a - b).abs() < 2e-5 * scale;
        assert!(close(surface.gaussian_curvature(p), gaussian, size * size), "K at {u} {v}");
        assert!(close(surface.mean_curvature(p), mean, size), "H at {u} {v}");

        // The three closed forms agree far more closely than finite differences can show.
        let exact = 1e-12 * size;
        assert!((0.5 * (principal.max + principal.min) - surface.mean_curvature(p)).abs() < exact);
        let product = principal.max * principal.min;
        assert!((product - surface.gaussian_curvature(p)).abs() < exact * size);
        assert!(principal.max >= principal.min);

        for (i, curvature) in [principal.max, principal.min].into_iter().enumerate() {
            let Some(direction) = principal.directions.map(|directions| directions[i]) else {
                assert!(principal.max - principal.min < 1e-9 * size);
                continue;
            };
            assert!((direction.length() - 1.0).abs() < 1e-12);
            assert!(direction.dot(surface.normal(p)).abs() < 1e-12);
            // Solve direction = a du + b dv, and take the normal curvature along it.
            let (x, y) = (direction.dot(du), direction.dot(dv));
            let (a, b) = ((g * x - f * y) / determinant, (e * y - f * x) / determinant);
            let along = a * a * l + 2.0 * a * b * m + b * b * n;
            assert!(close(along, curvature, size), "direction {i} at {u} {v}");
        }
    }
}

const SOME: [(f64, f64); 6] =
    [(0.1, 0.2), (1.3, -0.7), (2.9, 0.9), (-2.0, 1.2), (4.4, -1.1), (0.7, 0.05)];

#[test]
fn closed_forms_agree_with_finite_differences() {
    assert_curvature(&Sphere { radius: 2.5 }, &SOME);
    assert_curvature(&Ellipsoid { semi_axes: DVec3::new(3.0, 2.0, 1.0) }, &SOME);
    assert_curvature(&Ellipsoid { semi_axes: DVec3::new(0.5, 2.0, 1.5) }, &SOME);
    let torus = Torus { major: 5.0, minor: 2.0 };
    assert_curvature(&torus, &SOME);
    assert_curvature(&torus, &[(0.3, 3.1), (0.3, 2.0), (1.0, core::f64::consts::FRAC_PI_2)]);
    assert_curvature(&Cylinder { radius: 0.7, height: 3.0 }, &SOME);
    assert_curvature(&Catenoid { waist: 1.3, half_height: 2.0 }, &SOME);
    assert_curvature(&Saddle { coefficient: 0.5, half_width: 1.0 }, &SOME);
    assert_curvature(&Wave { amplitude: 0.3, wavelength: 2.0, half_width: 1.0 }, &SOME);
    assert_curvature(&Plane { half_width: 1.0 }, &SOME);
}

#[test]
fn signs_follow_the_convention() {
    let p = DVec3::new(0.0, 0.0, 4.0);
    assert_eq!(Sphere { radius: 4.0 }.mean_curvature(p), 0.25);
    assert_eq!(Sphere { radius: 4.0 }.gaussian_curvature(p), 0.0625);
    let saddle = Saddle { coefficient: 0.5, half_width: 1.0 }.principal_curvatures(DVec3::ZERO);
    assert_eq!((saddle.max, saddle.min), (1.0, -1.0));
    // The saddle rises along x, so it is concave there seen from above.
    assert!(saddle.directions.unwrap()[1].x.abs() > 1.0 - 1e-12);
}

#[test]
fn closed_shapes_are_oriented_outwards() {
    let sphere = Sphere { radius: 2.0 };
    let ellipsoid = Ellipsoid { semi_axes: DVec3::new(3.0, 2.0, 1.0) };
    let torus = Torus { major: 5.0, minor: 2.0 };
    let irregular = Irregular { seed: 7, ..Irregular::default() };
    let meshes: Vec<(PolygonSoup, &dyn AnalyticSurface, i64)> = vec![
        (sphere.uv_mesh(2, 3).unwrap(), &sphere, 2),
        (sphere.uv_mesh(24, 48).unwrap(), &sphere, 2),
        (sphere.icosphere(0).unwrap(), &sphere, 2),
        (sphere.icosphere(3).unwrap(), &sphere, 2),
        (sphere.geodesic(1).unwrap(), &sphere, 2),
        (sphere.geodesic(2).unwrap(), &sphere, 2),
        (sphere.geodesic(7).unwrap(), &sphere, 2),
        (sphere.irregular_icosphere(3, irregular).unwrap(), &sphere, 2),
        (ellipsoid.uv_mesh(12, 24).unwrap(), &ellipsoid, 2),
        (ellipsoid.icosphere(3).unwrap(), &ellipsoid, 2),
        (ellipsoid.irregular_icosphere(3, irregular).unwrap(), &ellipsoid, 2),
        (torus.mesh(24, 12).unwrap(), &torus, 0),
        (torus.irregular_mesh(24, 12, irregular).unwrap(), &torus, 0),
    ];
    for (soup, surface, characteristic) in &meshes {
        assert_eq!(topology(soup), (*characteristic, 0));
        assert!(volume(soup) > 0.0);
        assert_facing(soup, *surface);
    }
    for soup in [
        polyhedra::tetrahedron(),
        polyhedra::octahedron(),
        polyhedra::cube(),
        polyhedra::icosahedron(),
        inset_cube(0.2).unwrap(),
        seven_points::given(),
        seven_points::convex(),
    ] {
        assert_eq!(topology(&soup), (2, 0));
        assert!(volume(&soup) > 0.0);
    }
    assert_eq!(topology(&torus.shifted_mesh(12, 6).unwrap()), (0, 0));
    assert_eq!(topology(&torus.shifted_mesh(3, 3).unwrap()), (0, 0));
    assert_eq!(volume(&polyhedra::cube()), 8.0);
    assert!((volume(&polyhedra::octahedron()) - 4.0 / 3.0).abs() < 1e-15);
    assert!((volume(&polyhedra::tetrahedron()) - 8.0 / 3.0).abs() < 1e-15);
}

#[test]
fn open_shapes_face_the_side_of_their_normal() {
    let cylinder = Cylinder { radius: 1.0, height: 4.0 };
    let catenoid = Catenoid { waist: 1.0, half_height: 1.0 };
    let saddle = Saddle { coefficient: 0.5, half_width: 1.0 };
    let wave = Wave { amplitude: 0.2, wavelength: 1.0, half_width: 1.5 };
    let plane = Plane { half_width: 1.0 };
    let bent = Irregular { seed: 3, ..Irregular::default() };
    for phase in [RowPhase::Aligned, RowPhase::Staggered] {
        for (mesh, surface) in [
            (cylinder.mesh(8, 24, phase), &cylinder as &dyn AnalyticSurface),
            (catenoid.mesh(8, 24, phase), &catenoid),
        ] {
            let soup = mesh.unwrap();
            assert_eq!(topology(&soup), (0, 48));
            assert_facing(&soup, surface);
        }
    }
    for (mesh, surface) in [
        (cylinder.irregular_mesh(8, 24, bent), &cylinder as &dyn AnalyticSurface),
        (catenoid.irregular_mesh(8, 24, bent), &catenoid),
    ] {
        let soup = mesh.unwrap();
        assert_eq!(topology(&soup), (0, 48));
        assert_facing(&soup, surface);
    }
    let half = cylinder.half_with_bare_sides(24).unwrap();
    assert_eq!(topology(&half), (1, 50));
    assert_facing(&half, &cylinder);
    for diagonals in [Diagonals::Uniform, Diagonals::Alternating] {
        for (mesh, surface) in [
            (saddle.mesh(16, diagonals), &saddle as &dyn AnalyticSurface),
            (saddle.irregular_mesh(16, bent), &saddle),
            (wave.mesh(16, diagonals), &wave),
            (plane.mesh(16, diagonals), &plane),
            (plane.irregular_mesh(16, bent), &plane),
        ] {
            let soup = mesh.unwrap();
            assert_eq!(topology(&soup), (1, 64));
            assert_facing(&soup, surface);
        }
    }
    // The jitter keeps the outline of the square.
    assert!((area(&plane.irregular_mesh(16, bent).unwrap()) - 4.0).abs() < 1e-12);
}

#[test]
fn irregular_meshes_are_valid_for_many_seeds() {
    let torus = Torus { major: 3.0, minor: 1.0 };
    let plane = Plane { half_width: 1.0 };
    for seed in 0..50 {
        let irregular = Irregular { seed, ..Irregular::default() };
        for level in 0..4 {
            let mesh = Sphere::UNIT.irregular_icosphere(level, irregular).unwrap();
            assert!(
                level == 0 || triangles(&mesh).iter().all(|[a, b, c]| a.dot(b.cross(*c)) > 0.0)
            );
        }
        assert_facing(&torus.irregular_mesh(30, 20, irregular).unwrap(), &torus);
        assert_facing(&plane.irregular_mesh(20, irregular).unwrap(), &plane);
    }
}

#[test]
fn vertices_lie_on_the_surface() {
    let irregular = Irregular::default();
    let check = |soup: PolygonSoup, size: f64, distance: &dyn Fn(DVec3) -> f64| {
        for &p in soup.positions() {
            assert!(distance(p).abs() < 1e-12 * size, "{p} is {} away", distance(p));
        }
    };
    let sphere = Sphere { radius: 3.0 };
    let on_sphere = |p| sphere.signed_distance(p);
    check(sphere.uv_mesh(20, 30).unwrap(), 3.0, &on_sphere);
    check(sphere.icosphere(4).unwrap(), 3.0, &on_sphere);
    check(sphere.geodesic(9).unwrap(), 3.0, &on_sphere);
    check(sphere.irregular_icosphere(3, irregular).unwrap(), 3.0, &on_sphere);
    let torus = Torus { major: 5.0, minor: 2.0 };
    let on_torus = |p| torus.signed_distance(p);
    check(torus.mesh(30, 20).unwrap(), 7.0, &on_torus);
    check(torus.shifted_mesh(12, 6).unwrap(), 7.0, &on_torus);
    check(torus.irregular_mesh(30, 20, irregular).unwrap(), 7.0, &on_torus);
    let cylinder = Cylinder { radius: 2.0, height: 5.0 };
    let on_cylinder = |p| cylinder.signed_distance(p);
    check(cylinder.mesh(10, 20, RowPhase::Staggered).unwrap(), 2.0, &on_cylinder);
    check(cylinder.irregular_mesh(10, 20, irregular).unwrap(), 2.0, &on_cylinder);
    check(cylinder.half_with_bare_sides(24).unwrap(), 2.0, &on_cylinder);
    let axes = DVec3::new(3.0, 2.0, 1.0);
    let on_ellipsoid = |p: DVec3| (p / axes).length() - 1.0;
    check(Ellipsoid { semi_axes: axes }.icosphere(3).unwrap(), 1.0, &on_ellipsoid);
    let catenoid = Catenoid { waist: 0.8, half_height: 1.0 };
    let on_catenoid = |p: DVec3| p.x.hypot(p.y) - 0.8 * (p.z / 0.8).cosh();
    check(catenoid.irregular_mesh(10, 20, irregular).unwrap(), 2.0, &on_catenoid);
    let saddle = Saddle { coefficient: 0.5, half_width: 1.0 };
    let on_saddle = |p: DVec3| p.z - 0.5 * (p.x * p.x - p.y * p.y);
    check(saddle.irregular_mesh(20, irregular).unwrap(), 1.0, &on_saddle);
}

#[test]
fn distances_and_closest_points_agree() {
    let fields: [(&dyn SignedDistance, &dyn AnalyticSurface); 3] = [
        (&Sphere { radius: 1.5 }, &Sphere { radius: 1.5 }),
        (&Torus { major: 2.0, minor: 0.5 }, &Torus { major: 2.0, minor: 0.5 }),
        (&Cylinder { radius: 1.2, height: 1.0 }, &Cylinder { radius: 1.2, height: 1.0 }),
    ];
    let mut random = SplitMix64::new(11);
    for _ in 0..200 {
        let p = 3.0 * DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
        for (field, surface) in fields {
            let (distance, foot) = (field.signed_distance(p), field.closest_point(p));
            assert!(field.signed_distance(foot).abs() < 1e-14);
            assert!((foot + distance * surface.normal(foot) - p).length() < 1e-13);
        }
    }
    for (field, _) in fields {
        assert!(field.closest_point(DVec3::ZERO).is_finite());
    }
}

/// Counts, mean edge lengths and areas of the reference meshes of the curvature patches.
#[test]
fn meshes_match_the_reference_figures() {
    let cylinder = Cylinder { radius: 1.0, height: 4.0 };
    let saddle = Saddle { coefficient: 0.5, half_width: 1.0 };
    let long = Cylinder { radius: 1.0, height: 6.0 };
    let figures = [
        (long.half_with_bare_sides(24), 50, 48, 3.0960094525, 18.8361012183),
        (cylinder.mesh(32, 48, RowPhase::Aligned), 1584, 3072, 0.1454261057, 25.1148016244),
        (cylinder.mesh(32, 48, RowPhase::Staggered), 1584, 3072, 0.1375931972, 25.1184855627),
        (Sphere::UNIT.uv_mesh(24, 48), 1106, 2208, 0.1258741754, 12.5215625278),
        (Sphere::UNIT.icosphere(3), 642, 1280, 0.1507297052, 12.5064927340),
        (saddle.mesh(32, Diagonals::Alternating), 1089, 2048, 0.0813067941, 5.1222996149),
        (Torus { major: 2.0, minor: 1.0 }.mesh(64, 32), 2048, 4096, 0.2246869657, 78.7509566848),
    ];
    for (mesh, vertices, faces, edge, surface) in figures {
        let soup = mesh.unwrap();
        assert_eq!((soup.vertex_count(), soup.face_count()), (vertices, faces));
        assert!((mean_edge_length(&soup) - edge).abs() < 1e-10);
        assert!((area(&soup) - surface).abs() < 1e-9);
    }
}

#[test]
fn geodesic_spheres_have_the_expected_counts_and_valences() {
    for frequency in 1..9 {
        let soup = Sphere::UNIT.geodesic(frequency).unwrap();
        assert_eq!(soup.vertex_count(), 10 * frequency * frequency + 2);
        assert_eq!(soup.face_count(), 20 * frequency * frequency);
        let mut valences = vec![0; soup.vertex_count()];
        for &vertex in soup.corners() {
            valences[vertex as usize] += 1;
        }
        let counted: HashMap<i32, usize> =
            valences.iter().fold(HashMap::new(), |mut counted, &valence| {
                *counted.entry(valence).or_default() += 1;
                counted
            });
        assert_eq!(counted[&5], 12);
        assert_eq!(counted.get(&6).copied().unwrap_or(0), soup.vertex_count() - 12);
    }
    // At frequency two both constructions are the same polyhedron.
    let area_difference =
        area(&Sphere::UNIT.geodesic(2).unwrap()) - area(&Sphere::UNIT.icosphere(1).unwrap());
    assert!(area_difference.abs() < 1e-12);
}

/// The errors of the initial mesh in Dyn, Hormann, Kim, Levin 2001, Table 1: distances to the
/// torus at the distinct points of a lattice of 100 subdivisions per edge.
#[test]
fn shifted_torus_has_the_errors_of_table_1() {
    let torus = Torus { major: 5.0, minor: 2.0 };
    let soup = torus.shifted_mesh(12, 6).unwrap();
    assert_eq!(&faces(&soup)[..4], &[[0, 6, 1], [1, 6, 7], [1, 7, 2], [2, 7, 8]]);
    assert_eq!(faces(&soup)[142..], [[71, 5, 66], [66, 5, 0]]);
    let n = 100;
    let (mut sum, mut squares, mut largest) = (0.0, 0.0, 0.0_f64);
    // Vertices are on the torus and counted once; points inside an edge occur twice.
    let mut weights = soup.vertex_count() as f64;
    for [a, b, c] in triangles(&soup) {
        for i in 0..=n {
            for j in 0..=n - i {
                let k = n - i - j;
                let weight = match [i, j, k].iter().filter(|&&x| x == 0).count() {
                    0 => 1.0,
                    1 => 0.5,
                    _ => 0.0,
                };
                let p = (a * f64::from(i) + b * f64::from(j) + c * f64::from(k)) / f64::from(n);
                let distance = torus.signed_distance(p).abs();
                sum += weight * distance;
                squares += weight * distance * distance;
                weights += weight;
                largest = largest.max(distance);
            }
        }
    }
    assert!((sum / weights - 0.2342743622).abs() < 1e-9);
    assert!(((squares / weights).sqrt() - 0.2824122177).abs() < 1e-9);
    assert!((largest - 0.7939588303).abs() < 1e-9);
}

#[test]
fn inset_cube_has_the_area_of_the_formula() {
    for (inset, expected) in [(0.2, 24.4753), (0.5, 26.8328)] {
        assert!((area(&inset_cube(inset).unwrap()) - expected).abs() < 1e-4);
    }
    assert_eq!(area(&inset_cube(0.0).unwrap()), 24.0);
}

fn undirected_edges(soup: &PolygonSoup) -> HashSet<(u32, u32)> {
    let sides = soup.faces().flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]);
    sides.map(|(a, b)| (a.min(b), a.max(b))).collect()
}

#[test]
fn seven_points_differ_from_their_hull_by_three_edges() {
    let (given, convex) = (seven_points::given(), seven_points::convex());
    let [before, after] = [undirected_edges(&given), undirected_edges(&convex)];
    assert_eq!(before.difference(&after).count(), 3);
    assert!(volume(&convex) > volume(&given));
    for [a, b, c] in triangles(&convex) {
        let normal = (b - a).cross(c - a);
        for &p in convex.positions() {
            assert!(normal.dot(p - a) <= 1e-9);
        }
    }
}

#[test]
fn noise_has_the_size_asked_for() {
    let clean = Sphere::UNIT.icosphere(4).unwrap();
    let mut noisy = clean.clone();
    add_normal_noise(&mut noisy, 0.1, 3);
    let sigma = 0.1 * mean_edge_length(&clean);
    let variance = noisy.positions().iter().map(|p| (p.length() - 1.0).powi(2)).sum::<f64>()
        / noisy.vertex_count() as f64;
    assert!((variance.sqrt() / sigma - 1.0).abs() < 0.05);
    let mut again = clean.clone();
    add_normal_noise(&mut again, 0.1, 3);
    assert_eq!(noisy, again);
}

#[test]
fn seeds_decide_everything() {
    let make = |seed| {
        let irregular = Irregular { seed, ..Irregular::default() };
        [
            Sphere::UNIT.irregular_icosphere(2, irregular).unwrap(),
            Torus { major: 2.0, minor: 1.0 }.irregular_mesh(12, 8, irregular).unwrap(),
            Plane { half_width: 1.0 }.irregular_mesh(9, irregular).unwrap(),
        ]
    };
    assert_eq!(make(4), make(4));
    for (a, b) in make(4).iter().zip(&make(5)) {
        assert_ne!(a, b);
    }
}

#[test]
fn bad_parameters_are_refused_with_the_limit() {
    let irregular = |jitter| Irregular { jitter, seed: 0 };
    let torus = |major, minor| Torus { major, minor }.mesh(8, 8);
    let plane = Plane { half_width: 1.0 };
    let cylinder = Cylinder { radius: 1.0, height: 1.0 };
    let huge = usize::MAX;
    let refused = [
        (torus(2.0, 2.0), "not below its major radius"),
        (torus(2.0, 0.0), "must be positive and finite"),
        (torus(f64::INFINITY, 1.0), "must be positive and finite"),
        (torus(2.0, f64::NAN), "must be positive and finite"),
        (Torus { major: 2.0, minor: 1.0 }.mesh(2, 8), "at least 3"),
        (Torus { major: 2.0, minor: 1.0 }.shifted_mesh(8, 2), "at least 3"),
        (Torus { major: 2.0, minor: 1.0 }.mesh(huge, huge), "more than"),
        (Sphere { radius: -1.0 }.icosphere(1), "must be positive and finite"),
        (Sphere::UNIT.icosphere(14), "more than"),
        (Sphere::UNIT.icosphere(u32::MAX), "more than"),
        (Sphere::UNIT.geodesic(0), "at least 1"),
        (Sphere::UNIT.geodesic(huge), "more than"),
        (Sphere::UNIT.uv_mesh(1, 8), "at least 2"),
        (Sphere::UNIT.uv_mesh(huge, huge), "more than"),
        (Ellipsoid { semi_axes: DVec3::new(1.0, 0.0, 1.0) }.icosphere(1), "semi-axis"),
        (Sphere::UNIT.irregular_icosphere(2, irregular(0.3)), "at most 0.2"),
        (plane.irregular_mesh(3, irregular(f64::NAN)), "at most 0.2"),
        (plane.irregular_mesh(3, irregular(-0.1)), "at least 0"),
        (plane.mesh(0, Diagonals::Uniform), "at least 1"),
        (plane.mesh(huge, Diagonals::Uniform), "more than"),
        (cylinder.mesh(0, 8, RowPhase::Aligned), "at least 1"),
        (cylinder.mesh(1, 2, RowPhase::Aligned), "at least 3"),
        (cylinder.half_with_bare_sides(0), "at least 1"),
        (cylinder.half_with_bare_sides(huge), "more than"),
        (Catenoid { waist: 1e-3, half_height: 9.0 }.mesh(2, 3, RowPhase::Aligned), "rim radius"),
        (inset_cube(1.0), "below 1"),
        (inset_cube(f64::NAN), "below 1"),
    ];
    for (result, part) in refused {
        let message = result.unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
}

mod hull {
    use super::*;
    use robust::{Coord3D, orient3d};

    /// Positive if `p` is on the outside of the triangle's plane.
    fn above([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
        let [a, b, c, p] = [a, b, c, p].map(|v| Coord3D { x: v.x, y: v.y, z: v.z });
        -orient3d(a, b, c, p)
    }

    #[test]
    fn random_points_give_their_delaunay_triangulation() {
        for seed in 0..4 {
            for points in [4, 5, 20, 300] {
                let soup = Sphere::UNIT.random_hull(points, seed).unwrap();
                assert_eq!(soup.vertex_count(), points);
                assert_eq!(soup.face_count(), 2 * points - 4);
                assert_eq!(topology(&soup), (2, 0));
                assert!(volume(&soup) > 0.0);
                // On a sphere the plane of a triangle cuts off its circumcircle: an empty
                // half-space is an empty circle.
                for (triangle, corners) in triangles(&soup).into_iter().zip(faces(&soup)) {
                    for (i, &p) in soup.positions().iter().enumerate() {
                        assert!(corners.contains(&(i as u32)) || above(triangle, p) < 0.0);
                    }
                }
                assert!(soup.positions().iter().all(|p| (p.length() - 1.0).abs() < 1e-12));
                assert_eq!(soup, Sphere::UNIT.random_hull(points, seed).unwrap());
            }
        }
    }

    #[test]
    fn a_large_random_sphere_is_complete() {
        let soup = Sphere { radius: 1e-3 }.random_hull(50_000, 2).unwrap();
        assert_eq!(soup.face_count(), 99_996);
        assert_eq!(topology(&soup), (2, 0));
        let ellipsoid = Ellipsoid { semi_axes: DVec3::new(3.0, 2.0, 1.0) };
        let soup = ellipsoid.random_hull(500, 2).unwrap();
        assert_eq!(topology(&soup), (2, 0));
        assert_facing(&soup, &ellipsoid);
    }

    #[test]
    fn coplanar_points_are_handled_exactly() {
        // A 5 x 5 x 5 grid: all flat sides, edges and repeated directions.
        let points: Vec<DVec3> = (0..125)
            .map(|i| DVec3::new((i % 5) as f64, (i / 5 % 5) as f64, (i / 25) as f64) * 0.1)
            .collect();
        let faces = convex_hull(&points).unwrap();
        let soup = PolygonSoup::from_triangles(&points, &faces).unwrap();
        assert!((volume(&soup) - 0.064).abs() < 1e-15);
        for triangle in triangles(&soup) {
            assert!(points.iter().all(|&p| above(triangle, p) <= 0.0));
        }
        let sides: HashSet<(u32, u32)> =
            faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        assert_eq!(sides.len(), 3 * faces.len());
        assert!(sides.iter().all(|&(a, b)| sides.contains(&(b, a))));
    }

    #[test]
    fn the_seven_points_have_the_listed_hull() {
        let convex = seven_points::convex();
        assert_eq!(convex_hull(convex.positions()).unwrap(), faces(&convex));
    }

    #[test]
    fn points_without_volume_are_refused() {
        let flat: Vec<DVec3> = (0..50).map(|i| DVec3::new((i % 7) as f64, i as f64, 0.3)).collect();
        assert_eq!(convex_hull(&flat), Err(HullError::Flat { points: 50 }));
        assert_eq!(convex_hull(&[DVec3::ONE; 9]), Err(HullError::Flat { points: 9 }));
        assert_eq!(convex_hull(&[]), Err(HullError::Flat { points: 0 }));
        let bad = [DVec3::ZERO, DVec3::X, DVec3::NAN, DVec3::Y];
        assert_eq!(convex_hull(&bad), Err(HullError::NotFinite { point: 2 }));
        assert!(Sphere::UNIT.random_hull(3, 0).is_err());
        assert!(Sphere { radius: 0.0 }.random_hull(10, 0).is_err());
    }
}
