//! Walks along many sections at the same time, eight per SIMD group.
//!
//! The side through which a section leaves a face is unpredictable. A processor that walks one section
//! mispredicts half of the branches and waits for memory at each face. Here eight walks take each step
//! together, without a branch; a walk that ends makes room for the next one. Each walk has the same
//! bits as [`ScalarWalk`](crate::scalar_walk::ScalarWalk).

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8};
use glam::DVec3;

use crate::section_arc::{WalkEnd, max_steps};
use crate::section_plane::{SectionPlane, SignedVertex};
use crate::soa_mesh::{NONE, SoaMesh};
use crate::vec3x8::{LANES, LaneBits, Vec3Lanes, Vec3x8, put, take};

/// A walk in a face, with the side through which the section leaves it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SectionWalk {
    across: DVec3,
    /// Both ends of that side, in the order of the face.
    ends: [SignedVertex; 2],
    /// The `SoaMesh` index of the face.
    face: u32,
    side: u8,
    steps_left: usize,
}

impl SectionWalk {
    /// The walks along both halves of a section, forward first; as
    /// [`ScalarWalk::both_ways`](crate::scalar_walk::ScalarWalk::both_ways).
    pub(crate) fn both_ways(soa: &SoaMesh, start: u32, plane: &SectionPlane) -> Option<[Self; 2]> {
        let corners = soa.triangle(soa.faces[start as usize].corners);
        let signed = corners.map(|corner| SignedVertex::new(corner, plane.origin, plane.across));
        let mut exits = (0..3).filter_map(|side: u8| {
            let ends = [signed[usize::from(side)], signed[usize::from(side + 1) % 3]];
            (ends[0].is_above() != ends[1].is_above()).then(|| Self {
                across: plane.across,
                ends,
                face: start,
                side,
                steps_left: max_steps(soa.faces.len()),
            })
        });
        let (first, second) = (exits.next()?, exits.next()?);
        let ahead = |walk: &Self| walk.crossing().dot(plane.tangent);
        Some(if ahead(&first) >= ahead(&second) { [first, second] } else { [second, first] })
    }

    /// The point where the section leaves the face, relative to the origin of the section.
    pub(crate) fn crossing(&self) -> DVec3 {
        SignedVertex::crossing(&self.ends[0], &self.ends[1])
    }
}

/// One step of eight walks.
#[derive(Clone, Copy)]
pub(crate) struct WalkStep<S: Simd> {
    /// The lanes that took a step, as bits. The values of other lanes are undefined.
    pub(crate) lanes: u64,
    /// The `SoaMesh` indices of the entered faces.
    pub(crate) faces: [u32; LANES],
    /// The corner of each entered face that the previous face does not have, relative to the origin.
    pub(crate) apexes: Vec3x8<S>,
    /// The points where the sections leave the entered faces.
    pub(crate) crossings: Vec3x8<S>,
}

/// Supplies the walks and observes their steps.
pub(crate) trait WalkVisitor<S: Simd> {
    /// The next walk, which takes this lane; `None` when all have started.
    fn next_walk(&mut self, lane: usize) -> Option<SectionWalk>;

    /// Observes a step, and returns the lanes whose walks pause, as bits.
    fn visit(&mut self, simd: S, step: &WalkStep<S>) -> u64;

    /// Receives a walk that has paused.
    fn pause(&mut self, _lane: usize, _walk: SectionWalk) {}

    /// Observes that a walk cannot continue.
    fn finish(&mut self, lane: usize, cause: WalkEnd);

    /// Whether no walk needs another step.
    fn is_done(&self) -> bool {
        false
    }
}

