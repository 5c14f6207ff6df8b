//! What comes after the collapses: the mesh is brought closer to the original.
//!
//! **In:** a mesh without gaps, the surface of the original, and what must stay.
//! **Out:** a mesh with no more faces, closer to the original; which vertex became which; a report of
//! each step.
//!
//! Invariants:
//!
//! - Fixed vertices do not move, feature edges are neither flipped nor split, vertices on lines stay
//!   on the lines of the original.
//! - No face turns by more than sixty degrees in one step, and none turns over in the texture.
//! - A step that does not help is undone as a whole.
//! - Whoever watches may stop it between any two rounds, and has a whole mesh then.
//!
//! Uses the rooms `collapse`, to get rid of faces again, and `attributes`; and `mesh-metric` for
//! closest points. It proves nothing about distances: that is for `limit`, above.
//!
//! From the bottom: `blocks`, `curve`, `face_lists`, `norm` and `observer`; `fit`; `density`; `layout`,
//! `texture_fit` and `collapse_back`; `nested`;
//! `anneal` and `peaks`; `finishing`, which does one after the other.

pub(crate) mod anneal;
mod blocks;
pub(crate) mod collapse_back;
pub(crate) mod curve;
pub(crate) mod density;
pub(crate) mod face_lists;
pub(crate) mod finishing;
pub(crate) mod fit;
pub(crate) mod layout;
pub(crate) mod nested;
pub(crate) mod norm;
pub(crate) mod observer;
pub(crate) mod peaks;
pub(crate) mod texture_fit;
