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
pub use cost::{
    Collapse, Cost, CurvatureFactor, CurvatureNorm, GarlandHeckbert, Hybrid, Memoryless, Norm,
    Reach,
};
pub use driver::{Policies, Progress, Run, Update, collapse_edges};
pub use guard::{ComponentGuard, Guard, NormalGuard, Refusal, Refusals, ShapeGuard};
pub use log::{CollapseLog, LogEntry};
pub use patch::{EdgePatch, PatchFace, Place};
pub use placement::{BestEndpoint, ButterflyPoint, Midpoint, Optimal, Placement};
pub use quadric::Quadric;
pub use stop::{Limits, StopReason};
