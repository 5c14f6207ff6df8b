//! The tests of this crate, in one program: it is linked once.

mod distances;
mod proofs;
mod scales;
mod serde;
