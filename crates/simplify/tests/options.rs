//! Invalid options, logs and attributes are rejected with a reason.
#![allow(clippy::unwrap_used)]

use mesh_core::TriMesh;
use mesh_metric::Surface;
use mesh_shapes::Sphere;
use simplify::{
    AnnealOptions, CollapseLog, CornerAttributes, ErrorCheck, FitConstraints, FitNorm, FitOptions,
    MAX_CHANNELS, MaxErrorOptions, Options, PlacementRule, Preset, RecordError, RefineError,
    SimplifyError, Stages, anneal, fit, reduce_max_error, simplify,
};

fn sphere(cuts: u32) -> TriMesh {
    TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(cuts).unwrap()).unwrap()
}

/// The option that an error names.
fn named<T>(result: Result<T, SimplifyError>) -> &'static str {
    match result.err() {
        Some(SimplifyError::Option { option, .. }) => option,
        _ => "",
    }
}

#[test]
fn options_of_fit_max_error_and_annealing_are_checked() {
    let (fit_ok, max_error_ok, anneal_ok) =
        (FitOptions::default(), MaxErrorOptions::default(), AnnealOptions::default());
    let (mut mesh, surface) = (sphere(1), Surface::new(&sphere(2)).unwrap());
    let free = &mut FitConstraints::default();
    let bad_fits = [
        ("fit pull", FitOptions { pull: f64::NAN, ..fit_ok }),
        ("fit tail", FitOptions { tail: -1.0, ..fit_ok }),
        ("fit tail", FitOptions { tail: f64::INFINITY, ..fit_ok }),
        ("fit samples_per_face", FitOptions { samples_per_face: usize::MAX, ..fit_ok }),
    ];
    let bad_max_errors = [
        ("max_error above", MaxErrorOptions { above: 1.5, ..max_error_ok }),
        ("max_error share", MaxErrorOptions { share: f64::NAN, ..max_error_ok }),
        ("max_error spacing", MaxErrorOptions { spacing: 0.0, ..max_error_ok }),
        ("max_error max_rise", MaxErrorOptions { max_rise: f64::INFINITY, ..max_error_ok }),
        ("fit pull", MaxErrorOptions { fit: FitOptions { pull: -1.0, ..fit_ok }, ..max_error_ok }),
    ];
    let bad_anneals = [
        ("anneal jump", AnnealOptions { jump: f64::NAN, ..anneal_ok }),
        ("anneal share", AnnealOptions { share: 2.0, ..anneal_ok }),
        ("anneal starts", AnnealOptions { starts: 0, ..anneal_ok }),
        ("anneal reduction_per_round", AnnealOptions { reduction_per_round: -1.0, ..anneal_ok }),
        ("anneal samples_per_face", AnnealOptions { samples_per_face: 0, ..anneal_ok }),
        ("fit pull", AnnealOptions { fit: FitOptions { pull: -1.0, ..fit_ok }, ..anneal_ok }),
    ];
    let whole = |change: &dyn Fn(&mut Options)| {
        let mut options = Options::preset(Preset::Fast).to_faces(10);
        change(&mut options);
        named(simplify(&sphere(1), &options))
    };
    for (name, options) in bad_fits {
        assert_eq!(
            named(fit(&mut mesh, &surface, free, &options).map_err(SimplifyError::from)),
            name
        );
        assert_eq!(whole(&|all| all.refine.tuning.fit = options), name);
    }
    for (name, options) in bad_max_errors {
        assert_eq!(
            named(
                reduce_max_error(&mut mesh, &surface, free, &options).map_err(SimplifyError::from)
            ),
            name
        );
        assert_eq!(whole(&|all| all.refine.tuning.max_error = options), name);
    }
    for (name, options) in bad_anneals {
        assert_eq!(
            named(anneal(&mut mesh, &surface, free, &options).map_err(SimplifyError::from)),
            name
        );
        assert_eq!(whole(&|all| all.refine.tuning.anneal = options), name);
    }
    // Every number is a valid seed.
    let options = FitOptions { seed: u64::MAX, ..fit_ok };
    assert!(fit(&mut mesh, &surface, free, &options).is_ok());
}

