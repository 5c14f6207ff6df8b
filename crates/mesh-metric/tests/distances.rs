//! Distances compared with closed forms, brute force, an independent library, and real meshes.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use glam::{DQuat, DVec3};
use mesh_core::{FaceId, PolygonSoup, SplitMix64, TriMesh};
use mesh_metric::{
    CertifyOptions, CompareOptions, SignedDistance, Surface, SurfaceError, closest_on_triangle,
    compare, compare_until, hausdorff_bounds, hausdorff_bounds_until, one_sided_bounds,
    sample_surface, sampled_hausdorff, vertex_distances,
};
use mesh_shapes::{Plane, Sphere, polyhedra};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

fn mesh(soup: &PolygonSoup) -> TriMesh {
    TriMesh::from_soup(soup).unwrap()
}

fn moved(mesh: &TriMesh, place: impl Fn(DVec3) -> DVec3) -> TriMesh {
    let mut mesh = mesh.clone();
    for p in mesh.positions_mut() {
        *p = place(*p);
    }
    mesh
}

fn random_points(count: usize, size: f64, seed: u64) -> Vec<DVec3> {
    let mut random = SplitMix64::new(seed);
    let mut coordinate = || size * random.symmetric();
    (0..count).map(|_| DVec3::new(coordinate(), coordinate(), coordinate())).collect()
}

fn sphere() -> TriMesh {
    mesh(&Sphere { radius: 1.0 }.random_hull(400, 3).unwrap())
}

#[test]
fn closest_points_agree_with_brute_force() {
    let mesh = sphere();
    let surface = Surface::new(&mesh).unwrap();
    for point in random_points(2000, 2.0, 9) {
        let by_force = mesh
            .topology()
            .faces()
            .map(|f| closest_on_triangle(point, &mesh.triangle(f)).length())
            .fold(f64::INFINITY, f64::min);
        let closest = surface.closest(point);
        assert_eq!(closest.distance, by_force);
        let on_face = closest_on_triangle(point, &mesh.triangle(closest.face));
        assert_eq!(closest.offset, on_face);
        assert_eq!(surface.distance(point), by_force);
    }
}

/// A cone of needles across the axes, which the tree stores in sections.
#[test]
fn closest_points_on_needles_agree_with_brute_force() {
    let count = 3000;
    let rim = (0..count).map(|i| {
        let angle = core::f64::consts::TAU * f64::from(i) / f64::from(count);
        DVec3::new(angle.cos(), angle.sin(), 0.0)
    });
    let positions: Vec<DVec3> = rim.chain([DVec3::Z]).collect();
    let faces: Vec<[u32; 3]> = (0..count).map(|i| [i, (i + 1) % count, count]).collect();
    let cone = TriMesh::from_triangles(&positions, &faces).unwrap();
    let turned = moved(&cone, |p| DQuat::from_rotation_x(0.8) * DVec3::new(2.0 * p.x, p.y, p.z));
    let mut surface = Surface::new(&cone).unwrap();
    for mesh in [&cone, &turned] {
        surface.follow(mesh).unwrap();
        let mut order = surface.in_space().to_vec();
        order.sort_unstable();
        assert!(order.into_iter().eq(0..count));
        let points = random_points(300, 1.5, 11);
        let distances = surface.distances(&points);
        for (&point, distance) in points.iter().zip(distances) {
            let faces = mesh.topology().faces();
            let to_face = |f| closest_on_triangle(point, &mesh.triangle(f)).length();
            let by_force = faces.map(to_face).fold(f64::INFINITY, f64::min);
            assert_eq!(surface.closest(point).distance, by_force);
            assert_eq!(distance, by_force);
        }
    }
}

