//! Drops accessors, views and bytes that nothing refers to any more.
//!
//! Parts that nothing referred to before stay: what is not asked to change is written as it was.

use super::document::list_mut;
use super::references::{Target, each_range, each_reference, referenced};
use crate::gltf::accessor::Bytes;
use serde_json::{Map, Value};
use std::ops::Range;
use std::sync::Arc;

/// Cuts of a buffer keep the alignment of what follows to this many bytes.
const ALIGNMENT: usize = 8;

/// The parts that are referred to.
pub(super) struct Referenced {
    accessors: Vec<bool>,
    views: Vec<bool>,
    buffers: Vec<bool>,
}

impl Referenced {
    pub(super) fn of(json: &mut Value) -> Self {
        Self {
            accessors: referenced(json, Target::Accessor),
            views: referenced(json, Target::View),
            buffers: referenced(json, Target::Buffer),
        }
    }
}

/// Drops what was referred to `before`, and is not any more.
pub(super) fn prune(json: &mut Value, buffers: &mut Vec<Bytes>, before: &Referenced) {
    drop_unused(json, Target::Accessor, &before.accessors);
    let dropped = unused(json, Target::View, &before.views);
    cut(json, buffers, &dropped);
    remove(json, Target::View, &dropped);
    drop_buffers(json, buffers, &before.buffers);
}

/// Drops the buffers that were referred to `before`, and are not any more.
pub(super) fn drop_buffers(json: &mut Value, buffers: &mut Vec<Bytes>, before: &[bool]) {
    let dropped = unused(json, Target::Buffer, before);
    let mut index = 0;
    buffers.retain(|_| {
        index += 1;
        !dropped.get(index - 1).copied().unwrap_or(false)
    });
    remove(json, Target::Buffer, &dropped);
}

fn drop_unused(json: &mut Value, target: Target, before: &[bool]) {
    let dropped = unused(json, target, before);
    remove(json, target, &dropped);
}

fn unused(json: &mut Value, target: Target, before: &[bool]) -> Vec<bool> {
    let now = referenced(json, target);
    let was = before.iter().copied().chain(std::iter::repeat(false));
    now.iter().zip(was).map(|(&is, was)| was && !is).collect()
}

/// Removes items of a list, and adapts the references to the others.
fn remove(json: &mut Value, target: Target, dropped: &[bool]) {
    if !dropped.contains(&true) {
        return;
    }
    let mut next = 0;
    let places: Vec<u64> = dropped
        .iter()
        .map(|&is_dropped| {
            let place = next;
            next += u64::from(!is_dropped);
            place
        })
        .collect();
    each_reference(json, target, &mut |index| {
        if let Some(place) = index.as_u64().and_then(|index| places.get(index as usize)) {
            *index = (*place).into();
        }
    });
    if let Some(items) = json.get_mut(target.list()).and_then(Value::as_array_mut) {
        let mut is_dropped = dropped.iter().copied();
        items.retain(|_| !is_dropped.next().unwrap_or(false));
    }
}

/// A part of a buffer.
struct Part {
    buffer: usize,
    bytes: Range<usize>,
}

fn part(range: &Map<String, Value>) -> Option<Part> {
    let number = |name: &str| range.get(name).and_then(Value::as_u64);
    let buffer = usize::try_from(number("buffer")?).ok()?;
    let start = usize::try_from(number("byteOffset").unwrap_or(0)).ok()?;
    let length = usize::try_from(number("byteLength")?).ok()?;
    Some(Part { buffer, bytes: start..start.checked_add(length)? })
}

/// Cuts the bytes of the dropped views out of the buffers, as far as no other view has them.
fn cut(json: &mut Value, buffers: &mut [Bytes], dropped: &[bool]) {
    let mut gone: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
    for (view, &is_dropped) in list_mut(json, "bufferViews").iter_mut().zip(dropped) {
        if is_dropped {
            each_range(view, &mut |range| push_part(&mut gone, range));
        }
    }
    cut_ranges(json, buffers, gone, dropped);
}

/// Adds the part of a buffer that an object names to the parts of that buffer.
pub(super) fn push_part(parts: &mut [Vec<Range<usize>>], range: &Map<String, Value>) {
    if let Some(part) = part(range)
        && let Some(list) = parts.get_mut(part.buffer)
    {
        list.push(part.bytes);
    }
}

