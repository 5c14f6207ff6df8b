//! Collapses in blocks: results are bit-identical for any number of threads, meshes are valid, and the record replays.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use core::ops::ControlFlow;
use std::time::Duration;

use crate::common::model;
use glam::DVec3;
use mesh_core::{TriMesh, VertexId};
use mesh_metric::{CompareOptions, Surface, compare};
use mesh_shapes::{Irregular, Plane, Sphere, Torus, Wave};
use simplify::blocks::{Block, CostThreshold, FlatMesh, Fragment, Reduced, Rules};
use simplify::{
    ErrorCheck, Options, Preset, Schedule, Simplified, SimplifyError, StopReason, finish_collapses,
    simplify, simplify_observed,
};

/// A bent torus with enough faces for blocks.
fn torus(rings: usize) -> TriMesh {
    let soup = Torus { major: 5.0, minor: 2.0 }.mesh(rings, rings / 2).unwrap();
    let mut mesh = TriMesh::from_soup(&soup).unwrap();
    for p in mesh.positions_mut() {
        p.z += 0.1 * ((3.0 * p.x).sin() * (4.0 * p.y).sin() + (5.0 * p.z).sin());
    }
    mesh
}

/// An open flat mesh with hills.
fn hills(cells: usize) -> TriMesh {
    let wave = Wave { amplitude: 0.15, wavelength: 0.7, half_width: 1.0 };
    let soup = wave.irregular_mesh(cells, Irregular { jitter: 0.2, seed: 4 }).unwrap();
    TriMesh::from_soup(&soup).unwrap()
}

fn quick(preset: Preset) -> Options {
    let mut options = Options::preset(preset);
    options.refine = simplify::RefineOptions::none();
    options.record = true;
    options
}

fn bits(mesh: &TriMesh) -> (Vec<[u64; 3]>, Vec<[u32; 3]>) {
    let positions = mesh.positions().iter().map(|p| p.to_array().map(f64::to_bits)).collect();
    (positions, mesh.topology().triangles().collect())
}

fn mean_error(mesh: &TriMesh, result: &TriMesh) -> f64 {
    let [a, b] = [mesh, result].map(|mesh| Surface::new(mesh).unwrap());
    compare(&a, &b, &CompareOptions { samples: 60_000, ..CompareOptions::default() }).mean()
}

/// Checks that hold for every result.
fn assert_whole(mesh: &TriMesh, result: &Simplified, faces: usize) {
    let left = &result.mesh;
    left.topology().validate().unwrap();
    let count = left.topology().face_count();
    assert!(count == faces || count + 1 == faces, "{count}");
    assert_eq!(result.stop, StopReason::Faces);
    assert!(left.positions().iter().all(|p| p.is_finite()));
    assert_eq!(left.topology().components().count, mesh.topology().components().count);
    let before = mesh.topology().vertex_count();
    assert_eq!(before - result.collapses, left.topology().vertex_count());
    assert!(result.vertex_map.as_slice().iter().all(Option::is_some));
}

#[test]
fn threads_do_not_change_a_bit() {
    let meshes = [torus(400), hills(220)];
    for mesh in &meshes {
        // With this many faces left, the greedy loop does the whole run.
        let much = (Preset::Default, 30_000);
        let little = [Preset::Draft, Preset::Fast, Preset::Default].map(|preset| (preset, 2500));
        for (preset, faces) in little.into_iter().chain([much]) {
            let options = quick(preset).to_faces(faces);
            let run = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| simplify(mesh, &options).unwrap())
            };
            let one = run(1);
            assert_whole(mesh, &one, faces);
            for threads in [2, 3, 8] {
                let other = run(threads);
                assert!(bits(&one.mesh) == bits(&other.mesh), "{preset} {threads}");
                assert_eq!(one.log, other.log);
                assert_eq!(one.vertex_map, other.vertex_map);
                assert_eq!(one.rejections, other.rejections);
            }
        }
    }
}

