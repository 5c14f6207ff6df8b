//! `curvmesh repair`: from anything that can be read to an oriented 2-manifold of triangles.

use std::fmt;

use clap::Arg;
use mesh_core::build::{BuildReport, Repair as Repairs};
use mesh_core::fill::{FillOptions, FillReport};
use serde::Serialize;

use crate::args::REPAIRS;
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
///     curvmesh repair scan.ply -o closed.ply --weld 0.001% --fill-holes 100
///     curvmesh repair broken/ -o whole/
#[derive(Debug, clap::Args)]
#[command(
    verbatim_doc_comment,
    mut_arg("output", |output| output.required(true)),
    mut_args(name_heading)
)]
pub(crate) struct Repair {
    #[command(flatten)]
    job: Job,
    /// Then fill holes: those of at most so many edges, or `all`, the outline of an open surface
    /// included. Nothing looks whether the new faces cross others
    #[arg(long, value_name = "EDGES|all", value_parser = parse_holes, help_heading = "Holes")]
    fill_holes: Option<FillOptions>,
}

/// Here all repairs are made unless some are named.
fn name_heading(option: Arg) -> Arg {
    if option.get_help_heading() == Some(REPAIRS) {
        option.help_heading("Repairs (all unless some are named)")
    } else {
        option
    }
}

fn parse_holes(text: &str) -> Result<FillOptions, String> {
    let max_edges = match text {
        "all" => None,
        _ => Some(text.parse().map_err(|_| "expected a number of edges, or `all`".to_owned())?),
    };
    Ok(FillOptions { max_edges, ..FillOptions::default() })
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
    #[serde(skip_serializing_if = "Option::is_none")]
    holes: Option<Holes>,
}

/// What became of the holes.
#[derive(Serialize)]
struct Holes {
    filled: usize,
    new_faces: usize,
    new_vertices: usize,
    left: usize,
}

impl From<&FillReport> for Holes {
    fn from(report: &FillReport) -> Self {
        Self {
            filled: report.filled.len(),
            new_faces: report.new_faces(),
            new_vertices: report.new_vertices(),
            left: report.left.len(),
        }
    }
}

pub(crate) fn run(options: &Repair, session: &Session) -> Result<Outcome, Failure> {
    check_output(&options.job, &session.given)?;
    options.job.run(session, &|task, console| one(options, task, console))
}

fn one(options: &Repair, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let loading = &options.job.loading;
    let mut loaded = Seconds::time(&mut seconds.load, || {
        let model = loading.read(&task.input, console)?;
        let mut repairs = loading.repairs(&model)?;
        if !loading.repair.names_some() {
            let weld = repairs.weld;
            repairs = Repairs::lenient();
            if loading.repair.weld.is_some() {
                repairs.weld = weld;
            }
        }
        let loaded = assemble(&task.input, model, &repairs, false, console)?;
        loading.check_left(&task.input, loaded)
    })?;
    let holes = options
        .fill_holes
        .as_ref()
        .map(|holes| Seconds::time(&mut seconds.compute, || loaded.fill_holes(holes)))
        .map(|report| Holes::from(&report));
    let found = &loaded.report;
    let model = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
    task.save(&model, &options.job.save, &mut seconds, console)?;
    let [vertices_out, faces_out] = loaded.counts();
    let results = Results::new(found, [vertices_out, faces_out], holes);
    let report = task.report(console, [found.vertices_in, found.faces_in], results, seconds);
    let brief = report.results.to_string();
    report.done(console, format!("{}: {brief}", report.subject()), brief)
}

impl Results {
    fn new(
        found: &BuildReport,
        [vertices_out, faces_out]: [usize; 2],
        holes: Option<Holes>,
    ) -> Self {
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
            holes,
        }
    }
}

impl fmt::Display for Results {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} vertices, {} faces", self.vertices_out, self.faces_out)?;
        if self.unchanged && self.holes.is_none() {
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
        if let Some(Holes { filled, left, .. }) = &self.holes {
            write!(f, ", {filled} holes filled")?;
            if *left > 0 {
                write!(f, ", {left} left")?;
            }
        }
        Ok(())
    }
}
