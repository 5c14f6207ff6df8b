#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod camera;
pub mod colorbar;
pub mod colormap;
mod error;
pub mod labels;
pub mod legend;
mod occlusion;
#[cfg(feature = "textures")]
mod painting;
mod picture;
mod raster;
pub mod render;
pub mod scale;
mod scene;
pub mod sheet;
mod silhouette;
mod stroke;
pub mod svg;
mod text;
mod texture;
pub mod ticks;

#[doc(inline)]
pub use camera::{Side, View};
#[doc(inline)]
pub use colorbar::ColorBar;
#[doc(inline)]
pub use colormap::{ColorMap, UnknownColorMap};
#[doc(inline)]
pub use error::RenderError;
#[doc(inline)]
pub use labels::{LABEL_COLORS, Labels};
#[doc(inline)]
pub use legend::{Legend, MOST_SWATCHES};
#[cfg(feature = "textures")]
#[doc(inline)]
pub use painting::Painting;
#[doc(inline)]
pub use picture::{LARGEST_SIDE, Picture};
#[doc(inline)]
pub use render::render;
#[doc(inline)]
pub use scale::{BadRange, MISSING, Range, Scale, ScaleOptions, rank};
#[doc(inline)]
pub use scene::{Paint, Scene, Stroke, Style};
#[doc(inline)]
pub use sheet::{SheetOptions, sheet};
#[doc(inline)]
pub use svg::{Drawing, draw_svg};
#[doc(inline)]
pub use texture::{Skin, Texture};
