//! Levels of detail: several results of one run, some of which fit into memory.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;

use crate::common::{bits, open_torus, settings, split, torus, write};
use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, CompareOptions, Surface, compare, hausdorff_bounds};
use out_of_core::{
    Error, Next, Outcome, ResultMesh, Settings, Step, Work, assemble, refine_cell, run, write_tiles,
};
use simplify::{Options, Preset, RefineOptions, Target};

fn faces(count: usize) -> Target {
    Target { faces: Some(count), ..Target::default() }
}

fn ratio(share: f64) -> Target {
    Target { ratio: Some(share), ..Target::default() }
}

/// All results of a run as meshes, from the finest, with their bounds.
fn results(outcome: &Outcome, work: &Work, scratch: &Path) -> Vec<(TriMesh, Option<f64>)> {
    let mesh = |left: &ResultMesh| match left {
        ResultMesh::InMemory(mesh) => mesh.clone(),
        ResultMesh::OnDisk { level } => {
            let path = scratch.join("assembled.ply");
            assemble(work, *level, &path).unwrap();
            TriMesh::from_soup(&mesh_io::read(&path).unwrap().soup).unwrap()
        }
    };
    let finer = outcome.finer_levels.iter().map(|level| {
        let mesh = mesh(&level.load(work).unwrap());
        assert_eq!(mesh.topology().face_count() as u64, level.faces);
        (mesh, level.error)
    });
    finer.chain([(mesh(&outcome.result), outcome.error)]).collect()
}

fn euler(mesh: &TriMesh) -> i64 {
    let topology = mesh.topology();
    topology.vertex_count() as i64 - topology.edge_count() as i64 + topology.face_count() as i64
}

const SAMPLED: CompareOptions =
    CompareOptions { samples: 40_000, vertices: true, edges: true, seed: 1 };

fn mean(a: &TriMesh, b: &TriMesh) -> f64 {
    let [a, b] = [a, b].map(|mesh| Surface::new(mesh).unwrap());
    compare(&a, &b, &SAMPLED).mean()
}

/// Settings with results that fit into memory and results that do not.
fn given(preset: Preset) -> Settings {
    let finer = vec![faces(4000), ratio(0.6), faces(20_000)];
    Settings { finer_levels: finer, ..settings(preset, 1000, 10_000, 9000) }
}

#[test]
fn every_level_has_the_number_of_faces_asked_for_and_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let closed = ("closed", torus(60_000, 6), &[Preset::Fast, Preset::Default][..]);
    let open = ("open", open_torus(60_000, 6), &[Preset::Default][..]);
    for (name, mesh, presets) in [closed, open] {
        let input = write(&mesh, &folder.path().join(name).with_extension("ply"));
        let faces = mesh.topology().face_count();
        for &preset in presets {
            let mut given = given(preset);
            given.prove = Some(1e-3);
            let work = folder.path().join(format!("{name}-{preset}"));
            let work = split(&work, &input, &given).unwrap();
            let targets = work.targets();
            assert_eq!(targets, [(0.6 * faces as f64).ceil() as u64, 20_000, 4000, 1000]);
            let outcome = run(&work, &mut |_| true).unwrap();
            let is_apart = |level: &out_of_core::DetailLevel| {
                matches!(level.load(&work), Ok(ResultMesh::OnDisk { .. }))
            };
            let apart: Vec<bool> = outcome.finer_levels.iter().map(is_apart).collect();
            assert_eq!(apart, [true, true, false]);
            let made = results(&outcome, &work, folder.path());
            let mut last = 0.0;
            for ((level, proved), &target) in made.iter().zip(&targets) {
                let topology = level.topology();
                let count = topology.face_count() as u64;
                assert!(count.abs_diff(target) <= target / 100, "{preset}: {count} for {target}");
                assert!(topology.validate().is_ok());
                assert_eq!(topology.is_closed(), mesh.topology().is_closed());
                assert_eq!(euler(level), euler(&mesh), "{name} {preset} {count}");
                let options = Options::preset(preset).to_faces(count as usize);
                let whole = simplify::simplify(&mesh, &options).unwrap().mesh;
                let [here, there] = [level, &whole].map(|result| mean(&mesh, result));
                assert!(
                    here < 1.15 * there && here > last,
                    "{name} {preset} {count}: {here} {there}"
                );
                last = here;
                let [a, b] = [&mesh, level].map(|mesh| Surface::new(mesh).unwrap());
                let met = compare(&a, &b, &SAMPLED).hausdorff();
                assert!(met <= proved.unwrap(), "{name} {preset} {count}");
            }
            // As tiles, too.
            let tiles = folder.path().join("tiles");
            let level = outcome.finer_levels[0].load(&work).unwrap();
            assert_eq!(
                write_tiles(&work, &level, &tiles).unwrap().faces,
                outcome.finer_levels[0].faces
            );
        }
    }
}