/// Cuts ranges out of each buffer, as far as no view has them that is not dropped.
pub(super) fn cut_ranges(
    json: &mut Value,
    buffers: &mut [Bytes],
    gone: Vec<Vec<Range<usize>>>,
    dropped: &[bool],
) {
    let is_dropped = |place: usize| dropped.get(place).copied().unwrap_or(false);
    let mut kept: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
    for (place, view) in list_mut(json, "bufferViews").iter_mut().enumerate() {
        if !is_dropped(place) {
            each_range(view, &mut |range| push_part(&mut kept, range));
        }
    }
    let mut all_cuts = Vec::with_capacity(buffers.len());
    for ((buffer, gone), kept) in buffers.iter_mut().zip(gone).zip(kept) {
        let cuts = cuts(union(gone), &union(kept), buffer.get().len());
        if !cuts.is_empty() {
            *buffer = without(buffer.get(), &cuts);
        }
        all_cuts.push(cuts);
    }
    for (place, view) in list_mut(json, "bufferViews").iter_mut().enumerate() {
        if is_dropped(place) {
            continue;
        }
        each_range(view, &mut |range| {
            let Some(part) = part(range) else { return };
            let Some(cuts) = all_cuts.get(part.buffer).filter(|cuts| !cuts.is_empty()) else {
                return;
            };
            let before = cuts.iter().take_while(|cut| cut.end <= part.bytes.start);
            let offset = part.bytes.start - before.map(ExactSizeIterator::len).sum::<usize>();
            range.insert("byteOffset".to_owned(), offset.into());
        });
    }
    for (object, buffer) in list_mut(json, "buffers").iter_mut().zip(buffers) {
        if let (Some(object), false) = (object.as_object_mut(), buffer.get().is_empty()) {
            object.insert("byteLength".to_owned(), buffer.get().len().into());
        }
    }
}

/// The union of ranges, as disjoint ranges in order.
fn union(mut ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    ranges.sort_unstable_by_key(|range| (range.start, range.end));
    let mut all: Vec<Range<usize>> = Vec::with_capacity(ranges.len());
    for range in ranges {
        match all.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => all.push(range),
        }
    }
    all
}

/// The aligned parts of `gone` that are not in `kept`, in order.
fn cuts(gone: Vec<Range<usize>>, kept: &[Range<usize>], length: usize) -> Vec<Range<usize>> {
    let mut cuts = Vec::new();
    let mut first = 0;
    for range in gone {
        // Ranges that end before this one cannot overlap the next ones either.
        while kept.get(first).is_some_and(|other| other.end <= range.start) {
            first += 1;
        }
        let mut start = range.start;
        let overlapping = kept.get(first..).unwrap_or_default().iter();
        for other in overlapping.take_while(|other| other.start < range.end) {
            push_aligned(&mut cuts, start..other.start, length);
            start = start.max(other.end);
        }
        push_aligned(&mut cuts, start..range.end, length);
    }
    cuts
}

fn push_aligned(cuts: &mut Vec<Range<usize>>, range: Range<usize>, length: usize) {
    let start = range.start.next_multiple_of(ALIGNMENT);
    // The end of the buffer needs no alignment: nothing follows.
    let end = if range.end >= length { length } else { range.end / ALIGNMENT * ALIGNMENT };
    if start < end {
        cuts.push(start..end);
    }
}

fn without(bytes: &[u8], cuts: &[Range<usize>]) -> Bytes {
    let mut all = Vec::with_capacity(bytes.len());
    let mut start = 0;
    for cut in cuts {
        all.extend_from_slice(bytes.get(start..cut.start).unwrap_or_default());
        start = cut.end;
    }
    all.extend_from_slice(bytes.get(start..).unwrap_or_default());
    Bytes { length: all.len(), all: Arc::new(all) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Brute force: a byte is cut if a dropped view has it and no kept one, and its aligned word is cut as a whole.
    #[test]
    #[allow(clippy::single_range_in_vec_init)]
    fn bytes_of_dropped_views_are_cut_unless_others_have_them() {
        let mut random = 7_u64;
        let mut next = |below: usize| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 33) as usize % below
        };
        for _ in 0..300 {
            let length = 64 + next(64);
            let mut ranges = |count: usize| -> Vec<Range<usize>> {
                let range = |_| {
                    let start = next(length);
                    start..(start + next(30)).min(length)
                };
                (0..count).map(range).filter(|range| !range.is_empty()).collect()
            };
            let (gone, kept) = (ranges(4), ranges(3));
            let found = cuts(union(gone.clone()), &union(kept.clone()), length);
            let is_in = |ranges: &[Range<usize>], byte| ranges.iter().any(|r| r.contains(&byte));
            for byte in 0..length {
                let may = is_in(&gone, byte) && !is_in(&kept, byte);
                assert!(may || !is_in(&found, byte), "{byte} {gone:?} {kept:?} {found:?}");
            }
            for cut in &found {
                assert!(cut.start % ALIGNMENT == 0, "{found:?}");
                assert!(cut.end % ALIGNMENT == 0 || cut.end == length, "{found:?}");
            }
            // A whole word that may go is gone.
            for word in 0..length / ALIGNMENT {
                let bytes = word * ALIGNMENT..(word + 1) * ALIGNMENT;
                let part_of_one = union(gone.clone())
                    .iter()
                    .any(|r| r.start <= bytes.start && bytes.end <= r.end);
                if part_of_one && bytes.clone().all(|byte| !is_in(&kept, byte)) {
                    assert!(bytes.clone().all(|byte| is_in(&found, byte)), "{bytes:?} {found:?}");
                }
            }
        }
    }
}
