//! `curvmesh curvature --memory`: curvature of a mesh that does not fit into memory, region by region.

use dcurv::Totals;
use mesh_core::{TriMesh, VertexId};
use mesh_io::Format;
use mesh_render::{Range, Scale, ScaleOptions, rank};
use mesh_work::{Integrals, Quantity, VertexValues};
use out_of_core::{Columns, VertexScalars};

use crate::commands::curvature::options::{Curvature, EstimatorName, Shown};
use crate::commands::curvature::vertex::{Results, done};
use crate::console::Console;
use crate::failure::Failure;
use crate::load::Seconds;
use crate::streaming::{self, with_bar};
use crate::task::{Done, Task};

pub(crate) fn run(options: &Curvature, task: &Task, console: &Console) -> Result<Done, Failure> {
    let Curvature { job, streaming, estimate, quantity, .. } = options;
    let refuse = |what: &str| {
        let message = format!(
            "{what} needs the whole mesh in memory, which --memory does not allow; give more, or leave it out"
        );
        Err(Failure::usage(message))
    };
    match estimate.estimator {
        EstimatorName::Vertex => {}
        EstimatorName::Auto if estimate.noise.is_none() && estimate.shown == Shown::Mesh => {
            console.message(
                "with --memory, curvature is by --estimator vertex: fitted surfaces need the whole mesh",
            );
        }
        _ => return refuse("an estimator other than `vertex`"),
    }
    if options.look.is_wanted() {
        return refuse("--view");
    }
    let mut seconds = Seconds::default();
    let (disk_mesh, _scratch) = streaming.disk_mesh_of(task, job, &mut seconds, console)?;
    let shown = Quantity::ALL.iter().position(|q| q == quantity).unwrap_or_default();
    let (mut totals, mut willmore) = (Totals::default(), 0.0);
    let mut of_mesh = |mesh: &TriMesh, own: &[VertexId]| {
        let values = VertexValues::of(mesh, options.area.into());
        if mesh.topology().face_count() > 0 {
            totals = totals.plus(values.curvatures.totals_of(own));
            willmore += own.iter().map(|&v| values.willmore[v]).sum::<f64>();
        }
        rows(&values, own)
    };
    let numbers = Seconds::time(&mut seconds.compute, || {
        with_bar(console, |see| {
            disk_mesh.vertex_scalars(Quantity::ALL.len(), shown, &mut of_mesh, see)
        })
    })?;
    let scale = scale(options, &numbers).map_err(Failure::regions)?;
    if let Some(output) = &task.output {
        let names: Vec<&str> = match job.save.format_of(output) {
            Some(Format::Ply) => Quantity::ALL.iter().map(|q| q.property()).collect(),
            _ => Vec::new(),
        };
        let color = |row: &[f64]| {
            let [red, green, blue] = scale.color(row[shown]);
            [red, green, blue, u8::MAX]
        };
        let columns = Columns { numbers: &numbers, names: &names, color: &color };
        Seconds::time(&mut seconds.save, || {
            streaming::save(&disk_mesh, task, &job.save, Some(columns), console)
        })?;
        console.message(options.colors.explain(&scale));
    }
    let summary = disk_mesh.summary();
    let counts = [summary.vertices as usize, summary.triangles as usize];
    let integrals = Integrals::new(&totals, willmore);
    let results = Results::new(options, integrals, &totals, &scale);
    done(&task.report(console, counts, results, seconds), console)
}

/// Every quantity of some vertices, vertex by vertex.
fn rows(values: &VertexValues, own: &[VertexId]) -> Vec<f64> {
    let columns: Vec<_> = Quantity::ALL.iter().map(|&q| values.of_quantity(q)).collect();
    own.iter().flat_map(|&v| columns.iter().map(move |column| column[v])).collect()
}

/// The colours, by the ranks of all values.
fn scale(options: &Curvature, numbers: &VertexScalars) -> Result<Scale, out_of_core::Error> {
    let chosen = options.colors.options(options.quantity.is_signed(), false);
    let (Some(percentiles), Some(last)) =
        (chosen.range.percentiles(), numbers.count().checked_sub(1))
    else {
        return Ok(chosen.fit([]));
    };
    let mut ends = Vec::new();
    for percentile in percentiles {
        ends.extend(numbers.at_rank(rank(percentile, last as usize) as u64)?);
    }
    Ok(ScaleOptions { range: Range::Full, ..chosen }.fit(ends))
}