#[test]
fn all_triangles_within_a_distance_are_asked() {
    let fan: Vec<[u32; 3]> = (0..333).map(|i| [i, (i + 1) % 333, 333]).collect();
    let rim = (0..333).map(|i| {
        let (y, x) = (f64::from(i) / 53.0).sin_cos();
        DVec3::new(x, y, 0.0)
    });
    let cone = TriMesh::from_triangles(&rim.chain([DVec3::Z]).collect::<Vec<_>>(), &fan).unwrap();
    for mesh in [sphere(), cone] {
        let surface = Surface::new(&mesh).unwrap();
        for point in random_points(300, 1.5, 6) {
            let distance = 1.3 * surface.distance(point);
            let is_near =
                |f: &FaceId| closest_on_triangle(point, &mesh.triangle(*f)).length() <= distance;
            let near: BTreeSet<usize> =
                mesh.topology().faces().filter(is_near).map(FaceId::index).collect();
            let mut asked = BTreeSet::new();
            let found = surface.has_within(point, distance, |triangle| {
                asked.insert(triangle);
                false
            });
            assert!(!found);
            assert_eq!(asked, near);
            assert!(surface.has_within(point, distance, |triangle| near.contains(&triangle)));
        }
    }
}

#[test]
fn only_what_is_closer_than_a_distance_is_found() {
    let surface = Surface::new(&sphere()).unwrap();
    let points = random_points(3000, 2.0, 4);
    let all: Vec<f64> = points.iter().map(|&p| surface.distance(p)).collect();
    // Limits just above, just below, and equal to the distance.
    let than: Vec<f64> =
        all.iter().zip(0..).map(|(&d, i)| d * [1.0 + 1e-9, 1.0 - 1e-9, 1.0][i % 3]).collect();
    for (i, found) in surface.closer_points(&points, &than).into_iter().enumerate() {
        match i % 3 {
            0 => assert_eq!(found.unwrap().distance, all[i]),
            1 => assert!(found.is_none()),
            // The square of a root can be rounded in either direction.
            _ => assert!(found.is_none_or(|found| found.distance == all[i])),
        }
    }
}

#[test]
fn points_are_within_the_largest_of_their_distances() {
    let surface = Surface::new(&sphere()).unwrap();
    let points = random_points(3000, 2.0, 8);
    let distances = surface.distances(&points);
    let largest = distances.iter().copied().fold(0.0, f64::max);
    assert!(surface.are_within(&points, largest * (1.0 + 1e-12)));
    assert!(!surface.are_within(&points, largest * (1.0 - 1e-12)));
    // Points closer than a limit are within it; with one more point they are not.
    let (mut near, far): (Vec<DVec3>, Vec<DVec3>) =
        points.iter().partition(|&&point| surface.distance(point) < 0.3);
    assert!(surface.are_within(&near, 0.3));
    near.insert(near.len() / 2, far[0]);
    assert!(!surface.are_within(&near, 0.3));
    let vertices: Vec<DVec3> = surface.positions().to_vec();
    assert!(surface.are_within(&vertices, 1e-12) && !surface.are_within(&vertices, -1e-9));
    assert!(!surface.are_within(&vertices, f64::NAN) && surface.are_within(&[], 0.0));
    assert!(!surface.are_within(&[DVec3::NAN], f64::INFINITY));
}

#[test]
fn a_surface_follows_its_mesh() {
    let mut mesh = sphere();
    let mut surface = Surface::new(&mesh).unwrap();
    let count = surface.triangle_count();
    let mut order: Vec<u32> = surface.in_space().to_vec();
    order.sort_unstable();
    assert!(order.into_iter().eq(0..count as u32));
    mesh = moved(&mesh, |p| DVec3::new(p.x, 2.0 * p.y, p.z + 0.1 * p.x));
    let edges: Vec<_> = mesh.topology().edges().step_by(7).collect();
    let mut flips = 0;
    for edge in edges {
        if let Ok(flip) = mesh.topology().check_flip(edge) {
            mesh.flip(flip);
            flips += 1;
        }
    }
    assert!(flips > 50);
    surface.follow(&mesh).unwrap();
    let anew = Surface::new(&mesh).unwrap();
    assert_eq!(surface.bounding_box(), anew.bounding_box());
    let points = random_points(2000, 2.5, 6);
    let neighbours = surface.closest_to_neighbours(&points);
    for ((&p, d), by_neighbour) in points.iter().zip(anew.distances(&points)).zip(neighbours) {
        assert_eq!(surface.distance(p), d);
        assert_eq!(by_neighbour.distance, d);
    }
    let other = mesh_of_two();
    let error = surface.follow(&other).unwrap_err();
    assert_eq!(error, SurfaceError::OtherFaces { count, found: 2 });
    assert_eq!(surface.triangle_count(), count);
}

