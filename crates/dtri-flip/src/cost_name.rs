//! Costs by name.

use core::fmt;
use core::ops::ControlFlow;
use core::str::FromStr;

use dcurv::VertexArea;
use mesh_core::TriMesh;

use crate::cost::FlipCost;
use crate::costs::{
    AbsExtrinsic, AbsMean, FaceCost, FaceFunction, VertexCost, VertexFunction, VirtualWillmore,
    Willmore,
};
use crate::error::FlipError;
use crate::optimise::optimise_with;
use crate::options::FlipOptions;
use crate::progress::Progress;
use crate::report::FlipReport;

/// The costs of this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum CostName {
    /// `f1`: [`VertexFunction::SquaredMean`].
    F1,
    /// `f2`: [`AbsMean`].
    F2,
    /// `f3`: [`VertexFunction::AbsPrincipal`].
    F3,
    /// `gauss`: [`VertexFunction::AbsGaussian`].
    Gauss,
    /// `gauss-extrinsic`: [`AbsExtrinsic`].
    GaussExtrinsic,
    /// `area`: [`FaceFunction::Area`].
    Area,
    /// `delaunay`: [`FaceFunction::Cotangents`].
    Delaunay,
    /// `willmore`: [`VirtualWillmore`].
    Willmore,
    /// `willmore-potential`: [`Willmore`].
    WillmorePotential,
}

/// An unknown name of a cost.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown cost {0:?}; the costs are {names}", names = names())]
pub struct UnknownCost(String);

impl CostName {
    /// All costs.
    pub const ALL: &'static [Self] = &[
        Self::F1,
        Self::F2,
        Self::F3,
        Self::Gauss,
        Self::GaussExtrinsic,
        Self::Area,
        Self::Delaunay,
        Self::Willmore,
        Self::WillmorePotential,
    ];

    /// The name.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::F1 => "f1",
            Self::F2 => "f2",
            Self::F3 => "f3",
            Self::Gauss => "gauss",
            Self::GaussExtrinsic => "gauss-extrinsic",
            Self::Area => "area",
            Self::Delaunay => "delaunay",
            Self::Willmore => "willmore",
            Self::WillmorePotential => "willmore-potential",
        }
    }

    /// Whether each greedy flip lowers the reported cost; see
    /// [`FlipCost::is_potential`].
    #[must_use]
    pub fn is_potential(self) -> bool {
        self != Self::Willmore
    }

    /// Cost of a mesh. Only `f1` and `f3` use `area`.
    #[must_use]
    pub fn total(self, mesh: &TriMesh, area: VertexArea) -> f64 {
        self.with(area, Total(mesh))
    }

    /// [`optimise_with`] by this cost. Only `f1` and `f3` use `area`.
    ///
    /// # Errors
    /// As [`optimise_with`].
    pub fn optimise(
        self,
        mesh: &mut TriMesh,
        area: VertexArea,
        options: &FlipOptions,
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<FlipReport, FlipError> {
        self.with(area, Optimise { mesh, options, progress })
    }

    /// [`FlipOptions::in_force`] with this cost.
    #[must_use]
    pub fn in_force(self, options: &FlipOptions) -> FlipOptions {
        self.with(VertexArea::default(), InForce(options))
    }

    fn with<T: Task>(self, area: VertexArea, task: T) -> T::Output {
        let vertex_cost = |function| VertexCost { function, area };
        match self {
            Self::F1 => task.run(&vertex_cost(VertexFunction::SquaredMean)),
            Self::F2 => task.run(&AbsMean),
            Self::F3 => task.run(&vertex_cost(VertexFunction::AbsPrincipal)),
            Self::Gauss => task.run(&vertex_cost(VertexFunction::AbsGaussian)),
            Self::GaussExtrinsic => task.run(&AbsExtrinsic),
            Self::Area => task.run(&FaceCost(FaceFunction::Area)),
            Self::Delaunay => task.run(&FaceCost(FaceFunction::Cotangents)),
            Self::Willmore => task.run(&VirtualWillmore),
            Self::WillmorePotential => task.run(&Willmore),
        }
    }
}

/// An operation with a cost of any type.
trait Task {
    type Output;
    fn run<C: FlipCost>(self, cost: &C) -> Self::Output;
}

struct Total<'a>(&'a TriMesh);

impl Task for Total<'_> {
    type Output = f64;

    fn run<C: FlipCost>(self, cost: &C) -> f64 {
        cost.total(self.0)
    }
}

struct InForce<'a>(&'a FlipOptions);

impl Task for InForce<'_> {
    type Output = FlipOptions;

    fn run<C: FlipCost>(self, cost: &C) -> FlipOptions {
        self.0.in_force(cost)
    }
}

struct Optimise<'a> {
    mesh: &'a mut TriMesh,
    options: &'a FlipOptions,
    progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
}

impl Task for Optimise<'_> {
    type Output = Result<FlipReport, FlipError>;

    fn run<C: FlipCost>(self, cost: &C) -> Self::Output {
        optimise_with(self.mesh, cost, self.options, self.progress)
    }
}

impl FromStr for CostName {
    type Err = UnknownCost;

    fn from_str(name: &str) -> Result<Self, UnknownCost> {
        let found = Self::ALL.iter().copied().find(|cost| cost.as_str() == name);
        found.ok_or_else(|| UnknownCost(name.to_owned()))
    }
}

impl fmt::Display for CostName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

fn names() -> String {
    CostName::ALL.iter().map(|cost| cost.as_str()).collect::<Vec<_>>().join(", ")
}
