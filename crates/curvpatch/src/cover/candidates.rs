//! The patches that a cover is chosen from.

use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{FaceId, FaceMap, Handle, TriMesh, parallel};

use super::options::{CoverOptions, Seeds};
use crate::curvature::CurvatureEstimator;
use crate::fit::PatchFit;
use crate::size::{OptionError, PatchSizer, SizeOptions, SizedPatch, StopReason};

/// How far the search for candidates is, which takes nearly all of the time of a cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoverProgress {
    /// Faces that some candidate covers, or that were tried as a seed.
    pub settled: usize,
    /// All faces of the mesh. The search ends when all are settled.
    pub faces: usize,
}

/// A patch that may become part of the cover.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) fit: PatchFit,
    pub(super) stop: StopReason,
    /// The area of the faces it covers.
    pub(super) area: f64,
    /// One past its last face in the common list.
    faces_end: usize,
}

/// The patches that a cover is chosen from: finding them takes nearly all of the time of a cover,
/// so keep them to choose more than once.
// The faces that each candidate covers are in one flat list.
#[derive(Clone, Debug)]
pub struct CoverCandidates<'a> {
    mesh: &'a TriMesh,
    size: SizeOptions,
    candidates: Vec<Candidate>,
    faces: Vec<FaceId>,
    /// Whether a candidate was looked for at the face.
    tried: FaceMap<bool>,
    covered: FaceMap<bool>,
    /// How many faces are tried or covered.
    settled: usize,
    seeds: usize,
    cancelled: bool,
}

/// Seeds of the first round on a large mesh, and the least number of seeds of any round.
const PILOT_SEEDS: usize = 256;

/// A round over slivers goes on when one in so many has a candidate.
const WORTHWHILE: usize = 64;

/// The height of a sliver, as a share of its longest side. Its disc reaches over many other faces,
/// and its normal is as uncertain as it is thin.
const SLIVER: f64 = 0.02;

/// Seeds between two reports of progress.
const BLOCK: usize = 1024;

impl<'a> CoverCandidates<'a> {
    /// Candidates of automatic size for the seeds, in parallel: enough to cover every face that has
    /// one. `options.method` does not matter here.
    ///
    /// # Errors
    /// An option out of its range.
    pub fn find(
        estimator: &CurvatureEstimator<'a>,
        options: &CoverOptions,
    ) -> Result<Self, OptionError> {
        Self::find_watched(estimator, options, &mut |_| ControlFlow::Continue(()))
    }

    /// As [`CoverCandidates::find`], telling `watch` now and then how far it is. When `watch`
    /// breaks, the search ends with the candidates found so far.
    ///
    /// # Errors
    /// An option out of its range.
    pub fn find_watched(
        estimator: &CurvatureEstimator<'a>,
        options: &CoverOptions,
        watch: &mut dyn FnMut(CoverProgress) -> ControlFlow<()>,
    ) -> Result<Self, OptionError> {
        options.check()?;
        let mesh = estimator.mesh();
        let sizer = PatchSizer::new(estimator, options.size)?;
        let topology = mesh.topology();
        let mut found = Self {
            mesh,
            size: options.size,
            candidates: Vec::new(),
            faces: Vec::new(),
            tried: topology.face_map(false),
            covered: topology.face_map(false),
            settled: 0,
            seeds: 0,
            cancelled: false,
        };
        found.cancelled = found.search(&sizer, options, watch).is_break();
        Ok(found)
    }

    /// Looks for candidates until every face is covered by one or was a seed itself.
    fn search(
        &mut self,
        sizer: &PatchSizer<'_, 'a>,
        options: &CoverOptions,
        watch: &mut dyn FnMut(CoverProgress) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let all: Vec<FaceId> = self.mesh.topology().faces().collect();
        let redundancy = match options.seeds {
            Seeds::Redundancy(redundancy) if all.len() > Seeds::FEW_FACES => redundancy,
            _ => f64::INFINITY,
        };
        let (slivers, all): (Vec<_>, Vec<_>) = all.into_iter().partition(|&face| {
            options.seeds != Seeds::AllFaces && is_sliver(self.mesh.triangle(face))
        });
        let pilot = if redundancy.is_finite() { PILOT_SEEDS } else { all.len() };
        let mut per_seed = self.add_round(sizer, options, &spread(&all, pilot), watch)?;
        let mut open = all;
        while !open.is_empty() {
            let wanted = redundancy * open.len() as f64 / per_seed;
            let count = (wanted.min(open.len() as f64) as usize).max(PILOT_SEEDS);
            per_seed = self.add_round(sizer, options, &spread(&open, count), watch)?;
            // After the first full round, only what is still bare is of interest.
            open.retain(|&face| self.is_bare(face));
        }
        self.search_slivers(sizer, options, slivers, watch)
    }

