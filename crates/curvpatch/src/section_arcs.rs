//! Arcs of many sections, each measured for the same length.

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f64x8};
use glam::DVec3;

use crate::section_arc::{SectionArc, WalkEnd};
use crate::section_walk::{SectionWalk, WalkStep, WalkVisitor, walk_all};
use crate::soa_mesh::SoaMesh;
use crate::vec3x8::{LANES, LaneBits, Vec3Lanes, Vec3x8, put, take};

/// Measures both halves of sections.
struct ArcMeasurer<'w> {
    /// The walks along both halves of each section.
    sections: &'w [[SectionWalk; 2]],
    length: f64,
    /// The arcs that have started: all first halves, then all second halves.
    arcs: Vec<SectionArc>,
    /// The index of the arc in each lane.
    arc_of_lane: [usize; LANES],
    last: Vec3Lanes,
    walked: [f64; LANES],
}

impl ArcMeasurer<'_> {
    fn record(&mut self, lane: usize, arc: SectionArc) {
        if let Some(slot) = self.arcs.get_mut(self.arc_of_lane[lane]) {
            *slot = arc;
        }
    }

    /// The second half of a section, if it follows from the first half because the section is closed.
    fn reversed(&self, section: usize) -> Option<SectionArc> {
        let (arc, walks) = (self.arcs.get(section)?, self.sections.get(section)?);
        arc.reversed([walks[0].crossing(), walks[1].crossing()], self.length)
    }

    /// Both halves of all sections, after all walks have ended.
    fn into_pairs(self) -> Vec<[SectionArc; 2]> {
        let count = self.sections.len();
        let second =
            |section: usize| self.reversed(section).or(self.arcs.get(count + section).copied());
        let pair = |(section, &first)| [first, second(section).unwrap_or(SectionArc::EMPTY)];
        self.arcs.iter().take(count).enumerate().map(pair).collect()
    }
}

impl<S: Simd> WalkVisitor<S> for ArcMeasurer<'_> {
    #[inline(always)]
    fn next_walk(&mut self, lane: usize) -> Option<SectionWalk> {
        let count = self.sections.len();
        while self.arcs.len() < 2 * count {
            let index = self.arcs.len();
            let (section, half) = if index < count { (index, 0) } else { (index - count, 1) };
            let walk = self.sections.get(section)?[half];
            // The other half of a closed section is known.
            if half == 1 && self.reversed(section).is_some() {
                self.arcs.push(SectionArc::EMPTY);
                continue;
            }
            let ahead = walk.crossing();
            let step = ahead.length();
            if step >= self.length {
                self.arcs.push(SectionArc::full(self.length, 0.0, DVec3::ZERO, ahead, step));
                continue;
            }
            self.arcs.push(SectionArc::EMPTY);
            self.arc_of_lane[lane] = index;
            self.walked[lane] = step;
            put(&mut self.last, lane, ahead);
            return Some(walk);
        }
        None
    }

    #[inline(always)]
    fn visit(&mut self, simd: S, step: &WalkStep<S>) -> u64 {
        let last = Vec3x8::load(simd, &self.last);
        let walked: f64x8<S> = self.walked.simd_into(simd);
        let ahead = step.crossings.minus(last);
        let lengths = ahead.dot(ahead).sqrt();
        let sums = walked + lengths;
        let full = sums.simd_ge(f64x8::splat(simd, self.length)).to_bitmask() & step.lanes;
        for lane in LaneBits(full) {
            let (from, length) = (last.at(lane), lengths[lane]);
            let arc = SectionArc::full(self.length, walked[lane], from, ahead.at(lane), length);
            self.record(lane, arc);
        }
        sums.store_slice(&mut self.walked);
        last.plus(ahead).store(&mut self.last);
        full
    }

    #[inline(always)]
    fn finish(&mut self, lane: usize, cause: WalkEnd) {
        let (end, length) = (take(&self.last, lane), self.walked[lane]);
        self.record(lane, SectionArc { end, length, cut_short: Some(cause) });
    }
}

