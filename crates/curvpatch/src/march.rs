//! Many sections walked side by side over a terrain.
//!
//! Which way a section leaves a face is as good as the toss of a coin, so that a core which walks one
//! section guesses wrong at every other face and waits for memory at each. Here eight walkers take each step
//! together and none of them branches on its way; when one comes to its end, the next one takes its
//! place. Each walker takes the same way, to the last bit, as
//! [`SectionWalk`](crate::section::SectionWalk) does.

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f64x8, mask64x8};
use glam::DVec3;

use crate::section::{Arc, SectionPlane, Sighting, WalkEnd, most_steps};
use crate::terrain::{NONE, Terrain};
use crate::wide::{Columns, LANES, LanesOf, Wide, put, take};

/// A walker that stands in a face and looks at the side through which the section leaves it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walker {
    across: DVec3,
    /// Both ends of that side, in the order in which the face has them.
    ends: [Sighting; 2],
    /// The place of the face.
    face: u32,
    side: u8,
    steps_left: usize,
}

impl Walker {
    /// Two walkers in the same face, one for each half of the section, forward first; as
    /// [`SectionWalk::both_ways`](crate::section::SectionWalk::both_ways).
    pub(crate) fn both_ways(
        terrain: &Terrain,
        start: u32,
        plane: &SectionPlane,
    ) -> Option<[Self; 2]> {
        let corners = terrain.triangle(terrain.links[start as usize].corners);
        let seen = corners.map(|corner| Sighting::new(corner, plane.origin, plane.across));
        let mut exits = (0..3).filter_map(|side: u8| {
            let ends = [seen[usize::from(side)], seen[usize::from(side + 1) % 3]];
            (ends[0].is_above() != ends[1].is_above()).then(|| Self {
                across: plane.across,
                ends,
                face: start,
                side,
                steps_left: most_steps(terrain.links.len()),
            })
        });
        let (first, second) = (exits.next()?, exits.next()?);
        let ahead = |walker: &Self| walker.crossing().dot(plane.tangent);
        Some(if ahead(&first) >= ahead(&second) { [first, second] } else { [second, first] })
    }

    /// Where the section leaves the face, relative to its origin.
    pub(crate) fn crossing(&self) -> DVec3 {
        Sighting::crossing(&self.ends[0], &self.ends[1])
    }
}

/// What eight walkers have seen of the faces that they have come to.
#[derive(Clone, Copy)]
pub(crate) struct Strides<S: Simd> {
    /// The walkers that have taken a step, by bits; what is said of others is of no meaning.
    pub(crate) lanes: u64,
    /// The places of the faces.
    pub(crate) faces: [u32; LANES],
    /// Where the corners are that the faces before did not have, relative to the origin of the sections.
    pub(crate) apexes: Wide<S>,
    /// Where the sections leave the faces.
    pub(crate) crossings: Wide<S>,
}

/// Those that walk, and what they look for.
pub(crate) trait Party<S: Simd> {
    /// The next walker, which takes this lane; `None` when all have set out.
    fn set_out(&mut self, lane: usize) -> Option<Walker>;

    /// Takes note of a step, and tells which walkers come to rest, by bits.
    fn stride(&mut self, simd: S, strides: &Strides<S>) -> u64;

    /// Takes note of a walker that has come to rest by what [`Party::stride`] told.
    fn rest(&mut self, _lane: usize, _walker: Walker) {}

    /// Takes note of a walker that cannot go on.
    fn end(&mut self, lane: usize, cause: WalkEnd);

    /// Whether no one need take another step.
    fn is_over(&self) -> bool {
        false
    }
}

