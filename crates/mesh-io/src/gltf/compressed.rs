//! Views whose bytes are compressed (`EXT_meshopt_compression`, `KHR_meshopt_compression`).

use super::parts::{Bytes, at, item, part};
use super::schema::{Compressed, CompressionFilter, CompressionMode, Root, View};
use crate::error::ReadErrorKind;
use crate::input::Input;
use crate::meshopt::filters::Filter;
use crate::meshopt::{Mode, decode};

/// Records the memory of the views that must be decompressed, before any of them is.
pub(crate) fn spend(
    root: &Root,
    buffers: &[Bytes],
    input: &mut Input<'_>,
) -> Result<(), ReadErrorKind> {
    for (index, view) in root.buffer_views.iter().enumerate() {
        let buffer = buffers.get(view.buffer as usize);
        if view.extensions.compressed().is_some() && buffer.is_none_or(|b| b.get().is_empty()) {
            input.spend(view.byte_length, || at(&format!("bufferViews[{index}]")))?;
        }
    }
    Ok(())
}

/// Whether each buffer holds only what compressed views hold too, so that it need not be there.
pub(super) fn fallbacks(root: &Root) -> Vec<bool> {
    let mut fallbacks: Vec<Option<bool>> =
        root.buffers.iter().map(|buffer| buffer.extensions.is_fallback().then_some(true)).collect();
    for view in &root.buffer_views {
        let compressed = view.extensions.compressed();
        if let Some(slot) = fallbacks.get_mut(view.buffer as usize) {
            *slot = Some(slot.unwrap_or(true) && compressed.is_some());
        }
    }
    for compressed in root.buffer_views.iter().filter_map(|view| view.extensions.compressed()) {
        if let Some(slot) = fallbacks.get_mut(compressed.buffer as usize) {
            *slot = Some(false);
        }
    }
    fallbacks.into_iter().map(|fallback| fallback.unwrap_or(false)).collect()
}

/// The bytes of a view, decompressed once.
pub(super) fn decompress<'d>(
    buffers: &'d [Bytes],
    index: u32,
    view: &View,
    compressed: &'d Compressed,
) -> Result<&'d [u8], ReadErrorKind> {
    let path = format!("bufferViews[{index}]");
    let place = || at(&path);
    let unknown = |what: &str| ReadErrorKind::Unsupported {
        at: place(),
        what: format!("an unknown {what} of data compressed by meshopt"),
        cure: "export the file without compression",
    };
    let filter = match compressed.filter {
        CompressionFilter::None => Filter::None,
        CompressionFilter::Octahedral => Filter::Octahedral,
        CompressionFilter::Quaternion => Filter::Quaternion,
        CompressionFilter::Exponential => Filter::Exponential,
        CompressionFilter::Color => Filter::Color,
        CompressionFilter::Unknown => return Err(unknown("filter")),
    };
    let mode = match compressed.mode {
        CompressionMode::Attributes => Mode::Attributes(filter),
        CompressionMode::Triangles => Mode::Triangles,
        CompressionMode::Indices => Mode::Indices,
        CompressionMode::Unknown => return Err(unknown("mode")),
    };
    let (count, stride) = (compressed.count, u64::from(compressed.byte_stride));
    if count.checked_mul(stride) != Some(view.byte_length) {
        let expected = format!("{} bytes of values", view.byte_length);
        let found = format!("{count} compressed values of {stride} bytes");
        return Err(ReadErrorKind::malformed(place(), expected, found));
    }
    let buffer = item(buffers, compressed.buffer, "buffers", &path)?.get();
    let bytes = part(buffer, compressed.byte_offset, compressed.byte_length, place)?;
    // The product of both is in range, so both are, unless one is zero.
    let (count, stride) = (count as usize, stride as usize);
    let decoded = compressed.decoded.get_or_init(|| decode(mode, count, stride, bytes));
    decoded.as_deref().map_err(|broken| {
        let expected = format!("{count} compressed values of {stride} bytes");
        let found = format!("{broken}; the file is damaged: export it again");
        ReadErrorKind::malformed(place(), expected, found)
    })
}
