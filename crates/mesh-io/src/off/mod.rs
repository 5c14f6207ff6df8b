//! Geomview's OFF: `[ST][C][N][4][n]OFF`, as text or big-endian binary. Little-endian binary, which some libraries
//! write, can be read as well.

mod read;
mod write;

pub(crate) use read::{read, scan};
pub(crate) use write::{write_binary, write_text};
