//! Streams of indices of any kind (`INDICES`).
//!
//! An index is the difference from one of two earlier indices. The lowest bit says from which one.

use super::{Broken, Reader, unzigzag};

const HEADER: u8 = 0xd1;
/// The zeros at the end.
const TAIL: usize = 4;

/// Decodes `count` indices.
pub(crate) fn decode(bytes: &[u8], count: usize) -> Result<Vec<u32>, Broken> {
    let (&header, rest) = bytes.split_first().ok_or(Broken::Short)?;
    if header != HEADER {
        return Err(Broken::Header(header));
    }
    let body = rest.len().checked_sub(TAIL).and_then(|length| rest.get(..length));
    let body = body.ok_or(Broken::Short)?;
    // Every index takes a byte or more.
    if body.len() < count {
        return Err(Broken::Short);
    }
    let mut reader = Reader(body);
    let mut last = [0_u32; 2];
    let mut indices = Vec::with_capacity(count);
    for _ in 0..count {
        let code = reader.number()?;
        let [even, odd] = &mut last;
        let last = if code & 1 == 0 { even } else { odd };
        *last = last.wrapping_add(unzigzag(code >> 1));
        indices.push(*last);
    }
    reader.end()?;
    Ok(indices)
}