#[test]
fn a_largest_error_is_positive_and_finite() {
    for limit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = Options::default().within(limit, ErrorCheck::Sampled);
        assert_eq!(named(simplify(&sphere(1), &options)), "tolerance.distance", "{limit}");
    }
}

#[test]
fn attributes_with_too_many_numbers_are_refused() {
    let mesh = sphere(1);
    assert!(CornerAttributes::new(&mesh, false, |_| [1.0; MAX_CHANNELS]).is_ok());
    let error = CornerAttributes::new(&mesh, false, |_| [1.0; MAX_CHANNELS + 1]).unwrap_err();
    assert_eq!(error, RefineError::Channels { channels: MAX_CHANNELS + 1, most: MAX_CHANNELS });
}

#[test]
fn the_log_of_another_mesh_is_an_error() {
    let (mesh, other) = (sphere(3), sphere(2));
    let result = simplify(&mesh, &Options::preset(Preset::Fast).to_faces(200)).unwrap();
    let within_limit = |mesh: &TriMesh, limit: f64| {
        Stages::new(mesh, &result.log, Options::default()).within(limit, ErrorCheck::Sampled)
    };
    let within = |mesh: &TriMesh| within_limit(mesh, 0.2);
    assert!(within(&mesh).unwrap() > 0);
    assert!(matches!(within(&other), Err(SimplifyError::OtherMesh(_))));
    // A mesh of the same size, on which most of the collapses would be legal.
    let triangles: Vec<[u32; 3]> = mesh.topology().triangles().map(|[a, b, c]| [a, c, b]).collect();
    let turned = TriMesh::from_triangles(mesh.positions(), &triangles).unwrap();
    assert!(matches!(within(&turned), Err(SimplifyError::OtherMesh(_))));
    let none = within_limit(&mesh, f64::NAN);
    assert_eq!(named(none), "limit");
}

/// Each handle of a collapse, one after the other.
#[test]
fn a_record_with_a_collapse_of_what_the_mesh_does_not_have_is_refused() {
    let mesh = sphere(2);
    let result = simplify(&mesh, &Options::preset(Preset::Fast).to_faces(100)).unwrap();
    let mut record = Vec::new();
    result.log.write(&mesh, &mut record).unwrap();
    assert_eq!(CollapseLog::read(&mesh, &mut &record[..]).unwrap(), result.log);
    let (head, collapse) = (28, 48);
    let topology = mesh.topology();
    let (sides, vertices) =
        (topology.half_edge_capacity() as u32, topology.vertex_capacity() as u32);
    let numbers =
        [(0, sides), (4, vertices), (8, vertices)].map(|(at, n)| (at, n.to_le_bytes().to_vec()));
    let places = [16, 24, 32].map(|at| (at, f64::NAN.to_le_bytes().to_vec()));
    for (at, bytes) in numbers.into_iter().chain(places) {
        let mut record = record.clone();
        let at = head + 2 * collapse + at;
        record[at..at + bytes.len()].copy_from_slice(&bytes);
        let read = CollapseLog::read(&mesh, &mut &record[..]);
        assert!(matches!(read, Err(RecordError::Misfit { collapse: 2 })), "byte {at}");
    }
}

#[test]
fn placements_and_norms_are_what_their_names_say() {
    for &placement in PlacementRule::NAMED {
        assert_eq!(placement.name().parse(), Ok(placement));
        let error = "custom".parse::<PlacementRule>().unwrap_err().to_string();
        assert!(error.contains(placement.name()), "{error}");
    }
    for &norm in FitNorm::ALL {
        assert_eq!(norm.name().parse(), Ok(norm));
        let error = "l3".parse::<FitNorm>().unwrap_err().to_string();
        assert!(error.contains(norm.name()), "{error}");
    }
}
