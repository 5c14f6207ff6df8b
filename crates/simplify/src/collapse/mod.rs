//! The greedy loop over edge collapses, and the policies that steer it.
//!
//! **In:** a mesh, which is changed in place; a cost, a placement and guards; what must stay; limits.
//! **Out:** the collapses as a log that can be replayed, how often edges were refused and why, and why
//! the run ended.
//!
//! Invariants:
//!
//! - The mesh is a manifold after every collapse, and removed elements leave gaps: handles, the log
//!   and maps of the caller stay valid until the caller compacts the mesh.
//! - Policies see a collapse through an [`EdgePatch`](patch::EdgePatch), relative to the midpoint of
//!   the edge. They hear of every collapse that is carried out and of no other one.
//! - A log replayed on the mesh that it was made with gives the same bits, also when it is stopped
//!   early.
//! - An edge that was refused is tried again only once something round it has changed.
//!
//! Uses nothing of the other rooms of this crate; of other crates `mesh-core`, and `dcurv` for the
//! curvature costs.
//!
//! From the bottom: `symmetric`, `quadric`, `patch`; `constraint`, `refusal`, `stop`; `log`, `snapshot`,
//! `run`, `level`; the traits of `cost`, `placement` and `guard`, and those who implement them; `start`, `fixed`,
//! `stars`, `detail`, `evaluate`, `schedule`, `watch`, `valence`; `step`, which is one edge's turn; `driver`, which gives edges
//! their turns.

pub(crate) mod constraint;
mod contact;
pub(crate) mod cost;
mod detail;
pub(crate) mod driver;
mod evaluate;
pub(crate) mod fixed;
pub(crate) mod guard;
pub(crate) mod intersection;
pub(crate) mod level;
pub(crate) mod log;
pub(crate) mod patch;
pub(crate) mod placement;
pub(crate) mod policies;
pub(crate) mod policy;
pub(crate) mod quadric;
pub(crate) mod refusal;
pub(crate) mod run;
pub(crate) mod schedule;
pub(crate) mod snapshot;
mod stars;
pub(crate) mod start;
mod step;
pub(crate) mod stop;
pub(crate) mod symmetric;
pub(crate) mod valence;
mod watch;
