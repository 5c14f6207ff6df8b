//! The tests of this crate in one program, so that it is linked once.

mod bounds;
mod common;
mod disk_mesh;
mod files;
mod levels;
mod scratch;
mod whole;
mod work_folder;
