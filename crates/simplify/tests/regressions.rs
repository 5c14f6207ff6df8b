//! Errors seen in simplifiers, one test each.
#![allow(clippy::unwrap_used)]

use crate::common::joined;
use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::{EdgeMap, FaceId, PolygonSoup, TriMesh, VertexId, VertexMap};
use mesh_shapes::{Irregular, Plane, Sphere, Torus, Wave, polyhedra};
use simplify::{
    Boundary, Cost, EdgePatch, ErrorCheck, Midpoint, Options, Placement, Policies, Policy, Preset,
    Quadric, RefineOptions, Rejection, Schedule, Scratch, Simplified, SimplifyError, StopReason,
    Target, collapse_edges, simplify,
};
use std::ops::ControlFlow;

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

/// Both meshes in one.
fn together(a: &TriMesh, b: &TriMesh) -> TriMesh {
    let part = |mesh: &TriMesh| (mesh.positions().to_vec(), mesh.topology().triangles().collect());
    joined(&[a, b].map(part))
}

fn grid(cells: usize) -> TriMesh {
    mesh(&Plane { half_width: 1.0 }.mesh(cells, Default::default()).unwrap())
}

fn wave(cells: usize) -> TriMesh {
    let wave = Wave { amplitude: 0.15, wavelength: 1.1, half_width: 1.0 };
    let irregular = Irregular { jitter: 0.2, seed: 4 };
    mesh(&wave.irregular_mesh(cells, irregular).unwrap())
}

/// The presets that are fast enough for larger meshes in tests.
const QUICK: [Preset; 4] = [Preset::Fast, Preset::Default, Preset::Quality, Preset::ThinFeatures];

fn run(mesh: &TriMesh, preset: Preset, faces: usize) -> Simplified {
    let result = simplify(mesh, &Options::preset(preset).to_faces(faces)).unwrap();
    result.mesh.topology().validate().unwrap();
    assert!(result.mesh.topology().is_compact());
    assert!(result.mesh.positions().iter().all(|p| p.is_finite()));
    result
}

#[test]
fn trap_1_the_number_of_faces_is_what_was_asked_for() {
    let sphere = mesh(&Sphere { radius: 1.0 }.icosphere(4).unwrap());
    let (torus, open) = (mesh(&Torus { major: 1.0, minor: 0.4 }.mesh(60, 40).unwrap()), wave(40));
    for preset in QUICK {
        for mesh in [&sphere, &torus, &open] {
            for faces in [1000, 601, 300, 77] {
                let result = run(mesh, preset, faces);
                let got = result.mesh.topology().face_count();
                assert!(got == faces || got == faces - 1, "{preset}: {got}, not {faces}");
                assert_eq!(result.stop, StopReason::Faces);
            }
        }
        let vertices = Target { vertices: Some(123), ..Target::default() };
        let mut options = Options::preset(preset);
        options.target = vertices;
        let result = simplify(&sphere, &options).unwrap();
        assert_eq!(result.mesh.topology().vertex_count(), 123);
        assert_eq!(result.stop, StopReason::Vertices);
        let ratio = Target { ratio: Some(0.25), faces: Some(10), ..Target::default() };
        options.target = ratio;
        let result = simplify(&sphere, &options).unwrap();
        assert_eq!(result.mesh.topology().face_count(), 1280);
    }
}

#[test]
fn trap_2_flat_and_nearly_flat_grids_stay_in_their_bounding_box() {
    let flat = grid(40);
    let mut random = SplitMix64::new(2);
    let mut nearly = flat.clone();
    nearly.positions_mut().iter_mut().for_each(|p| p.z = 1e-9 * random.symmetric());
    for mesh in [&flat, &nearly] {
        for &preset in Preset::ALL {
            let result = run(mesh, preset, 100);
            // The butterfly mask extrapolates at corners of the boundary.
            let is_butterfly = preset.name().starts_with("paper");
            let limit = if is_butterfly { 1.1 } else { 1.0 + 1e-6 };
            for p in result.mesh.positions() {
                assert!(p.x.abs() <= limit && p.y.abs() <= limit, "{preset}: {p}");
                assert!(p.z.abs() <= 1e-8, "{preset}: {p}");
            }
        }
    }
}

