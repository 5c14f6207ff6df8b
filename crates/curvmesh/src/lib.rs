#![doc = include_str!("../README.md")]

#[cfg(feature = "curvpatch")]
pub use curvpatch;
#[cfg(feature = "dcurv")]
pub use dcurv;
#[cfg(feature = "dtri-flip")]
pub use dtri_flip;
#[cfg(feature = "mesh-collapse")]
pub use mesh_collapse;
pub use mesh_core;
#[cfg(feature = "mesh-io")]
pub use mesh_io;
#[cfg(feature = "mesh-metric")]
pub use mesh_metric;
#[cfg(feature = "mesh-refine")]
pub use mesh_refine;
#[cfg(feature = "mesh-render")]
pub use mesh_render;
pub use mesh_shapes;
#[cfg(feature = "mesh-view")]
pub use mesh_view;
#[cfg(feature = "mesh-work")]
pub use mesh_work;
#[cfg(feature = "out-of-core")]
pub use out_of_core;
#[cfg(feature = "simplify")]
pub use simplify;

/// The programs of the front page and of the tutorial compile.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
#[doc = include_str!("../../../docs/tutorials/rust.md")]
struct Documentation;
