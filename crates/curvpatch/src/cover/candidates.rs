//! The patches from which a cover is selected.

use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{FaceId, FaceMap, Handle, TriMesh, parallel};

use super::options::{CoverOptions, Seeds};
use crate::curvature_estimator::CurvatureEstimator;
use crate::patch_fit::PatchFit;
use crate::patch_sizer::{PatchSizer, SizedPatch, StopReason};
use crate::size_options::{OptionError, SizeOptions};

/// Progress of the search for candidates, which takes most of the time of a cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoverProgress {
    /// Number of faces that a candidate covers or that were tried as base face.
    pub settled: usize,
    /// Number of faces of the mesh. The search ends when all are settled.
    pub faces: usize,
}

/// A patch that can be selected for the cover.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) fit: PatchFit,
    pub(super) stop: StopReason,
    /// The area of the covered faces.
    pub(super) area: f64,
    /// One past its last face in the common list.
    faces_end: usize,
}

/// The patches from which a cover is selected.
///
/// The search takes most of the time of a cover. Keep the candidates to select several covers.
#[derive(Clone, Debug)]
pub struct CoverCandidates<'a> {
    mesh: &'a TriMesh,
    size: SizeOptions,
    candidates: Vec<Candidate>,
    /// The covered faces of all candidates, one after the other.
    faces: Vec<FaceId>,
    /// Whether a face was tried as base face.
    tried: FaceMap<bool>,
    covered: FaceMap<bool>,
    /// Number of faces that are tried or covered.
    settled: usize,
    seeds: usize,
    cancelled: bool,
}

/// Number of seeds of the first round on a large mesh, and minimum of every round.
const PILOT_SEEDS: usize = 256;

/// Rounds over slivers continue while at least one in this many has a candidate.
const MAX_SEEDS_PER_CANDIDATE: usize = 64;

/// The largest height of a sliver, relative to its longest side. The disc of a sliver extends over many
/// other faces, and its normal is inaccurate.
const SLIVER: f64 = 0.02;

/// Number of seeds between two progress reports.
const BLOCK: usize = 1024;

impl<'a> CoverCandidates<'a> {
    /// Searches candidates of automatic size in parallel, enough to cover every face that has one.
    /// `options.method` is not used.
    ///
    /// # Errors
    /// An option out of its range.
    pub fn find(
        estimator: &CurvatureEstimator<'a>,
        options: &CoverOptions,
    ) -> Result<Self, OptionError> {
        Self::find_with_progress(estimator, options, &mut |_| ControlFlow::Continue(()))
    }

    /// As [`CoverCandidates::find`], with progress reports to `progress`. If `progress` breaks, the search
    /// ends with the candidates found so far.
    ///
    /// # Errors
    /// An option out of its range.
    pub fn find_with_progress(
        estimator: &CurvatureEstimator<'a>,
        options: &CoverOptions,
        progress: &mut dyn FnMut(CoverProgress) -> ControlFlow<()>,
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
        found.cancelled = found.search(&sizer, options, progress).is_break();
        Ok(found)
    }

    /// Searches candidates until every face is covered or tried.
    fn search(
        &mut self,
        sizer: &PatchSizer<'_, 'a>,
        options: &CoverOptions,
        progress: &mut dyn FnMut(CoverProgress) -> ControlFlow<()>,
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
        let mut per_seed = self.add_round(sizer, options, &evenly_spaced(&all, pilot), progress)?;
        let mut open = all;
        while !open.is_empty() {
            let wanted = redundancy * open.len() as f64 / per_seed;
            let count = (wanted.min(open.len() as f64) as usize).max(PILOT_SEEDS);
            per_seed = self.add_round(sizer, options, &evenly_spaced(&open, count), progress)?;
            // After the first full round, only uncovered faces are tried.
            open.retain(|&face| self.is_open(face));
        }
        self.search_slivers(sizer, options, slivers, progress)
    }