fn mesh_of_two() -> TriMesh {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    TriMesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap()
}

#[test]
fn a_proof_ends_whenever_it_is_told_to() {
    let other = mesh(&Sphere { radius: 1.0 }.random_hull(300, 8).unwrap());
    let [a, b] = [&sphere(), &other].map(|mesh| Surface::new(mesh).unwrap());
    let options = CertifyOptions { tolerance: 1e-7, ..CertifyOptions::default() };
    let mut asked = 0;
    let never = &mut || {
        asked += 1;
        false
    };
    let whole = hausdorff_bounds_until(&a, &b, &options, never).unwrap();
    assert_eq!(whole, hausdorff_bounds(&a, &b, &options));
    // The run can be stopped in every round of either direction.
    assert!(asked > 8, "{asked}");
    for end in 0..asked {
        let mut left = end;
        let stops = &mut || {
            left -= 1;
            left < 0
        };
        assert!(hausdorff_bounds_until(&a, &b, &options, stops).is_none(), "{end}");
    }
}

#[test]
fn many_at_once_are_as_far_as_one_by_one() {
    let surface = Surface::new(&sphere()).unwrap();
    // Dense, scattered, and non-finite points.
    let mut points: Vec<DVec3> =
        sample_surface(&surface, 20_000, 5).iter().map(|sample| 1.01 * sample.position).collect();
    points.extend(random_points(1000, 2.0, 10));
    points.push(DVec3::new(f64::NAN, 0.0, 0.0));
    points.push(DVec3::INFINITY);
    points.extend(random_points(10, 0.1, 11));
    let distances = surface.distances(&points);
    for ((&point, &distance), closest) in
        points.iter().zip(&distances).zip(surface.closest_points(&points))
    {
        assert_eq!(closest.distance.to_bits(), distance.to_bits());
        if point.is_finite() {
            assert_eq!(distance, surface.distance(point));
        } else {
            assert!(distance.is_nan());
        }
    }
}

#[test]
fn closest_points_agree_with_parry() {
    use parry3d_f64::math::Vector;
    use parry3d_f64::query::PointQuery;
    use parry3d_f64::shape::TriMesh as Oracle;
    let mesh = sphere();
    let surface = Surface::new(&mesh).unwrap();
    let corners = mesh.positions().iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let oracle = Oracle::new(corners, mesh.topology().triangles().collect()).unwrap();
    for point in random_points(1000, 2.0, 21) {
        let expected =
            oracle.distance_to_local_point(Vector::new(point.x, point.y, point.z), false);
        assert!((surface.distance(point) - expected).abs() < 1e-12);
    }
}

#[test]
fn signs_tell_inside_from_outside() {
    let mesh = mesh(&polyhedra::cube());
    let signed = SignedDistance::new(&mesh).unwrap();
    let half = mesh.bounding_box().unwrap().extent() / 2.0;
    let center = mesh.bounding_box().unwrap().center();
    for point in random_points(5000, 3.0 * half.x, 4) {
        // The distance to a box in closed form.
        let q = point.abs() - half;
        let expected = q.max(DVec3::ZERO).length() + q.max_element().min(0.0);
        let got = signed.distance(center + point);
        assert!((got - expected).abs() < 1e-12, "{point}: {got}, not {expected}");
    }
}

