//! Studies of single algorithms, whose results are also shown in the reproduction of the papers.
//!
//! [`convex_study`] counts how often edge flips find a scrambled convex hull again. [`limit_study`] compares simplified
//! meshes with the best possible ones. Both print.
#![allow(clippy::print_stdout, clippy::print_stderr)]

pub mod convex_study;
pub mod limit_study;
