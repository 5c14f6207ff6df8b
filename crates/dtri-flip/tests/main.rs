//! The tests of this crate, in one program, so that it is linked once.

mod common;
mod extrinsic;
mod guards;
mod high_valence;
mod postconditions;
mod ruin_recreate;
mod runs;
mod scales;
mod serde;
mod seven_points;
mod torus;
mod willmore;
