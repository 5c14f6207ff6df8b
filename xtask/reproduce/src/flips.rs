//! Edge flips as in the papers: without shape constraint.

use std::ops::ControlFlow;

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions, FlipReport, ShapeConstraint};
use mesh_core::TriMesh;

use xtask_common::Failure;

/// Optimises a mesh by flips with these options, but without shape constraint as in the papers.
pub(crate) fn optimise(
    mesh: &mut TriMesh,
    cost: CostName,
    area: VertexArea,
    options: &FlipOptions,
) -> Result<FlipReport, Failure> {
    let go_on = &mut |_| ControlFlow::Continue(());
    let shape = Some(ShapeConstraint::Unrestricted);
    let options = &FlipOptions { shape, ..options.clone() };
    cost.optimise(mesh, area, options, go_on).map_err(Failure::mesh)
}
