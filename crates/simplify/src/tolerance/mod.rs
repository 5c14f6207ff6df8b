//! Error limits: how far collapses may go.
//!
//! **Input:** the original, a run of collapses on it, and a distance.
//! **Output:** the number of collapses that stay, the resulting mesh, and its distance from the original, sampled or
//! proved.
//!
//! Invariants:
//!
//! - Distances are two-sided, and every comparison with a limit uses the same measurement.
//! - A mesh reported as within a limit was measured after its last change.
//! - Every level examined is a replay of the log of one run.
//!
//! Uses `mesh-collapse` and `mesh-refine` for levels and their refinement, and `mesh-metric` for distances. It does not
//! depend on the options of a run: the caller passes what to refine, measure and decimate.
//!
//! Layers, lowest first: `measure`, `bisection`, `edge_face_incidence`, `prepared_triangle`, `proofs`, `coverage` and
//! `edge_coverage`; `level_estimate` and `distance_constraint`; `decimate`; `level_search`.

mod bisection;
mod coverage;
mod decimate;
mod distance_constraint;
mod edge_coverage;
mod edge_face_incidence;
pub(crate) mod level_estimate;
pub(crate) mod level_search;
pub(crate) mod measure;
mod prepared_triangle;
mod proofs;