/// The log has the same form as the log of the greedy loop: legal collapses of the original, in an order in which every
/// prefix is a level.
#[test]
fn the_record_replays_to_the_same_bits_and_to_levels() {
    for mesh in [torus(340), hills(200)] {
        for (preset, faces) in [
            (Preset::Draft, 3000),
            (Preset::Fast, 20_000),
            (Preset::Default, 1200),
            (Preset::Default, 12_000),
        ] {
            let result = simplify(&mesh, &quick(preset).to_faces(faces)).unwrap();
            assert_eq!(result.log.len(), result.collapses);
            let (level, vertex_map) = result.log.level(&mesh, result.log.len()).unwrap();
            assert!(bits(&level) == bits(&result.mesh), "{preset} {faces}");
            assert_eq!(vertex_map, result.vertex_map);
            let count = result.log.count_for_faces(2 * faces);
            let (level, _) = result.log.level(&mesh, count).unwrap();
            level.topology().validate().unwrap();
            let of_level = mean_error(&mesh, &level);
            let mut alone = quick(preset);
            alone.cost.schedule = Schedule::Lazy;
            let alone = simplify(&mesh, &alone.to_faces(2 * faces)).unwrap();
            let of_alone = mean_error(&mesh, &alone.mesh);
            assert!(of_level < 1.3 * of_alone, "{preset} {faces}: {of_level} {of_alone}");
        }
    }
}

/// The whole mesh as a fragment before the first pass.
fn fragment(mesh: &TriMesh) -> Fragment {
    Fragment {
        positions: mesh.positions().to_vec(),
        own: mesh.positions().len(),
        triangles: mesh.topology().triangles().collect(),
        ..Fragment::default()
    }
}

/// After passes made elsewhere, the log of the rest belongs to the mesh that these passes have left.
#[test]
fn the_rest_after_passes_made_elsewhere_is_recorded_too() {
    let mesh = torus(400);
    let size = mesh.bounding_box().unwrap().diagonal();
    let whole = fragment(&mesh);
    for preset in [Preset::Draft, Preset::Fast, Preset::Default] {
        let mut options = quick(preset).to_faces(3000);
        let rules = simplify::rules(&options, size).unwrap();
        let sheet = FlatMesh::from_fragment(whole.clone());
        let threshold = CostThreshold::leaving(0.5, &[&sheet.forecast(0, &rules, 0.3, 4)]);
        let left = sheet.reduce(0, &rules, threshold).into_fragment();
        let start = TriMesh::from_triangles(&left.positions, &left.triangles).unwrap();
        let faces = mesh.topology().face_count();
        assert!(start.topology().face_count() < 2 * faces / 3);
        let mut finish = |record: bool| {
            options.record = record;
            let go_on = &mut |_: &_| ControlFlow::Continue(());
            finish_collapses(left.clone(), &options, size, faces, go_on).unwrap()
        };
        let ((end, run), (unrecorded, _)) = (finish(true), finish(false));
        assert!(bits(&end) == bits(&unrecorded), "{preset}");
        let (level, _) = run.log.level(&start, run.log.len()).unwrap();
        assert!(bits(&level) == bits(&end), "{preset}");
        let (level, _) = run.log.level(&start, run.log.count_for_faces(9000)).unwrap();
        assert!(level.topology().face_count().abs_diff(9000) < 2);
        level.topology().validate().unwrap();
    }
}

/// A cost is an area times a squared distance, so it scales with the unit of length.
#[test]
fn a_ceiling_is_a_cost() {
    let small = torus(60);
    let mut large = small.clone();
    large.positions_mut().iter_mut().for_each(|p| *p *= 8.0);
    let size = small.bounding_box().unwrap().diagonal();
    let left = |mesh: &TriMesh, unit: f64, cost: f64| {
        let rules = Rules::of_size(unit * size);
        let cost = cost * (unit * size).powi(4);
        FlatMesh::new(mesh).reduce(0, &rules, CostThreshold::at(cost, &rules)).face_count()
    };
    let costs = [0.0, 1e-10, 1e-8, 1e-6];
    let counts = costs.map(|cost| left(&small, 1.0, cost));
    assert_eq!(counts, costs.map(|cost| left(&large, 8.0, cost)));
    assert!(counts.is_sorted_by(|a, b| a > b), "{counts:?}");
    assert_eq!(counts[0], small.topology().face_count());
}

#[test]
fn a_part_of_a_mesh_has_no_end_of_its_own() {
    let mesh = torus(60);
    let size = mesh.bounding_box().unwrap().diagonal();
    let mut part = fragment(&mesh);
    part.own -= 1;
    let faces = part.triangles.len();
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let options = quick(Preset::Fast).to_faces(2000);
    let error = finish_collapses(part, &options, size, faces, go_on).unwrap_err();
    assert!(matches!(error, SimplifyError::Conflict { .. }), "{error}");
    assert!(error.to_string().contains("join all fragments"));
}

