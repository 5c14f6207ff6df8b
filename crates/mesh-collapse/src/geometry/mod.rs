//! Quadrics, and the faces around an edge.

mod contact;
pub(crate) mod edge_patch;
pub(crate) mod new_intersections;
pub(crate) mod quadric;
pub(crate) mod symmetric;
