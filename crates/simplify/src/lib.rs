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
//! All lengths are in model units. Results are bitwise the same for any number of threads.

mod anneal;
mod collapse_back;
mod constraint;
mod cost;
mod curve;
mod driver;
mod face_lists;
mod finish;
mod fit;
mod guard;
mod intersection;
mod log;
mod options;
mod patch;
mod peaks;
mod placement;
mod quadric;
mod queue;
mod record;
mod rounds;
mod simplify;
mod squeeze;
mod stop;
mod symmetric;
mod tether;
mod texture_fit;
mod transfer;
mod wedges;
mod within;

pub use anneal::{AnnealOptions, AnnealReport, anneal};
pub use constraint::{Boundary, Constraints};
pub use cost::{
    AttributeDeviation, Collapse, Cost, CurvatureFactor, CurvatureNorm, GarlandHeckbert, Hybrid,
    Memoryless, Norm, Reach,
};
pub use curve::Curve;
pub use driver::{Policies, Progress, Run, Update, collapse_edges};
pub use fit::{FitConstraints, FitOptions, FitReport, fit};
pub use guard::{
    ComponentGuard, Guard, IntersectionGuard, NormalGuard, Refusal, Refusals, ShapeGuard,
    TextureGuard,
};
pub use log::{CollapseLog, LogEntry};
pub use options::{ErrorCheck, Metric, Options, PlacementRule, Preset, UnknownPreset};
pub use patch::{EdgePatch, PatchFace, Place};
pub use peaks::{PeakOptions, PeakReport, cut_peaks};
pub use placement::{BestEndpoint, ButterflyPoint, Midpoint, Optimal, Placement};
pub use quadric::Quadric;
pub use record::RecordError;
pub use simplify::{AchievedError, Simplified, SimplifyError, simplify, simplify_observed};
pub use stop::{Limits, StopReason};
pub use symmetric::Symmetric3;
pub use transfer::{CornerSource, corner_sources, seam_nodes};
pub use wedges::{CornerAttributes, MAX_CHANNELS};
pub use within::collapses_within;
