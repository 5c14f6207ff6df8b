//! `curvmesh curvature`: discrete curvature, as numbers and as colours.

mod face;
mod frame;
mod options;
mod orientation;
mod passing;
mod vertex;

use crate::batch::check_output;
use crate::commands::curvature::options::{EstimatorName, Shown};
use crate::console::Console;
use crate::failure::Failure;
use crate::session::{Outcome, Session};
use crate::task::{Done, Task};

pub(crate) use options::Curvature;

pub(crate) fn run(options: &Curvature, session: &Session) -> Result<Outcome, Failure> {
    let given = &session.given;
    options.check_given(given)?;
    check_output(&options.job, given)?;
    options.job.run(session, &|task, console| one(options, task, console))
}

fn one(options: &Curvature, task: &Task, console: &Console) -> Result<Done, Failure> {
    if options.streaming.is_needed(&[&task.input], &options.job.loading)? {
        return passing::run(options, task, console);
    }
    match options.estimate.estimator {
        EstimatorName::Auto if options.estimate.shown == Shown::Mesh => {
            vertex::run(options, task, console)
        }
        EstimatorName::Vertex => vertex::run(options, task, console),
        EstimatorName::Face => face::run(options, task, console),
        _ => frame::run(options, task, console),
    }
}