#[test]
fn trap_3_coordinates_that_are_not_finite_are_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut mesh = grid(3);
        mesh.positions_mut()[5].y = bad;
        let error = simplify(&mesh, &Options::default().to_faces(4)).unwrap_err();
        assert!(matches!(error, SimplifyError::NotFinite { vertex, .. } if vertex.get() == 5));
        let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
        assert!(TriMesh::from_triangles(mesh.positions(), &triangles).is_err());
    }
}

#[test]
fn trap_4_the_boundary_stays_or_the_result_says_how_far_it_moved() {
    let open = wave(30);
    let on_boundary = |mesh: &TriMesh| {
        let topology = mesh.topology();
        let all = topology.vertices().filter(|&v| topology.is_boundary_vertex(v));
        let mut points: Vec<[f64; 3]> = all.map(|v| mesh.position(v).to_array()).collect();
        points.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap());
        points
    };
    for preset in QUICK {
        let mut options = Options::preset(preset).to_faces(300);
        options.protect.boundary = Boundary::Lock;
        let locked = simplify(&open, &options).unwrap();
        assert_eq!(on_boundary(&locked.mesh), on_boundary(&open));
        assert_eq!(locked.boundary_shift, Some(0.0));

        options.protect.boundary = Boundary::Quadrics;
        let kept = simplify(&open, &options).unwrap();
        assert!(on_boundary(&kept.mesh).len() < on_boundary(&open).len());
        let shift = kept.boundary_shift.unwrap();
        assert!(shift > 0.0 && shift < 0.1, "{preset}: {shift}");

        // A flat square keeps its outline with any number of faces.
        let square = run(&grid(20), preset, 2);
        assert!(square.boundary_shift.unwrap() < 1e-5, "{preset}: {:?}", square.boundary_shift);
        assert!((square.mesh.area() - 4.0).abs() < 1e-5);
    }
    assert_eq!(run(&mesh(&polyhedra::icosahedron()), Preset::Fast, 10).boundary_shift, None);
}

#[test]
fn trap_5_two_plates_far_apart_reduce_alike() {
    let near = moved(&wave(24), |p| 10.0 * p);
    let far = moved(&near, |p| p + 900.0 * DVec3::Z);
    let plates = together(&near, &far);
    let half = near.positions().len() as u32;
    for preset in QUICK {
        // The log contains the collapses of the run, without the decimation to the tolerance.
        let mut options = Options::preset(preset).within(0.1, ErrorCheck::Sampled);
        options.tolerance.decimate = false;
        let result = simplify(&plates, &options).unwrap();
        assert_eq!(result.stop, StopReason::Error);
        let reduced = result.log.entries();
        let [first, second] =
            [true, false].map(|f| reduced.iter().filter(|e| (e.kept.get() < half) == f).count());
        assert!(first > 150 && first.abs_diff(second) <= first / 50, "{preset}: {first} {second}");
    }
}

#[test]
fn trap_6_moving_or_scaling_the_mesh_changes_nothing() {
    let sphere = Sphere { radius: 1.0 }.irregular_icosphere(3, Irregular { jitter: 0.2, seed: 9 });
    for original in [mesh(&sphere.unwrap()), wave(20)] {
        for preset in QUICK {
            let sequence = |mesh: &TriMesh| {
                let log = run(mesh, preset, 100).log;
                log.entries().iter().map(|e| (e.removed, e.kept)).collect::<Vec<_>>()
            };
            let expected = sequence(&original);
            for scale in [1e-6, 1e6] {
                assert_eq!(sequence(&moved(&original, |p| scale * p)), expected, "{preset}");
            }
            // The positions are rounded after the shift, so they are the same at both places.
            let shift = DVec3::new(1e6, -1e6, 1e6);
            let there = moved(&original, |p| p + shift);
            let here = moved(&there, |p| p - shift);
            assert_eq!(sequence(&there), sequence(&here), "{preset}");
        }
    }
}

