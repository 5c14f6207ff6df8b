//! Fitted and averaged curvature against surfaces of known curvature, at irregular samplings.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use dcurv::{
    CurvatureOptions, Curvatures, FitScale, FittedCurvature, JetFitOptions, PrincipalFrame,
    align_directions, ball_curvature, ball_curvatures, ball_curvatures_until, corrected_curvature,
    corrected_curvatures, estimate_noise, fitted_curvature, fitted_curvatures,
    fitted_curvatures_until,
};
use glam::DVec3;
use mesh_core::{FaceId, Handle, PolygonSoup, TriMesh, VertexId, VertexMap};
use mesh_shapes::{
    AnalyticSurface, Cylinder, Ellipsoid, Irregular, RowPhase, Saddle, Sphere, Torus,
    add_normal_noise,
};
use std::sync::atomic::{AtomicUsize, Ordering};

const TORUS: Torus = Torus { major: 2.0, minor: 1.0 };
const SADDLE: Saddle = Saddle { coefficient: 0.5, half_width: 1.0 };
const ELLIPSOID: Ellipsoid = Ellipsoid { semi_axes: DVec3::new(1.0, 0.8, 0.6) };
const CYLINDER: Cylinder = Cylinder { radius: 1.0, height: 2.0 };

fn mesh(soup: &PolygonSoup) -> TriMesh {
    TriMesh::from_soup(soup).unwrap()
}

/// The frames of fitted surfaces.
fn fitted_frames(mesh: &TriMesh, options: &JetFitOptions) -> VertexMap<Option<PrincipalFrame>> {
    fitted_curvatures(mesh, options).map(|fit| fit.map(|fit| fit.frame))
}

/// The largest error of the two principal curvatures, and of the direction of the larger one where
/// they differ by a half or more.
fn errors<'a>(
    mesh: &TriMesh,
    surface: &dyn AnalyticSurface,
    region: &dyn Fn(DVec3) -> bool,
    frames: impl Iterator<Item = (VertexId, &'a Option<PrincipalFrame>)>,
) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for (v, frame) in frames.filter(|(v, _)| region(mesh.position(*v))) {
        let (frame, exact) = (frame.unwrap(), surface.principal_curvatures(mesh.position(v)));
        let [max, min] = [frame.k_max.value() - exact.max, frame.k_min.value() - exact.min];
        worst[0] = worst[0].max(max.abs()).max(min.abs());
        assert!(frame.direction_max.dot(frame.normal).abs() < 1e-12);
        let expected = frame.normal.cross(frame.direction_max);
        assert!(expected.distance(frame.direction_min) < 1e-12);
        if exact.max - exact.min > 0.5 {
            let turn = frame.direction_max.cross(exact.directions.unwrap()[0]).length();
            worst[1] = worst[1].max(turn);
        }
    }
    worst
}

/// Refines irregular samplings of a surface, and returns the mean order in which the errors of the
/// fit fall.
fn orders(
    name: &str,
    surface: &dyn AnalyticSurface,
    region: &dyn Fn(DVec3) -> bool,
    rings: usize,
    refined: &dyn Fn(usize) -> PolygonSoup,
) -> [f64; 2] {
    let options = JetFitOptions::rings(rings);
    let found = [16, 32, 64, 128].map(|n| {
        let mesh = mesh(&refined(n));
        errors(&mesh, surface, region, fitted_frames(&mesh, &options).iter())
    });
    let order = |i: usize| (found[0][i] / found[3][i].max(1e-12)).log2() / 3.0;
    println!("{name}, {rings} rings: {found:.5?}  orders {:5.2} {:5.2}", order(0), order(1));
    [order(0), order(1)]
}

