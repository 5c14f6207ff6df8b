//! `curvmesh convert`: converts between formats, with repairs if asked.

use serde::Serialize;

use crate::batch::{Job, check_output};
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::given::Given;
use crate::load::Seconds;
use crate::scene::Merging;
use crate::session::{Outcome, Session};
use crate::streaming::{self, Streaming};
use crate::task::{Done, Task};

/// Convert between formats, with repairs if requested
///
/// Without repairs the faces are written as they are read, polygons and defects included. With
/// repairs the output is an oriented 2-manifold of triangles. A scene that is written as glTF or GLB
/// stays whole.
///
///     curvmesh convert scan.ply -o scan.glb
///     curvmesh convert parts.stl -o whole.obj --lenient
///     curvmesh convert scans/ -o glb/ --to glb
///     curvmesh convert huge.stl -o huge.ply --memory 1GiB
///     curvmesh convert - -o - --from stl --to ply < part.stl > part.ply
#[derive(Debug, clap::Args)]
#[command(
    verbatim_doc_comment,
    override_usage = "curvmesh convert [OPTIONS] --output <OUT> <IN>..."
)]
pub(crate) struct Convert {
    #[command(flatten)]
    job: Job,
    #[command(flatten)]
    merging: Merging,
    #[command(flatten)]
    streaming: Streaming,
}

#[derive(Serialize)]
struct Nothing {}

impl Convert {
    /// `IN OUT` means `IN -o OUT`.
    pub(crate) fn with_output(mut self) -> Result<Self, Failure> {
        if self.job.output.is_none() {
            if self.job.inputs.len() != 2 {
                return Err(Failure::usage("say where the result goes: -o OUT"));
            }
            self.job.output = self.job.inputs.pop();
        }
        Ok(self)
    }
}

pub(crate) fn run(options: &Convert, session: &Session) -> Result<Outcome, Failure> {
    check_output(&options.job, &session.given)?;
    options.job.run(session, &|task, console| one(options, task, &session.given, console))
}

/// Further options that need one mesh: repairs.
const NEEDING_ONE: [&str; 10] = [
    "strict",
    "lenient",
    "weld",
    "drop_out_of_range",
    "drop_not_finite",
    "drop_degenerate",
    "drop_duplicates",
    "reorient",
    "cut_non_manifold",
    "drop_unreferenced",
];

fn one(options: &Convert, task: &Task, given: &Given, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let loading = &options.job.loading;
    if options.streaming.is_needed(&[&task.input], loading)? {
        return passing(options, task, console);
    }
    let at = (given, console);
    let written = task.written(&options.job.save);
    if options.merging.keeps_scene(&task.input, written, loading, &NEEDING_ONE, at)? {
        let scene = Seconds::time(&mut seconds.load, || loading.scene(&task.input, console))?;
        task.save_scene(&scene, &options.job.save, &mut seconds, console)?;
        let counts = scene.counts().map(|count| count as usize);
        return report(task, counts, seconds, console);
    }
    let model = Seconds::time(&mut seconds.load, || loading.content(&task.input, console))?;
    task.save(&model, &options.job.save, &mut seconds, console)?;
    let counts = [model.soup.vertex_count(), model.soup.face_count()];
    report(task, counts, seconds, console)
}

/// Converts a mesh that is larger than memory as a stream.
fn passing(options: &Convert, task: &Task, console: &Console) -> Result<Done, Failure> {
    let Convert { job, streaming, .. } = options;
    let mut seconds = Seconds::default();
    let (disk_mesh, _scratch) = streaming.disk_mesh_of(task, job, &mut seconds, console)?;
    Seconds::time(&mut seconds.save, || {
        streaming::save(&disk_mesh, task, &job.save, None, console)
    })?;
    let summary = disk_mesh.summary();
    let counts = [summary.vertices as usize, summary.faces as usize];
    report(task, counts, seconds, console)
}

fn report(
    task: &Task,
    counts: [usize; 2],
    seconds: Seconds,
    console: &Console,
) -> Result<Done, Failure> {
    let report = task.report(console, counts, Nothing {}, seconds);
    let brief =
        format!("{}, {}", counted(report.vertices, "vertices"), counted(report.faces, "faces"));
    report.done(console, format!("{}: {brief}", report.subject()), brief)
}