#[test]
fn a_spike_has_the_right_sign_beyond_its_tip() {
    // A needle: at the tip, the normals of most faces point away from points beyond it.
    let corners = [[0.0, 0.0, 10.0], [1.0, 0.0, 0.0], [-1.0, 0.1, 0.0], [-1.0, -0.1, 0.0]];
    let mesh =
        TriMesh::from_triangles(&corners, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).unwrap();
    assert!(mesh.volume() > 0.0);
    let signed = SignedDistance::new(&mesh).unwrap();
    for point in random_points(500, 0.5, 8) {
        let beyond = DVec3::new(point.x, point.y, 10.6 + point.z);
        assert!(signed.distance(beyond) > 0.0, "{beyond}");
    }
    assert!(signed.distance(DVec3::new(0.0, 0.0, 1.0)) < 0.0);
}

#[test]
fn an_offset_copy_is_the_offset_away() {
    let offset = 0.123_456_789;
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let flat =
        moved(&mesh(&Plane { half_width: 0.5 }.mesh(13, Default::default()).unwrap()), |p| {
            turn * p
        });
    let copy = moved(&flat, |p| p + turn * (offset * DVec3::Z));
    let (a, b) = (Surface::new(&flat).unwrap(), Surface::new(&copy).unwrap());
    let options = CompareOptions { samples: 10_000, ..Default::default() };
    let result = compare(&a, &b, &options);
    for side in [result.forward, result.backward] {
        for value in [side.mean, side.rms, side.max, side.worst.from.distance(side.worst.to)] {
            assert!((value - offset).abs() < 1e-12, "{side:?}");
        }
    }
    let bounds =
        hausdorff_bounds(&a, &b, &CertifyOptions { tolerance: 1e-13, ..Default::default() });
    assert!(bounds.converged && bounds.lower <= offset && offset <= bounds.upper);
    assert!(bounds.upper - bounds.lower < 1e-12);
}

#[test]
fn parallel_triangles_moved_sideways_have_the_distance_of_their_corners() {
    // The corner (0, 0, 0) of the first is sqrt(1 + 4) from the second.
    let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let shifted = corners.map(|[x, y, z]| [x + 1.0, y, z + 2.0]);
    let surface = |c: &[[f64; 3]]| Surface::from_triangles(c, &[[0, 1, 2]]).unwrap();
    let options = CertifyOptions { tolerance: 1e-6, ..Default::default() };
    let bounds = hausdorff_bounds(&surface(&corners), &surface(&shifted), &options);
    let exact = 5.0_f64.sqrt();
    assert!(bounds.lower <= exact && exact <= bounds.upper, "{bounds:?}");
    assert!(bounds.upper - bounds.lower <= 1.001e-6);
}

#[test]
fn a_tent_is_measured_in_the_middle_where_it_has_no_vertex() {
    // The flat square is farthest from the ridge of the tent; half of the ridge lies above the interior of faces.
    let square = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
    let flat = Surface::from_triangles(&square, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let tent = [square.to_vec(), vec![[1.0, 1.0, 1.0]]].concat();
    let tent =
        Surface::from_triangles(&tent, &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]).unwrap();
    let options = CertifyOptions { tolerance: 1e-5, ..Default::default() };
    // From the centre of the square, the faces of the tent are 1/sqrt(2) away.
    let expected = 0.5_f64.sqrt();
    let bounds = one_sided_bounds(&flat, &tent, &options);
    assert!(bounds.lower <= expected && expected <= bounds.upper, "{bounds:?}");
    assert!(bounds.converged && bounds.upper - bounds.lower <= 1.001e-5);
    assert!(bounds.at.distance(DVec3::new(1.0, 1.0, 0.0)) < 1e-4);
    let back = one_sided_bounds(&tent, &flat, &options);
    assert!(back.lower <= 1.0 && 1.0 <= back.upper);
}

