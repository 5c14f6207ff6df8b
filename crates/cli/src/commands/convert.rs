//! `curvmesh convert`: from one format to another, repairing as asked.

use std::path::PathBuf;

use serde::Serialize;

use crate::args::RepairOptions;
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Report;
use crate::load::{Seconds, content};
use crate::save::{SaveOptions, check_target, save};

/// Convert between formats, repairing as asked
///
/// Without repairs the faces are written as they are read, polygons and defects included. With
/// repairs the output is an oriented 2-manifold of triangles.
///
///     curvmesh convert scan.ply scan.glb
///     curvmesh convert parts.stl whole.obj --lenient
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Convert {
    /// The file to read
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The file to write
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    save: SaveOptions,
    #[command(flatten)]
    repair: RepairOptions,
}

#[derive(Serialize)]
struct Nothing {}

pub(crate) fn run(options: &Convert, console: &Console) -> Result<(), Failure> {
    check_target(&options.output, &options.save)?;
    let mut seconds = Seconds::default();
    let model =
        Seconds::time(&mut seconds.load, || content(&options.input, &options.repair, console))?;
    Seconds::time(&mut seconds.save, || save(&options.output, &model, &options.save, console))?;
    let counts = [model.soup.vertex_count(), model.soup.face_count()];
    let report = Report::new("convert", &options.input, counts, Nothing {}, seconds)
        .with_output(&options.output);
    let text =
        format!("{}: {} vertices, {} faces", report.subject(), report.vertices, report.faces);
    console.result(&report, text)
}
