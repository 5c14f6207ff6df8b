//! Streams of values (`ATTRIBUTES`), versions 0 and 1.
//!
//! Values are stored in blocks, each byte of a value in a plane of its own. A plane holds the differences from value to
//! value in groups of 16, and each group has as few bits as it needs.

use super::stream::{Broken, Reader};

const HEADER: u8 = 0xa0;
/// The values of a group.
const GROUP: usize = 16;
/// The most values of a block.
const BLOCK: usize = 256;
/// The most bytes of a block.
const BLOCK_BYTES: usize = 8192;
/// The bits of the differences of a group, by the two bits in the header of the plane.
const BITS_0: [usize; 4] = [0, 2, 4, 8];
const BITS_1: [[usize; 4]; 2] = [[0, 1, 2, 4], [1, 2, 4, 8]];

/// The differences of one byte of all values of a block.
type Plane = [u8; BLOCK];

fn values_of_block(stride: usize) -> usize {
    (BLOCK_BYTES / stride.max(1) / GROUP * GROUP).min(BLOCK)
}

/// Decodes `count` values of `stride` bytes, a multiple of four of at most 256.
pub(crate) fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Broken> {
    let (&header, rest) = bytes.split_first().ok_or(Broken::Short)?;
    let (has_channels, least) = match header.checked_sub(HEADER) {
        Some(0) => (false, 32),
        Some(1) => (true, 24),
        _ => return Err(Broken::Header(header)),
    };
    let tail = stride + if has_channels { stride / 4 } else { 0 };
    let body = rest.len().checked_sub(tail.max(least)).ok_or(Broken::Short)?;
    let (body, padded) = rest.split_at_checked(body).ok_or(Broken::Short)?;
    let tail = padded.get(padded.len() - tail..).ok_or(Broken::Short)?;
    let (first, channels) = tail.split_at_checked(stride).ok_or(Broken::Short)?;
    let mut last: Vec<[u8; 4]> = first.as_chunks().0.to_vec();
    let channels: Vec<Channel> = if has_channels {
        channels.iter().map(|&code| Channel::of(code)).collect::<Result<_, _>>()?
    } else {
        vec![Channel::Bytes; last.len()]
    };
    let mut reader = Reader(body);
    let mut values = vec![0; count * stride];
    let mut planes: Vec<[Plane; 4]> = vec![[[0; BLOCK]; 4]; last.len()];
    for block in values.chunks_mut(values_of_block(stride) * stride) {
        let count = block.len() / stride;
        let controls = if has_channels { reader.take(stride / 4)? } else { &[] };
        for (index, planes) in planes.iter_mut().enumerate() {
            for (byte, plane) in planes.iter_mut().enumerate() {
                let control = controls.get(index).map(|bits| bits >> (2 * byte) & 3);
                read_plane(&mut reader, plane, count, control)?;
            }
        }
        let all = planes.iter().zip(&channels).zip(&mut last).enumerate();
        for (index, ((planes, channel), last)) in all {
            let [a, b, c, d] = planes;
            let differences = a.iter().zip(b).zip(c).zip(d);
            for (value, (((&a, &b), &c), &d)) in block.chunks_exact_mut(stride).zip(differences) {
                *last = channel.next(*last, [a, b, c, d]);
                if let Some(place) = value.get_mut(4 * index..4 * index + 4) {
                    place.copy_from_slice(last);
                }
            }
        }
    }
    reader.end()?;
    Ok(values)
}

/// Reads the differences of a plane. In version 1, `control` says how they are stored.
fn read_plane(
    reader: &mut Reader<'_>,
    plane: &mut Plane,
    count: usize,
    control: Option<u8>,
) -> Result<(), Broken> {
    let bits = match control {
        None => BITS_0,
        Some(0) => BITS_1[0],
        Some(1) => BITS_1[1],
        Some(2) => {
            plane.fill(0);
            return Ok(());
        }
        Some(_) => {
            let plain = reader.take(count)?;
            plane.iter_mut().zip(plain).for_each(|(slot, &byte)| *slot = byte);
            return Ok(());
        }
    };
    let groups = count.div_ceil(GROUP);
    let header = reader.take(groups.div_ceil(4))?;
    let codes = header.iter().flat_map(|byte| [0, 2, 4, 6].map(|shift| byte >> shift & 3));
    for (group, code) in plane.as_chunks_mut::<GROUP>().0.iter_mut().take(groups).zip(codes) {
        read_group(reader, group, bits[usize::from(code & 3)])?;
    }
    Ok(())
}

fn read_group(reader: &mut Reader<'_>, group: &mut [u8; GROUP], bits: usize) -> Result<(), Broken> {
    match bits {
        0 => group.fill(0),
        8 => group.copy_from_slice(reader.take(GROUP)?),
        _ => {
            let packed = reader.take(bits * GROUP / 8)?;
            let each = 8 / bits;
            // All bits set: the difference is larger, and is in a byte after the group.
            let sentinel = (1_u8 << bits) - 1;
            for (slots, &byte) in group.chunks_exact_mut(each).zip(packed) {
                for (place, slot) in slots.iter_mut().enumerate() {
                    // Only single bits start with the least significant one.
                    let shift = if bits == 1 { place } else { 8 - bits * (place + 1) };
                    *slot = byte >> shift & sentinel;
                }
            }
            for slot in group.iter_mut().filter(|slot| **slot == sentinel) {
                *slot = reader.byte()?;
            }
        }
    }
    Ok(())
}

