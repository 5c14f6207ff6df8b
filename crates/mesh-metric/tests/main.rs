//! The tests of this crate in one program, so that it is linked once.

mod distances;
mod normals;
mod points;
mod proofs;
mod scales;
mod serde;
