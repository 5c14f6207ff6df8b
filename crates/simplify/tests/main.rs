//! The tests of this crate in one program, so that it is linked once.

mod anneal;
mod any_mesh;
mod blocks;
mod cancel;
mod common;
mod constraints;
mod fit;
mod high_valence;
mod intersections;
mod limits;
mod max_error;
mod norm;
mod options;
mod own_policies;
mod poses;
mod published;
mod regressions;
mod scales;
mod stages;
mod stop;
mod touching;
mod transfer;
mod unused_vertices;
