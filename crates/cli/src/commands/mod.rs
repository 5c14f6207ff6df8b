//! One file or folder per command. A command uses shared modules, and no other command.

pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod curvature;
pub(crate) mod distance;
pub(crate) mod flip;
pub(crate) mod info;
pub(crate) mod lod;
pub(crate) mod man;
pub(crate) mod patch;
pub(crate) mod region;
pub(crate) mod render;
pub(crate) mod repair;
pub(crate) mod simplify;
pub(crate) mod subdivide;
pub(crate) mod view;
