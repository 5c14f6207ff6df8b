//! The tests of this crate, in one program: it is linked once.

mod common;
mod crowded;
mod guards;
mod rebuild;
mod runs;
mod serde;
mod seven_points;
mod torus;
mod willmore;
