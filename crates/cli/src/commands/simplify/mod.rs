//! `curvmesh simplify`: edge collapse to fewer faces, of one mesh or of a scene.

mod options;
mod scene;
mod whole;

pub(crate) use options::Simplify;

use crate::batch::check_output;
use crate::failure::Failure;
use crate::session::{Outcome, Session};

pub(crate) fn run(options: &Simplify, session: &Session) -> Result<Outcome, Failure> {
    options.targets.explain(&session.console);
    options.policy.check_given(&session.given)?;
    check_output(&options.job, &session.given)?;
    options.look.check(&options.job.inputs)?;
    options.job.run(session, &|task, console| {
        if scene::is_kept(options, task, &session.given, console)? {
            return scene::one(options, task, console);
        }
        session.given.refuse(&["per", "poses"], "the result is one mesh")?;
        whole::one(options, task, &session.given, console)
    })
}
