//! `curvmesh repair`: from anything that can be read to an oriented 2-manifold of triangles.

use std::fmt;

use mesh_core::build::{BuildReport, Repair as Repairs};
use serde::Serialize;

use crate::batch::{Job, check_output};
use crate::console::Console;
use crate::failure::Failure;
use crate::load::{Seconds, assemble};
use crate::session::{Outcome, Session};
use crate::task::{Done, Task};

/// Make an oriented manifold of triangles out of anything that can be read
///
/// All repairs are made unless some are named; then those alone are, with --weld for how vertices are
/// merged. What was done is reported. Coordinates that are not finite have no repair.
///
///     curvmesh repair parts.stl -o whole.obj
///     curvmesh repair scan.ply -o closed.ply --weld 0.001%
///     curvmesh repair broken/ -o whole/
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment, mut_arg("output", |output| output.required(true)))]
pub(crate) struct Repair {
    #[command(flatten)]
    job: Job,
}

/// Counts of what was found and repaired.
#[derive(Serialize)]
struct Results {
    vertices_out: usize,
    faces_out: usize,
    unchanged: bool,
    triangulated_polygons: usize,
    welded_vertices: usize,
    dropped_out_of_range: usize,
    dropped_degenerate: usize,
    dropped_duplicates: usize,
    reversed_faces: usize,
    cut_edges: usize,
    split_vertices: usize,
    dropped_vertices: usize,
    zero_area_faces: usize,
}

pub(crate) fn run(options: &Repair, session: &Session) -> Result<Outcome, Failure> {
    check_output(&options.job, &session.given)?;
    options.job.run(session, &|task, console| one(options, task, console))
}

fn one(options: &Repair, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let loading = &options.job.loading;
    let loaded = Seconds::time(&mut seconds.load, || {
        let model = loading.read(&task.input, console)?;
        let mut repairs = loading.repairs(&model)?;
        if !loading.repair.names_some() {
            let weld = repairs.weld;
            repairs = Repairs::lenient();
            if loading.repair.weld.is_some() {
                repairs.weld = weld;
            }
        }
        assemble(&task.input, model, &repairs, false, console)
    })?;
    let found = &loaded.report;
    let model = loaded.to_model(&loaded.provenance.corner_source)?;
    task.save(&model, &options.job.save, &mut seconds, console)?;
    let [vertices_out, faces_out] = loaded.counts();
    let results = Results::new(found, [vertices_out, faces_out]);
    let report = task.report(console, [found.vertices_in, found.faces_in], results, seconds);
    let brief = report.results.to_string();
    report.done(console, format!("{}: {brief}", report.subject()), brief)
}

impl Results {
    fn new(found: &BuildReport, [vertices_out, faces_out]: [usize; 2]) -> Self {
        Self {
            vertices_out,
            faces_out,
            unchanged: found.is_unchanged(),
            triangulated_polygons: found.triangulated,
            welded_vertices: found.welded_vertices.count(),
            dropped_out_of_range: found.dropped_out_of_range.count(),
            dropped_degenerate: found.dropped_degenerate.count(),
            dropped_duplicates: found.dropped_duplicates.count(),
            reversed_faces: found.flipped_faces.count(),
            cut_edges: found.cut_edges.count(),
            split_vertices: found.split_vertices.count(),
            dropped_vertices: found.dropped_vertices.count(),
            zero_area_faces: found.zero_area_faces.count(),
        }
    }
}

impl fmt::Display for Results {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} vertices, {} faces", self.vertices_out, self.faces_out)?;
        if self.unchanged {
            return f.write_str(", nothing to repair");
        }
        let counts = [
            (self.welded_vertices, "vertices merged"),
            (
                self.dropped_out_of_range + self.dropped_degenerate + self.dropped_duplicates,
                "faces dropped",
            ),
            (self.reversed_faces, "faces reversed"),
            (self.cut_edges, "edges cut"),
            (self.dropped_vertices, "vertices dropped"),
        ];
        for (count, what) in counts.into_iter().filter(|&(count, _)| count > 0) {
            write!(f, ", {count} {what}")?;
        }
        Ok(())
    }
}
