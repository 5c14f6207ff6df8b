//! The tests of this crate, as one program.

mod charts;
mod constraint_choices;
mod labels;