#[test]
fn trap_7_closed_components_end_as_tetrahedra() {
    let sphere = mesh(&Sphere { radius: 1.0 }.icosphere(2).unwrap());
    let two = together(&sphere, &moved(&sphere, |p| 0.3 * p + 5.0 * DVec3::X));
    for &preset in Preset::ALL {
        for (mesh, components) in [(&sphere, 1), (&two, 2)] {
            let result = run(mesh, preset, 0);
            assert_eq!(result.stop, StopReason::NothingLeft);
            let topology = result.mesh.topology();
            assert_eq!(topology.components().count, components);
            assert!(topology.is_closed() && topology.face_count() >= 4 * components);
            let by_norm = preset.name().starts_with("paper");
            if !by_norm {
                assert_eq!(topology.face_count(), 4 * components, "{preset}");
            }
        }
    }
    let mut options = Options::preset(Preset::Fast);
    options.protect.min_component_vertices = Some(20);
    let kept = simplify(&two, &options).unwrap();
    assert_eq!(kept.mesh.topology().vertex_count(), 40);
    assert!(kept.rejections.of(Rejection::Component) > 0);
}

/// Prefers the edges inside a range of vertices, then edges to earlier vertices, then the rest.
struct Prefer(std::ops::Range<u32>);

impl Policy for Prefer {}

impl Cost for Prefer {
    fn cost(&self, patch: &EdgePatch<'_>, _: Option<&Quadric>, _: DVec3, _: &mut Scratch) -> f64 {
        let ends = [patch.removed(), patch.kept()].map(VertexId::get);
        match ends {
            _ if ends.iter().all(|v| self.0.contains(v)) => 0.0,
            _ if ends.iter().all(|v| *v < self.0.end) => 1.0 + patch.squared_length(),
            _ => 1000.0 + patch.squared_length(),
        }
    }
}

#[test]
fn trap_8_a_refused_edge_is_tried_again() {
    // A tower of triangles. The middle triangle is not a face, so its edges fail the link condition until the lower
    // half of the tower is gone.
    let levels = 9_u32;
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut triangles = vec![[0, 2, 1], [3 * levels - 3, 3 * levels - 2, 3 * levels - 1]];
    for level in 0..levels {
        for corner in 0..3 {
            let angle = f64::from(corner) * std::f64::consts::TAU / 3.0;
            points.push([angle.cos(), angle.sin(), f64::from(level)]);
            if level + 1 < levels {
                let (a, b) = (3 * level + corner, 3 * level + (corner + 1) % 3);
                triangles.extend([[a, b, b + 3], [a, b + 3, a + 3]]);
            }
        }
    }
    let mut tower = TriMesh::from_triangles(&points, &triangles).unwrap();
    let middle = 3 * (levels / 2)..3 * (levels / 2) + 3;
    let policies = Policies::new(Prefer(middle.clone()), Midpoint);
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let result =
        collapse_edges(&mut tower, policies, &Default::default(), &Target::default(), go_on);
    assert!(result.rejections.of(Rejection::LinkCondition) >= 3);
    let of_middle = |v: VertexId| middle.contains(&v.get());
    let first = result.log.entries().iter().position(|e| of_middle(e.removed) && of_middle(e.kept));
    assert!(first.unwrap() > 0);
    assert_eq!(tower.topology().face_count(), 4);
}

#[test]
fn trap_9_valences_stay_bounded_on_a_flat_grid() {
    let check = |preset: Preset, side: usize, faces: usize| {
        let mut options = Options::preset(preset).to_faces(faces);
        options.refine = RefineOptions::none();
        let result = simplify(&grid(side), &options).unwrap();
        let topology = result.mesh.topology();
        let highest = topology.vertices().map(|v| topology.valence(v)).max().unwrap();
        println!("{preset}: {side} x {side}, highest valence {highest}");
        assert!(topology.face_count() <= faces);
        assert!(highest < 40, "{preset}: {highest}");
    };
    check(Preset::Fast, 1500, 15_000);
    check(Preset::Default, 200, 1500);
}

/// A cube whose sides are cut into squares, and its twelve edges as features.
fn cube_with_features() -> (TriMesh, EdgeMap<bool>) {
    let mut fine = mesh(&polyhedra::cube());
    for _ in 0..4 {
        let (topology, _) = fine.topology().subdivide_1_to_4().unwrap();
        let mut points = fine.positions().to_vec();
        points.extend(fine.topology().edges().map(|e| {
            let [a, b] = fine.topology().edge_vertices(e);
            0.5 * (fine.position(a) + fine.position(b))
        }));
        fine = TriMesh::new(topology, points).unwrap();
    }
    let mut features = fine.topology().edge_map(false);
    for e in fine.topology().edges() {
        let [f, g] = fine.topology().edge_faces(e).map(Option::unwrap);
        features[e] = fine.face_normal(f).dot(fine.face_normal(g)) < 0.5;
    }
    (fine, features)
}