#[test]
fn nothing_is_recorded_unless_asked() {
    let mesh = torus(240);
    let options = Options::preset(Preset::Draft).to_faces(2000);
    let bare = simplify(&mesh, &options).unwrap();
    assert!(bare.log.is_empty() && bare.collapses > 10_000);
    let mut recorded = options;
    recorded.record = true;
    let recorded = simplify(&mesh, &recorded).unwrap();
    assert!(bits(&bare.mesh) == bits(&recorded.mesh));
    assert_eq!(bare.vertex_map, recorded.vertex_map);
}

/// Blocks are as close to the original as one queue for the whole mesh; on grids, where most costs are equal, nearly
/// so.
#[test]
fn regions_cost_no_accuracy() {
    let made = [torus(240), hills(160)].map(|mesh| (mesh, 1.1));
    let real = ["igea.ply"].into_iter().filter_map(model);
    for (mesh, most) in made.into_iter().chain(real.map(|mesh| (mesh, 1.03))) {
        for faces in [1500, 25_000] {
            let error = |schedule: Schedule| {
                let mut options = quick(Preset::Fast).to_faces(faces);
                options.cost.schedule = schedule;
                mean_error(&mesh, &simplify(&mesh, &options).unwrap().mesh)
            };
            let (regions, lazy) = (error(Schedule::Parallel), error(Schedule::Lazy));
            assert!(regions < most * lazy, "{faces}: {regions} {lazy}");
            let draft = simplify(&mesh, &quick(Preset::Draft).to_faces(faces)).unwrap();
            let draft = mean_error(&mesh, &draft.mesh);
            assert!(draft < 1.5 * lazy, "{faces}: {draft} {lazy}");
        }
        // The presets with the hybrid metric: after quadrics in blocks, and with the greedy loop for the whole run.
        for (part, most) in [(49.0, most), (5.0, 1.03), (2.5, 1.03)] {
            let error = |schedule: Schedule| {
                let faces = (mesh.topology().face_count() as f64 / part) as usize;
                let mut options = quick(Preset::Default).to_faces(faces);
                options.cost.schedule = schedule;
                mean_error(&mesh, &simplify(&mesh, &options).unwrap().mesh)
            };
            let (regions, lazy) = (error(Schedule::Parallel), error(Schedule::Lazy));
            assert!(regions < most * lazy, "default, 1 in {part}: {regions} {lazy}");
        }
    }
}

/// The time at which the hybrid metric takes over has little effect, also on meshes that are too small for blocks.
/// Every run is recorded completely.
#[test]
fn the_metric_may_take_over_late() {
    for mesh in [torus(60), hills(70)] {
        let faces = mesh.topology().face_count();
        let run = |switch_ratio: Option<f64>, wanted: usize| {
            let mut options = quick(Preset::Default).to_faces(wanted);
            options.cost.switch_ratio = switch_ratio;
            let result = simplify(&mesh, &options).unwrap();
            assert_whole(&mesh, &result, wanted);
            let (level, _) = result.log.level(&mesh, result.log.len()).unwrap();
            assert!(bits(&level) == bits(&result.mesh));
            (result.mesh.topology().canonical_triangles(), mean_error(&mesh, &result.mesh).ln())
        };
        let mut logs = [0.0; 3];
        for wanted in (25..=53).step_by(4).map(|part| faces / part) {
            let from_start = run(None, wanted);
            let later = [24.0, 10.0, 3.0].map(|factor| run(Some(factor), wanted));
            assert!(from_start.0 != later[1].0);
            later.iter().zip(&mut logs).for_each(|(late, sum)| *sum += late.1 - from_start.1);
        }
        assert!(logs.iter().all(|sum| (sum / 8.0).abs() < 0.03), "{logs:?}");
        // A switch near the beginning equals no switch.
        assert!(run(Some(5.0), faces * 2 / 5).0 == run(None, faces * 2 / 5).0);
    }
    for factor in [0.5, f64::NAN, f64::INFINITY] {
        let mut options = quick(Preset::Default).to_faces(100);
        options.cost.switch_ratio = Some(factor);
        assert!(matches!(simplify(&torus(20), &options), Err(SimplifyError::Option { .. })));
    }
}

