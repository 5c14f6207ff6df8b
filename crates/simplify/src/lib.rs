#![doc = include_str!("../README.md")]
#![cfg_attr(not(feature = "finish"), allow(rustdoc::broken_intra_doc_links))]
//!
//! ## The source
//!
//! There are five rooms, each above those before it: `collapse` (the loop and its policies),
//! `regions` (collapses on every core), `attributes`, `finish` (fit, anneal, peaks) and `limit` (the largest error).

#[cfg(feature = "finish")]
mod attributes;
#[cfg_attr(not(feature = "finish"), allow(dead_code, reason = "rooms above use the rest"))]
mod collapse;
#[cfg(feature = "finish")]
mod course;
#[cfg(feature = "finish")]
mod error;
#[cfg(feature = "finish")]
mod finish;
#[cfg(feature = "finish")]
mod limit;
#[cfg(feature = "finish")]
mod memory;
#[cfg(feature = "finish")]
mod named;
#[cfg(feature = "finish")]
mod options;
#[cfg(feature = "finish")]
mod preset;
#[cfg(feature = "finish")]
pub mod regions;
#[cfg(feature = "finish")]
mod simplify;

#[cfg(feature = "finish")]
pub use attributes::attribute_deviation::AttributeDeviation;
#[cfg(feature = "finish")]
pub use attributes::transfer::seams::seam_nodes;
#[cfg(feature = "finish")]
pub use attributes::transfer::{CornerSource, corner_sources};
#[cfg(feature = "finish")]
pub use attributes::wedges::{CornerAttributes, MAX_CHANNELS};
pub use collapse::constraint::{Boundary, Constraints};
pub use collapse::cost::{Cost, GarlandHeckbert, Hybrid, Memoryless, Reach, Surcharge};
#[cfg(feature = "curvature")]
pub use collapse::cost::{CurvatureFactor, CurvatureNorm, Norm};
pub use collapse::driver::collapse_edges;
pub use collapse::guard::{
    CloneGuard, ComponentGuard, Guard, Guards, IntersectionGuard, NormalGuard, ShapeGuard,
};
pub use collapse::log::record::RecordError;
pub use collapse::log::{CollapseLog, LogEntry, ReplayError};
pub use collapse::patch::{Collapse, EdgePatch, PatchFace, Place};
pub use collapse::placement::{BestEndpoint, ButterflyPoint, Midpoint, Optimal, Placement};
pub use collapse::policies::{Policies, Update};
pub use collapse::policy::{Needs, Policy, Scratch};
pub use collapse::quadric::Quadric;
pub use collapse::refusal::{Refusal, Refusals};
pub use collapse::run::{Phase, Progress, Run};
pub use collapse::stop::{Limits, StopReason};
pub use collapse::symmetric::Symmetric3;
#[cfg(feature = "finish")]
pub use course::{finish_collapses, rules};
#[cfg(feature = "finish")]
pub use error::SimplifyError;
#[cfg(feature = "finish")]
pub use finish::anneal::{AnnealOptions, AnnealReport, anneal};
#[cfg(feature = "finish")]
pub use finish::curve::Curve;
#[cfg(feature = "finish")]
pub use finish::fit::constraints::FitConstraints;
#[cfg(feature = "finish")]
pub use finish::fit::{FitOptions, FitReport, fit};
#[cfg(feature = "finish")]
pub use finish::norm::FitNorm;
#[cfg(feature = "finish")]
pub use finish::peaks::{PeakOptions, PeakReport, cut_peaks};
#[cfg(feature = "finish")]
pub use limit::measure::{AchievedError, ErrorCheck};
#[cfg(feature = "finish")]
pub use limit::within::collapses_within;
#[cfg(feature = "finish")]
pub use memory::memory_needed;
#[cfg(feature = "finish")]
pub use options::{
    AttributeOptions, CollapseOptions, FinishOptions, LimitOptions, Metric, Options, PlacementRule,
};
#[cfg(feature = "finish")]
pub use preset::{Preset, UnknownPreset};
#[cfg(feature = "finish")]
pub use simplify::{Simplified, simplify, simplify_observed, simplify_with};
