//! Kept elements, importance, and limits on new faces, judged by brute force on the result of every preset.
#![allow(clippy::unwrap_used)]

use std::collections::HashSet;

use glam::DVec3;
use mesh_core::{EdgeMap, SplitMix64, TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;
use mesh_shapes::{Irregular, Plane, Sphere, Wave};
use proptest::prelude::*;
use simplify::{
    CornerAttributes, ErrorCheck, FaceLimits, Options, Plan, Preset, Rejection, Schedule,
    SimplifyError, simplify,
};

/// A rough grid with holes, and a bumpy sphere beside it.
fn random_mesh(seed: u64, cells: usize, holes: usize) -> Option<TriMesh> {
    let mut random = SplitMix64::new(seed);
    let irregular = Irregular { jitter: 0.2, seed };
    let soup = Plane { half_width: 1.0 }.irregular_mesh(cells, irregular).unwrap();
    let mut points: Vec<DVec3> = soup.positions().to_vec();
    points.iter_mut().for_each(|p| p.z = 0.15 * (3.0 * p.x).sin() + 0.05 * random.symmetric());
    let mut triangles: Vec<[u32; 3]> = soup.faces().map(|f| f.try_into().unwrap()).collect();
    for _ in 0..holes.min(triangles.len() - 1) {
        let gone = (random.uniform() * triangles.len() as f64) as usize;
        triangles.swap_remove(gone);
    }
    let shift = points.len() as u32;
    let ball = Sphere { radius: 0.5 }.irregular_icosphere(2, irregular).unwrap();
    points.extend(ball.positions().iter().map(|&p| p + 3.0 * DVec3::X));
    triangles.extend(ball.faces().map(|f| [f[0] + shift, f[1] + shift, f[2] + shift]));
    TriMesh::from_triangles(&points, &triangles).ok()
}

/// Positions as sets of bits, which can be compared exactly.
fn bits<const N: usize>(points: [DVec3; N]) -> Vec<[u64; 3]> {
    let mut bits: Vec<[u64; 3]> = points.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
    bits.sort_unstable();
    bits
}

fn smallest_angle(corners: [DVec3; 3]) -> f64 {
    let angle = |i: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
        (b - a).angle_between(c - a)
    };
    [0, 1, 2].map(angle).into_iter().fold(f64::INFINITY, f64::min)
}

/// All violations of the constraints that the options hold.
fn judge(
    input: &TriMesh,
    result: &TriMesh,
    options: &Options,
    faces: &[[DVec3; 3]],
) -> Vec<String> {
    let mut found = Vec::new();
    let (old, new) = (input.topology(), result.topology());
    let places: HashSet<_> = new.vertices().map(|v| bits([result.position(v)])).collect();
    for (v, &locked) in options.protect.locked.iter().flat_map(VertexMap::iter) {
        if locked && !old.is_isolated_vertex(v) && !places.contains(&bits([input.position(v)])) {
            found.push(format!("{v:?} is not where it was"));
        }
    }
    let there: HashSet<_> = new.faces().map(|f| bits(result.triangle(f))).collect();
    found.extend(
        faces.iter().filter(|face| !there.contains(&bits(**face))).map(|f| format!("no {f:?}")),
    );
    let FaceLimits { max_edge, min_angle, max_valence } = options.protect.limits;
    if let Some(limit) = max_edge {
        let before: HashSet<_> = old.edges().map(|e| bits(input.segment(e))).collect();
        for segment in new.edges().map(|e| result.segment(e)) {
            let length = segment[0].distance(segment[1]);
            if length > limit * (1.0 + 1e-9) && !before.contains(&bits(segment)) {
                found.push(format!("edge of length {length} instead of {limit}"));
            }
        }
    }
    if let Some(limit) = min_angle {
        let before: HashSet<_> = old.faces().map(|f| bits(input.triangle(f))).collect();
        for triangle in new.faces().map(|f| result.triangle(f)) {
            let angle = smallest_angle(triangle);
            if angle < limit - 1e-7 && !before.contains(&bits(triangle)) {
                found.push(format!("angle of {angle} instead of {limit}"));
            }
        }
    }
    if let Some(limit) = max_valence {
        let most = old.vertices().map(|v| old.valence(v)).max().unwrap().max(limit);
        found.extend(
            new.vertices()
                .filter(|&v| new.valence(v) > most)
                .map(|v| format!("{} edges instead of {most}", new.valence(v))),
        );
    }
    found
}