#[test]
fn fits_converge_at_every_vertex_of_irregular_samplings() {
    let disorder = Irregular::default();
    let inside = |p: DVec3| p.x.abs().max(p.y.abs()) < 0.7;
    let middle = |p: DVec3| (p.z - 1.0).abs() < 0.5;
    let everywhere = |_: DVec3| true;
    for rings in [2, 3] {
        let torus = |n| TORUS.irregular_mesh(2 * n, n, disorder).unwrap();
        let saddle = |n| SADDLE.irregular_mesh(n, disorder).unwrap();
        let cylinder = |n| CYLINDER.irregular_mesh(n / 2, n, disorder).unwrap();
        let ellipsoid = |n: usize| ELLIPSOID.irregular_icosphere(n.ilog2() - 1, disorder).unwrap();
        for [curvature, _] in [
            orders("torus", &TORUS, &everywhere, rings, &torus),
            orders("saddle", &SADDLE, &inside, rings, &saddle),
            orders("cylinder", &CYLINDER, &middle, rings, &cylinder),
            orders("ellipsoid", &ELLIPSOID, &everywhere, rings, &ellipsoid),
        ] {
            assert!(curvature >= 0.7);
        }
        let [_, direction] = orders("torus", &TORUS, &everywhere, rings, &torus);
        assert!(direction >= 0.7);
    }
}

#[test]
fn fits_are_one_sided_at_the_boundary_and_still_converge() {
    let everywhere = |_: DVec3| true;
    let saddle = |n| SADDLE.irregular_mesh(n, Irregular::default()).unwrap();
    let [curvature, _] = orders("saddle with its boundary", &SADDLE, &everywhere, 2, &saddle);
    assert!(curvature >= 0.7);
    // Two triangles have too few points; a corner with few edges has just enough.
    let square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]];
    let two = TriMesh::from_triangles(&square, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    assert!(fitted_frames(&two, &JetFitOptions::default()).iter().all(|(_, f)| f.is_none()));
    let grid = mesh(&SADDLE.mesh(4, Default::default()).unwrap());
    let one = JetFitOptions::rings(1);
    assert!(fitted_frames(&grid, &one).iter().all(|(_, frame)| frame.is_some()));
}

#[test]
fn more_rings_average_noise_out() {
    let mut soup = Sphere::UNIT.icosphere(4).unwrap();
    add_normal_noise(&mut soup, 0.02, 3);
    let mesh = mesh(&soup);
    let worst = [2, 3, 4].map(|rings| {
        let options = JetFitOptions::rings(rings);
        errors(&mesh, &Sphere::UNIT, &|_| true, fitted_frames(&mesh, &options).iter())[0]
    });
    println!("errors by rings: {worst:.3?}");
    assert!(worst.windows(2).all(|w| w[1] < w[0]) && worst[2] < 0.35 * worst[0]);
}

#[test]
fn one_vertex_and_all_give_the_same_bits_on_any_number_of_threads() {
    let mesh = mesh(&TORUS.irregular_mesh(40, 20, Irregular::default()).unwrap());
    let options = JetFitOptions::default();
    let in_pool = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (fitted_curvatures(&mesh, &options), ball_curvatures(&mesh, 0.4).unwrap()))
    };
    let (frames, balls) = in_pool(1);
    assert_eq!(in_pool(3), (frames.clone(), balls.clone()));
    for vertex in mesh.topology().vertices().step_by(7) {
        assert_eq!(fitted_curvature(&mesh, vertex, &options), frames[vertex]);
        assert_eq!(ball_curvature(&mesh, vertex, 0.4).unwrap(), balls[vertex]);
    }
}

#[test]
fn a_ball_round_everything_holds_the_totals() {
    for mesh in [
        mesh(&TORUS.irregular_mesh(30, 15, Irregular::default()).unwrap()),
        mesh(&SADDLE.irregular_mesh(12, Irregular::default()).unwrap()),
    ] {
        let ball = ball_curvature(&mesh, VertexId::new(0), 20.0).unwrap();
        let curvatures = Curvatures::of(&mesh, &CurvatureOptions::default());
        let [all, inner] = [curvatures.totals(), curvatures.interior_totals()];
        assert!((ball.area.value() - mesh.area()).abs() < 1e-12 * mesh.area());
        assert!((ball.gaussian.value() - inner.gaussian.value()).abs() < 1e-11);
        assert!((ball.mean.value() - all.mean.value()).abs() < 1e-10);
        assert!((ball.abs_dihedral.value() - all.abs_dihedral.value()).abs() < 1e-10);
        let trace = ball.tensor.x_axis.x + ball.tensor.y_axis.y + ball.tensor.z_axis.z;
        assert!((trace - 2.0 * ball.mean.value()).abs() < 1e-10);
    }
}