/// The two other sides of a face, the next one first.
const OTHERS: [[u8; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// Eight walkers, and which of their sides they have come in through.
struct Group {
    across: Columns,
    firsts: Columns,
    first_distances: [f64; LANES],
    seconds: Columns,
    second_distances: [f64; LANES],
    /// Those whose first end is above the plane, by bits: it stays so.
    is_first_above: u64,
    faces: [u32; LANES],
    sides: [u8; LANES],
    steps_left: [usize; LANES],
}

impl Group {
    const EMPTY: Self = Self {
        across: [[0.0; LANES]; 3],
        firsts: [[0.0; LANES]; 3],
        first_distances: [0.0; LANES],
        seconds: [[0.0; LANES]; 3],
        second_distances: [0.0; LANES],
        is_first_above: 0,
        faces: [0; LANES],
        sides: [0; LANES],
        steps_left: [0; LANES],
    };

    #[inline(always)]
    fn put(&mut self, lane: usize, walker: &Walker) {
        let [first, second] = &walker.ends;
        put(&mut self.across, lane, walker.across);
        put(&mut self.firsts, lane, first.at);
        put(&mut self.seconds, lane, second.at);
        self.first_distances[lane] = first.distance;
        self.second_distances[lane] = second.distance;
        self.is_first_above &= !(1 << lane);
        self.is_first_above |= u64::from(first.is_above()) << lane;
        self.faces[lane] = walker.face;
        self.sides[lane] = walker.side;
        self.steps_left[lane] = walker.steps_left;
    }

    #[inline(always)]
    fn walker(&self, lane: usize) -> Walker {
        let first = Sighting { at: take(&self.firsts, lane), distance: self.first_distances[lane] };
        let second =
            Sighting { at: take(&self.seconds, lane), distance: self.second_distances[lane] };
        Walker {
            across: take(&self.across, lane),
            ends: [first, second],
            face: self.faces[lane],
            side: self.sides[lane],
            steps_left: self.steps_left[lane],
        }
    }

    /// Goes into the next face, and leaves in `sides` the one through which.
    #[inline(always)]
    fn enter(&mut self, terrain: &Terrain, start: u32, lane: usize) -> Result<(), WalkEnd> {
        let side = usize::from(self.sides[lane]);
        let entry = terrain.links[self.faces[lane] as usize].beyond[side];
        if entry == NONE {
            return Err(WalkEnd::Boundary);
        }
        let face = entry / 3;
        if face == start {
            return Err(WalkEnd::Returned);
        }
        if self.steps_left[lane] == 0 {
            return Err(WalkEnd::Lost);
        }
        self.steps_left[lane] -= 1;
        self.faces[lane] = face;
        self.sides[lane] = (entry % 3) as u8;
        Ok(())
    }

    /// Looks, in the faces that have been gone into, for the side that the sections leave through.
    #[inline(always)]
    fn look<S: Simd>(
        &mut self,
        simd: S,
        terrain: &Terrain,
        origin: DVec3,
        lanes: u64,
    ) -> Strides<S> {
        let mut others = [[0; 2]; LANES];
        let mut apexes = [DVec3::ZERO; LANES];
        for lane in 0..LANES {
            others[lane] = OTHERS[usize::from(self.sides[lane])];
            let corners = terrain.links[self.faces[lane] as usize].corners;
            apexes[lane] = terrain.positions[corners[usize::from(others[lane][1])] as usize];
        }
        let apexes = Wide::gather(simd, apexes).minus(Wide::splat(simd, origin));
        let distances = Wide::load(simd, &self.across).dot(apexes);
        let is_above = distances.simd_ge(f64x8::splat(simd, 0.0)).to_bitmask();
        // Seen from the old face the side runs from the first end to the second; the new face has it the
        // other way round, followed by first - apex and apex - second.
        let is_as_first = !(is_above ^ self.is_first_above);
        for lane in 0..LANES {
            self.sides[lane] = others[lane][(is_as_first >> lane & 1) as usize];
        }
        let replaces_first: mask64x8<S> = mask64x8::from_bitmask(simd, is_as_first & 0xFF);
        let firsts = Wide::select(replaces_first, apexes, Wide::load(simd, &self.firsts));
        let seconds = Wide::select(replaces_first, Wide::load(simd, &self.seconds), apexes);
        let first_distances =
            replaces_first.select(distances, self.first_distances.simd_into(simd));
        let second_distances =
            replaces_first.select(self.second_distances.simd_into(simd), distances);
        firsts.store(&mut self.firsts);
        seconds.store(&mut self.seconds);
        first_distances.store_slice(&mut self.first_distances);
        second_distances.store_slice(&mut self.second_distances);
        let share = first_distances / (first_distances - second_distances);
        let crossings = firsts.plus(seconds.minus(firsts).times(share));
        Strides { lanes, faces: self.faces, apexes, crossings }
    }
}

/// Lets a party walk sections through `origin` that come from the face `start`.
#[inline(always)]
pub(crate) fn march<S: Simd>(
    simd: S,
    terrain: &Terrain,
    origin: DVec3,
    start: u32,
    party: &mut impl Party<S>,
) {
    let mut group = Group::EMPTY;
    group.faces = [start; LANES];
    let mut idle = (1_u64 << LANES) - 1;
    let mut on_foot = 0_u64;
    loop {
        for lane in LanesOf(idle) {
            if let Some(walker) = party.set_out(lane) {
                group.put(lane, &walker);
                on_foot |= 1 << lane;
            }
        }
        idle = 0;
        if on_foot == 0 {
            return;
        }
        for lane in LanesOf(on_foot) {
            if let Err(cause) = group.enter(terrain, start, lane) {
                party.end(lane, cause);
                idle |= 1 << lane;
            }
        }
        on_foot &= !idle;
        let strides = group.look(simd, terrain, origin, on_foot);
        let resting = party.stride(simd, &strides) & on_foot;
        if party.is_over() {
            return;
        }
        for lane in LanesOf(resting) {
            party.rest(lane, group.walker(lane));
        }
        on_foot &= !resting;
        idle |= resting;
    }
}

/// Those that measure both halves of sections, for one length.
struct Surveyors<'w> {
    /// The walkers of both halves of each section.
    sections: &'w [[Walker; 2]],
    length: f64,
    /// All first halves, then the second ones: so far as they have set out.
    arcs: Vec<Arc>,
    /// The number of the arc of each lane.
    numbers: [usize; LANES],
    last: Columns,
    walked: [f64; LANES],
}

impl Surveyors<'_> {
    fn finish(&mut self, lane: usize, arc: Arc) {
        if let Some(place) = self.arcs.get_mut(self.numbers[lane]) {
            *place = arc;
        }
    }

    /// The second half of a section, where that follows from the first one as far as that has been walked.
    fn reversed(&self, section: usize) -> Option<Arc> {
        let (arc, walkers) = (self.arcs.get(section)?, self.sections.get(section)?);
        arc.reversed([walkers[0].crossing(), walkers[1].crossing()], self.length)
    }

    /// Both halves of all sections, once they have been walked.
    fn both(self) -> Vec<[Arc; 2]> {
        let count = self.sections.len();
        let second =
            |section: usize| self.reversed(section).or(self.arcs.get(count + section).copied());
        let both = |(section, &first)| [first, second(section).unwrap_or(Arc::EMPTY)];
        self.arcs.iter().take(count).enumerate().map(both).collect()
    }
}

