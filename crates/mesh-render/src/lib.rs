#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod camera;
pub mod colorbar;
pub mod colormap;
mod error;
mod picture;
mod raster;
pub mod render;
pub mod scale;
mod scene;
pub mod sheet;
mod silhouette;
mod stroke;
mod text;
mod texture;
pub mod ticks;

pub use camera::{Side, View};
pub use colorbar::ColorBar;
pub use colormap::{ColorMap, UnknownColorMap};
pub use error::RenderError;
pub use picture::{LARGEST_SIDE, Picture};
pub use render::render;
pub use scale::{BadRange, MISSING, Range, Scale, ScaleOptions};
pub use scene::{Paint, Scene, Stroke, Style};
pub use sheet::{SheetOptions, sheet};
pub use texture::{Skin, Texture};