/// The two other sides of a face, the next one first.
const OTHER_SIDES: [[u8; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// The state of eight walks.
struct WalkLanes {
    across: Vec3Lanes,
    firsts: Vec3Lanes,
    first_distances: [f64; LANES],
    seconds: Vec3Lanes,
    second_distances: [f64; LANES],
    /// The lanes whose first end is above the plane, as bits. The bit never changes during a walk.
    is_first_above: u64,
    faces: [u32; LANES],
    sides: [u8; LANES],
    steps_left: [usize; LANES],
}

impl WalkLanes {
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
    fn put(&mut self, lane: usize, walk: &SectionWalk) {
        let [first, second] = &walk.ends;
        put(&mut self.across, lane, walk.across);
        put(&mut self.firsts, lane, first.at);
        put(&mut self.seconds, lane, second.at);
        self.first_distances[lane] = first.distance;
        self.second_distances[lane] = second.distance;
        self.is_first_above &= !(1 << lane);
        self.is_first_above |= u64::from(first.is_above()) << lane;
        self.faces[lane] = walk.face;
        self.sides[lane] = walk.side;
        self.steps_left[lane] = walk.steps_left;
    }

    #[inline(always)]
    fn walk(&self, lane: usize) -> SectionWalk {
        let first =
            SignedVertex { at: take(&self.firsts, lane), distance: self.first_distances[lane] };
        let second =
            SignedVertex { at: take(&self.seconds, lane), distance: self.second_distances[lane] };
        SectionWalk {
            across: take(&self.across, lane),
            ends: [first, second],
            face: self.faces[lane],
            side: self.sides[lane],
            steps_left: self.steps_left[lane],
        }
    }

    /// Moves a walk to the next face. `sides` then holds the side through which it entered.
    #[inline(always)]
    fn cross_side(&mut self, soa: &SoaMesh, start: u32, lane: usize) -> Result<(), WalkEnd> {
        let side = usize::from(self.sides[lane]);
        let entry = soa.faces[self.faces[lane] as usize].opposite[side];
        if entry == NONE {
            return Err(WalkEnd::Boundary);
        }
        let face = entry / 3;
        if face == start {
            return Err(WalkEnd::Returned);
        }
        if self.steps_left[lane] == 0 {
            return Err(WalkEnd::StepLimit);
        }
        self.steps_left[lane] -= 1;
        self.faces[lane] = face;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0, 1 or 2")]
        let side = (entry % 3) as u8;
        self.sides[lane] = side;
        Ok(())
    }

    /// Finds the sides through which the sections leave the faces that they entered.
    #[inline(always)]
    fn find_exits<S: Simd>(
        &mut self,
        simd: S,
        soa: &SoaMesh,
        origin: DVec3,
        lanes: u64,
    ) -> WalkStep<S> {
        let mut others = [[0; 2]; LANES];
        let mut apexes = [DVec3::ZERO; LANES];
        for lane in 0..LANES {
            others[lane] = OTHER_SIDES[usize::from(self.sides[lane])];
            let corners = soa.faces[self.faces[lane] as usize].corners;
            apexes[lane] = soa.positions[corners[usize::from(others[lane][1])] as usize];
        }
        let apexes = Vec3x8::gather(simd, apexes).minus(Vec3x8::splat(simd, origin));
        let distances = Vec3x8::load(simd, &self.across).dot(apexes);
        let is_above = distances.simd_ge(f64x8::splat(simd, 0.0)).to_bitmask();
        // The old face has the side as first - second. The new face has it reversed, followed by
        // first - apex and apex - second.
        let is_as_first = !(is_above ^ self.is_first_above);
        for lane in 0..LANES {
            self.sides[lane] = others[lane][(is_as_first >> lane & 1) as usize];
        }
        let replaces_first: mask64x8<S> = mask64x8::from_bitmask(simd, is_as_first & 0xFF);
        let firsts = Vec3x8::select(replaces_first, apexes, Vec3x8::load(simd, &self.firsts));
        let seconds = Vec3x8::select(replaces_first, Vec3x8::load(simd, &self.seconds), apexes);
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
        WalkStep { lanes, faces: self.faces, apexes, crossings }
    }
}

/// Runs all walks of a visitor. The sections pass through `origin` in the face `start`.
#[inline(always)]
pub(crate) fn walk_all<S: Simd>(
    simd: S,
    soa: &SoaMesh,
    origin: DVec3,
    start: u32,
    visitor: &mut impl WalkVisitor<S>,
) {
    let mut lanes = WalkLanes::EMPTY;
    lanes.faces = [start; LANES];
    let mut idle = (1_u64 << LANES) - 1;
    let mut active = 0_u64;
    loop {
        for lane in LaneBits(idle) {
            if let Some(walk) = visitor.next_walk(lane) {
                lanes.put(lane, &walk);
                active |= 1 << lane;
            }
        }
        idle = 0;
        if active == 0 {
            return;
        }
        for lane in LaneBits(active) {
            if let Err(cause) = lanes.cross_side(soa, start, lane) {
                visitor.finish(lane, cause);
                idle |= 1 << lane;
            }
        }
        active &= !idle;
        let step = lanes.find_exits(simd, soa, origin, active);
        let paused = visitor.visit(simd, &step) & active;
        if visitor.is_done() {
            return;
        }
        for lane in LaneBits(paused) {
            visitor.pause(lane, lanes.walk(lane));
        }
        active &= !paused;
        idle |= paused;
    }
}
