//! Simplification of triangle meshes by edge collapse.
//!
//! [`simplify()`] takes [`Options`], most easily one of the presets, and returns a mesh together with
//! what was done, why it stopped, and what was refused. Underneath, [`collapse_edges`] is a greedy
//! loop over separate policies that can be mixed and replaced:
//!
//! - [`Cost`]: what a collapse costs. [`GarlandHeckbert`] (quadrics accumulated from the original),
//!   [`Memoryless`] (quadrics of the current faces), [`Hybrid`] (both), [`CurvatureFactor`] (any of
//!   them, raised where curvature changes), [`CurvatureNorm`] (Kim, Kim and Levin 2002).
//! - [`Placement`]: where the remaining vertex goes. [`Optimal`], with or without keeping the volume,
//!   [`ButterflyPoint`], [`BestEndpoint`], [`Midpoint`].
//! - [`Guard`]: what is refused. [`NormalGuard`], [`ShapeGuard`], [`ComponentGuard`],
//!   [`IntersectionGuard`]; manifoldness is always guarded.
//! - [`Limits`]: when to stop. [`Constraints`]: what must stay.
//!
//! [`fit()`] then moves the vertices closer to the original, [`anneal()`] spends patience on it, and
//! [`cut_peaks()`] takes down the largest errors. With [`Options::max_error`], and no attributes, the
//! coarsest level within it is collapsed further where that does not exceed it.
//!
//! The source has four rooms, each above those before it: `collapse` (the loop and its policies),
//! `attributes`, `finish` (fit, anneal, peaks) and `limit` (the largest error).
//!
//! All lengths are in model units. Results are bitwise the same for any number of threads.

mod attributes;
mod collapse;
mod error;
mod finish;
mod limit;
mod named;
mod options;
mod preset;
mod simplify;

pub use attributes::attribute_deviation::AttributeDeviation;
pub use attributes::texture_guard::TextureGuard;
pub use attributes::transfer::seams::seam_nodes;
pub use attributes::transfer::{CornerSource, corner_sources};
pub use attributes::wedges::{CornerAttributes, MAX_CHANNELS};
pub use collapse::constraint::{Boundary, Constraints};
pub use collapse::cost::{
    Cost, CurvatureFactor, CurvatureNorm, GarlandHeckbert, Hybrid, Memoryless, Norm, Reach,
};
pub use collapse::driver::collapse_edges;
pub use collapse::guard::{ComponentGuard, Guard, IntersectionGuard, NormalGuard, ShapeGuard};
pub use collapse::log::record::RecordError;
pub use collapse::log::{CollapseLog, LogEntry, ReplayError};
pub use collapse::patch::{Collapse, EdgePatch, PatchFace, Place};
pub use collapse::placement::{BestEndpoint, ButterflyPoint, Midpoint, Optimal, Placement};
pub use collapse::policies::{Policies, Update};
pub use collapse::quadric::Quadric;
pub use collapse::refusal::{Refusal, Refusals};
pub use collapse::run::{Phase, Progress, Run};
pub use collapse::stop::{Limits, StopReason};
pub use collapse::symmetric::Symmetric3;
pub use error::SimplifyError;
pub use finish::anneal::{AnnealOptions, AnnealReport, anneal};
pub use finish::curve::Curve;
pub use finish::fit::constraints::FitConstraints;
pub use finish::fit::{FitOptions, FitReport, fit};
pub use finish::peaks::{PeakOptions, PeakReport, cut_peaks};
pub use limit::measure::{AchievedError, ErrorCheck};
pub use limit::within::collapses_within;
pub use options::{Metric, Options, PlacementRule};
pub use preset::{Preset, UnknownPreset};
pub use simplify::{Simplified, simplify, simplify_observed};