/// The kind of the differences of four bytes.
#[derive(Clone, Copy)]
enum Channel {
    Bytes,
    Words,
    /// The bits that differ, rotated.
    Bits(u32),
}

impl Channel {
    fn of(code: u8) -> Result<Self, Broken> {
        match (code & 15, code >> 4) {
            (0, 0) => Ok(Self::Bytes),
            (1, 0) => Ok(Self::Words),
            (2, rotation) => Ok(Self::Bits(u32::from(rotation))),
            _ => Err(Broken::Channel(code)),
        }
    }

    /// The value after `last`.
    fn next(self, last: [u8; 4], difference: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => {
                let mut next = last;
                for (byte, code) in next.iter_mut().zip(difference) {
                    *byte = byte.wrapping_add((code >> 1) ^ (code & 1).wrapping_neg());
                }
                next
            }
            Self::Words => {
                let word = |[a, b]: [u8; 2], code: [u8; 2]| {
                    let code = u16::from_le_bytes(code);
                    let difference = (code >> 1) ^ (code & 1).wrapping_neg();
                    u16::from_le_bytes([a, b]).wrapping_add(difference).to_le_bytes()
                };
                let ([a, b, c, d], [e, f, g, h]) = (last, difference);
                let ([a, b], [c, d]) = (word([a, b], [e, f]), word([c, d], [g, h]));
                [a, b, c, d]
            }
            Self::Bits(rotation) => {
                let bits = u32::from_le_bytes(difference).rotate_right(rotation);
                (u32::from_le_bytes(last) ^ bits).to_le_bytes()
            }
        }
    }
}

/// Encodes values of `stride` bytes, a multiple of four of at most 256, in version 0, which both extensions have.
pub(crate) fn encode(values: &[u8], stride: usize) -> Vec<u8> {
    let mut stream = vec![HEADER];
    let first = values.get(..stride).map_or_else(|| vec![0; stride], <[u8]>::to_vec);
    let mut last = first.clone();
    for block in values.chunks(values_of_block(stride) * stride) {
        for (byte, last) in last.iter_mut().enumerate() {
            let mut plane: Plane = [0; BLOCK];
            let mut count = 0;
            for (slot, value) in plane.iter_mut().zip(block.chunks_exact(stride)) {
                let next = value.get(byte).copied().unwrap_or_default();
                let difference = next.wrapping_sub(*last);
                *slot = (difference << 1) ^ (difference >> 7).wrapping_neg();
                *last = next;
                count += 1;
            }
            write_plane(&mut stream, &plane, count);
        }
    }
    stream.resize(stream.len() + 32_usize.saturating_sub(stride), 0);
    stream.extend(first);
    stream
}

fn write_plane(stream: &mut Vec<u8>, plane: &Plane, count: usize) {
    let groups = count.div_ceil(GROUP);
    let header = stream.len();
    stream.resize(header + groups.div_ceil(4), 0);
    let mut last = None;
    for (place, group) in plane.as_chunks::<GROUP>().0.iter().take(groups).enumerate() {
        // With equal sizes, plain bytes come first and then the bits of the group before: both compress further.
        let mut best = (group_size(group, 8), 3, 8);
        for (code, bits) in (0..3).zip(BITS_0) {
            let size = group_size(group, bits);
            if size < best.0 || (size == best.0 && last == Some(bits) && best.2 != 8) {
                best = (size, code, bits);
            }
        }
        let (_, code, bits) = best;
        if let Some(byte) = stream.get_mut(header + place / 4) {
            *byte |= code << (2 * (place % 4));
        }
        write_group(stream, group, bits);
        last = Some(bits);
    }
}

/// The bytes that a group takes with this number of bits.
fn group_size(group: &[u8; GROUP], bits: usize) -> usize {
    match bits {
        0 if group.iter().all(|&difference| difference == 0) => 0,
        0 => usize::MAX,
        8 => GROUP,
        _ => {
            let sentinel = (1_u8 << bits) - 1;
            bits * GROUP / 8 + group.iter().filter(|&&difference| difference >= sentinel).count()
        }
    }
}

fn write_group(stream: &mut Vec<u8>, group: &[u8; GROUP], bits: usize) {
    match bits {
        0 => {}
        8 => stream.extend(group),
        _ => {
            let sentinel = (1_u8 << bits) - 1;
            for differences in group.chunks_exact(8 / bits) {
                let pack = |byte: u8, &difference: &u8| byte << bits | difference.min(sentinel);
                stream.push(differences.iter().fold(0, pack));
            }
            stream.extend(group.iter().filter(|&&difference| difference >= sentinel));
        }
    }
}