#[test]
fn levels_have_the_same_bits_however_they_come_about() {
    let mesh = torus(60_000, 2);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    // The preset that uses more than quadrics.
    let given = given(Preset::Default);
    let place = |name: &str| folder.path().join(name);
    let of = |outcome: &Outcome, work: &Work| -> Vec<_> {
        results(outcome, work, folder.path()).iter().map(|(mesh, _)| bits(mesh)).collect()
    };
    let work = split(&place("whole"), &input, &given).unwrap();
    let whole = of(&run(&work, &mut |_| true).unwrap(), &work);
    assert_eq!(whole.len(), 4);

    // With one thread, step by step, in another order.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let work = split(&place("steps"), &input, &given).unwrap();
        let mut level = 0;
        let (mut finished, mut strips) = (Vec::new(), 0);
        loop {
            let plan = work.plan(level).unwrap();
            if plan.results > 0 {
                finished.push((level, plan.cells));
            }
            match plan.next {
                Next::InMemory | Next::Done => break,
                Next::SeamStrips { .. } => strips += 1,
                Next::Pass { .. } => {
                    (0..plan.cells).rev().for_each(|cell| drop(work.reduce(level, cell)));
                }
            }
            let joined = work.cells(level + 1).unwrap();
            (0..joined).rev().for_each(|cell| drop(work.join(level + 1, cell).unwrap()));
            level += 1;
        }
        assert_eq!((finished.len(), strips), (2, 2));
        for (level, cells) in finished.into_iter().rev() {
            let finish = |cell| drop(refine_cell(&work, level, cell, &mut |_| true).unwrap());
            (0..cells).rev().for_each(finish);
        }
        assert!(of(&run(&work, &mut |_| true).unwrap(), &work) == whole);
    });

    // Stopped at random steps, and with a region that was cut short.
    let mut random = fastrand::Rng::with_seed(7);
    let mut stops = 0;
    let outcome = loop {
        let mut left = random.usize(1..12);
        let observer = &mut |_: Step| {
            left = left.saturating_sub(1);
            left > 0 || stops > 20
        };
        let done = split(&place("stopped"), &input, &given).and_then(|work| run(&work, observer));
        match done {
            Ok(done) => break done,
            Err(Error::Stopped) => stops += 1,
            Err(error) => panic!("{error}"),
        }
        if stops % 4 == 1 {
            cut_one_short(&place("stopped"), &mut random);
        }
    };
    assert!(stops > 2, "{stops}");
    let work = Work::open(&place("stopped")).unwrap();
    assert!(of(&outcome, &work) == whole);
    // Finished steps are not repeated.
    let mut steps = 0;
    let again = run(&work, &mut |_| {
        steps += 1;
        true
    });
    assert!(steps == 0 && of(&again.unwrap(), &work) == whole, "{steps}");
}

/// Truncates a finished region, as a power failure would.
fn cut_one_short(work: &Path, random: &mut fastrand::Rng) {
    let mut finished = Vec::new();
    for level in 0..20 {
        let Ok(files) = std::fs::read_dir(work.join(format!("level-{level}"))) else { break };
        finished.extend(files.map(|file| file.unwrap().path()).filter(|path| {
            path.extension().is_some_and(|extension| extension == "refined" || extension == "lod")
        }));
    }
    finished.sort();
    if let Some(path) = random.choice(finished) {
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    }
}