    /// Searches candidates at slivers that no candidate covers, twice as many in each round, until a round
    /// finds nearly none.
    fn search_slivers(
        &mut self,
        sizer: &PatchSizer<'_, 'a>,
        options: &CoverOptions,
        mut open: Vec<FaceId>,
        progress: &mut dyn FnMut(CoverProgress) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        open.retain(|&face| self.is_open(face));
        let mut count = PILOT_SEEDS;
        while !open.is_empty() {
            let (seeds, before) = (evenly_spaced(&open, count), self.len());
            count *= 2;
            self.add_round(sizer, options, &seeds, progress)?;
            open.retain(|&face| self.is_open(face));
            if seeds.len() >= PILOT_SEEDS
                && (self.len() - before) * MAX_SEEDS_PER_CANDIDATE < seeds.len()
            {
                break;
            }
        }
        for &face in &open {
            self.settle(face);
        }
        let faces = self.mesh.topology().face_count();
        progress(CoverProgress { settled: self.settled, faces })
    }

    /// Whether a face is neither covered nor tried.
    fn is_open(&self, face: FaceId) -> bool {
        !self.tried[face] && !self.covered[face]
    }

    /// Searches candidates at the seeds that were not tried before. Returns the mean number of faces that
    /// a seed covers, at least 1.
    fn add_round(
        &mut self,
        sizer: &PatchSizer<'_, 'a>,
        options: &CoverOptions,
        seeds: &[FaceId],
        progress: &mut dyn FnMut(CoverProgress) -> ControlFlow<()>,
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
                // A patch that does not cover its own base face is useless.
                if let Some((area, sized)) = sized.filter(|(_, sized)| sized.faces.contains(&seed))
                {
                    self.add(area, &sized);
                }
            }
            self.seeds += block.len();
            let faces = self.mesh.topology().face_count();
            progress(CoverProgress { settled: self.settled, faces })?;
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

    /// Counts a face that becomes tried or covered, unless it is already.
    fn settle(&mut self, face: FaceId) {
        self.settled += usize::from(!self.tried[face] && !self.covered[face]);
    }

    /// Number of candidates.
    #[must_use]
    pub fn len(&self) -> usize {
        self.candidates.len()
    }

    /// Whether there are no candidates.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    /// Number of faces that were tried as base face.
    #[must_use]
    pub fn seeds(&self) -> usize {
        self.seeds
    }

    /// Whether the search was cancelled.
    #[must_use]
    pub fn cancelled(&self) -> bool {
        self.cancelled
    }

    pub(super) fn mesh(&self) -> &'a TriMesh {
        self.mesh
    }

    /// The conditions that every candidate fulfils.
    pub(super) fn size(&self) -> &SizeOptions {
        &self.size
    }

    pub(super) fn get(&self, index: usize) -> &Candidate {
        &self.candidates[index]
    }

    /// The base face of a candidate; it breaks ties.
    pub(super) fn base(&self, index: usize) -> FaceId {
        self.candidates[index].fit.point.face()
    }

    /// The covered faces of a candidate.
    pub(super) fn faces(&self, index: usize) -> &[FaceId] {
        let start = if index == 0 { 0 } else { self.candidates[index - 1].faces_end };
        &self.faces[start..self.candidates[index].faces_end]
    }

    pub(super) fn face_capacity(&self) -> usize {
        self.mesh.topology().face_capacity()
    }

    /// The area of the face with this index; 0 for a removed face.
    pub(super) fn face_area(&self, index: usize) -> f64 {
        let face = FaceId::from_index(index);
        if self.mesh.topology().contains_face(face) { self.mesh.face_area(face) } else { 0.0 }
    }
}

fn is_sliver([a, b, c]: [DVec3; 3]) -> bool {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (b - a).cross(c - a).length() < SLIVER * longest
}

/// At most `count` of the faces, evenly spaced by index.
fn evenly_spaced(faces: &[FaceId], count: usize) -> Vec<FaceId> {
    let count = count.min(faces.len());
    (0..count).map(|i| faces[i * faces.len() / count]).collect()
}
