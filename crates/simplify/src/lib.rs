#![doc = include_str!("../README.md")]

mod dispatch;
mod error;
mod memory;
mod options;
mod plan;
mod preset;
mod simplify;
mod tolerance;

pub use mesh_collapse::*;
pub use mesh_refine::*;

pub use error::SimplifyError;
pub use memory::memory_needed;
pub use options::{
    AttributeOptions, CollapseOptions, LimitOptions, Metric, Options, PlacementRule, RefineOptions,
};
pub use plan::{finish_collapses, rules};
pub use preset::{Preset, UnknownPreset};
pub use simplify::{Simplified, simplify, simplify_observed, simplify_with};
pub use tolerance::measure::{AchievedError, ErrorCheck};
pub use tolerance::within::collapses_within;
