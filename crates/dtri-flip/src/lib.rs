#![doc = include_str!("../README.md")]

mod anneal;
mod cost;
mod cost_name;
mod costs;
mod crowded;
mod error;
mod features;
mod fold;
mod greedy;
mod intersection;
mod lattice_error;
mod look_ahead;
mod optimise;
mod options;
mod quad;
mod queue;
mod rebuild;
mod region;
mod report;
mod rules;
mod run;
mod trial;
mod waiting;
mod watch;

pub use cost::{Change, FlipCost, Reach};
pub use cost_name::{CostName, UnknownCost};
pub use costs::{
    AbsMean, FaceCost, FaceFunction, VertexCost, VertexCostCache, VertexFunction, VirtualWillmore,
    Willmore,
};
pub use error::FlipError;
pub use features::feature_edges;
pub use lattice_error::{LatticeError, lattice_error};
pub use optimise::{optimise, optimise_with};
pub use options::{Anneal, FlipOptions, Rebuild, Ties, Update};
pub use quad::Quad;
pub use report::{FlipReport, Refused, Stop};
pub use watch::{Phase, Progress};
