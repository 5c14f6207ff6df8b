//! Records of collapses from arbitrary bytes, and from valid records with some bytes changed.

use std::sync::OnceLock;

use mesh_core::TriMesh;
use mesh_shapes::Sphere;
use mesh_work::LevelRecord;
use simplify::{CollapseLog, Options, Preset, simplify};

use crate::shape::assert_sound;

/// Reads a record and makes levels from it. The first byte tells whether the other bytes are the record, or pairs of a
/// position, in two bytes, and a new byte for it.
pub fn attack(data: &[u8]) {
    let Some((&kind, rest)) = data.split_first() else { return };
    let (mesh, good) = good();
    let mut bytes = rest.to_vec();
    if kind % 2 == 1 {
        bytes = good.clone();
        for &[high, low, value] in rest.as_chunks::<3>().0 {
            let at = usize::from(u16::from_be_bytes([high, low])) % bytes.len();
            bytes[at] = value;
        }
    }
    // The checksum of the file finds every change. Below, the log has none.
    let is_read = LevelRecord::read(mesh, &mut bytes.as_slice()).is_ok();
    assert_eq!(
        is_read,
        bytes.starts_with(good),
        "a changed record was read, or a good one was refused"
    );
    match CollapseLog::read(mesh, &mut bytes.as_slice()) {
        Ok(log) => levels(mesh, &log),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn levels(mesh: &TriMesh, log: &CollapseLog) {
    for count in [0, 1, log.len() / 2, log.len(), log.count_for_faces(20)] {
        // A collapse that is not legal is refused.
        if let Ok((level, became)) = log.level(mesh, count) {
            assert_sound(&level);
            for vertex in became.as_slice().iter().flatten() {
                assert!(
                    level.topology().contains_vertex(*vertex),
                    "{vertex:?} is not in the level"
                );
            }
        }
    }
    let mut again = Vec::new();
    log.write(mesh, &mut again).expect("a vector takes everything");
    let again = CollapseLog::read(mesh, &mut again.as_slice()).expect("what was written is read");
    assert_eq!(format!("{again:?}"), format!("{log:?}"));
}

/// A mesh, and a record of it.
fn good() -> &'static (TriMesh, Vec<u8>) {
    static GOOD: OnceLock<(TriMesh, Vec<u8>)> = OnceLock::new();
    GOOD.get_or_init(|| {
        let soup = Sphere { radius: 2.0 }.icosphere(1).expect("a sphere");
        let mesh = TriMesh::from_soup(&soup).expect("a sphere is a mesh");
        let options = Options::preset(Preset::Fast).to_faces(8);
        let log = simplify(&mesh, &options).expect("a sphere can be simplified").log;
        let mut bytes = Vec::new();
        let record = LevelRecord { log, ..LevelRecord::default() };
        record.write(&mesh, &mut bytes).expect("a vector takes everything");
        (mesh, bytes)
    })
}
