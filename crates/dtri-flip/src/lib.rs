//! Edge-flip optimisation of triangle meshes: the vertices stay, and one edge flip after another
//! changes the triangulation to lower a cost.
//!
//! The method is that of Dyn, Hormann, Kim and Levin 2001, *Optimizing 3D triangulations using
//! discrete curvature analysis* (DHKL01): a greedy run that always takes the flip with the largest
//! gain, on a priority queue that is kept exact, and looks some flips ahead where no single one
//! helps. The papers leave two questions open: how to leave a local minimum, for which there is
//! seeded simulated [annealing](Anneal); and how to avoid self-intersections, for which there is an
//! exact [guard](FlipOptions::forbid_intersections).
//!
//! ```
//! use dtri_flip::{AbsMean, FlipOptions, Stop, optimise};
//! use mesh_core::{TriMesh, shapes};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let torus = shapes::Torus { major: 5.0, minor: 2.0 }.shifted_mesh(12, 6)?;
//! let mut mesh = TriMesh::from_soup(&torus)?;
//! let report = optimise(&mut mesh, &AbsMean, &FlipOptions::default())?;
//! assert_eq!(report.stop, Stop::LocalMinimum);
//! assert_eq!(report.flips, 54);
//! assert!((report.cost_after - 138.196323).abs() < 1e-6);
//! # Ok(())
//! # }
//! ```
//!
//! # Costs
//!
//! | name | cost | type |
//! |---|---|---|
//! | `f1` | integral of H², `sum of Hbar² / S` | [`VertexCost`] |
//! | `f2` | integral of \|H\|, `sum of \|Hbar\|` | [`AbsMean`] |
//! | `f3` | integral of \|k1\| + \|k2\| | [`VertexCost`] |
//! | `gauss` | `sum of \|Kbar\|` | [`VertexCost`] |
//! | `area` | total area | [`FaceCost`] |
//! | `delaunay` | sum of the cotangents of all angles | [`FaceCost`] |
//! | `willmore` | virtual Willmore energy, as printed in the paper | [`VirtualWillmore`] |
//! | `willmore-potential` | Bobenko's Willmore energy | [`Willmore`] |
//!
//! Any type that implements [`FlipCost`] is a cost. [`CostName`] chooses one by its name.

mod anneal;
mod cost;
mod cost_name;
mod costs;
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
mod region;
mod report;
mod run;
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
pub use options::{Anneal, FlipOptions, Ties, Update};
pub use quad::Quad;
pub use report::{FlipReport, Refused, Stop};
pub use watch::{Phase, Progress};