#[test]
fn averages_over_balls_converge_on_irregular_samplings() {
    // The radius shrinks with the square root of the edge length.
    let disorder = Irregular::default();
    let mut last = [f64::INFINITY; 4];
    for n in [24_u32, 48, 96] {
        let mesh = mesh(&TORUS.irregular_mesh(2 * n as usize, n as usize, disorder).unwrap());
        let radius = 4.0 / f64::from(n).sqrt();
        let mut worst = [0.0_f64; 4];
        for (vertex, ball) in ball_curvatures(&mesh, radius).unwrap().iter() {
            let p = mesh.position(vertex);
            let (exact, frame) = (TORUS.principal_curvatures(p), ball.principal().unwrap());
            let errors = [
                ball.gaussian().value() - TORUS.gaussian_curvature(p),
                ball.mean().value() - TORUS.mean_curvature(p),
                frame.k_max.value() - exact.max,
                if exact.max - exact.min > 0.5 {
                    frame.direction_max.cross(exact.directions.unwrap()[0]).length()
                } else {
                    0.0
                },
            ];
            for (worst, error) in worst.iter_mut().zip(errors) {
                *worst = worst.max(error.abs());
            }
        }
        println!("radius {radius:.3}: {worst:.4?}");
        assert!(worst.iter().zip(last).all(|(now, before)| *now < 0.9 * before));
        last = worst;
    }
    assert!(last.iter().all(|&error| error < 0.2));
}

#[test]
fn averages_are_smooth_where_pointwise_values_are_not() {
    let mut soup = CYLINDER.mesh(40, 120, RowPhase::Staggered).unwrap();
    add_normal_noise(&mut soup, 0.05, 1);
    let mesh = mesh(&soup);
    let middle = |v: VertexId| (mesh.position(v).z - 1.0).abs() < 0.5;
    let spread = |values: &mut dyn Iterator<Item = f64>| {
        values.fold(0.0_f64, |worst, h| worst.max((h - 0.5).abs()))
    };
    let curvatures = Curvatures::of(&mesh, &CurvatureOptions::default());
    let vertices = || mesh.topology().vertices().filter(|&v| middle(v));
    let pointwise = spread(&mut vertices().map(|v| curvatures[v].mean().value()));
    let balls = ball_curvatures(&mesh, 0.3).unwrap();
    let averaged = spread(&mut vertices().map(|v| balls[v].mean().value()));
    println!("largest error of H: pointwise {pointwise:.3}, averaged {averaged:.3}");
    assert!(averaged < 0.05 * pointwise && averaged < 0.2);
}

#[test]
fn other_sheets_near_by_do_not_count() {
    // Two parallel squares at a distance of a tenth, seen from opposite sides.
    let at = |i: u32, z: f64| [f64::from(i % 9) / 8.0, f64::from(i / 9) / 8.0, z];
    let points: Vec<[f64; 3]> =
        (0..81).map(|i| at(i, 0.0)).chain((0..81).map(|i| at(i, 0.1))).collect();
    let cells = (0..72).filter(|i| i % 9 < 8);
    let faces: Vec<[u32; 3]> = cells
        .flat_map(|i| {
            let [a, b, c, d] = [i, i + 1, i + 10, i + 9];
            [[a, b, c], [a, c, d], [a + 81, c + 81, b + 81], [a + 81, d + 81, c + 81]]
        })
        .collect();
    let mesh = TriMesh::from_triangles(&points, &faces).unwrap();
    let ball = ball_curvature(&mesh, VertexId::new(40), 0.3).unwrap();
    let disk = core::f64::consts::PI * 0.09;
    assert!((ball.area.value() - disk).abs() < 1e-12, "{}", ball.area.value());
    assert_eq!((ball.mean.value(), ball.abs_dihedral.value()), (0.0, 0.0));
}

#[test]
fn a_radius_must_be_a_length() {
    let mesh = mesh(&Sphere::UNIT.icosphere(1).unwrap());
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = ball_curvatures(&mesh, radius).unwrap_err();
        assert!(error.to_string().contains("positive finite"), "{error}");
    }
}