/// The arc that ends on the way from one crossing to the next.
fn full(length: f64, walked: f64, last: DVec3, ahead: DVec3, step: f64) -> Arc {
    Arc { end: last + (length - walked) / step * ahead, length, cut_short: None }
}

impl<S: Simd> Party<S> for Surveyors<'_> {
    #[inline(always)]
    fn set_out(&mut self, lane: usize) -> Option<Walker> {
        let count = self.sections.len();
        while self.arcs.len() < 2 * count {
            let number = self.arcs.len();
            let (section, half) = if number < count { (number, 0) } else { (number - count, 1) };
            let walker = self.sections.get(section)?[half];
            // Where a section has come back, its other half is known.
            if half == 1 && self.reversed(section).is_some() {
                self.arcs.push(Arc::EMPTY);
                continue;
            }
            let ahead = walker.crossing();
            let step = ahead.length();
            if step >= self.length {
                self.arcs.push(full(self.length, 0.0, DVec3::ZERO, ahead, step));
                continue;
            }
            self.arcs.push(Arc::EMPTY);
            self.numbers[lane] = number;
            self.walked[lane] = step;
            put(&mut self.last, lane, ahead);
            return Some(walker);
        }
        None
    }

    #[inline(always)]
    fn stride(&mut self, simd: S, strides: &Strides<S>) -> u64 {
        let last = Wide::load(simd, &self.last);
        let walked: f64x8<S> = self.walked.simd_into(simd);
        let ahead = strides.crossings.minus(last);
        let steps = ahead.dot(ahead).sqrt();
        let sums = walked + steps;
        let resting = sums.simd_ge(f64x8::splat(simd, self.length)).to_bitmask() & strides.lanes;
        for lane in LanesOf(resting) {
            let arc = full(self.length, walked[lane], last.at(lane), ahead.at(lane), steps[lane]);
            self.finish(lane, arc);
        }
        sums.store_slice(&mut self.walked);
        last.plus(ahead).store(&mut self.last);
        resting
    }

    #[inline(always)]
    fn end(&mut self, lane: usize, cause: WalkEnd) {
        let (end, length) = (take(&self.last, lane), self.walked[lane]);
        self.finish(lane, Arc { end, length, cut_short: Some(cause) });
    }
}

