//! Quadrics, and the faces around an edge.

pub(crate) mod edge_patch;
pub(crate) mod new_intersections;
mod part_contacts;
pub(crate) mod quadric;
pub(crate) mod symmetric;