/// Keeps one in `one_in` vertices and faces. Returns the corners of the kept faces.
fn keep_some(mesh: &TriMesh, options: &mut Options, seed: u64, one_in: f64) -> Vec<[DVec3; 3]> {
    let topology = mesh.topology();
    let mut random = SplitMix64::new(seed);
    let mut marks = topology.vertex_map(false);
    marks.as_mut_slice().iter_mut().for_each(|mark| *mark = random.uniform() * one_in < 1.0);
    options.protect.keep_vertices(topology, |v| marks[v]);
    let mut kept = topology.face_map(false);
    kept.as_mut_slice().iter_mut().for_each(|mark| *mark = random.uniform() * one_in < 1.0);
    options.protect.keep_faces(topology, &kept);
    topology.faces().filter(|&f| kept[f]).map(|f| mesh.triangle(f)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_stage_honours_the_constraints(
        seed in 0_u64..10_000,
        cells in 3_usize..12,
        holes in 0_usize..5,
        preset in 0..Preset::ALL.len(),
        schedule in 0_usize..3,
        share in 0.02_f64..0.9,
        which in 1_usize..32,
        edge in 0.1_f64..1.0,
        degrees in 2.0_f64..35.0,
        valence in 5_usize..10,
        within in prop::option::of(0.005_f64..0.1),
        certified in prop::bool::ANY,
    ) {
        let mesh = random_mesh(seed, cells, holes);
        prop_assume!(mesh.is_some());
        let mesh = mesh.unwrap();
        let mut options = Options::preset(Preset::ALL[preset]);
        options.cost.schedule = [Schedule::Lazy, Schedule::Parallel, Schedule::Exact][schedule];
        options.target.ratio = Some(share);
        let is_chosen = |bit: usize| which & (1 << bit) != 0;
        options.protect.limits = FaceLimits {
            max_edge: is_chosen(0).then_some(edge),
            min_angle: is_chosen(1).then_some(degrees.to_radians()),
            max_valence: is_chosen(2).then_some(valence),
        };
        let kept = match is_chosen(3) {
            true => keep_some(&mesh, &mut options, seed, 12.0),
            false => Vec::new(),
        };
        if is_chosen(4) {
            let weight = |v: VertexId| if mesh.position(v).x > 0.0 { 5.0 } else { 0.0 };
            options.protect.importance = Some(VertexMap::from_fn(mesh.topology(), weight));
        }
        if let Some(distance) = within {
            let check = if certified { ErrorCheck::Certified } else { ErrorCheck::Sampled };
            options = options.within(distance, check);
        }
        let result = simplify(&mesh, &options).unwrap();
        prop_assert_eq!(result.mesh.topology().validate(), Ok(()));
        prop_assert!(result.mesh.positions().iter().all(|p| p.is_finite()));
        let found = judge(&mesh, &result.mesh, &options, &kept);
        prop_assert!(found.is_empty(), "{found:?}");
        if let Some(shortfall) = &result.shortfall {
            prop_assert!(result.mesh.topology().face_count() > shortfall.wanted_faces.unwrap());
            prop_assert!(shortfall.held_by.iter().all(|&(_, count)| count > 0));
        }
    }

}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Faces that are moved back because they folded in the texture still honour the limits.
    #[test]
    fn textured_meshes_honour_the_limits(
        seed in 0_u64..1000, share in 0.1_f64..0.6, edge in 0.2_f64..0.6, degrees in 2.0_f64..25.0,
        stage in 2_usize..4,
    ) {
        let mesh = random_mesh(seed, 7, 0).unwrap();
        let topology = mesh.topology();
        let mut options = Options::preset(Preset::ALL[stage]);
        options.target.ratio = Some(share);
        options.protect.limits = FaceLimits {
            max_edge: Some(edge), min_angle: Some(degrees.to_radians()), max_valence: Some(9),
        };
        // A texture that is squeezed in waves folds easily.
        let texture = |h| {
            let p = mesh.position(topology.origin(h));
            [p.x + 0.09 * (11.0 * p.y).sin(), p.y + 0.09 * (13.0 * p.x).sin(), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        };
        options.attributes.corners = Some(CornerAttributes::new(&mesh, true, texture).unwrap());
        options.protect.features = Some(EdgeMap::from_fn(topology, |_| false));
        let kept = keep_some(&mesh, &mut options, seed, 20.0);
        let result = simplify(&mesh, &options).unwrap();
        let found = judge(&mesh, &result.mesh, &options, &kept);
        prop_assert!(found.is_empty(), "{found:?}");
    }
}

fn wave(cells: usize) -> TriMesh {
    let wave = Wave { amplitude: 0.15, wavelength: 0.7, half_width: 1.0 };
    let soup = wave.irregular_mesh(cells, Irregular { jitter: 0.2, seed: 4 }).unwrap();
    TriMesh::from_soup(&soup).unwrap()
}

/// Where vertices count more, more of them stay, and the result is closer to the input.
#[test]
fn important_parts_keep_more_faces_and_smaller_errors() {
    let mesh = wave(40);
    let original = Surface::new(&mesh).unwrap();
    let points: Vec<DVec3> =
        mesh.topology().faces().map(|f| mesh.triangle(f).iter().sum::<DVec3>() / 3.0).collect();
    for preset in [Preset::Draft, Preset::Fast, Preset::Default, Preset::Quality] {
        let halves = |weight: Option<f64>| {
            let mut options = Options::preset(preset).to_faces(320);
            options.protect.importance = weight.map(|weight| {
                let of = |v: VertexId| if mesh.position(v).x > 0.0 { weight } else { 1.0 };
                VertexMap::from_fn(mesh.topology(), of)
            });
            let result = simplify(&mesh, &options).unwrap().mesh;
            let surface = Surface::new(&result).unwrap();
            let is_right = |p: &DVec3| p.x > 0.0;
            let (right, left): (Vec<DVec3>, Vec<DVec3>) = points.iter().partition(|p| is_right(p));
            let square = |points: &[DVec3]| {
                let distances = surface.distances(points);
                distances.iter().map(|d| d * d).sum::<f64>()
            };
            let faces = result.topology().faces();
            let of_right = faces.filter(|&f| is_right(&result.triangle(f).iter().sum())).count();
            (of_right, square(&right), square(&left))
        };
        let (plain, weighted) = (halves(None), halves(Some(100.0)));
        assert!(weighted.0 > plain.0 + 40, "{preset:?} {plain:?} {weighted:?}");
        assert!(
            weighted.1 < 0.75 * plain.1 && weighted.2 > plain.2,
            "{preset:?} {plain:?} {weighted:?}"
        );
    }
    assert!(original.triangle_count() > 3000);
}

/// Only ratios of importance count.
#[test]
fn equal_importance_changes_nothing() {
    let mesh = wave(24);
    for preset in [Preset::Fast, Preset::Default, Preset::Quality] {
        let run = |weight: Option<f64>| {
            let mut options = Options::preset(preset).to_faces(200);
            options.cost.schedule = Schedule::Lazy;
            options.refine.anneal = false;
            options.protect.importance = weight.map(|w| mesh.topology().vertex_map(w));
            simplify(&mesh, &options).unwrap().mesh
        };
        let (plain, same) = (run(None), run(Some(4.0)));
        assert_eq!(plain.positions(), same.positions(), "{preset:?}");
        assert!(plain.topology().triangles().eq(same.topology().triangles()));
        // Nothing is important: any mesh will do.
        run(Some(0.0)).topology().validate().unwrap();
    }
}

#[test]
fn what_is_not_reached_is_reported_with_the_reasons() {
    let mesh = wave(16);
    let mut options = Options::preset(Preset::Default).to_faces(60);
    assert_eq!(simplify(&mesh, &options).unwrap().shortfall, None);
    options.protect.limits.max_edge = Some(0.2);
    let result = simplify(&mesh, &options).unwrap();
    let shortfall = result.shortfall.unwrap();
    assert_eq!((shortfall.wanted_faces, shortfall.wanted_vertices), (Some(60), None));
    assert_eq!(shortfall.held_by[0].0, Rejection::MaxEdge);
    assert!(result.mesh.topology().face_count() > 60);
    options.protect.limits = FaceLimits { max_valence: Some(3), ..FaceLimits::default() };
    // All vertices have five or six edges.
    let ball = TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(2).unwrap()).unwrap();
    let shortfall = simplify(&ball, &options).unwrap().shortfall.unwrap();
    assert!(shortfall.held_by.iter().any(|&(reason, _)| reason == Rejection::MaxValence));
}

