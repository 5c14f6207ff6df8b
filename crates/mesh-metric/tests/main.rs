//! The tests of this crate in one program, so that it is linked once.

mod distances;
mod proofs;
mod scales;
mod serde;