/// Both halves of sections through `origin` in the face `start`, each walked for the same length.
///
/// The arcs have the bits of [`Section::measure`](crate::section::Section::measure).
pub(crate) fn measure_arcs(
    soa: &SoaMesh,
    origin: DVec3,
    start: u32,
    sections: &[[SectionWalk; 2]],
    length: f64,
) -> Vec<[SectionArc; 2]> {
    let mut measurer = ArcMeasurer {
        sections,
        length,
        arcs: Vec::with_capacity(2 * sections.len()),
        arc_of_lane: [0; LANES],
        last: [[0.0; LANES]; 3],
        walked: [0.0; LANES],
    };
    dispatch!(soa.simd, simd => walk_all(simd, soa, origin, start, &mut measurer));
    measurer.into_pairs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar_walk::ScalarWalk;
    use crate::section_plane::SectionPlane;
    use mesh_core::TriMesh;
    use mesh_shapes::{Diagonals, Saddle, Torus};

    /// On a torus and on a grid with boundary, with lengths at which arcs end for every reason.
    #[test]
    fn arcs_have_the_bits_of_scalar_walks() {
        let torus = TriMesh::from_soup(&Torus { major: 3.0, minor: 1.0 }.mesh(40, 24).unwrap());
        let saddle = Saddle { coefficient: 0.5, half_width: 1.0 }.mesh(12, Diagonals::Alternating);
        let sheet = TriMesh::from_soup(&saddle.unwrap());
        let mut causes = [0; 3];
        for mesh in [torus.unwrap(), sheet.unwrap()] {
            let soa = SoaMesh::new(&mesh);
            for face in mesh.topology().faces().step_by(11) {
                let [a, b, c] = mesh.triangle(face);
                let (normal, origin) =
                    ((b - a).cross(c - a).normalize(), (a + 2.0 * b + 3.0 * c) / 6.0);
                let start = soa.index_of(face);
                let planes: Vec<SectionPlane> = (0..13)
                    .map(|turn| {
                        let (sin, cos) = (0.24 * f64::from(turn)).sin_cos();
                        let ahead = (b - a).normalize();
                        let tangent = cos * ahead + sin * normal.cross(ahead);
                        SectionPlane::new(origin, normal, tangent)
                    })
                    .collect();
                let scalar: Vec<[ScalarWalk<'_>; 2]> = planes
                    .iter()
                    .filter_map(|plane| ScalarWalk::both_ways(&mesh, face, plane))
                    .collect();
                let batched: Vec<[SectionWalk; 2]> = planes
                    .iter()
                    .filter_map(|plane| SectionWalk::both_ways(&soa, start, plane))
                    .collect();
                for length in [0.01, 0.3, 2.0, 40.0] {
                    let found = measure_arcs(&soa, origin, start, &batched, length);
                    assert_eq!(found.len(), scalar.len());
                    for (found, walks) in found.iter().zip(&scalar) {
                        let ahead = walks[0].arc(length);
                        let starts = [walks[0].crossing(), walks[1].crossing()];
                        let reversed = ahead.reversed(starts, length);
                        let expected = [ahead, reversed.unwrap_or_else(|| walks[1].arc(length))];
                        for (found, expected) in found.iter().zip(expected) {
                            assert_eq!(found.end.to_array(), expected.end.to_array());
                            assert_eq!(found.length, expected.length);
                            assert_eq!(found.cut_short, expected.cut_short);
                            causes[match found.cut_short {
                                None => 0,
                                Some(WalkEnd::Boundary) => 1,
                                Some(WalkEnd::Returned | WalkEnd::StepLimit) => 2,
                            }] += 1;
                        }
                    }
                }
            }
        }
        assert!(causes.iter().all(|&count| count > 100), "{causes:?}");
    }
}
