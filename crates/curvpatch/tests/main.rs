//! The tests of this crate in one program, so that it is linked once.

mod accuracy;
mod common;
mod covers;
mod local_scale;
mod models;
mod patches;
mod robustness;
mod sections;
mod single_faces;