#[test]
fn bounds_hold_at_the_limit_of_pieces() {
    let (coarse, fine) = (Sphere { radius: 1.0 }.icosphere(2), Sphere { radius: 1.0 }.icosphere(4));
    let (a, b) = (mesh(&coarse.unwrap()), mesh(&fine.unwrap()));
    let (a, b) = (Surface::new(&a).unwrap(), Surface::new(&b).unwrap());
    let tight = hausdorff_bounds(&a, &b, &CertifyOptions { tolerance: 1e-6, ..Default::default() });
    assert!(tight.converged && tight.upper - tight.lower <= 1.001e-6, "{tight:?}");
    let options =
        CertifyOptions { tolerance: 1e-6, max_pieces: 1000, max_pieces_per_face: 0, limit: None };
    let stopped = hausdorff_bounds(&a, &b, &options);
    assert!(!stopped.converged);
    assert!(stopped.lower <= tight.upper && tight.lower <= stopped.upper);
    let sampled = compare(&a, &b, &CompareOptions { samples: 50_000, ..Default::default() });
    assert!(sampled.hausdorff() <= tight.upper);
    assert!(sampled.hausdorff() > 0.9 * tight.lower);
}

/// Needles and scattered samples use different search methods from other triangles.
#[test]
fn the_largest_sampled_distance_alone_is_that_of_a_comparison() {
    let sphere = |level| Sphere { radius: 1.0 }.icosphere(level).unwrap();
    let [coarse, fine] = [2, 4].map(|level| Surface::new(&mesh(&sphere(level))).unwrap());
    let stretched = moved(&mesh(&sphere(4)), |p| p * DVec3::new(1.0, 1e-4, 300.0));
    let needles = Surface::new(&stretched).unwrap();
    for (a, b) in [(&coarse, &fine), (&fine, &coarse), (&coarse, &needles), (&needles, &fine)] {
        for samples in [300, 30_000] {
            let options = CompareOptions { samples, ..Default::default() };
            let whole = compare(a, b, &options).hausdorff();
            assert!(whole > 0.0);
            assert_eq!(sampled_hausdorff(a, b, &options), whole);
        }
    }
}

#[test]
fn surfaces_that_coincide_are_certified_in_few_pieces_however_small_the_tolerance() {
    let tile = Plane { half_width: 0.5 };
    let [a, b] = [7, 32].map(|cells| mesh(&tile.mesh(cells, Default::default()).unwrap()));
    let faces = a.topology().face_count() + b.topology().face_count();
    let (a, b) = (Surface::new(&a).unwrap(), Surface::new(&b).unwrap());
    let options = CertifyOptions { tolerance: 1e-10, ..Default::default() };
    let bounds = hausdorff_bounds(&a, &b, &options);
    assert!(bounds.converged && bounds.upper <= 1.01e-10, "{bounds:?}");
    assert!(bounds.pieces < 20 * faces, "{} pieces for {faces} faces", bounds.pieces);
}

#[test]
fn a_limit_is_decided_on_the_right_side() {
    let (a, b) = (sphere(), moved(&sphere(), |p| p * DVec3::new(1.0, 1.1, 0.9)));
    let (a, b) = (Surface::new(&a).unwrap(), Surface::new(&b).unwrap());
    let exact = hausdorff_bounds(&a, &b, &CertifyOptions { tolerance: 1e-6, ..Default::default() });
    for (limit, within) in [(0.5, false), (0.999, false), (1.001, true), (2.0, true)] {
        let limit = limit * exact.lower;
        let options = CertifyOptions { limit: Some(limit), ..Default::default() };
        let decided = hausdorff_bounds(&a, &b, &options);
        assert!(decided.converged);
        assert_eq!((decided.upper <= limit, decided.lower > limit), (within, !within));
        assert!(decided.lower <= exact.upper && exact.lower <= decided.upper);
        assert!(decided.pieces < exact.pieces);
    }
}

