//! Studies of one algorithm each, whose results the reproduction of the papers shows too.
//!
//! [`convex_study`] counts how often edge flips find a scrambled convex hull again. [`limit_study`]
//! measures how far simplified meshes are from the best possible ones. Both print.
#![allow(clippy::print_stdout, clippy::print_stderr)]

pub mod convex_study;
pub mod limit_study;
