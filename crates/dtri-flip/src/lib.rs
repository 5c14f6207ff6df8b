#![doc = include_str!("../README.md")]

mod affected_edges;
mod anneal;
mod blocked_edges;
mod cost;
mod cost_name;
mod costs;
mod error;
mod features;
mod flip_state;
mod fold;
mod greedy;
mod high_valence;
mod lattice_error;
mod look_ahead;
mod optimise;
mod options;
mod progress;
mod quad;
mod queue;
mod report;
mod ruin_recreate;
mod rules;
mod run;
mod self_intersection;
mod shape;

pub use cost::{Change, FlipCost, Stencil};
pub use cost_name::{CostName, UnknownCost};
pub use costs::{
    AbsExtrinsic, AbsMean, FaceCost, FaceFunction, VertexCost, VertexCostCache, VertexFunction,
    VirtualWillmore, Willmore,
};
pub use error::FlipError;
pub use features::feature_edges;
pub use lattice_error::{LatticeError, lattice_error};
pub use optimise::{optimise, optimise_with};
pub use options::{Anneal, FlipOptions, Rebuild, Ties, Update};
pub use progress::{Phase, Progress};
pub use quad::Quad;
pub use report::{FlipReport, Rejections, Stop};
pub use shape::{ShapeConstraint, UnknownShapeConstraint};
