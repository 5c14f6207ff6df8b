#![doc = include_str!("../README.md")]

mod assemble;
mod cells;
mod error;
mod finish;
mod incoming;
mod join;
mod reduce;
mod region;
mod rest;
mod run;
mod scratch;
mod sizes;
mod split;
mod star;
mod work;

pub use assemble::assemble;
pub use cells::Cells;
pub use error::Error;
pub use incoming::{Input, Summary};
pub use join::join;
pub use reduce::{proved_distance, reduce};
pub use region::Region;
pub use run::{Left, Outcome, run};
pub use sizes::Sizes;
pub use split::Repairs;
pub use work::{Manifest, Next, Plan, Record, Settings, Source, Step, Work};