#[test]
fn unused_vertices_are_no_matter() {
    let soup = Sphere::UNIT.icosphere(2).unwrap();
    let mut with_more = soup.clone();
    for far in [3e38, -1e300] {
        with_more.push_vertex([far; 3]);
    }
    let (plain, more) = (mesh(&soup), mesh(&with_more));
    let options = JetFitOptions::default();
    let (a, b) = (fitted_frames(&plain, &options), fitted_frames(&more, &options));
    let (c, d) = (ball_curvatures(&plain, 0.5).unwrap(), ball_curvatures(&more, 0.5).unwrap());
    let [e, f] = [&plain, &more].map(|mesh| Curvatures::of(mesh, &CurvatureOptions::default()));
    for vertex in plain.topology().vertices() {
        assert_eq!((a[vertex], c[vertex], e[vertex]), (b[vertex], d[vertex], f[vertex]));
    }
    let unused = VertexId::from_index(plain.positions().len());
    assert_eq!((b[unused], d[unused]), (None, dcurv::BallCurvature::default()));
    assert_eq!(e.totals().f1, f.totals().f1);
    assert_eq!(plain.bounding_box(), more.bounding_box());
}

#[test]
fn a_cone_of_many_faces_takes_no_quadratic_time() {
    let n = 200_000_u32;
    let rim = (0..n).map(|i| {
        let angle = core::f64::consts::TAU * f64::from(i) / f64::from(n);
        [angle.cos(), angle.sin(), 0.0]
    });
    let points: Vec<[f64; 3]> = rim.chain([[0.0, 0.0, 1.0]]).collect();
    let faces: Vec<[u32; 3]> = (0..n).map(|i| [i, (i + 1) % n, n]).collect();
    let mesh = TriMesh::from_triangles(&points, &faces).unwrap();
    let frames = fitted_frames(&mesh, &JetFitOptions::rings(3));
    assert_eq!(frames.len(), points.len());
}

#[test]
fn what_is_not_stopped_is_the_same_and_what_is_gives_nothing() {
    let mesh = mesh(&Sphere { radius: 1.0 }.random_hull(500, 3).unwrap());
    let (radius, options) = (0.3, JetFitOptions::default());
    let asked = AtomicUsize::new(0);
    let stops_at = |limit| {
        let asked = &asked;
        asked.store(0, Ordering::Relaxed);
        move || asked.fetch_add(1, Ordering::Relaxed) >= limit
    };
    let balls = ball_curvatures_until(&mesh, radius, &stops_at(usize::MAX)).unwrap().unwrap();
    assert_eq!(balls, ball_curvatures(&mesh, radius).unwrap());
    let often = asked.load(Ordering::Relaxed);
    assert!(often >= mesh.topology().vertex_count());
    let fits = fitted_curvatures_until(&mesh, &options, &stops_at(usize::MAX)).unwrap();
    assert_eq!(fits, fitted_curvatures(&mesh, &options));
    for limit in [0, 100, often - 1] {
        assert_eq!(ball_curvatures_until(&mesh, radius, &stops_at(limit)), Ok(None));
        assert_eq!(fitted_curvatures_until(&mesh, &options, &stops_at(limit)), None);
    }
    assert!(ball_curvatures_until(&mesh, f64::NAN, &|| true).is_err());
}

/// A disc of thin triangles from a hub, and one more ring: balls of four mean edges contain all faces.
fn crowded_disc(count: u32) -> TriMesh {
    let mut vertices = vec![[0.0, 0.0, 0.0]];
    for ring in 1..=2 {
        let radius = if ring == 1 { 1.0 } else { 1.001 };
        vertices.extend((0..count).map(|i| {
            let (sin, cos) = (core::f64::consts::TAU * f64::from(i) / f64::from(count)).sin_cos();
            [radius * cos, radius * sin, 0.0]
        }));
    }
    let mut triangles = Vec::new();
    for i in 0..count {
        let (a, b) = (1 + i, 1 + (i + 1) % count);
        triangles.extend([[0, a, b], [a, a + count, b + count], [a, b + count, b]]);
    }
    TriMesh::from_triangles(&vertices, &triangles).unwrap()
}

