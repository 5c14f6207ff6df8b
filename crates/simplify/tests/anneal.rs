//! Annealing of the layout: how near it comes to the least possible distance, and what it keeps.
#![allow(clippy::unwrap_used)]
#![cfg(feature = "finish")]

use core::ops::ControlFlow;
use core::time::Duration;

use mesh_core::shapes::{Diagonals, Ellipsoid, Irregular, Saddle, Sphere};
use mesh_core::{TriMesh, VertexId};
use mesh_metric::{Surface, sample_surface};
use simplify::{
    AnnealOptions, FitConstraints, FitOptions, Options, Phase, Preset, StopReason, anneal,
    simplify, simplify_observed,
};

fn sphere() -> TriMesh {
    let irregular = Irregular { jitter: 0.2, seed: 1 };
    TriMesh::from_soup(&Sphere { radius: 1.0 }.irregular_icosphere(5, irregular).unwrap()).unwrap()
}

/// Of the preset, with annealing of the layout alone and less of it.
fn annealing(sweeps: usize) -> Options {
    let mut options = Options::preset(Preset::Extreme);
    options.finish.peaks = None;
    options.finish.anneal = Some(AnnealOptions { sweeps, rounds: 0, ..AnnealOptions::default() });
    options
}

/// Over the least root mean square distance of as many triangles from a unit sphere:
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
    without.finish.anneal = None;
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
        let mut mesh = start.clone();
        let report =
            anneal(&mut mesh, &original, &mut FitConstraints::default(), &options).unwrap();
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
        let mut mesh = start.clone();
        let report =
            anneal(&mut mesh, &original, &mut FitConstraints::default(), &options).unwrap();
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

/// Half axes 1, 0.6 and 0.35: the tips are sixty times as curved as the flat sides, and have to have the
/// faces that belong there.
#[test]
fn an_ellipsoid_is_laid_out_anew_and_comes_nearer() {
    let axes = glam::DVec3::new(1.0, 0.6, 0.35);
    let irregular = Irregular { jitter: 0.2, seed: 1 };
    let soup = Ellipsoid { semi_axes: axes }.irregular_icosphere(5, irregular).unwrap();
    let mesh = TriMesh::from_soup(&soup).unwrap();
    let result = simplify(&mesh, &annealing(160).to_faces(500)).unwrap();
    let report = result.anneal.unwrap();
    // From 125 faces on: 160 sweeps, and a fourth of them after the faces were cut in four.
    assert!(report.is_layout_kept && report.sweeps == 200, "{report:?}");
    assert!(report.rms_after < 0.97 * report.rms_before, "{report:?}");
    let topology = result.mesh.topology();
    let regular = topology.vertices().filter(|&v| topology.valence(v) == 6).count();
    assert!(5 * regular > 4 * topology.vertex_count(), "{regular}");
    // Every vertex of the original has become one near it.
    let near = |(v, new): (VertexId, &Option<VertexId>)| {
        new.is_some_and(|w| mesh.position(v).distance(result.mesh.position(w)) < 0.5)
    };
    assert!(result.vertex_map.iter().all(near));
}
