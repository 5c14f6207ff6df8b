//! `curvmesh convert`: from one format to another, repairing as asked.

use std::path::PathBuf;

use mesh_io::Model;
use serde::Serialize;

use crate::args::RepairOptions;
use crate::console::Console;
use crate::failure::Failure;
use crate::load::{Seconds, load, read};
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
struct Report {
    command: &'static str,
    input: String,
    output: String,
    vertices: usize,
    faces: usize,
    seconds: Seconds,
}

pub(crate) fn run(options: &Convert, console: &Console) -> Result<(), Failure> {
    check_target(&options.output, &options.save)?;
    let mut seconds = Seconds::default();
    let model = Seconds::time(&mut seconds.load, || source(options, console))?;
    Seconds::time(&mut seconds.save, || save(&options.output, &model, &options.save, console))?;
    let report = Report {
        command: "convert",
        input: options.input.display().to_string(),
        output: options.output.display().to_string(),
        vertices: model.soup.vertex_count(),
        faces: model.soup.face_count(),
        seconds: seconds.summed(),
    };
    let text = format!("{}: {} vertices, {} faces", report.output, report.vertices, report.faces);
    console.result(&report, text)
}

/// The content to be written: the file's own, or that of the repaired mesh.
fn source(options: &Convert, console: &Console) -> Result<Model, Failure> {
    if !options.repair.any() {
        return read(&options.input, console);
    }
    let loaded = load(&options.input, &options.repair, console)?;
    loaded.to_model(&loaded.provenance.corner_source)
}
