//! Annealing of the layout: how close the result is to the least possible distance, and which constraints it keeps.
#![allow(clippy::unwrap_used)]

use core::ops::ControlFlow;
use core::time::Duration;

use mesh_core::{TriMesh, VertexId};
use mesh_metric::{Surface, sample_surface};
use mesh_shapes::{Diagonals, Ellipsoid, Irregular, Saddle, Sphere};
use simplify::{
    AnnealOptions, AnnealReport, FitConstraints, FitNorm, FitOptions, Options, Phase, Preset,
    StopReason, anneal, simplify, simplify_observed,
};

fn sphere() -> TriMesh {
    let irregular = Irregular { jitter: 0.2, seed: 1 };
    TriMesh::from_soup(&Sphere { radius: 1.0 }.irregular_icosphere(5, irregular).unwrap()).unwrap()
}

/// The preset `extreme` with one annealed layout only, and fewer sweeps.
fn annealing(sweeps: usize) -> Options {
    let mut options = Options::preset(Preset::Extreme);
    options.refine.max_error = false;
    let one = AnnealOptions { sweeps, starts: 1, rounds: 0, ..AnnealOptions::default() };
    options.refine.tuning.anneal = one;
    options
}

/// The annealed mesh and the report.
fn annealed(
    start: &TriMesh,
    original: &Surface,
    options: &AnnealOptions,
) -> (TriMesh, AnnealReport) {
    let mut mesh = start.clone();
    let report = anneal(&mut mesh, original, &mut FitConstraints::default(), options).unwrap();
    (mesh, report)
}

/// The ratio of the root mean square distance from the unit sphere to the least possible for this number of triangles,
/// 4 pi / (n sqrt(180)).
fn rms_over_limit(mesh: &TriMesh) -> f64 {
    let samples = sample_surface(&Surface::new(mesh).unwrap(), 100_000, 9);
    let squares = samples.iter().map(|s| (s.position.length() - 1.0).powi(2)).sum::<f64>();
    let n = mesh.topology().face_count() as f64;
    (squares / samples.len() as f64).sqrt() * n * 180_f64.sqrt() / (4.0 * core::f64::consts::PI)
}

#[test]
fn a_sphere_comes_nearer_to_the_limit() {
    let mesh = sphere();
    let mut without = annealing(0).to_faces(300);
    without.refine.anneal = false;
    let plain = rms_over_limit(&simplify(&mesh, &without).unwrap().mesh);
    let result = simplify(&mesh, &annealing(60).to_faces(300)).unwrap();
    let report = result.anneal.unwrap();
    assert!(report.is_layout_kept && report.sweeps == 60 && report.rms_after < report.rms_before);
    let annealed = rms_over_limit(&result.mesh);
    assert_eq!(result.mesh.topology().face_count(), 300);
    assert!(annealed > 1.0 && annealed - 1.0 < 0.75 * (plain - 1.0), "{plain} {annealed}");
}

#[test]
fn it_repeats_itself_and_is_never_worse() {
    let mesh = sphere();
    let original = Surface::new(&mesh).unwrap();
    let start = simplify(&mesh, &Options::preset(Preset::Default).to_faces(200)).unwrap().mesh;
    let run = |seed| {
        let fit = FitOptions { seed, ..FitOptions::default() };
        let options = AnnealOptions { sweeps: 12, rounds: 1, fit, ..AnnealOptions::default() };
        let (mesh, report) = annealed(&start, &original, &options);
        assert!(report.rms_after <= report.rms_before);
        (mesh.positions().to_vec(), report)
    };
    assert!(run(3) == run(3));
    assert!(run(3) != run(4));
}

#[test]
fn a_boundary_stays_and_a_limit_of_time_ends_it() {
    let saddle = Saddle { half_width: 1.0, coefficient: 0.5 };
    let mesh = TriMesh::from_soup(&saddle.mesh(40, Diagonals::Uniform).unwrap()).unwrap();
    let original = Surface::new(&mesh).unwrap();
    let start = simplify(&mesh, &Options::preset(Preset::Default).to_faces(200)).unwrap().mesh;
    for time_limit in [None, Some(Duration::ZERO)] {
        let options =
            AnnealOptions { sweeps: 10, rounds: 0, time_limit, ..AnnealOptions::default() };
        let (mesh, report) = annealed(&start, &original, &options);
        assert_eq!(report.sweeps, if time_limit.is_some() { 0 } else { 10 });
        for v in start.topology().vertices().filter(|&v| start.topology().is_boundary_vertex(v)) {
            assert_eq!(mesh.position(v), start.position(v));
        }
    }
}