/// Both circles of a cylinder of one row lie on a sphere, too. A flat strip is flat.
#[test]
fn strips_of_one_row_have_no_curvature_unless_they_are_flat() {
    for (inner, height) in [(1.0, 2.0), (1.0, 0.3), (0.5, 0.7), (0.5, 0.0)] {
        let count = 24;
        let rim = |i: u32, radius: f64, z: f64| {
            let (y, x) = (f64::from(i) * core::f64::consts::TAU / f64::from(count)).sin_cos();
            DVec3::new(radius * x, radius * y, z)
        };
        let points = (0..count).map(|i| rim(i, 1.0, 0.0));
        let points: Vec<DVec3> = points.chain((0..count).map(|i| rim(i, inner, height))).collect();
        let sides = |i: u32| {
            let next = (i + 1) % count;
            [[i, next, next + count], [i, next + count, i + count]]
        };
        let triangles: Vec<[u32; 3]> = (0..count).flat_map(sides).collect();
        let mesh = TriMesh::from_triangles(&points, &triangles).unwrap();
        for (_, fit) in fitted_curvatures(&mesh, &JetFitOptions::default()).iter() {
            match fit {
                None => assert!(height > 0.0),
                Some(fit) => assert!(height == 0.0 && fit.frame.k_max.value().abs() < 1e-9),
            }
        }
    }
}

/// The default radius is reduced so that the total number of faces in balls is at most 1,000 per vertex, as a sample
/// shows, and 400 in a mesh with a vertex of very high valence.
#[test]
fn the_default_ball_radius_bounds_the_faces_per_ball() {
    let near = |fan: &TriMesh, radius: f64| {
        // Faces in a ball around a vertex of the rim, counted by the nearest corner.
        let center = fan.position(VertexId::new(1));
        let corners = |face| fan.triangle(face).map(|corner| corner.distance(center));
        let is_near = |&face: &FaceId| corners(face).iter().any(|&distance| distance <= radius);
        fan.topology().faces().filter(is_near).count()
    };
    let four = |mesh: &TriMesh| 4.0 * mesh.mean_edge_length().unwrap();
    let fan = crowded_disc(6000);
    let radius = dcurv::default_ball_radius(&fan);
    assert!(radius < 0.5 * four(&fan), "{radius}");
    assert!(near(&fan, radius) <= 400, "{}", near(&fan, radius));
    // The limit of vertices of fewer edges.
    let smaller = crowded_disc(1000);
    let radius = dcurv::default_ball_radius(&smaller);
    assert_eq!(radius, four(&smaller));
    assert!((400..1000).contains(&near(&smaller, radius)));
    let even = TriMesh::from_soup(&Sphere::UNIT.icosphere(4).unwrap()).unwrap();
    assert_eq!(dcurv::default_ball_radius(&even), four(&even));
}

/// The errors of both principal curvatures, divided by the larger one, at interior vertices: the median and the 95th
/// percentile. And the share of vertices whose error is within the predicted one.
fn relative_errors(
    mesh: &TriMesh,
    surface: &dyn AnalyticSurface,
    fits: &VertexMap<Option<FittedCurvature>>,
) -> [f64; 3] {
    let (mut errors, mut within) = (Vec::new(), 0);
    for vertex in mesh.topology().vertices().filter(|&v| !mesh.topology().is_boundary_vertex(v)) {
        let exact = surface.principal_curvatures(mesh.position(vertex));
        let fit = fits[vertex].unwrap();
        let [max, min] = [fit.frame.k_max.value() - exact.max, fit.frame.k_min.value() - exact.min];
        let error = max.abs().max(min.abs());
        within += usize::from(error <= fit.error.value());
        errors.push(error / exact.max.abs().max(exact.min.abs()));
    }
    errors.sort_by(f64::total_cmp);
    let count = errors.len();
    [errors[count / 2], errors[(count - 1) * 95 / 100], within as f64 / count as f64]
}

