//! Simplification of triangle meshes by edge collapse.

mod constraint;
mod cost;
mod driver;
mod guard;
mod log;
mod patch;
mod placement;
mod quadric;
mod queue;
mod stop;

pub use constraint::{Boundary, Constraints};
pub use cost::{Collapse, Cost, GarlandHeckbert, Hybrid, Memoryless, Reach};
pub use driver::{Policies, Progress, Run, collapse_edges};
pub use guard::{ComponentGuard, Guard, NormalGuard, Refusal, Refusals, ShapeGuard};
pub use log::{CollapseLog, LogEntry};
pub use patch::{EdgePatch, PatchFace, Place};
pub use placement::{BestEndpoint, Midpoint, Optimal, Placement};
pub use quadric::Quadric;
pub use stop::{Limits, StopReason};
