#![doc = include_str!("../README.md")]

mod after_collapses;
mod cheaper;
mod collapse;
mod dispatch;
mod error;
mod folds;
mod memory;
mod option_checks;
mod options;
mod plan;
mod preset;
mod run;
mod shortfall;
mod simplified;
mod simplify;
mod stages;
mod tolerance;
mod unit_size;

pub use mesh_collapse::*;
pub use mesh_refine::*;

pub use collapse::finish_collapses;
pub use error::SimplifyError;
pub use memory::memory_needed;
pub use options::{
    AttributeOptions, CostOptions, Metric, Options, PlacementRule, RefineOptions, ToleranceOptions,
    Tuning, UnknownPlacement,
};
pub use plan::{Plan, rules};
pub use preset::{Preset, UnknownPreset};
pub use shortfall::Shortfall;
pub use simplified::Simplified;
pub use simplify::{simplify, simplify_observed, simplify_with};
pub use stages::Stages;
pub use tolerance::measure::{AchievedError, ErrorCheck};
