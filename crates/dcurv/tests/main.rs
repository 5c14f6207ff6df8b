//! The tests of this crate, in one program, so that it is linked once.

mod convergence;
mod fitted;
mod laws;
mod properties;
mod published;
mod real_meshes;
mod scales;
mod serde;