/// If only an error limit ends the run, all presets whose metric decimation makes superfluous do the same before
/// decimation, and record it.
#[test]
fn regions_do_all_that_comes_before_a_decimation() {
    let mesh = torus(200);
    let within = |options: &Options| {
        let options = options.clone().within(0.01, ErrorCheck::Sampled);
        assert!(options.tolerance.decimate);
        let result = simplify(&mesh, &options).unwrap();
        assert!(result.error.unwrap().is_within(0.01));
        let (level, _) = result.log.level(&mesh, result.collapses).unwrap();
        let [left, of_level] = [&result.mesh, &level].map(|mesh| mesh.topology().face_count());
        assert!(left < of_level && of_level < mesh.topology().face_count());
        (bits(&level), bits(&result.mesh))
    };
    let fast = within(&Options::preset(Preset::Fast));
    let default = Options::preset(Preset::Default);
    assert!(within(&default) == fast);
    let mut others = [default.clone(), default];
    others[0].cost.curvature_weight = 0.2;
    others[1].cost.switch_ratio = None;
    for options in others {
        assert!(within(&options).0 != fast.0);
    }
}

/// All detail is in one corner, where no block was sampled: no pass goes too far.
#[test]
fn uneven_meshes_come_to_the_number_of_faces() {
    for (corner, faces) in [(DVec3::new(7.0, 0.0, 0.0), 40_000), (DVec3::ZERO, 12_000)] {
        let mut mesh = torus(400);
        for (i, p) in mesh.positions_mut().iter_mut().enumerate() {
            let near = (1.0 - p.distance(corner) / 3.0).max(0.0);
            p.z += near * 0.05 * ((i * i % 97) as f64 / 97.0 - 0.5);
        }
        let result = simplify(&mesh, &quick(Preset::Fast).to_faces(faces)).unwrap();
        assert_whole(&mesh, &result, faces);
    }
}

#[test]
fn real_meshes_stay_whole() {
    // Closed and open meshes, with one component and many, with slivers.
    let names = ["igea.ply", "helicopter.obj", "armadillo_52k.off", "beast.obj", "conrod.stl"];
    for name in names.into_iter().chain(["zurich_georef.obj", "stanford-bunny.obj", "cow.obj"]) {
        let Some(mesh) = model(name) else { return };
        let before = mesh.topology().face_count();
        for preset in [Preset::Draft, Preset::Fast] {
            for ratio in [0.3, 0.02] {
                let faces = (ratio * before as f64).ceil() as usize;
                let result = simplify(&mesh, &quick(preset).to_faces(faces)).unwrap();
                result.mesh.topology().validate().unwrap();
                let left = result.mesh.topology().face_count();
                let is_there = left == faces || left + 1 == faces;
                assert!(is_there || result.stop == StopReason::NothingLeft, "{name} {left}");
                let level = result.log.level(&mesh, result.log.len()).unwrap().0;
                assert!(bits(&level) == bits(&result.mesh), "{name} {preset} {ratio}");
                let closed = mesh.topology().is_closed();
                assert_eq!(result.mesh.topology().is_closed(), closed, "{name}");
            }
        }
    }
}

#[test]
fn removed_and_unused_vertices_are_no_trouble() {
    let mut mesh = torus(240);
    for _ in 0..500 {
        let side = mesh.topology().half_edges().nth(7).unwrap();
        if let Ok(legal) = mesh.topology().check_collapse(side) {
            let place = mesh.position(legal.kept());
            mesh.collapse(legal, place);
        }
    }
    mesh.add_vertex([1.0, 2.0, 3.0]).unwrap();
    let result = simplify(&mesh, &quick(Preset::Fast).to_faces(3000)).unwrap();
    result.mesh.topology().validate().unwrap();
    let (level, vertex_map) = result.log.level(&mesh, result.log.len()).unwrap();
    assert!(bits(&level) == bits(&result.mesh));
    assert_eq!(vertex_map, result.vertex_map);
    let lone = VertexId::new(mesh.topology().vertex_capacity() as u32 - 1);
    let lone = result.vertex_map[lone].unwrap();
    assert!(result.mesh.topology().is_isolated_vertex(lone));
}

