//! The tests of this crate, in one program: it is linked once.

mod bounds;
mod common;
mod files;
mod levels;
mod passing;
mod whole;
