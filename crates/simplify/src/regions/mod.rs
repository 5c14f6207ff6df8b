//! A mesh in regions that are collapsed each by itself.

mod corners;
mod partition;
mod pass;
pub(crate) mod rules;
pub(crate) mod run;
mod sheet;
mod tile;
mod waiting;
