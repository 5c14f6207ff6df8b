//! Files of regions: reading gives the written region or a typed error.

#![allow(clippy::unwrap_used, clippy::panic)]

use crate::common::{bits, settings, simplify, split, torus, write};
use ::simplify::Preset;
use out_of_core::{Error, Region, run};

#[test]
fn every_change_of_a_file_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let input = write(&torus(2000, 0), &folder.path().join("in.ply"));
    let given = settings(Preset::Draft, 100, 700, 200);
    let work = split(&folder.path().join("work"), &input, &given).unwrap();
    work.plan(0).unwrap();
    work.reduce(0, 1).unwrap();
    for name in ["cell-1.region", "cell-1.reduced"] {
        let path = work.folder().join("level-0").join(name);
        let region = Region::read(&path).unwrap();
        let copy = folder.path().join("copy");
        region.write(&copy).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes, std::fs::read(&copy).unwrap());
        let mut random = fastrand::Rng::with_seed(1);
        for round in 0..300 {
            let mut changed = bytes.clone();
            if round % 3 == 0 {
                changed.truncate(random.usize(0..bytes.len()));
            } else {
                let place =
                    if round % 3 == 1 { random.usize(0..68) } else { random.usize(0..bytes.len()) };
                changed[place] ^= 1 << random.u8(0..8);
            }
            std::fs::write(&copy, &changed).unwrap();
            let read = Region::read(&copy);
            assert!(
                matches!(
                    read,
                    Err(Error::Damaged { .. } | Error::RegionTooLarge { .. } | Error::Io { .. })
                ),
                "{round}: {read:?}"
            );
        }
    }
}

/// A run that is killed while it splits its input, or while it removes its files, leaves no manifest, and perhaps
/// levels of other settings. The next run starts again, and leaves no such files.
#[test]
fn a_folder_without_its_manifest_is_begun_anew() {
    let folder = tempfile::tempdir().unwrap();
    let input = write(&torus(20_000, 0), &folder.path().join("in.ply"));
    let [draft, fast] =
        [Preset::Draft, Preset::Fast].map(|preset| settings(preset, 400, 2000, 1000));
    let expected = simplify(&folder.path().join("other"), &input, &fast).unwrap();
    let place = folder.path().join("work");
    let killed = split(&place, &input, &draft).unwrap();
    let levels = run(&killed, &mut |_| true).unwrap().levels.len();
    assert!(levels > 1);
    // The lock of a killed process is free.
    drop(killed);
    std::fs::remove_file(place.join("run.json")).unwrap();
    std::fs::remove_dir_all(place.join("level-0")).unwrap();
    std::fs::create_dir_all(place.join("scratch/left")).unwrap();
    let work = split(&place, &input, &fast).unwrap();
    let done = run(&work, &mut |_| true).unwrap().into_mesh().unwrap();
    assert!(bits(&done) == bits(&expected.mesh));
    work.remove();
    assert!(!place.exists());
}

/// Invalid regions are rejected even with a correct checksum.
#[test]
fn what_is_no_region_is_refused_with_a_checksum_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("region");
    let point = glam::DVec3::ZERO;
    let good = Region {
        own: 3,
        vertex_ids: vec![1, 4, 7],
        positions: vec![point, point + glam::DVec3::X, point + glam::DVec3::Y],
        triangles: vec![[0, 1, 2]],
        ..Region::default()
    };
    good.write(&path).unwrap();
    assert_eq!(Region::read(&path).unwrap(), good);
    let bad = [
        Region { triangles: vec![[0, 1, 3]], ..good.clone() },
        Region { triangles: vec![[0, 1, 1]], ..good.clone() },
        Region { triangles: vec![[0, 1, 2], [0, 1, 2]], ..good.clone() },
        Region { non_manifold: vec![5], ..good.clone() },
        Region { vertex_ids: vec![4, 1, 7], ..good.clone() },
        Region { positions: vec![glam::DVec3::NAN; 3], ..good.clone() },
        Region { own: 2, other_cells: vec![0], ..good.clone() },
    ];
    for region in bad {
        region.write(&path).unwrap();
        assert!(matches!(Region::read(&path), Err(Error::Damaged { .. })), "{region:?}");
    }
}
