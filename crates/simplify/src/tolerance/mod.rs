//! A largest error: how far collapses may go.
//!
//! **In:** the original, a run of collapses on it, and a distance.
//! **Out:** how many of the collapses may stay, the mesh that is left, and its distance from the
//! original, sampled or proved.
//!
//! Invariants:
//!
//! - A distance counts both ways, and is measured in one way wherever it is compared with a limit.
//! - What is said to be within a limit was measured after the last change of the mesh.
//! - Every level that is looked at is a replay of the log of one run.
//!
//! Uses the rooms `collapse` and `finish`, and `mesh-metric` for distances. It knows no options: what
//! is finished, measured and decimated to the tolerance, and how, is handed in.
//!
//! From the bottom: `measure`, `levels`, `covers`, `prepared`, `proofs`, `reach` and `spokes`; `guess`, `within` and `tether`;
//! `squeeze`; `search`.

mod bisection;
mod coverage;
mod decimate;
mod distance_constraint;
mod edge_face_incidence;
mod incident_edges;
pub(crate) mod level_search;
pub(crate) mod lower_bound_search;
pub(crate) mod measure;
mod prepared_triangle;
mod proofs;
pub(crate) mod within;
