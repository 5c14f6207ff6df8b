//! Bounds summed over regions and passes: the exact distance must never exceed them.

#![allow(clippy::unwrap_used, clippy::panic)]

use crate::common::{settings, simplify, torus, write};
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::Preset;

#[test]
fn two_hundred_random_partitions() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = fastrand::Rng::with_seed(16);
    let (mut passes, mut tightest) = (0, 0.0_f64);
    for round in 0..200_u64 {
        let mesh = torus(random.usize(400..2000), round);
        let input = write(&mesh, &folder.path().join("in.ply"));
        let faces = mesh.topology().face_count();
        let preset = if round % 2 == 0 { Preset::Draft } else { Preset::Fast };
        let target = (random.f64() * 0.5 * faces as f64) as usize + 20;
        let rest = random.u64(60..2000);
        let mut given =
            settings(preset, target, random.u64(40..900), rest.max(target as u64 * 11 / 10));
        given.prove = Some(1e-3);
        let work = folder.path().join("work");
        let done = simplify(&work, &input, &given).unwrap();
        std::fs::remove_dir_all(&work).unwrap();
        let [before, after] = [&mesh, &done.mesh].map(|mesh| Surface::new(mesh).unwrap());
        let size = before.bounding_box().diagonal();
        let options = CertifyOptions { tolerance: 1e-3 * size, ..CertifyOptions::default() };
        let exact = hausdorff_bounds(&before, &after, &options);
        let proved = done.error.unwrap();
        assert!(exact.lower <= proved, "round {round}: {} above {proved}", exact.lower);
        passes += done.levels.len() - 1;
        tightest = tightest.max(exact.lower / proved);
    }
    // There are runs with several passes, and bounds that are not trivial.
    assert!(passes > 150 && tightest > 0.5, "{passes} passes, at best {tightest}");
}
