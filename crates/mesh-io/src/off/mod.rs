//! Geomview's OFF: `[ST][C][N][4][n]OFF`, as text or big-endian binary; little-endian
//! binary, which some libraries write, is read too.

mod read;
mod write;

pub(crate) use read::read;
pub(crate) use write::{write_binary, write_text};