#[test]
fn near_points_decide_across_a_pipe_with_long_triangles() {
    let pipe = Torus { major: 5.0, minor: 0.4 };
    for (rings, sides) in [(24, 12), (24, 24), (24, 48), (24, 96), (150, 12)] {
        let mesh = mesh(&pipe.mesh(rings, sides).unwrap());
        for scale in [FitScale::Nearest, FitScale::Noise(estimate_noise(&mesh))] {
            let options = JetFitOptions { scale, ..JetFitOptions::default() };
            let [median, worst, _] =
                relative_errors(&mesh, &pipe, &fitted_curvatures(&mesh, &options));
            println!("{rings} x {sides}, {scale:?}: {median:.5} {worst:.5}");
            assert!(median < 0.02 && worst < 0.03, "{rings} x {sides}: {median} {worst}");
        }
    }
}

#[test]
fn spheres_and_cylinders_are_exact_however_coarse() {
    for level in 1..4 {
        let mesh = mesh(&Sphere::UNIT.irregular_icosphere(level, Irregular::default()).unwrap());
        let fits = fitted_curvatures(&mesh, &JetFitOptions::default());
        let [_, worst, _] = relative_errors(&mesh, &Sphere::UNIT, &fits);
        assert!(worst < 1e-6, "level {level}: {worst}");
    }
    // Eight sides: a section of an octagon is a circle of the right radius.
    let mesh = mesh(&CYLINDER.mesh(8, 12, RowPhase::Aligned).unwrap());
    let fits = fitted_curvatures(&mesh, &JetFitOptions::default());
    let [median, worst, _] = relative_errors(&mesh, &CYLINDER, &fits);
    println!("octagonal cylinder {median:.5} {worst:.5}");
    assert!(worst < 0.02, "{worst}");
}

/// Regular, irregular and stretched samplings of surfaces.
fn samplings() -> Vec<(&'static str, PolygonSoup, &'static dyn AnalyticSurface)> {
    let disorder = Irregular::default();
    vec![
        ("ellipsoid", ELLIPSOID.irregular_icosphere(4, disorder).unwrap(), &ELLIPSOID),
        ("hull", ELLIPSOID.random_hull(1500, 5).unwrap(), &ELLIPSOID),
        ("torus", TORUS.mesh(80, 40).unwrap(), &TORUS),
        ("irregular torus", TORUS.irregular_mesh(80, 40, disorder).unwrap(), &TORUS),
        ("stretched torus", TORUS.irregular_mesh(40, 80, disorder).unwrap(), &TORUS),
        ("saddle", SADDLE.irregular_mesh(30, disorder).unwrap(), &SADDLE),
    ]
}

#[test]
fn noise_is_estimated_from_the_mesh() {
    for (name, soup, _) in samplings() {
        let edge = mesh_shapes::mean_edge_length(&soup);
        let clean = estimate_noise(&mesh(&soup)) / edge;
        assert!(clean < 2e-4, "{name}: {clean}");
        for relative in [0.002, 0.01, 0.05] {
            let mut noisy = soup.clone();
            add_normal_noise(&mut noisy, relative, 7);
            let found = estimate_noise(&mesh(&noisy)) / edge;
            println!("{name}: {relative} {found:.5}");
            assert!((0.75..1.25).contains(&(found / relative)), "{name}: {relative} {found}");
        }
    }
    let lonely = mesh(&PolygonSoup::default());
    assert_eq!(estimate_noise(&lonely), 0.0);
}

#[test]
fn the_scale_follows_the_noise_and_the_error_is_known() {
    for (name, soup, surface) in samplings() {
        for relative in [0.0, 0.01, 0.05] {
            let mut noisy = soup.clone();
            add_normal_noise(&mut noisy, relative, 11);
            let (clean, noisy) = (mesh(&soup), mesh(&noisy));
            let noise = estimate_noise(&noisy);
            let scale = |scale| JetFitOptions { scale, ..JetFitOptions::default() };
            // Exact values belong to the points without noise.
            let measured = |options: &JetFitOptions| {
                relative_errors(&clean, surface, &fitted_curvatures(&noisy, options))
            };
            let chosen = measured(&scale(FitScale::Noise(noise)));
            let edge = noisy.mean_edge_length().unwrap();
            let fixed = [1.0, 2.0, 3.0, 4.0]
                .map(|k| measured(&scale(FitScale::Radius(k * edge))))
                .into_iter()
                .chain([measured(&JetFitOptions::default())])
                .map(|[median, ..]| median)
                .fold(f64::INFINITY, f64::min);
            println!("{name}, noise {relative}: chosen {chosen:.4?}, best fixed {fixed:.4}");
            assert!(chosen[0] < 2.5 * fixed + 1e-3, "{name} {relative}: {} {fixed}", chosen[0]);
            assert!(chosen[2] > 0.85, "{name} {relative}: {} within their errors", chosen[2]);
        }
    }
}

