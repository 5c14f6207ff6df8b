#![doc = include_str!("../README.md")]

pub mod blocks;
mod constraint;
mod cost;
mod engine;
mod geometry;
mod placement;
mod policies;
mod policy;
mod protect;
mod record;
mod rejection;

pub use constraint::{
    CloneConstraint, ComponentConstraint, Constraint, Constraints, FaceLimits,
    IntersectionConstraint, NormalConstraint, ShapeConstraint,
};
pub use cost::{Cost, CostModifier, GarlandHeckbert, Hybrid, Memoryless, Reach};
#[cfg(feature = "curvature")]
pub use cost::{CurvatureFactor, CurvatureNorm, CurvatureTerm, Norm};
pub use engine::edge_collapse::{cheapest_edges, collapse_edges, collapse_edges_from};
pub use engine::start::Start;
pub use geometry::edge_patch::{Collapse, EdgePatch, PatchFace, Place};
pub use geometry::new_intersections::{ChangedFace, NewIntersections};
pub use geometry::quadric::Quadric;
pub use geometry::symmetric::{Factors, Symmetric3};
pub use placement::{BestEndpoint, ButterflyPoint, LeastCost, Midpoint, Optimal, Placement};
pub use policies::{Policies, Schedule};
pub use policy::{Needs, Policy, Scratch};
pub use protect::{Boundary, Protect, Protected};
pub use record::level::{Level, with_gaps};
pub use record::log::serialization::RecordError;
pub use record::log::{CollapseLog, LogEntry, ReplayError};
pub use record::run::{Phase, Progress, Run};
pub use record::snapshot::Snapshot;
pub use record::target::{StopReason, Target};
pub use rejection::{Rejection, Rejections};
