//! Loads a mesh and warns of components that are inside out: mean curvature has the wrong sign there.

use mesh_core::UnitScale;
use mesh_core::measure::Facing;
use mesh_work::Loaded;

use crate::commands::curvature::options::Curvature;
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::load::Seconds;
use crate::task::Task;
use crate::text::printable;

/// The mesh and its number of components that are inside out. A mesh is refused if its areas are not numbers.
pub(super) fn load(
    options: &Curvature,
    task: &Task,
    seconds: &mut Seconds,
    console: &Console,
) -> Result<(Loaded, usize), Failure> {
    let loaded = task.load(&options.job.loading, seconds, console)?;
    UnitScale::with_areas(&loaded.mesh).map_err(Failure::refused)?;
    let facings = Seconds::time(&mut seconds.compute, || loaded.mesh.facings());
    let count = facings.count(Facing::InsideOut);
    if count > 0 {
        let all = facings.of_component.len();
        console.message(format_args!(
            "{}: warning: {} of {all} inside out, where H, k1 and k2 have the wrong sign; `--reorient` turns them outward",
            printable(task.input.display()),
            counted(count, "components")
        ));
    }
    Ok((loaded, count))
}
