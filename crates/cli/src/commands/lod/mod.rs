//! `curvmesh lod`: levels of detail from one run of collapses.

mod options;
mod place;
mod regions;
mod scene;
mod whole;

use crate::failure::Failure;
use crate::session::{Outcome, Session};

pub(crate) use options::Lod;

pub(crate) fn run(options: &Lod, session: &Session) -> Result<Outcome, Failure> {
    if options.is_in_regions()? {
        session.given.refuse(&["per", "poses"], "the result is one mesh")?;
        return regions::run(options, session);
    }
    options.check_given(&session.given)?;
    if scene::is_kept(options, session)? {
        return scene::run(options, session);
    }
    session.given.refuse(&["per", "poses"], "the result is one mesh")?;
    whole::run(options, session)
}