/// For a mesh that fits, the levels equal the levels of a run in memory, bit for bit. (Presets that use more than
/// quadrics start differently with so few faces.)
#[test]
fn levels_of_what_fits_are_those_of_one_run() {
    let mesh = torus(20_000, 3);
    let folder = tempfile::tempdir().unwrap();
    let input = write(&mesh, &folder.path().join("in.ply"));
    for preset in [Preset::Draft, Preset::Fast] {
        let mut given = settings(preset, 500, 100_000, 100_000);
        given.finer_levels = vec![ratio(0.4), faces(1500)];
        given.options.refine = RefineOptions::none();
        let work = split(&folder.path().join(preset.name()), &input, &given).unwrap();
        let outcome = run(&work, &mut |_| true).unwrap();
        let mut options = given.options.clone();
        options.record = true;
        let log = simplify::simplify(&mesh, &options).unwrap().log;
        let made = results(&outcome, &work, folder.path());
        for (target, (level, _)) in work.targets().into_iter().zip(made) {
            let count = log.count_for_faces(target as usize);
            let (expected, _) = log.level(&mesh, count).unwrap();
            assert!(bits(&expected) == bits(&level), "{preset} {target}");
        }
    }
}

#[test]
fn bounds_of_all_levels_hold_for_random_partitions() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = fastrand::Rng::with_seed(61);
    let (mut apart, mut tightest) = (0, 0.0_f64);
    for round in 0..30_u64 {
        let mesh = torus(random.usize(800..2400), round);
        let input = write(&mesh, &folder.path().join("in.ply"));
        let preset = if round % 3 == 0 { Preset::Default } else { Preset::Fast };
        let mut given = settings(preset, 60, random.u64(60..500), random.u64(150..900));
        given.finer_levels = (0..3).map(|_| ratio(0.05 + 0.8 * random.f64())).collect();
        given.prove = Some(1e-3);
        let folder_of_run = folder.path().join("work");
        let work = split(&folder_of_run, &input, &given).unwrap();
        let outcome = run(&work, &mut |_| true).unwrap();
        let is_apart = |level: &&out_of_core::DetailLevel| {
            matches!(level.load(&work), Ok(ResultMesh::OnDisk { .. }))
        };
        apart += outcome.finer_levels.iter().filter(is_apart).count();
        let before = Surface::new(&mesh).unwrap();
        let size = before.bounding_box().diagonal();
        let options = CertifyOptions { tolerance: 1e-3 * size, ..CertifyOptions::default() };
        for (level, proved) in results(&outcome, &work, folder.path()) {
            let exact = hausdorff_bounds(&before, &Surface::new(&level).unwrap(), &options);
            let proved = proved.unwrap();
            assert!(exact.lower <= proved, "round {round}: {} above {proved}", exact.lower);
            tightest = tightest.max(exact.lower / proved);
        }
        std::fs::remove_dir_all(&folder_of_run).unwrap();
    }
    assert!(apart > 10 && tightest > 0.5, "{apart} levels in regions, at best {tightest}");
}

#[test]
fn a_level_is_a_number_of_faces() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = torus(20_000, 0);
    let input = write(&mesh, &folder.path().join("in.ply"));
    let work = folder.path().join("work");
    for bad in [
        Target::default(),
        Target { cost: Some(1.0), ..faces(500) },
        Target { vertices: Some(20), ..Target::default() },
    ] {
        let given = Settings { finer_levels: vec![bad], ..settings(Preset::Fast, 100, 700, 800) };
        assert!(matches!(split(&work, &input, &given), Err(Error::Unsupported(..))));
        assert!(!work.exists());
    }
    // Equal targets, more faces than the input has, and coarser than in the options: all results exist.
    let finer = vec![faces(50), faces(50_000), faces(10_000), faces(10_000), ratio(0.0)];
    let given = Settings { finer_levels: finer, ..settings(Preset::Fast, 100, 4000, 5000) };
    let work = split(&work, &input, &given).unwrap();
    let outcome = run(&work, &mut |_| true).unwrap();
    let counts: Vec<u64> = outcome.finer_levels.iter().map(|level| level.faces).collect();
    assert_eq!(counts[..3], [mesh.topology().face_count() as u64, counts[1], counts[1]]);
    assert!(counts[1].abs_diff(10_000) <= 100, "{counts:?}");
    assert_eq!(counts[3..], [100, 50]);
    assert!(outcome.faces < 50);
}
