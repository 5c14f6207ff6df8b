//! Edge flips to the end, as the papers run them.

use std::ops::ControlFlow;

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions, FlipReport};
use mesh_core::TriMesh;

use xtask_common::Failure;

/// Optimises a mesh by flips until no flip lowers the cost, or as the options say.
pub(crate) fn optimise(
    mesh: &mut TriMesh,
    cost: CostName,
    area: VertexArea,
    options: &FlipOptions,
) -> Result<FlipReport, Failure> {
    let go_on = &mut |_| ControlFlow::Continue(());
    cost.optimise(mesh, area, options, go_on).map_err(Failure::mesh)
}