/// However a run ends, its result is complete.
#[test]
fn a_run_can_be_ended_at_any_time() {
    let mesh = torus(400);
    for looks in [0, 1, 2, 3, 5, 9] {
        for preset in [Preset::Draft, Preset::Default] {
            let mut seen = 0;
            let result = simplify_observed(&mesh, &quick(preset).to_faces(1000), &mut |_| {
                seen += 1;
                if seen > looks { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            let result = result.unwrap();
            result.mesh.topology().validate().unwrap();
            let is_stopped = result.stop == StopReason::Cancelled;
            assert_eq!(is_stopped, seen > looks, "{looks} {preset}");
            assert!(is_stopped || looks > 3);
            assert_eq!(looks == 0, result.collapses == 0);
            let (level, _) = result.log.level(&mesh, result.log.len()).unwrap();
            assert!(bits(&level) == bits(&result.mesh), "{looks} {preset}");
        }
    }
}

/// Also on meshes that are too small for blocks, and with rare checks of the clock.
#[test]
fn no_time_is_no_collapse() {
    for mesh in [torus(20), torus(300)] {
        for &preset in Preset::ALL {
            let mut options = Options::preset(preset).to_faces(100);
            options.target.time = Some(Duration::ZERO);
            let result = simplify(&mesh, &options).unwrap();
            assert_eq!((result.stop, result.collapses), (StopReason::Time, 0), "{preset}");
            assert!(bits(&result.mesh) == bits(&mesh));
        }
    }
}

#[test]
fn scale_and_place_do_not_matter() {
    let mesh = hills(220);
    let run = |mesh: &TriMesh| simplify(mesh, &quick(Preset::Fast).to_faces(3000)).unwrap();
    let here = run(&mesh);
    let mut large = mesh.clone();
    large.positions_mut().iter_mut().for_each(|p| *p *= 1024.0);
    let there = run(&large);
    let pairs = here.mesh.positions().iter().zip(there.mesh.positions());
    assert!(pairs.clone().all(|(a, b)| (*a * 1024.0).distance(*b) < 1e-9));
    let mut far = mesh.clone();
    far.positions_mut().iter_mut().for_each(|p| *p += 1e6);
    let error = mean_error(&far, &run(&far).mesh);
    assert!(error < 1.05 * mean_error(&mesh, &here.mesh));
}

#[test]
fn flat_and_touching_places_are_no_trouble() {
    // A flat mesh: all costs are zero. All vertices at one place: no costs at all.
    let flat =
        TriMesh::from_soup(&Plane { half_width: 1.0 }.mesh(170, Default::default()).unwrap());
    let flat = flat.unwrap();
    let result = simplify(&flat, &quick(Preset::Draft).to_faces(400)).unwrap();
    assert_whole(&flat, &result, 400);
    assert!(result.mesh.positions().iter().all(|p| p.z == 0.0 && p.abs().max_element() < 1.0001));
    let mut point = TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(6).unwrap()).unwrap();
    point.positions_mut().iter_mut().for_each(|p| *p *= 0.0);
    let result = simplify(&point, &quick(Preset::Draft).to_faces(400)).unwrap();
    result.mesh.topology().validate().unwrap();
}

/// Blocks that are done one by one, in any order, give the same result as blocks that are done together.
#[test]
fn regions_do_not_see_each_other() {
    for mesh in [torus(400), hills(220)] {
        let rules = Rules::new(&mesh);
        let mut sheet = FlatMesh::new(&mesh);
        for pass in 0..3 {
            let partition = sheet.partition(pass);
            let region = |i| Block::new(&sheet, &partition, i, &rules);
            let forecast = region(1).forecast(&rules, 0.2);
            let threshold = CostThreshold::leaving(0.5, &[&forecast]);
            assert_eq!(
                CostThreshold::leaving(1.0, &[&forecast]),
                CostThreshold::leaving(2.0, &[&forecast])
            );
            assert_eq!(region(0).reduce(&rules, CostThreshold::NONE).collapses(), 0);
            let count = partition.blocks();
            let mut backwards: Vec<Reduced> =
                (0..count).rev().map(|i| region(i).reduce(&rules, threshold)).collect();
            backwards.reverse();
            let faces: usize = backwards.iter().map(Reduced::face_count).sum();
            let together = FlatMesh::join(backwards);
            assert_eq!(together.face_count(), faces);
            assert!(10 * faces < 7 * sheet.face_count(), "{faces} of {}", sheet.face_count());
            let left = together.to_mesh();
            left.topology().validate().unwrap();
            assert_eq!(left.topology().is_closed(), mesh.topology().is_closed());
            assert_eq!(left.topology().components().count, 1);
            sheet = together;
        }
        let error = mean_error(&mesh, &sheet.to_mesh());
        let options = quick(Preset::Draft).to_faces(sheet.face_count());
        let alone = simplify(&mesh, &options).unwrap();
        assert!(error < 1.5 * mean_error(&mesh, &alone.mesh));
    }
}
