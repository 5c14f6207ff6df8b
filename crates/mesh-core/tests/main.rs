//! The tests of this crate, in one program, so that it is linked once.

mod build;
mod butterfly;
mod diagnose;
mod downstream;
mod edits;
mod extents;
mod faces;
mod facing;
mod scales;
mod serde;
mod topology;
mod touching;