/// Both halves of sections through `origin` that come from the face `start`, each walked for the same
/// length; the arcs of [`Section::measure`](crate::section::Section::measure).
pub(crate) fn arcs(
    terrain: &Terrain,
    origin: DVec3,
    start: u32,
    sections: &[[Walker; 2]],
    length: f64,
) -> Vec<[Arc; 2]> {
    let mut surveyors = Surveyors {
        sections,
        length,
        arcs: Vec::with_capacity(2 * sections.len()),
        numbers: [0; LANES],
        last: [[0.0; LANES]; 3],
        walked: [0.0; LANES],
    };
    dispatch!(terrain.simd, simd => march(simd, terrain, origin, start, &mut surveyors));
    surveyors.both()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::SectionWalk;
    use mesh_core::TriMesh;
    use mesh_core::shapes::{Diagonals, Saddle, Torus};

    /// Over a torus and a grid with a boundary, with lengths at which all arcs end in different ways.
    #[test]
    fn arcs_are_those_of_single_walkers_to_the_last_bit() {
        let torus = TriMesh::from_soup(&Torus { major: 3.0, minor: 1.0 }.mesh(40, 24).unwrap());
        let saddle = Saddle { coefficient: 0.5, half_width: 1.0 }.mesh(12, Diagonals::Alternating);
        let sheet = TriMesh::from_soup(&saddle.unwrap());
        let mut causes = [0; 3];
        for mesh in [torus.unwrap(), sheet.unwrap()] {
            let terrain = Terrain::new(&mesh);
            for face in mesh.topology().faces().step_by(11) {
                let [a, b, c] = mesh.triangle(face);
                let (normal, origin) =
                    ((b - a).cross(c - a).normalize(), (a + 2.0 * b + 3.0 * c) / 6.0);
                let start = terrain.place(face);
                let planes: Vec<SectionPlane> = (0..13)
                    .map(|turn| {
                        let (sin, cos) = (0.24 * f64::from(turn)).sin_cos();
                        let ahead = (b - a).normalize();
                        let tangent = cos * ahead + sin * normal.cross(ahead);
                        SectionPlane::new(origin, normal, tangent)
                    })
                    .collect();
                let alone: Vec<[SectionWalk<'_>; 2]> = planes
                    .iter()
                    .filter_map(|plane| SectionWalk::both_ways(&mesh, face, plane))
                    .collect();
                let together: Vec<[Walker; 2]> = planes
                    .iter()
                    .filter_map(|plane| Walker::both_ways(&terrain, start, plane))
                    .collect();
                for length in [0.01, 0.3, 2.0, 40.0] {
                    let found = arcs(&terrain, origin, start, &together, length);
                    assert_eq!(found.len(), alone.len());
                    for (found, walks) in found.iter().zip(&alone) {
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
                                Some(WalkEnd::Returned | WalkEnd::Lost) => 2,
                            }] += 1;
                        }
                    }
                }
            }
        }
        assert!(causes.iter().all(|&count| count > 100), "{causes:?}");
    }
}
