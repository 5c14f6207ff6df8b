//! Postconditions of commands: no command makes a mesh worse in kind.
//!
//! [`kinds`] makes meshes as CAD programs and scanners do, [`wear`] gives them attributes and the flaws of files,
//! [`commands`] lists the commands and what each [promises](Promise), and [`violations`] compares input with output.
//! The tests of the program run a bounded number of cases, the torture tool more.

pub mod commands;
mod judge;
pub mod kinds;
mod parts;
mod turned;
pub mod wear;

pub use judge::{Promise, Topology, violations};
pub use turned::Turning;
