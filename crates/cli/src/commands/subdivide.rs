//! `curvmesh subdivide`: butterfly subdivision.

use clap::Args;
use mesh_core::butterfly::{ButterflyOptions, IrregularRule};
use mesh_work::{Subdivided, SubdivisionError, subdivide_step};
use serde::Serialize;

use crate::batch::{Job, check_output};
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::load::Seconds;
use crate::session::{Outcome, Session};
use crate::task::{Done, Task};

/// Subdivide a mesh smoothly by the butterfly scheme
///
/// Every step cuts each face into four. The vertices of the input stay where they are. New vertices
/// between them lie on a smooth surface, and on smooth curves along boundaries. Where that would make
/// slivers or turn faces over, they lie at the middle of their edges. Texture coordinates, colours and
/// numbers are interpolated, materials and groups kept; normals are left out.
///
///     curvmesh subdivide part.obj -o smooth.obj
///     curvmesh subdivide part.stl -o smooth.stl --steps 3
#[derive(Debug, Args)]
#[command(verbatim_doc_comment, mut_arg("output", |output| output.required(true)))]
pub(crate) struct Subdivide {
    #[command(flatten)]
    job: Job,
    /// How often every face is cut into four, at most 12 times
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = parse_steps, help_heading = "Subdivision")]
    steps: u32,
    /// Tension of the butterfly mask; with 0, new vertices are the middles of their edges
    #[arg(long, value_name = "W", default_value_t = 0.0625, value_parser = parse_tension, help_heading = "Subdivision")]
    tension: f64,
    /// Use the eight-point rule everywhere, also at vertices without six edges, where it is not
    /// smooth
    #[arg(long, help_heading = "Subdivision")]
    eight_point: bool,
}

#[derive(Serialize)]
struct Results {
    steps: u32,
    vertices_out: usize,
    faces_out: usize,
    /// New vertices at the middle of their edges, since a curved one would make a sliver or turn a face over.
    straight_edges: usize,
}

pub(crate) fn run(options: &Subdivide, session: &Session) -> Result<Outcome, Failure> {
    check_output(&options.job, &session.given)?;
    options.job.run(session, &|task, console| one(options, task, console))
}

fn one(options: &Subdivide, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let loaded = task.load(&options.job.loading, &mut seconds, console)?;
    let counts = loaded.counts();
    let mut model = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
    (model.vertex_normals, model.corner_normals) = (None, None);
    let rules = ButterflyOptions {
        tension: options.tension,
        irregular: if options.eight_point {
            IrregularRule::EightPoint
        } else {
            IrregularRule::Zorin
        },
    };
    let bar = console.progress(u64::from(options.steps), "subdividing");
    let (mut mesh, mut straight_edges) = (loaded.mesh, 0);
    for _ in 0..options.steps {
        let step: Subdivided =
            Seconds::time(&mut seconds.compute, || subdivide_step(&mesh, &model, &rules))
                .map_err(failed)?;
        (mesh, model) = (step.mesh, step.model);
        straight_edges += step.straight_edges;
        bar.inc(1);
    }
    bar.finish_and_clear();
    if straight_edges > 0 {
        console.message(format_args!(
            "{straight_edges} new vertices are at the middle of their edges: the curve of the scheme would make slivers \
             or turn faces over there; a lower --tension curves less"
        ));
    }
    task.save(&model, &options.job.save, &mut seconds, console)?;
    let topology = mesh.topology();
    let (steps, vertices_out, faces_out) =
        (options.steps, topology.vertex_count(), topology.face_count());
    let results = Results { steps, vertices_out, faces_out, straight_edges };
    let report = task.report(console, counts, results, seconds);
    let brief = format!("{} -> {}", report.faces, counted(faces_out, "faces"));
    let text = format!("{}: {brief}, {}", report.subject(), counted(vertices_out, "vertices"));
    report.done(console, text, brief)
}

fn failed(error: SubdivisionError) -> Failure {
    match error {
        SubdivisionError::Model(error) => Failure::model(error),
        other => Failure::refused(other),
    }
}

/// The largest number of steps: a triangle becomes sixteen million.
const MOST_STEPS: u32 = 12;

fn parse_steps(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(steps @ 1..=MOST_STEPS) => Ok(steps),
        _ => Err(format!("expected a number from 1 to {MOST_STEPS}")),
    }
}

fn parse_tension(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(tension) if (0.0..=0.25).contains(&tension) => Ok(tension),
        _ => Err("expected a number from 0 to 0.25, like 0.0625".into()),
    }
}