#[test]
fn it_stops_when_told_to() {
    let mesh = sphere();
    let mut asked = 0;
    let result = simplify_observed(&mesh, &annealing(1000).to_faces(300), &mut |now| {
        asked += usize::from(now.phase == Phase::Anneal);
        if asked > 4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .unwrap();
    assert_eq!(result.stop, StopReason::Cancelled);
    result.mesh.topology().validate().unwrap();
}

/// Half axes 1, 0.6 and 0.35: the tips are sixty times as curved as the flat sides, and need denser faces.
#[test]
fn an_ellipsoid_is_laid_out_anew_and_comes_nearer() {
    let axes = glam::DVec3::new(1.0, 0.6, 0.35);
    let irregular = Irregular { jitter: 0.2, seed: 1 };
    let soup = Ellipsoid { semi_axes: axes }.irregular_icosphere(5, irregular).unwrap();
    let mesh = TriMesh::from_soup(&soup).unwrap();
    let result = simplify(&mesh, &annealing(160).to_faces(500)).unwrap();
    // The layout starts with a quarter of the faces. No closed mesh has 125 faces, so some faces are cut at the end.
    assert_eq!(result.mesh.topology().face_count(), 500);
    let report = result.anneal.unwrap();
    // 160 sweeps with the coarse faces, and a quarter of that number after each face was cut in four.
    assert!(report.is_layout_kept && report.sweeps == 200, "{report:?}");
    assert!(report.rms_after < 0.97 * report.rms_before, "{report:?}");
    let topology = result.mesh.topology();
    let regular = topology.vertices().filter(|&v| topology.valence(v) == 6).count();
    assert!(5 * regular > 4 * topology.vertex_count(), "{regular}");
    // Every vertex of the original maps to a vertex near it.
    let near = |(v, new): (VertexId, &Option<VertexId>)| {
        new.is_some_and(|w| mesh.position(v).distance(result.mesh.position(w)) < 0.5)
    };
    assert!(result.vertex_map.iter().all(near));
}

/// One of six layouts is made first. The five others start with 100 faces, and two of them are carried on.
#[test]
fn the_closest_of_several_layouts_is_kept_on_smooth_surfaces_alone() {
    let mesh = sphere();
    let original = Surface::new(&mesh).unwrap();
    let start = simplify(&mesh, &Options::default().to_faces(400)).unwrap().mesh;
    let run = |starts| {
        let options = AnnealOptions { sweeps: 40, starts, rounds: 0, ..AnnealOptions::default() };
        let (mesh, report) = annealed(&start, &original, &options);
        assert_eq!(mesh.topology().face_count(), 400);
        report
    };
    let (one, six) = (run(1), run(6));
    assert_eq!((one.layouts, one.sweeps), (1, 40 + 10));
    assert_eq!((six.layouts, six.sweeps), (6, 6 * 40 + 3 * 10));
    assert!(one.rms_after < one.rms_before);
    // The errors would be equal if none of the other layouts were closer.
    assert!(six.rms_after < one.rms_after, "{} {}", one.rms_after, six.rms_after);

    // Bumps that 100 faces cannot represent.
    let mut mesh = mesh;
    for p in mesh.positions_mut() {
        let [x, y, z] = p.to_array().map(|x| (9.0 * x).sin());
        *p *= 1.0 + 0.2 * x * y * z;
    }
    let mut options = annealing(12).to_faces(400);
    options.refine.tuning.anneal.starts = 6;
    let result = simplify(&mesh, &options).unwrap();
    assert_eq!(result.anneal.unwrap().layouts, 1);
}

/// A run that stops during the later layouts keeps the first one.
#[test]
fn a_layout_that_is_better_outlives_a_stop() {
    let mesh = sphere();
    let mut options = annealing(20).to_faces(400);
    options.refine.tuning.anneal.starts = 6;
    let mut asked = 0;
    let result = simplify_observed(&mesh, &options, &mut |now| {
        asked += usize::from(now.phase == Phase::Anneal);
        if asked > 60 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .unwrap();
    assert_eq!(result.stop, StopReason::Cancelled);
    let report = result.anneal.unwrap();
    assert!(report.layouts == 1 && report.is_layout_kept, "{report:?}");
    assert!(report.rms_after < report.rms_before);
}

/// Six new layouts from 100 faces, then exchanges of faces, then the reduction of the largest errors.
#[test]
fn threads_do_not_change_a_bit() {
    let mesh = sphere();
    for norm in [FitNorm::L2, FitNorm::Max] {
        let mut options = Options::preset(Preset::Extreme).to_faces(400);
        let quick = AnnealOptions { sweeps: 12, starts: 6, rounds: 1, ..AnnealOptions::default() };
        options.refine.tuning.anneal = quick;
        options.refine.norm = norm;
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let result = pool.install(|| simplify(&mesh, &options).unwrap());
            let bits: Vec<_> =
                result.mesh.positions().iter().map(|p| p.to_array().map(f64::to_bits)).collect();
            (bits, result.mesh.topology().canonical_triangles(), result.anneal, result.vertex_map)
        };
        let one = run(1);
        assert!(one.2.as_ref().unwrap().is_layout_kept);
        for threads in [2, 3, 8] {
            assert!(one == run(threads), "{} {threads}", norm.name());
        }
    }
}

/// A saddle with a boundary curve: the new layout keeps its boundary vertices on the curve, as closely as its edges
/// allow.
#[test]
fn a_rim_is_followed_by_a_new_layout() {
    let saddle = Saddle { half_width: 1.0, coefficient: 0.5 };
    let mesh = TriMesh::from_soup(&saddle.mesh(60, Diagonals::Uniform).unwrap()).unwrap();
    let result = simplify(&mesh, &annealing(40).to_faces(450)).unwrap();
    let report = result.anneal.unwrap();
    assert!(report.sweeps >= 50 && report.rms_after <= report.rms_before, "{report:?}");
    let topology = result.mesh.topology();
    topology.validate().unwrap();
    let rim: Vec<VertexId> =
        topology.vertices().filter(|&v| topology.is_boundary_vertex(v)).collect();
    for &v in &rim {
        let p = result.mesh.position(v);
        assert!((p.x.abs().max(p.y.abs()) - 1.0).abs() < 5e-3, "{p}");
        assert!((p.z - 0.5 * (p.x * p.x - p.y * p.y)).abs() < 1e-2, "{p}");
    }
    let is_corner = |v: &&VertexId| {
        let p = result.mesh.position(**v);
        p.x.abs() + p.y.abs() > 2.0 - 1e-9
    };
    assert_eq!(rim.iter().filter(is_corner).count(), 4);
}

/// The equator of a sphere as a feature: its vertices stay close to it, and it stays one ring of edges.
#[test]
fn features_stay_where_they_are() {
    let soup = Sphere { radius: 1.0 }.uv_mesh(32, 64).unwrap();
    let mesh = TriMesh::from_soup(&soup).unwrap();
    let topology = mesh.topology();
    let is_on_equator = |mesh: &TriMesh, v: VertexId| mesh.position(v).z.abs() < 0.02;
    let mut features = topology.edge_map(false);
    for e in topology.edges() {
        features[e] = topology.edge_vertices(e).into_iter().all(|v| is_on_equator(&mesh, v));
    }
    let marked = features.as_slice().iter().filter(|&&feature| feature).count();
    assert_eq!(marked, 64);
    let mut options = annealing(20).to_faces(300);
    options.refine.tuning.anneal.rounds = 2;
    options.protect.features = Some(features);
    let result = simplify(&mesh, &options).unwrap();
    assert!(result.anneal.unwrap().sweeps == 20);
    let new = result.mesh.topology();
    let on_equator: Vec<VertexId> =
        new.vertices().filter(|&v| is_on_equator(&result.mesh, v)).collect();
    assert!(on_equator.len() >= 8);
    for &v in &on_equator {
        let ring = new.one_ring(v).filter(|&w| is_on_equator(&result.mesh, w));
        assert_eq!(ring.count(), 2, "{v:?}");
    }
}

/// Two spheres, one closely inside the other. Coarse layouts made separately would cross.
#[test]
fn new_layouts_do_not_cross_when_that_is_forbidden() {
    let one = TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(4).unwrap()).unwrap();
    let count = one.positions().len() as u32;
    let corners = |f| one.topology().face_vertices(f).map(|v: VertexId| v.get());
    let outer: Vec<[u32; 3]> = one.topology().faces().map(corners).collect();
    let inner = outer.iter().map(|corners| corners.map(|v| v + count));
    let triangles: Vec<[u32; 3]> = outer.iter().copied().chain(inner).collect();
    let smaller = one.positions().iter().map(|p| 0.9 * *p);
    let positions: Vec<_> = one.positions().iter().copied().chain(smaller).collect();
    let mesh = TriMesh::from_triangles(&positions, &triangles).unwrap();
    let crossings = |mesh: &TriMesh| {
        let triangle = |f| (mesh.topology().face_vertices(f), mesh.triangle(f));
        let faces: Vec<_> = mesh.topology().faces().map(triangle).collect();
        let crosses = |&(i, j): &(usize, usize)| mesh_core::triangles_cross(faces[i], faces[j]);
        (0..faces.len()).flat_map(|i| (0..i).map(move |j| (i, j))).filter(crosses).count()
    };
    let mut options = annealing(12).to_faces(800);
    options.protect.forbid_intersections = true;
    let result = simplify(&mesh, &options).unwrap();
    assert!(result.anneal.unwrap().sweeps >= 12);
    assert_eq!(crossings(&result.mesh), 0);
}

/// `quality` exchanges faces if the original has many more faces than the result; the number of rounds grows with that
/// ratio.
#[test]
fn rounds_are_in_proportion_to_the_reduction() {
    let mesh = sphere();
    let options = Options::preset(Preset::Quality);
    let few = options.refine.tuning.anneal;
    let faces = mesh.topology().face_count();
    let original = Surface::new(&mesh).unwrap();
    for (wanted, most) in [(30, 4), (60, 2), (200, 0)] {
        let result = simplify(&mesh, &options.clone().to_faces(wanted)).unwrap();
        assert_eq!(faces / wanted / few.reduction_per_round as usize, most);
        assert_eq!(few.has_work(&result.mesh, &original), most > 0);
        assert_eq!(result.anneal.map_or(0, |report| report.rounds), most);
        let all = AnnealOptions { reduction_per_round: 0.0, rounds: 7, ..few };
        assert_eq!(annealed(&result.mesh, &original, &all).1.rounds, 7);
    }
}
