//! Streams of indices of any kind (`INDICES`).
//!
//! An index is the difference from one of two earlier indices. The lowest bit says from which one.

use super::stream::{Broken, Reader, unzigzag, write_number, zigzag};

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

/// Encodes indices; `None` if two that follow each other are too far apart.
pub(crate) fn encode(indices: &[u32]) -> Option<Vec<u8>> {
    let mut stream = vec![HEADER];
    let mut last = [0_u32; 2];
    let mut current = 0;
    for &index in indices {
        // A difference of less than 32 takes one byte. If it is larger, the other index may be nearer.
        let from = |current: usize| index.wrapping_sub(last[current & 1]).cast_signed();
        if from(current).unsigned_abs() >= 30 {
            current ^= 1;
        }
        let difference = from(current);
        if difference.unsigned_abs() >= 1 << 30 {
            return None;
        }
        write_number(&mut stream, zigzag(difference) << 1 | u32::from(current == 1));
        last[current & 1] = index;
    }
    stream.extend([0; TAIL]);
    Some(stream)
}
