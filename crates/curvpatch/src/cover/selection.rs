//! Selection of patches from candidates: greedy, sequential, and removal of redundant patches.

use core::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use mesh_core::FaceId;

use super::candidates::CoverCandidates;

/// A candidate in the heap, with the area that it added at its latest evaluation.
#[derive(PartialEq)]
struct HeapEntry {
    gain: f64,
    base: Reverse<FaceId>,
    candidate: usize,
}

impl Eq for HeapEntry {}

impl Ord for HeapEntry {
    fn cmp(&self, other: &Self) -> Ordering {
        self.gain.total_cmp(&other.gain).then(self.base.cmp(&other.base))
    }
}

impl PartialOrd for HeapEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The number of selected candidates that cover each face.
struct CoverCounts(Vec<u32>);

impl CoverCounts {
    fn new(candidates: &CoverCandidates<'_>) -> Self {
        Self(vec![0; candidates.face_capacity()])
    }

    fn is_uncovered(&self, face: FaceId) -> bool {
        self.0[face.index()] == 0
    }

    fn add(&mut self, faces: &[FaceId]) {
        for face in faces {
            self.0[face.index()] += 1;
        }
    }
}

/// Selects the candidate with the largest uncovered area until every face with a candidate is covered.
///
/// Gains only decrease. An entry that is still the largest after its update is therefore the best.
pub(super) fn greedy(candidates: &CoverCandidates<'_>, areas: &[f64]) -> Vec<usize> {
    let entry = |candidate: usize, gain: f64| HeapEntry {
        gain,
        base: Reverse(candidates.base(candidate)),
        candidate,
    };
    let mut counts = CoverCounts::new(candidates);
    let mut heap: BinaryHeap<HeapEntry> =
        (0..candidates.len()).map(|i| entry(i, candidates.get(i).area)).collect();
    let mut selected = Vec::new();
    while let Some(HeapEntry { candidate, .. }) = heap.pop() {
        let faces = candidates.faces(candidate);
        let uncovered = || faces.iter().filter(|&&face| counts.is_uncovered(face));
        if uncovered().next().is_none() {
            continue;
        }
        let current = entry(candidate, uncovered().map(|face| areas[face.index()]).sum());
        if heap.peek().is_some_and(|next| *next > current) {
            heap.push(current);
        } else {
            counts.add(faces);
            selected.push(candidate);
        }
    }
    prune(candidates, counts, selected)
}

/// Selects, by descending area, the candidates whose base face is not covered. A second pass selects
/// candidates that still cover new faces, since not every face is a base face.
pub(super) fn sequential(candidates: &CoverCandidates<'_>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    let rank = |i: usize| (candidates.get(i).area, Reverse(candidates.base(i)));
    order.sort_by(|&a, &b| {
        let ((area_a, base_a), (area_b, base_b)) = (rank(a), rank(b));
        area_b.total_cmp(&area_a).then(base_b.cmp(&base_a))
    });
    let mut counts = CoverCounts::new(candidates);
    let mut selected = Vec::new();
    for &candidate in &order {
        if counts.is_uncovered(candidates.base(candidate)) {
            counts.add(candidates.faces(candidate));
            selected.push(candidate);
        }
    }
    for &candidate in &order {
        let faces = candidates.faces(candidate);
        if faces.iter().any(|&face| counts.is_uncovered(face)) {
            counts.add(faces);
            selected.push(candidate);
        }
    }
    prune(candidates, counts, selected)
}

/// Removes candidates whose faces are all covered by others, starting with the one selected last.
fn prune(
    candidates: &CoverCandidates<'_>,
    mut counts: CoverCounts,
    mut selected: Vec<usize>,
) -> Vec<usize> {
    let mut kept = Vec::with_capacity(selected.len());
    while let Some(candidate) = selected.pop() {
        let faces = candidates.faces(candidate);
        if faces.iter().all(|face| counts.0[face.index()] >= 2) {
            for face in faces {
                counts.0[face.index()] -= 1;
            }
        } else {
            kept.push(candidate);
        }
    }
    kept.reverse();
    kept
}
