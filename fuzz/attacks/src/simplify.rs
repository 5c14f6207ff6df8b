//! Simplification with every preset, guard and limit.

use core::ops::ControlFlow;

use arbitrary::{Result, Unstructured};
use dtri_flip::feature_edges;
use mesh_core::TriMesh;
use simplify::{
    AnnealOptions, Boundary, CornerAttributes, ErrorCheck, FitOptions, Options, PlacementRule,
    Preset, Simplified, StopReason, Tuning, simplify_observed,
};

use crate::shape::{assert_sound, mesh};

/// Simplifies a mesh: the result must be valid, and satisfy the options.
pub fn attack(data: &[u8]) {
    // Too few bytes are not an error.
    let _ = run(&mut Unstructured::new(data));
}

fn run(u: &mut Unstructured<'_>) -> Result<()> {
    let mesh = mesh(u)?;
    let options = options(u, &mesh)?;
    let patience = if u.ratio(1, 4)? { u.int_in_range(0..=20)? } else { u64::MAX };
    let mut asked = 0;
    let result = simplify_observed(&mesh, &options, &mut |_| {
        asked += 1;
        if asked > patience { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    match result {
        Ok(simplified) => check(&mesh, &options, &simplified),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    Ok(())
}

fn options(u: &mut Unstructured<'_>, mesh: &TriMesh) -> Result<Options> {
    let mut options = Options::preset(*u.choose(Preset::ALL)?);
    // The presets, with smaller parameters.
    let Tuning { fit, anneal, max_error } = &mut options.refine.tuning;
    *fit = FitOptions { rounds: fit.rounds.min(2), samples_per_face: 4, ..*fit };
    *anneal = AnnealOptions { starts: 3, rounds: 2, samples_per_face: 4, ..*anneal };
    anneal.fit.samples_per_face = 4;
    let rounds = max_error.fit.rounds.min(2);
    max_error.fit = FitOptions { rounds, samples_per_face: 4, ..max_error.fit };
    (max_error.share, max_error.rounds) = (0.5, 2);
    let faces = mesh.topology().face_count();
    let mut distance = None;
    match u.int_in_range(0..=5)? {
        0 => options.target.ratio = Some(f64::from(u.int_in_range(0..=10)?) / 10.0),
        1 => options.target.vertices = Some(u.int_in_range(0..=20)?),
        2 => options.target.cost = Some(f64::from(u.int_in_range(0..=20)?) / 10.0),
        3 => distance = Some(f64::from(u.int_in_range(1..=20)?) / 10.0),
        _ => options.target.faces = Some(u.int_in_range(0..=faces)?),
    }
    if u.ratio(1, 3)? {
        options.placement = *u.choose(&[
            PlacementRule::OptimalVolume,
            PlacementRule::Optimal,
            PlacementRule::Endpoint,
            PlacementRule::Midpoint,
            PlacementRule::Butterfly,
        ])?;
    }
    let mut check = *u.choose(&[None, Some(ErrorCheck::Sampled), Some(ErrorCheck::Certified)])?;
    // The number of samples for a large mesh would dominate the time.
    if check == Some(ErrorCheck::Sampled) && !u.ratio(1, 16)? {
        check = Some(ErrorCheck::Certified);
    }
    options.tolerance.check = check;
    options.protect.boundary = *u.choose(&[Boundary::Quadrics, Boundary::Lock, Boundary::Free])?;
    if u.ratio(1, 4)? {
        let angle = f64::from(u.int_in_range(0..=30)?) / 10.0;
        options.protect.features = Some(feature_edges(mesh, angle));
    }
    options.protect.forbid_intersections = u.ratio(1, 3)?;
    if u.ratio(1, 4)? {
        options.protect.min_component_vertices = Some(u.int_in_range(0..=8)?);
    }
    if u.ratio(1, 4)? {
        options.cost.curvature_weight = f64::from(u.int_in_range(0..=20)?) / 2.0;
    }
    if u.ratio(1, 4)? {
        let has_texture = u.arbitrary()?;
        let numbers: [u8; 7] = u.arbitrary()?;
        let attributes = CornerAttributes::new(mesh, has_texture, |half_edge| {
            let at = half_edge.index();
            [numbers[at % 7], numbers[at / 7 % 7]].map(|number| f64::from(number / 64))
        });
        options.attributes.corners = attributes.ok();
    }
    if let Some(distance) = distance {
        // Sometimes incompatible options.
        if u.ratio(1, 8)? {
            options.tolerance.distance = Some(distance);
            options.tolerance.decimate = u.arbitrary()?;
        } else {
            options = options.within(distance, check.unwrap_or_default());
        }
    }
    Ok(options)
}

fn check(mesh: &TriMesh, options: &Options, result: &Simplified) {
    assert_sound(&result.mesh);
    let [old, new] = [mesh, &result.mesh].map(TriMesh::topology);
    assert!(new.face_count() <= old.face_count(), "more faces than before");
    assert!(new.is_compact());
    assert_eq!(result.vertex_map.len(), old.vertex_capacity());
    for vertex in result.vertex_map.as_slice().iter().flatten() {
        assert!(new.contains_vertex(*vertex), "{vertex:?} is not in the result");
    }
    assert!(result.max_cost.is_finite(), "the largest cost is {}", result.max_cost);
    if result.stop == StopReason::Faces {
        let ratio =
            options.target.ratio.map_or(0, |r| (r * old.face_count() as f64).ceil() as usize);
        let target = options.target.faces.unwrap_or(0).max(ratio);
        assert!(new.face_count() <= target, "{} faces, not {target}", new.face_count());
    }
    // The log must fit the mesh, even if the result was changed afterwards.
    let replayed = result.log.replay(mesh, result.log.len()).expect("the log fits the mesh");
    replayed.topology().validate().expect("a replay keeps the invariants");
    if options.protect.boundary == Boundary::Lock {
        for vertex in old.vertices().filter(|&v| old.is_boundary_vertex(v)) {
            let became = result.vertex_map[vertex].expect("locked vertices stay");
            assert_eq!(result.mesh.position(became), mesh.position(vertex), "{vertex:?} is locked");
        }
    }
    if let Some(error) = result.error {
        assert!(error.lower >= 0.0, "the error is {}", error.lower);
        if let Some(upper) = error.upper {
            assert!(error.lower <= upper, "bounds {} and {upper}", error.lower);
        }
        let is_limited =
            options.tolerance.distance.is_some() && result.stop != StopReason::Cancelled;
        if let (Some(limit), true) = (options.tolerance.distance, is_limited) {
            assert!(error.is_within(limit), "{error:?} with a limit of {limit}");
        }
    }
}