#[test]
fn means_converge_to_the_closed_form() {
    // Concentric spheres: every distance is the difference of the radii, up to the faceting.
    let of_radius = |radius| mesh(&Sphere { radius }.icosphere(6).unwrap());
    let (a, b) = (Surface::new(&of_radius(1.0)).unwrap(), Surface::new(&of_radius(1.25)).unwrap());
    let result = compare(&a, &b, &CompareOptions { samples: 20_000, ..Default::default() });
    assert!((result.mean() - 0.25).abs() < 2e-4 && (result.rms() - 0.25).abs() < 2e-4);
    // A plane against one inclined by 45 degrees through the middle: the mean of |x| sin 45.
    let flat = mesh(&Plane { half_width: 1.0 }.mesh(4, Default::default()).unwrap());
    let steep = moved(&flat, |p| 10.0 * DVec3::new(p.x, p.y, p.x));
    let result = compare(
        &Surface::new(&flat).unwrap(),
        &Surface::new(&steep).unwrap(),
        &CompareOptions { samples: 100_000, ..Default::default() },
    );
    let sine = 0.5_f64.sqrt();
    assert!((result.forward.mean - 0.5 * sine).abs() < 1e-4, "{result:?}");
    assert!((result.forward.rms - sine / 3.0_f64.sqrt()).abs() < 1e-4);
    assert!((result.forward.max - sine).abs() < 1e-12);
}

#[test]
fn one_thread_and_eight_threads_give_the_same_bits() {
    let (a, b) = (sphere(), moved(&sphere(), |p| p * DVec3::new(1.0, 1.1, 0.9)));
    let run = |threads: usize| {
        let pool = rayon_pool(threads);
        pool.install(|| {
            let (a, b) = (Surface::new(&a).unwrap(), Surface::new(&b).unwrap());
            let options = CompareOptions { samples: 30_000, ..Default::default() };
            let certify = CertifyOptions { tolerance: 1e-4, ..Default::default() };
            (compare(&a, &b, &options), hausdorff_bounds(&a, &b, &certify))
        })
    };
    assert_eq!(run(1), run(8));
}

fn rayon_pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

#[test]
fn vertices_far_from_the_other_surface_stand_out() {
    let flat = mesh(&Plane { half_width: 1.0 }.mesh(4, Default::default()).unwrap());
    let mut bent = flat.clone();
    bent.positions_mut()[12].z = 0.5;
    let distances = vertex_distances(&bent, &Surface::new(&flat).unwrap());
    for (vertex, &distance) in distances.iter() {
        assert_eq!(distance, if vertex.index() == 12 { 0.5 } else { 0.0 });
    }
}

#[test]
fn bad_input_is_refused_with_a_reason() {
    let none: [[f64; 3]; 0] = [];
    assert_eq!(Surface::from_triangles(&none, &[]).unwrap_err(), SurfaceError::Empty);
    let points = [[0.0; 3], [1.0; 3], [f64::NAN, 0.0, 0.0]];
    let missing = Surface::from_triangles(&points, &[[0, 1, 7]]).unwrap_err();
    assert!(matches!(missing, SurfaceError::IndexOutOfRange { triangle: 0, vertex: 7, .. }));
    let nan = Surface::from_triangles(&points, &[[0, 1, 2]]).unwrap_err();
    assert!(matches!(nan, SurfaceError::NotFinite { vertex: 2, .. }));
    // A position that no triangle uses does not matter.
    assert!(Surface::from_triangles(&points, &[[0, 1, 1]]).is_ok());
}

#[test]
fn a_surface_without_area_is_measured_by_its_edges() {
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let line = Surface::from_triangles(&points, &[[0, 1, 2]]).unwrap();
    let raised = points.map(|[x, y, z]| [x, y + 3.0, z]);
    let other = Surface::from_triangles(&raised, &[[0, 1, 2]]).unwrap();
    assert!(sample_surface(&line, 10, 1).is_empty());
    let result = compare(&line, &other, &CompareOptions::default());
    assert_eq!((result.forward.mean, result.forward.max), (3.0, 3.0));
}