    /// Looks for candidates at slivers that no other one covers, twice as many in each round, until
    /// one has found next to none.
    fn search_slivers(
        &mut self,
        sizer: &PatchSizer<'_, 'a>,
        options: &CoverOptions,
        mut open: Vec<FaceId>,
        watch: &mut dyn FnMut(CoverProgress) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        open.retain(|&face| self.is_bare(face));
        let mut count = PILOT_SEEDS;
        while !open.is_empty() {
            let (seeds, before) = (spread(&open, count), self.len());
            count *= 2;
            self.add_round(sizer, options, &seeds, watch)?;
            open.retain(|&face| self.is_bare(face));
            if seeds.len() >= PILOT_SEEDS && (self.len() - before) * WORTHWHILE < seeds.len() {
                break;
            }
        }
        for &face in &open {
            self.settle(face);
        }
        let faces = self.mesh.topology().face_count();
        watch(CoverProgress { settled: self.settled, faces })
    }

    /// Whether a face is not covered by any candidate and was no seed.
    fn is_bare(&self, face: FaceId) -> bool {
        !self.tried[face] && !self.covered[face]
    }

    /// Looks for candidates at the seeds that were not tried before; returns the mean number of
    /// faces that one covers, and at least one.
    fn add_round(
        &mut self,
        sizer: &PatchSizer<'_, 'a>,
        options: &CoverOptions,
        seeds: &[FaceId],
        watch: &mut dyn FnMut(CoverProgress) -> ControlFlow<()>,
    ) -> ControlFlow<(), f64> {
        let seeds: Vec<FaceId> = seeds.iter().copied().filter(|&f| !self.tried[f]).collect();
        let before = self.faces.len();
        for block in seeds.chunks(BLOCK) {
            let sized = parallel::collect_with(
                block.len(),
                || sizer.clone(),
                |sizer, i| sizer.fit_largest(block[i].into(), &options.shapes).ok(),
            );
            for (&seed, sized) in block.iter().zip(sized) {
                self.settle(seed);
                self.tried[seed] = true;
                // A patch that leaves out its own face stands for nothing.
                if let Some((area, sized)) = sized.filter(|(_, sized)| sized.faces.contains(&seed))
                {
                    self.add(area, &sized);
                }
            }
            self.seeds += block.len();
            let faces = self.mesh.topology().face_count();
            watch(CoverProgress { settled: self.settled, faces })?;
        }
        let gained = (self.faces.len() - before) as f64;
        ControlFlow::Continue((gained / seeds.len().max(1) as f64).max(1.0))
    }

    fn add(&mut self, area: f64, sized: &SizedPatch) {
        for &face in &sized.faces {
            self.settle(face);
            self.covered[face] = true;
        }
        self.faces.extend_from_slice(&sized.faces);
        let faces_end = self.faces.len();
        self.candidates.push(Candidate { fit: sized.fit, stop: sized.stop, area, faces_end });
    }

    /// Counts a face that is about to become tried or covered, unless it is already.
    fn settle(&mut self, face: FaceId) {
        self.settled += usize::from(!self.tried[face] && !self.covered[face]);
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.candidates.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    /// For how many faces a candidate was looked for.
    #[must_use]
    pub fn seeds(&self) -> usize {
        self.seeds
    }

    /// Whether the search was broken off.
    #[must_use]
    pub fn cancelled(&self) -> bool {
        self.cancelled
    }

    pub(super) fn mesh(&self) -> &'a TriMesh {
        self.mesh
    }

    /// What every candidate keeps.
    pub(super) fn size(&self) -> &SizeOptions {
        &self.size
    }

    pub(super) fn get(&self, index: usize) -> &Candidate {
        &self.candidates[index]
    }

    /// The base face of a candidate, which breaks ties.
    pub(super) fn base(&self, index: usize) -> FaceId {
        self.candidates[index].fit.point.face()
    }

    /// The faces that a candidate covers.
    pub(super) fn faces(&self, index: usize) -> &[FaceId] {
        let start = if index == 0 { 0 } else { self.candidates[index - 1].faces_end };
        &self.faces[start..self.candidates[index].faces_end]
    }

    pub(super) fn face_capacity(&self) -> usize {
        self.mesh.topology().face_capacity()
    }

    /// The area of the face with this index; 0 for a removed one.
    pub(super) fn face_area(&self, index: usize) -> f64 {
        let face = FaceId::from_index(index);
        if self.mesh.topology().contains_face(face) { self.mesh.face_area(face) } else { 0.0 }
    }
}

fn is_sliver([a, b, c]: [DVec3; 3]) -> bool {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (b - a).cross(c - a).length() < SLIVER * longest
}

/// About `count` of the faces, evenly spread.
fn spread(faces: &[FaceId], count: usize) -> Vec<FaceId> {
    let count = count.min(faces.len());
    (0..count).map(|i| faces[i * faces.len() / count]).collect()
}