/// Fits through the vertex follow the noise of the short edges. They must not rule out smoother fits, which are right.
/// Within the radius of such a fit, there are many more points across the triangles than three rings hold, and the
/// curvature along, which is uncertain, must not excuse a wrong curvature across.
#[test]
fn long_triangles_with_noise_are_smoothed() {
    let torus = Torus { major: 2.0, minor: 0.7 };
    // Triangles that are six, twelve and twenty times longer than wide.
    for [around, across] in [[25, 54], [18, 78], [14, 98]] {
        let soup = torus.mesh(around, across).unwrap();
        for relative in [0.002, 0.005, 0.01] {
            let mut noisy = soup.clone();
            add_normal_noise(&mut noisy, relative, 3);
            let (clean, noisy) = (mesh(&soup), mesh(&noisy));
            let scale = FitScale::Noise(estimate_noise(&noisy));
            let fits =
                fitted_curvatures(&noisy, &JetFitOptions { scale, ..JetFitOptions::default() });
            let [median, most, within] = relative_errors(&clean, &torus, &fits);
            println!("{around} by {across}, noise {relative}: {median:.4} {most:.4} {within:.3}");
            assert!(median < 0.08, "{around} by {across}, noise {relative}: {median}");
            assert!(most < 0.3, "{around} by {across}, noise {relative}: {most}");
            assert!(within > 0.9, "{around} by {across}, noise {relative}: {within}");
        }
    }
}

/// Prisms of few sides and many rows: all near points are in three columns, which determine no polynomial of fourth
/// degree. With noise, the places within a column foretell the heights.
#[test]
fn three_columns_of_points_determine_the_curvature() {
    let cylinder = Cylinder { radius: 1.0, height: 3.0 };
    for sides in 6..=12 {
        let soup = cylinder.mesh(sides, 1000 / sides, RowPhase::Aligned).unwrap();
        let clean = mesh(&soup);
        let errors = |mesh: &TriMesh, scale: FitScale| {
            let fits =
                fitted_curvatures(mesh, &JetFitOptions { scale, ..JetFitOptions::default() });
            relative_errors(&clean, &cylinder, &fits)
        };
        for scale in [FitScale::Nearest, FitScale::Noise(estimate_noise(&clean))] {
            let [_, worst, _] = errors(&clean, scale);
            assert!(worst < 0.01, "{sides} sides, {scale:?}: {worst}");
        }
        let mut noisy = soup.clone();
        add_normal_noise(&mut noisy, 0.01, 7);
        let noise = 0.01 * mesh_shapes::mean_edge_length(&soup);
        let noisy = mesh(&noisy);
        let found = estimate_noise(&noisy);
        let [median, worst, _] = errors(&noisy, FitScale::Noise(found));
        println!("{sides} sides: noise {:.3}, errors {median:.4} {worst:.4}", found / noise);
        assert!((0.75..1.25).contains(&(found / noise)), "{sides} sides: {}", found / noise);
        assert!(median < 0.15, "{sides} sides: {median} {worst}");
    }
}

