//! Costs, cost modifiers and constraints of collapses that are Python functions of arrays.
//!
//! A function is called with many edges per call: with all of them before the first collapse, and after each collapse
//! with the edges whose neighbourhood has changed. In between, its values are kept.

use std::sync::Arc;

use ::simplify::{
    BestEndpoint, Collapse, Constraint, Cost, CostModifier, CurvatureFactor, EdgePatch, Memoryless,
    Options, Placement, Policies, Policy, Quadric, Reach, RefineOptions, Rejection, Scratch,
};
use mesh_core::glam::DVec3;
use mesh_core::{EdgeId, EdgeMap, HalfEdgeId, Remap, TriMesh, VertexId, VertexMap, as_u32};
use numpy::{PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::failure::Failure;
use crate::host::Watch;
use crate::views::{frames, matrix};

/// Policies chosen at run time.
pub(crate) type ChosenPolicies = Policies<Box<dyn Cost>, Box<dyn Placement>>;

/// The functions of a run.
pub(crate) struct CollapseFunctions {
    /// The cost, instead of the cost of the preset.
    pub(crate) cost: Option<Py<PyAny>>,
    /// A factor on the cost: `cost * (1 + weight)`.
    pub(crate) weight: Option<Py<PyAny>>,
    /// Returns which edges may collapse.
    pub(crate) constraint: Option<Py<PyAny>>,
}

impl CollapseFunctions {
    pub(crate) fn is_none(&self) -> bool {
        self.cost.is_none() && self.weight.is_none() && self.constraint.is_none()
    }

    /// The policies of the options, with these functions. There are no steps after the collapses, because the functions
    /// apply to collapses.
    pub(crate) fn policies(
        self,
        options: &Options,
        watch: &Arc<Watch>,
    ) -> (ChosenPolicies, Options) {
        let Options { cost: named, placement, .. } = options;
        let told = |function| Told::new(function, watch);
        let is_own = self.cost.is_some();
        let cost: Box<dyn Cost> = match self.cost {
            Some(function) => Box::new(FunctionCost(told(function))),
            // Python refers to presets and placements by name.
            None => named.metric.cost().unwrap_or_else(|| Box::new(Memoryless)),
        };
        let placement = placement.placement().unwrap_or_else(|| Box::new(BestEndpoint));
        let mut policies = Policies::new(cost, placement);
        policies.schedule = named.schedule;
        if named.curvature_weight > 0.0 && !is_own {
            policies.modifiers.push(Box::new(CurvatureFactor::new(named.curvature_weight)));
        }
        if let Some(function) = self.weight {
            policies.modifiers.push(Box::new(FunctionModifier(told(function))));
        }
        if let Some(function) = self.constraint {
            policies.constraints.push(FunctionConstraint(told(function)));
        }
        let mut options = options.clone().custom();
        options.refine = RefineOptions::none();
        options.tolerance.decimate = false;
        (policies, options)
    }
}

/// The values of a function for each edge.
#[derive(Clone)]
struct Told {
    function: Arc<Py<PyAny>>,
    watch: Arc<Watch>,
    values: EdgeMap<f64>,
    /// The original numbers of the vertices.
    original: VertexMap<u32>,
}

impl Told {
    fn new(function: Py<PyAny>, watch: &Arc<Watch>) -> Self {
        Self {
            function: Arc::new(function),
            watch: Arc::clone(watch),
            values: EdgeMap::from_vec(Vec::new()),
            original: VertexMap::from_vec(Vec::new()),
        }
    }

    /// Evaluates all edges.
    fn prepare(&mut self, mesh: &TriMesh) {
        let topology = mesh.topology();
        self.original = VertexMap::from_vec((0..as_u32(topology.vertex_capacity())).collect());
        self.values = topology.edge_map(f64::NAN);
        let edges: Vec<EdgeId> = topology.edges().collect();
        self.ask(mesh, &edges);
    }

    /// Evaluates the edges at the remaining vertex and at its neighbours again.
    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        let topology = mesh.topology();
        let ring = topology.one_ring(collapse.kept);
        let vertices = core::iter::once(collapse.kept).chain(ring);
        let at = |v: VertexId| topology.outgoing(v).map(HalfEdgeId::edge);
        let mut edges: Vec<EdgeId> = vertices.flat_map(at).collect();
        edges.sort_unstable();
        edges.dedup();
        self.ask(mesh, &edges);
    }

    fn compacted(&mut self, remap: &Remap) {
        self.values = self.values.compact(remap);
        self.original = self.original.compact(remap);
    }

    fn ask(&mut self, mesh: &TriMesh, edges: &[EdgeId]) {
        if edges.is_empty() || self.watch.is_cancelled() {
            return;
        }
        match Python::attach(|py| self.call(py, mesh, edges)) {
            Ok(values) => {
                for (&edge, value) in edges.iter().zip(values) {
                    self.values[edge] = value;
                }
            }
            Err(error) => self.watch.raise(error),
        }
    }

    fn call(&self, py: Python<'_>, mesh: &TriMesh, edges: &[EdgeId]) -> PyResult<Vec<f64>> {
        let topology = mesh.topology();
        let place = |v: VertexId| mesh.position(v).to_array();
        let ends: Vec<_> = edges.iter().map(|&e| topology.edge_vertices(e)).collect();
        let ids = ends.iter().map(|ends| ends.map(|v| self.original[v].cast_signed())).collect();
        let points = ends.iter().map(|ends| ends.map(place)).collect();
        let apex = |h| topology.apex(h).map_or([f64::NAN; 3], place);
        let apexes = edges.iter().map(|e| e.half_edges().map(apex)).collect();
        let arrays = (matrix(py, ids)?, frames(py, points)?, frames(py, apexes)?);
        let answer = self.function.bind(py).call1(arrays)?;
        let answer: PyReadonlyArray1<'_, f64> = answer.extract()?;
        if answer.len() != edges.len() {
            let message = format!(
                "the function was asked about {} edges and said something of {}; it must return one \
                 number for each",
                edges.len(),
                answer.len()
            );
            return Err(Failure::new("ArrayError", message).raise(py));
        }
        Ok(answer.as_array().to_vec())
    }

    fn of(&self, patch: &EdgePatch<'_>) -> f64 {
        self.values.get(patch.half_edge().edge()).copied().unwrap_or(f64::NAN)
    }
}

