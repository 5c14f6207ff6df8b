//! `curvmesh lod`: levels of detail from one run of collapses.

mod options;
mod regions;
mod whole;

use crate::failure::Failure;
use crate::session::{Outcome, Session};

pub(crate) use options::Lod;

pub(crate) fn run(options: &Lod, session: &Session) -> Result<Outcome, Failure> {
    if options.is_in_regions()? {
        return regions::run(options, session);
    }
    whole::run(options, session)
}