/// The total length of the edges of a cone is thousands of times its size.
#[test]
fn the_edges_of_needles_have_no_more_points_than_their_share() {
    let count = 5000;
    let rim = |i: u32| {
        let angle = core::f64::consts::TAU * f64::from(i) / f64::from(count);
        DVec3::new(angle.cos(), angle.sin(), 0.0)
    };
    let points: Vec<DVec3> = (0..count).map(rim).chain([DVec3::Z]).collect();
    let triangles: Vec<[u32; 3]> = (0..count).map(|i| [i, (i + 1) % count, count]).collect();
    let cone = Surface::from_triangles(&points, &triangles).unwrap();
    let options = CompareOptions { samples: 10_000, ..CompareOptions::default() };
    let measured = compare(&cone, &cone, &options).forward;
    let on_edges = measured.samples - options.samples - points.len();
    assert!((20_000..=40_000).contains(&on_edges), "{on_edges}");
    // Without area, the edges are the whole surface, but get no more points.
    let flat: Vec<DVec3> = (0..=count).map(|i| DVec3::X * f64::from(i * i)).collect();
    let line = Surface::from_triangles(&flat, &triangles).unwrap();
    let measured = compare(&line, &cone, &options).forward;
    assert!((20_000..=40_000 + flat.len()).contains(&measured.samples), "{}", measured.samples);
}

proptest! {
    /// Random triangle soups, including slivers: no sample exceeds the certified bounds, and the bounds are as close as
    /// requested.
    #[test]
    fn samples_stay_within_certified_bounds(
        seed in 0_u64..1000, count in 1_usize..12, thin in prop::bool::ANY
    ) {
        let soup = |seed| {
            let mut points = random_points(3 * count, 1.0, seed);
            if thin {
                points[2] = 0.5 * points[0] + 0.5 * points[1];
            }
            let triangles: Vec<[u32; 3]> =
                (0..count as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            Surface::from_triangles(&points, &triangles).unwrap()
        };
        let (a, b) = (soup(seed), soup(seed + 5000));
        let certify = CertifyOptions { tolerance: 1e-3, ..Default::default() };
        let bounds = hausdorff_bounds(&a, &b, &certify);
        prop_assert!(bounds.converged && bounds.lower <= bounds.upper);
        prop_assert!(bounds.upper - bounds.lower <= 1.0001e-3);
        let sampled = compare(&a, &b, &CompareOptions { samples: 2000, ..Default::default() });
        prop_assert!(sampled.hausdorff() <= bounds.upper);
        prop_assert!(sampled.forward.mean <= sampled.forward.rms);
        prop_assert!(sampled.forward.rms <= sampled.forward.max);
    }
}

/// Counts its calls, and returns true from call number `limit` on.
fn stops_at(asked: &AtomicUsize, limit: usize) -> impl Fn() -> bool + Sync {
    move || asked.fetch_add(1, Ordering::Relaxed) >= limit
}

#[test]
fn measuring_that_is_not_stopped_is_the_same_and_stops_soon_otherwise() {
    let (a, b) = (sphere(), moved(&sphere(), |p| 1.1 * p));
    let (a, b) = (Surface::new(&a).unwrap(), Surface::new(&b).unwrap());
    let options = CompareOptions { samples: 100_000, ..CompareOptions::default() };
    let asked = AtomicUsize::new(0);
    let found = compare_until(&a, &b, &options, &stops_at(&asked, usize::MAX)).unwrap();
    assert_eq!(found, compare(&a, &b, &options));
    // Calls are frequent: one per thousand points.
    let often = asked.into_inner();
    assert!(often >= 2 * options.samples / 1024, "{often}");
    for limit in [0, 1, often / 3, often - 1] {
        let asked = AtomicUsize::new(0);
        assert_eq!(compare_until(&a, &b, &options, &stops_at(&asked, limit)), None);
    }
    let points = random_points(20_000, 2.0, 4);
    let asked = AtomicUsize::new(0);
    let found = a.distances_until(&points, &stops_at(&asked, usize::MAX)).unwrap();
    assert_eq!(found, a.distances(&points));
    assert!(asked.into_inner() >= points.len() / 1024);
    assert_eq!(a.distances_until(&points, &|| true), None);
}
