//! The tests of this crate, as one program.

#[path = "../../mesh-io/tests/built_scene/mod.rs"]
mod built_scene;
mod charts;
mod constraint_choices;
mod labels;
mod scales;
mod scene_trees;
mod scenes;
