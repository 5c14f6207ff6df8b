//! Attacks on the libraries: functions that take arbitrary bytes, do with them what a caller may
//! do, and panic when a promise is broken.
//!
//! The fuzzer calls them with bytes that it finds (`fuzz/fuzz_targets`), and a test with those that
//! are kept (`fuzz/corpus`), on a stable toolchain. An attack is in a module named after what it is
//! made on. Readers take the bytes as they are; the others make meshes with vertices at small whole
//! numbers of them ([`shape`]), which are full of coincidences: equal lengths, flat quadrilaterals,
//! faces without area, faces that touch.
// A broken promise is a panic here.
#![allow(clippy::expect_used, clippy::panic, clippy::missing_panics_doc)]

pub mod build;
pub mod distance;
pub mod edits;
pub mod flip;
pub mod patch;
pub mod read;
pub mod record;
pub mod round_trip;
pub mod shape;
pub mod simplify;
pub mod work_folder;

/// An attack with arbitrary bytes.
pub type Attack = fn(&[u8]);

/// All attacks by name; the corpus of each is in a folder of that name.
pub const ALL: &[(&str, Attack)] = &[
    ("read_obj", read::obj),
    ("read_ply", read::ply),
    ("read_stl", read::stl),
    ("read_off", read::off),
    ("read_gltf", read::gltf),
    ("round_trip", round_trip::attack),
    ("build_mesh", build::attack),
    ("edits", edits::attack),
    ("flip", flip::attack),
    ("simplify", simplify::attack),
    ("patch", patch::attack),
    ("distance", distance::attack),
    ("record", record::attack),
    ("work_folder", work_folder::attack),
];