#[test]
fn corrected_curvature_converges_and_averages_noise() {
    let disorder = Irregular::default();
    let mut last = [f64::INFINITY; 3];
    for n in [24_u32, 48, 96] {
        let mesh = mesh(&TORUS.irregular_mesh(2 * n as usize, n as usize, disorder).unwrap());
        let radius = 4.0 / f64::from(n).sqrt();
        let mut worst = [0.0_f64; 3];
        for (vertex, ball) in corrected_curvatures(&mesh, radius).unwrap().iter() {
            let p = mesh.position(vertex);
            let frame = ball.principal().unwrap();
            let exact = TORUS.principal_curvatures(p);
            // The trace of the tensor is twice the mean curvature.
            let trace = frame.k_max.value() + frame.k_min.value();
            assert!((trace - 2.0 * ball.mean().value()).abs() < 0.2 * exact.max.abs());
            let errors = [
                ball.gaussian().value() - TORUS.gaussian_curvature(p),
                ball.mean().value() - TORUS.mean_curvature(p),
                frame.k_max.value() - exact.max,
            ];
            for (worst, error) in worst.iter_mut().zip(errors) {
                *worst = worst.max(error.abs());
            }
            if vertex.index() % 97 == 0 {
                assert_eq!(corrected_curvature(&mesh, vertex, radius).unwrap(), *ball);
            }
        }
        println!("radius {radius:.3}: {worst:.4?}");
        assert!(worst.iter().zip(last).all(|(now, before)| *now < 0.9 * before));
        last = worst;
    }
    // A sphere with noise: less error than vertex curvatures by far, and no more than plain averages.
    let mut soup = Sphere::UNIT.icosphere(4).unwrap();
    add_normal_noise(&mut soup, 0.05, 1);
    let noisy = mesh(&soup);
    let worst = |values: &mut dyn Iterator<Item = f64>| {
        values.map(|h| (h - 1.0).abs()).fold(0.0_f64, f64::max)
    };
    let corrected = corrected_curvatures(&noisy, 0.4).unwrap();
    let corrected = worst(&mut corrected.iter().map(|(_, ball)| ball.mean().value()));
    let balls = ball_curvatures(&noisy, 0.4).unwrap();
    let plain = worst(&mut balls.iter().map(|(_, ball)| ball.mean().value()));
    println!("H of a noisy sphere: corrected {corrected:.4}, plain {plain:.4}");
    assert!(corrected < 0.1 && corrected < 1.2 * plain);
}

#[test]
fn directions_agree_in_sign_along_a_torus() {
    let mesh = mesh(&TORUS.mesh(60, 30).unwrap());
    let mut frames = fitted_frames(&mesh, &JetFitOptions::default());
    let scrambled = frames.clone();
    align_directions(&mesh, &mut frames);
    for edge in mesh.topology().edges() {
        let [a, b] = mesh.topology().edge_vertices(edge).map(|v| frames[v].unwrap());
        assert!(a.direction_max.dot(b.direction_max) > 0.0);
        assert!(a.direction_min.dot(b.direction_min) > 0.0);
    }
    // Only signs differ.
    for (vertex, frame) in frames.iter() {
        let (now, before) = (frame.unwrap(), scrambled[vertex].unwrap());
        assert_eq!(now.direction_max.abs(), before.direction_max.abs());
        assert_eq!((now.k_max, now.normal), (before.k_max, before.normal));
    }
}

/// A fit at the rim of a fan takes neighbours along the rim, not all vertices of the fan.
#[test]
fn fits_beside_a_vertex_of_high_valence_take_few_points() {
    let sides: u32 = 3000;
    let rim = |i: u32| {
        let angle = core::f64::consts::TAU * f64::from(i) / f64::from(sides);
        DVec3::new(angle.cos(), angle.sin(), 0.01 * (9.0 * angle).sin())
    };
    let points: Vec<_> = (0..sides).map(rim).chain([DVec3::ZERO]).collect();
    let faces: Vec<[u32; 3]> = (0..sides).map(|i| [i, (i + 1) % sides, sides]).collect();
    let mesh = TriMesh::from_triangles(&points, &faces).unwrap();
    for scale in [FitScale::Nearest, FitScale::Noise(0.001), FitScale::Radius(0.05)] {
        let options = JetFitOptions { scale, ..JetFitOptions::default() };
        for vertex in (0..sides).step_by(100).map(VertexId::new) {
            let fit = fitted_curvature(&mesh, vertex, &options);
            assert!(fit.is_none_or(|fit| fit.points <= 400), "{scale:?} {vertex:?}");
        }
    }
}
