//! Simplification of very small and very large meshes. Work is counted, not timed: the same bits after the same number
//! of calls of the observer are the same work.
#![allow(clippy::unwrap_used)]

use core::ops::ControlFlow;

use mesh_core::TriMesh;
use mesh_shapes::{Irregular, Torus};
use proptest::prelude::*;
use simplify::{
    ErrorCheck, FaceLimits, Metric, Options, Preset, SimplifyError, simplify, simplify_observed,
};

fn torus(seed: u64, scale: f64) -> TriMesh {
    let irregular = Irregular { seed, ..Irregular::default() };
    let soup = Torus { major: 1.0, minor: 0.4 }.irregular_mesh(14, 9, irregular).unwrap();
    let mut mesh = TriMesh::from_soup(&soup).unwrap();
    mesh.positions_mut().iter_mut().for_each(|p| *p *= scale);
    mesh
}

/// Positions, errors and reports without their unit as bits, faces, and the number of calls of the observer.
fn measure(seed: u64, scale: f64, options: &Options) -> (Vec<u64>, Vec<[u32; 3]>, usize) {
    let mesh = torus(seed, scale);
    let mut calls = 0;
    let result = simplify_observed(&mesh, options, &mut |_| {
        calls += 1;
        ControlFlow::Continue(())
    })
    .unwrap();
    let places = result.mesh.positions().iter().flat_map(|&p| (p / scale).to_array());
    let mut numbers: Vec<f64> = places.collect();
    let log = result.log.entries().iter().flat_map(|entry| (entry.position / scale).to_array());
    numbers.extend(log);
    numbers.extend(result.error.map(|error| error.lower / scale));
    numbers.extend(result.error.and_then(|error| error.upper).map(|upper| upper / scale));
    numbers.extend(
        result.fit.iter().flat_map(|fit| [fit.rms_before, fit.rms_last]).map(|x| x / scale),
    );
    numbers.extend(result.anneal.iter().map(|anneal| anneal.rms_after / scale));
    numbers.extend(result.max_error.iter().map(|reduced| reduced.largest_after / scale));
    let bits = numbers.iter().map(|number| number.to_bits()).collect();
    (bits, result.mesh.topology().triangles().collect(), calls)
}

/// Options by number, with lengths for a mesh of this size.
fn options(kind: usize, scale: f64) -> Options {
    let preset = |preset| Options::preset(preset).to_faces(90);
    let mut options = match kind {
        0 => preset(Preset::Draft),
        1 => preset(Preset::Fast),
        2 => preset(Preset::Default),
        3 => preset(Preset::Quality),
        4 => preset(Preset::PaperL1),
        5 => preset(Preset::PaperL2),
        6 => Options::default().within(0.03 * scale, ErrorCheck::Sampled),
        7 => Options::preset(Preset::Quality).within(0.03 * scale, ErrorCheck::Certified),
        8 => {
            let mut options = preset(Preset::Default);
            options.protect.limits =
                FaceLimits { max_edge: Some(0.7 * scale), ..FaceLimits::default() };
            options.cost.curvature_weight = 1.0;
            options
        }
        9 => {
            let mut options = preset(Preset::Fast);
            options.cost.metric = Metric::Memoryless;
            options.protect.forbid_intersections = true;
            options
        }
        _ => {
            let mut options = preset(Preset::Quadrics);
            // Powers of the scale that are numbers; the extreme ones are tested below.
            options.target =
                simplify::Target { cost: Some(1e-3 * scale.powi(4)), ..Default::default() };
            options
        }
    };
    options.record = true;
    options
}

const KINDS: usize = 11;

/// The largest exponents at which the size is allowed.
const EXPONENTS: [i32; 10] = [-956, -700, -400, -250, -60, 60, 250, 400, 700, 996];

#[test]
fn scaled_meshes_give_scaled_bits_for_all_options() {
    for kind in 0..KINDS {
        let unit = measure(1, 1.0, &options(kind, 1.0));
        assert!(unit.1.len() < 252, "{kind}: {}", unit.1.len());
        for exponent in EXPONENTS {
            // Costs have the unit of a power of length, which must be a number.
            if kind == KINDS - 1 && exponent.abs() > 250 {
                continue;
            }
            let scale = f64::from(exponent).exp2();
            let found = measure(1, scale, &options(kind, scale));
            assert!(found == unit, "options {kind}, 2^{exponent}: {} faces", found.1.len());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn scaled_meshes_give_scaled_bits(seed in 0_u64..100, kind in 0..KINDS - 1, exponent in -956_i32..=996) {
        let scale = f64::from(exponent).exp2();
        let unit = measure(seed, 1.0, &options(kind, 1.0));
        prop_assert!(measure(seed, scale, &options(kind, scale)) == unit);
    }
}

/// The largest cost has the unit of the cost, and is infinite or 0 only where it is no number.
#[test]
fn costs_have_the_size_of_the_mesh() {
    let cost = |preset, exponent: i32| {
        let mesh = torus(2, f64::from(exponent).exp2());
        simplify(&mesh, &Options::preset(preset).to_faces(90)).unwrap().max_cost
    };
    for (preset, power) in [(Preset::Fast, 4), (Preset::PaperL1, -1), (Preset::PaperL2, -2)] {
        let unit = cost(preset, 0);
        for exponent in [-200, -100, 100, 200] {
            assert_eq!(cost(preset, exponent), unit * f64::from(exponent * power).exp2());
        }
    }
}

#[test]
fn sizes_that_leave_too_few_digits_are_refused() {
    for exponent in [-1020, -960, 1000, 1021] {
        let mesh = torus(1, f64::from(exponent).exp2());
        let error = simplify(&mesh, &Options::default().to_faces(90)).unwrap_err();
        assert!(matches!(error, SimplifyError::Scale(_)), "{error}");
        assert!(error.to_string().contains("scale the mesh"), "{error}");
    }
}
