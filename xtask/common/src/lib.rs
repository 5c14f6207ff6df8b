//! Modules shared by the programs of this repository: `xtask`, `reproduce`, `benches` and `torture`.
//!
//! These are programs, so unlike the libraries they print.
#![allow(clippy::print_stdout, clippy::print_stderr)]

pub mod decimals;
mod failure;
#[cfg(feature = "studies")]
mod numbers;
#[cfg(feature = "studies")]
pub mod plot;
#[cfg(feature = "studies")]
mod progress;
mod virtual_environment;

pub use failure::{Failure, exit_code};
#[cfg(feature = "studies")]
pub use numbers::Numbers;
#[cfg(feature = "studies")]
pub use progress::progress_bar;
pub use virtual_environment::{VirtualEnvironment, check};
