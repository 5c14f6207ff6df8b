//! The tests of this crate, in one program: it is linked once.

mod anneal;
mod any_mesh;
mod cancel;
mod common;
mod fit;
mod high_valence;
mod intersections;
mod limits;
mod norm;
mod options;
mod own_policies;
mod peaks;
mod published;
mod regions;
mod stop;
mod touching;
mod transfer;
mod traps;
mod unused_vertices;
