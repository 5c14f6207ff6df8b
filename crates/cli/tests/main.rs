//! The tests of this crate, in one program, so that it is linked once.

mod attributes;
mod book;
#[path = "../../mesh-io/tests/built_scene/mod.rs"]
mod built_scene;
mod commands;
mod common;
mod compare;
mod constraints;
mod conventions;
mod counts;
mod faults;
mod interrupt;
mod large;
mod losses;
mod many;
mod needed_repairs;
mod patch;
mod pictures;
mod points;
mod postconditions;
mod principal;
mod real_meshes;
mod scenes;
mod settings;
mod shapes;
mod simplify;
mod split;
mod streaming;
mod views;