#[test]
fn constraints_that_mean_nothing_are_refused() {
    let mesh = wave(4);
    let refused = |limits: FaceLimits| {
        let mut options = Options::preset(Preset::Fast);
        options.protect.limits = limits;
        matches!(simplify(&mesh, &options), Err(SimplifyError::Option { .. }))
    };
    let none = FaceLimits::default();
    assert!(!refused(none));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(refused(FaceLimits { max_edge: Some(bad), ..none }));
        assert!(refused(FaceLimits { min_angle: Some(bad), ..none }));
    }
    assert!(refused(FaceLimits { min_angle: Some(60_f64.to_radians()), ..none }));
    assert!(refused(FaceLimits { max_valence: Some(2), ..none }));
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let mut options = Options::preset(Preset::Fast);
        options.protect.importance = Some(mesh.topology().vertex_map(bad));
        let error = simplify(&mesh, &options).unwrap_err();
        assert!(matches!(error, SimplifyError::Importance { .. }));
    }
}

/// Blocks know no such constraints, so the greedy loop does the whole run.
#[test]
fn constraints_exclude_blocks() {
    let mesh = wave(8);
    let plan = |change: fn(&mut Options)| {
        let mut options = Options::preset(Preset::Fast);
        options.cost.schedule = Schedule::Parallel;
        change(&mut options);
        Plan::of(&options, &mesh)
    };
    assert!(!matches!(plan(|_| {}), Plan::Greedy));
    assert!(matches!(plan(|o| o.protect.limits.max_edge = Some(1.0)), Plan::Greedy));
    assert!(matches!(plan(|o| o.protect.limits.min_angle = Some(0.1)), Plan::Greedy));
    assert!(matches!(plan(|o| o.protect.limits.max_valence = Some(9)), Plan::Greedy));
    assert!(matches!(plan(|o| o.protect.kept = Some(EdgeMap::from_vec(Vec::new()))), Plan::Greedy));
    let weighted = |o: &mut Options| o.protect.importance = Some(VertexMap::from_vec(Vec::new()));
    assert!(matches!(plan(weighted), Plan::Greedy));
}
