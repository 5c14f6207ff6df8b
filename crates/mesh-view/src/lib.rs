#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod encode;
mod error;
mod exhibit;
mod markup;
mod page;
mod reduce;
mod sight;
mod text;
mod up;

pub use crate::markup::GENERATOR;
pub use error::ViewError;
pub use exhibit::{Directions, Exhibit, Field, Lines, Materials, On, Surface};
pub use page::{Layout, Page, Precision, Section, Start};
pub use sight::{Sight, Toward, Upright};
pub use up::Up;
