//! `curvmesh curvature`: discrete curvature, as numbers and as colours.

mod face;
mod options;
mod vertex;

use crate::console::Console;
use crate::failure::Failure;

pub(crate) use options::Curvature;

pub(crate) fn run(options: &Curvature, console: &Console) -> Result<(), Failure> {
    if options.estimate.is_by_face() {
        face::run(options, console)
    } else {
        vertex::run(options, console)
    }
}
