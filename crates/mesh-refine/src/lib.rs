#![doc = include_str!("../README.md")]

mod anneal;
pub mod attributes;
mod block_loop;
mod collapse_back;
mod curve;
mod density;
mod error;
mod face_lists;
mod face_quality;
mod fit;
mod max_error;
mod multiresolution;
mod norm;
mod observer;
mod pipeline;
mod texture_folds;
mod unfold;
mod vertex_relocation;

pub use anneal::{AnnealOptions, AnnealReport, anneal};
pub use attributes::attribute_deviation::AttributeDeviation;
pub use attributes::transfer::seams::seam_nodes;
pub use attributes::transfer::{CornerSource, corner_sources};
pub use attributes::wedges::{CornerAttributes, MAX_CHANNELS};
pub use collapse_back::{Back, CollapseBack, collapse_back_placed};
pub use curve::Curve;
pub use error::RefineError;
pub use face_lists::FaceLists;
pub use fit::constraints::FitConstraints;
pub use fit::{FitOptions, FitReport, fit};
pub use max_error::{MaxErrorOptions, MaxErrorReport, reduce_max_error};
pub use norm::{FitNorm, UnknownNorm};
pub use observer::{Observe, Observer};
pub use pipeline::{Pipeline, Refined, Steps};
pub use texture_folds::Texture;
pub use unfold::{UnfoldOptions, UnfoldReport, unfold};