struct FunctionCost(Told);

#[derive(Clone)]
struct FunctionConstraint(Told);

struct FunctionModifier(Told);

macro_rules! follows {
    ($($policy:ty),+) => {
        $(impl Policy for $policy {
            fn prepare(&mut self, mesh: &TriMesh) {
                self.0.prepare(mesh);
            }

            fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
                self.0.collapsed(mesh, collapse);
            }

            fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
                self.0.compacted(remap);
            }
        })+
    };
}

follows!(FunctionCost, FunctionConstraint, FunctionModifier);

impl Cost for FunctionCost {
    /// For the place of the vertex.
    fn quadric(&self, patch: &EdgePatch<'_>) -> Option<Quadric> {
        Memoryless.quadric(patch)
    }

    fn cost(&self, patch: &EdgePatch<'_>, _: Option<&Quadric>, _: DVec3, _: &mut Scratch) -> f64 {
        self.0.of(patch)
    }

    fn reach(&self) -> Reach {
        Reach::OneRing
    }
}

impl CostModifier for FunctionModifier {
    fn raise(&self, cost: f64, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> f64 {
        cost * (1.0 + self.0.of(patch).max(0.0))
    }

    fn reach(&self) -> Reach {
        Reach::OneRing
    }
}

impl Constraint for FunctionConstraint {
    fn check(&self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
        if self.0.of(patch) > 0.0 { Ok(()) } else { Err(Rejection::Other) }
    }
}
