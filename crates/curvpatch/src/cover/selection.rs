//! Choosing patches from candidates: greedy, in one pass, and without the superfluous ones.

use core::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use mesh_core::FaceId;

use super::candidates::CoverCandidates;

/// A candidate in the heap, by the area it would add when it was last looked at.
#[derive(PartialEq)]
struct Offer {
    gain: f64,
    base: Reverse<FaceId>,
    candidate: usize,
}

impl Eq for Offer {}

impl Ord for Offer {
    fn cmp(&self, other: &Self) -> Ordering {
        self.gain.total_cmp(&other.gain).then(self.base.cmp(&other.base))
    }
}

impl PartialOrd for Offer {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// How many chosen candidates cover each face.
struct Counts(Vec<u32>);

impl Counts {
    fn new(candidates: &CoverCandidates<'_>) -> Self {
        Self(vec![0; candidates.face_capacity()])
    }

    fn is_bare(&self, face: FaceId) -> bool {
        self.0[face.index()] == 0
    }

    fn add(&mut self, faces: &[FaceId]) {
        for face in faces {
            self.0[face.index()] += 1;
        }
    }
}

/// Takes the candidate with the largest uncovered area until every face with a candidate is
/// covered. Gains only shrink, so an offer that is still the best after being brought up to date
/// is the best of all.
pub(super) fn greedy(candidates: &CoverCandidates<'_>, areas: &[f64]) -> Vec<usize> {
    let offer = |candidate: usize, gain: f64| Offer {
        gain,
        base: Reverse(candidates.base(candidate)),
        candidate,
    };
    let mut counts = Counts::new(candidates);
    let mut offers: BinaryHeap<Offer> =
        (0..candidates.len()).map(|i| offer(i, candidates.get(i).area)).collect();
    let mut chosen = Vec::new();
    while let Some(Offer { candidate, .. }) = offers.pop() {
        let faces = candidates.faces(candidate);
        let bare = || faces.iter().filter(|&&face| counts.is_bare(face));
        if bare().next().is_none() {
            continue;
        }
        let current = offer(candidate, bare().map(|face| areas[face.index()]).sum());
        if offers.peek().is_some_and(|next| *next > current) {
            offers.push(current);
        } else {
            counts.add(faces);
            chosen.push(candidate);
        }
    }
    prune(candidates, counts, chosen)
}

/// Goes through the candidates by descending area and takes those whose base face is not covered;
/// then, where not every face is a seed, those that still add something.
pub(super) fn sequential(candidates: &CoverCandidates<'_>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    let rank = |i: usize| (candidates.get(i).area, Reverse(candidates.base(i)));
    order.sort_by(|&a, &b| {
        let ((area_a, base_a), (area_b, base_b)) = (rank(a), rank(b));
        area_b.total_cmp(&area_a).then(base_b.cmp(&base_a))
    });
    let mut counts = Counts::new(candidates);
    let mut chosen = Vec::new();
    for &candidate in &order {
        if counts.is_bare(candidates.base(candidate)) {
            counts.add(candidates.faces(candidate));
            chosen.push(candidate);
        }
    }
    for &candidate in &order {
        let faces = candidates.faces(candidate);
        if faces.iter().any(|&face| counts.is_bare(face)) {
            counts.add(faces);
            chosen.push(candidate);
        }
    }
    prune(candidates, counts, chosen)
}

/// Drops candidates whose faces are all covered by others, the last chosen first.
fn prune(
    candidates: &CoverCandidates<'_>,
    mut counts: Counts,
    mut chosen: Vec<usize>,
) -> Vec<usize> {
    let mut kept = Vec::with_capacity(chosen.len());
    while let Some(candidate) = chosen.pop() {
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
