//! A stopped run returns its best mesh so far, with a consistent map and log.
#![allow(clippy::unwrap_used)]

use std::ops::ControlFlow;

use mesh_core::TriMesh;
use mesh_metric::{CompareOptions, Surface, compare};
use mesh_shapes::{Irregular, Wave};
use simplify::{
    AnnealOptions, ErrorCheck, Options, Phase, Preset, Progress, Simplified, StopReason, simplify,
    simplify_observed,
};

fn wave() -> TriMesh {
    let wave = Wave { amplitude: 0.15, wavelength: 1.1, half_width: 1.0 };
    let soup = wave.irregular_mesh(40, Irregular { jitter: 0.2, seed: 4 }).unwrap();
    TriMesh::from_soup(&soup).unwrap()
}

/// The map reaches all vertices of the mesh. If nothing was done after the collapses, mesh and map agree with the log.
/// A mesh that was decimated to the tolerance has fewer faces.
fn assert_consistent(original: &TriMesh, result: &Simplified) {
    result.mesh.topology().validate().unwrap();
    let mut is_met = result.mesh.topology().vertex_map(false);
    for new in result.vertex_map.as_slice().iter().flatten() {
        is_met[*new] = true;
    }
    let (level, vertex_map) = result.log.level(original, result.log.len()).unwrap();
    let is_decimated = result.mesh.topology().face_count() < level.topology().face_count();
    let is_finished = result.anneal.is_some() || result.max_error.is_some() || is_decimated;
    if !is_finished {
        assert!(is_met.as_slice().iter().all(|met| *met));
        assert_eq!(result.vertex_map, vertex_map);
        assert_eq!(result.mesh.topology().face_count(), level.topology().face_count());
        if result.fit.is_none() {
            assert_eq!(result.mesh.positions(), level.positions());
        }
    }
}

/// Stops a run after this number of calls in a phase.
fn stopped_in(mesh: &TriMesh, options: &Options, phase: Phase, after: usize) -> Option<Simplified> {
    let mut asked = 0;
    let mut is_over = false;
    let observe = &mut |now: &Progress| {
        assert!(!is_over, "asked again after it was told to stop");
        asked += usize::from(now.phase == phase);
        is_over = asked == after;
        if is_over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let result = simplify_observed(mesh, options, observe).unwrap();
    is_over.then_some(result)
}

#[test]
fn a_run_with_a_largest_error_that_is_cancelled_is_within_it() {
    let mesh = wave();
    let original = Surface::new(&mesh).unwrap();
    for decimate in [false, true] {
        let limit = 0.01;
        let mut options = Options::preset(Preset::Default).within(limit, ErrorCheck::Certified);
        options.tolerance.decimate = decimate;
        let whole = simplify(&mesh, &options).unwrap();
        let (mut coarser, mut decimated) = (0, 0);
        for phase in
            [Phase::Collapse, Phase::Search, Phase::Fit, Phase::Measure, Phase::DecimateToTolerance]
        {
            // The proof itself can be interrupted as well.
            for after in [1, 2, 4, 8, 16, 32, 64] {
                let Some(result) = stopped_in(&mesh, &options, phase, after) else { continue };
                assert_eq!(result.stop, StopReason::Cancelled);
                assert_consistent(&mesh, &result);
                let samples = CompareOptions { samples: 20_000, ..CompareOptions::default() };
                let found = Surface::new(&result.mesh).unwrap();
                assert!(compare(&original, &found, &samples).hausdorff() <= limit);
                let faces = result.mesh.topology().face_count();
                assert!(faces >= whole.mesh.topology().face_count());
                assert_eq!(result.error.is_some(), faces < mesh.topology().face_count());
                coarser += usize::from(faces < mesh.topology().face_count());
                let (level, _) = result.log.level(&mesh, result.log.len()).unwrap();
                decimated += usize::from(faces < level.topology().face_count());
            }
        }
        assert!(coarser > 0, "nothing was kept");
        // Work done before the stop is kept.
        assert_eq!(decimated > 0, decimate);
    }
}

#[test]
fn fit_annealing_and_peaks_can_be_cancelled_between_rounds() {
    let mesh = wave();
    let mut options = Options::preset(Preset::Quality).to_faces(400);
    options.refine.tuning.anneal = AnnealOptions { rounds: 3, ..AnnealOptions::default() };
    options.tolerance.check = Some(ErrorCheck::Sampled);
    let whole = simplify(&mesh, &options).unwrap();
    assert!(whole.error.is_some());
    for phase in [Phase::Collapse, Phase::Fit, Phase::Anneal, Phase::MaxError, Phase::Measure] {
        let result = stopped_in(&mesh, &options, phase, 1).unwrap();
        assert_eq!(result.stop, StopReason::Cancelled, "{phase:?}");
        assert_eq!(result.error, None, "{phase:?}");
        assert_consistent(&mesh, &result);
        let rounds = result.fit.map_or(0, |fit| fit.rounds);
        let annealed = result.anneal.map_or(0, |anneal| anneal.rounds);
        match phase {
            Phase::Collapse => assert!(result.mesh.topology().face_count() > 400),
            Phase::Fit => assert_eq!(rounds, 0),
            Phase::Anneal => assert_eq!((rounds, annealed), (9, 0)),
            Phase::MaxError => assert_eq!((rounds, annealed), (9, 3)),
            _ => assert_eq!(result.mesh.positions(), whole.mesh.positions()),
        }
    }
    let second = stopped_in(&mesh, &options, Phase::Fit, 3).unwrap();
    assert_eq!(second.fit.unwrap().rounds, 2);
    assert_consistent(&mesh, &second);
}