#[test]
fn trap_15_locked_vertices_and_feature_edges_stay() {
    let (cube, features) = cube_with_features();
    let bounds = cube.bounding_box().unwrap();
    for preset in QUICK {
        let mut options = Options::preset(preset).to_faces(60);
        options.protect.features = Some(features.clone());
        let result = simplify(&cube, &options).unwrap();
        result.mesh.topology().validate().unwrap();
        let simplified = &result.mesh;
        for corner in 0..8 {
            let pick = |axis: usize| {
                if corner >> axis & 1 == 1 { bounds.max[axis] } else { bounds.min[axis] }
            };
            let at = DVec3::new(pick(0), pick(1), pick(2));
            assert!(simplified.positions().contains(&at), "{preset}: no vertex at {at}");
        }
        // Each of the twelve edges is still complete: the sharp edges have the same total length.
        let topology = simplified.topology();
        let sharp = topology.edges().filter(|&e| {
            let [f, g]: [FaceId; 2] = topology.edge_faces(e).map(Option::unwrap);
            simplified.face_normal(f).dot(simplified.face_normal(g)) < 0.5
        });
        let length: f64 = sharp
            .map(|e| {
                let [a, b] = topology.edge_vertices(e);
                simplified.position(a).distance(simplified.position(b))
            })
            .sum();
        let expected = 12.0 * bounds.extent().x;
        assert!((length - expected).abs() < 1e-4 * expected, "{preset}: {length}, not {expected}");
    }

    let sphere = mesh(&Sphere { radius: 1.0 }.icosphere(3).unwrap());
    let mut locked: VertexMap<bool> = sphere.topology().vertex_map(false);
    for v in sphere.topology().vertices().step_by(20) {
        locked[v] = true;
    }
    for &preset in Preset::ALL {
        let mut options = Options::preset(preset).to_faces(100);
        options.protect.locked = Some(locked.clone());
        let result = simplify(&sphere, &options).unwrap();
        for (v, _) in locked.iter().filter(|(_, locked)| **locked) {
            let new = result.vertex_map[v].unwrap();
            assert_eq!(result.mesh.position(new), sphere.position(v), "{preset}");
        }
    }
}

#[test]
fn trap_17_one_thread_and_eight_threads_give_the_same_bits() {
    let original = wave(40);
    for preset in QUICK {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut options = Options::preset(preset).to_faces(400);
                options.tolerance.check = Some(ErrorCheck::Certified);
                let result = simplify(&original, &options).unwrap();
                let bits: Vec<_> = result
                    .mesh
                    .positions()
                    .iter()
                    .map(|p| p.to_array().map(f64::to_bits))
                    .collect();
                let triangles: Vec<_> = result.mesh.topology().triangles().collect();
                (bits, triangles, result.log, result.error)
            })
        };
        assert_eq!(run(1), run(8), "{preset}");
    }
}

/// A placement is any type that implements the trait.
struct Quarter;

impl Policy for Quarter {}

impl Placement for Quarter {
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        _: Option<&Quadric>,
        _: &mut dyn FnMut(DVec3) -> f64,
    ) -> simplify::Place {
        simplify::Place::At(0.5 * patch.ends()[0])
    }
}

#[test]
fn costs_and_placements_from_outside_work() {
    let mut sphere = mesh(&Sphere { radius: 1.0 }.icosphere(2).unwrap());
    let mut policies = Policies::new(Prefer(0..40), Quarter);
    policies.schedule = Schedule::Exact;
    let limits = Target { faces: Some(200), ..Target::default() };
    let result = collapse_edges(&mut sphere, policies, &Default::default(), &limits, &mut |_| {
        ControlFlow::Continue(())
    });
    assert_eq!(sphere.topology().face_count(), 200);
    assert_eq!(result.log.len(), 60);
}
