//! Levels of detail: stages of one sequence of edge collapses, with attributes and errors.

use std::io::{ErrorKind, Read, Write};

use mesh_core::{TriMesh, as_u32};
use mesh_io::{Model, ModelError};
use mesh_metric::{CompareOptions, Comparison, Surface, SurfaceError, compare};
use simplify::{
    CollapseLog, ErrorCheck, Options, RecordError, ReplayError, SimplifyError, Target,
    collapses_within,
};

use crate::attributes::Attributes;
use crate::constraint_choices::{ConstraintChoices, ConstraintError};
use crate::loaded::Source;

/// The levels to make.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelSteps {
    /// One level for each ratio of the face count of the input.
    pub ratios: Vec<f64>,
    /// One level for each face count. A level may have one face fewer.
    pub faces: Vec<usize>,
    /// One level for each distance from the input, in model units: the coarsest within it.
    pub errors: Vec<f64>,
}

/// A level of detail.
#[derive(Clone, Debug)]
pub struct LevelOfDetail {
    /// The model with attributes.
    pub model: Model,
    /// The mesh.
    pub mesh: TriMesh,
    /// Number of collapses that lead to it.
    pub collapses: usize,
    /// Distances between the input (first surface) and the level.
    pub distance: Comparison,
}

/// The run that levels are stages of.
#[derive(Clone, Debug)]
pub struct LevelPlan {
    /// The options of the run.
    pub options: Options,
    /// The attributes of the levels, with merged charts if the coarsest level has no room for all of them.
    pub attributes: Attributes,
    /// The numbers of vertices and faces that [`ConstraintChoices::keep`] keeps.
    pub kept: [usize; 2],
}

/// The collapses of a run, as they are kept for levels made later.
#[derive(Clone, Debug, Default)]
pub struct LevelRecord {
    /// The collapses.
    pub log: CollapseLog,
    /// The number of faces that charts were merged for; `None` if none were.
    pub room: Option<u32>,
}

/// What follows the collapses in a record if charts were merged, before the number of faces.
const ROOM: &[u8; 4] = b"ROOM";

impl LevelRecord {
    /// Writes the log, and after it `ROOM` and the number of faces (4 bytes, little-endian) if charts were merged.
    ///
    /// # Errors
    /// The writer fails.
    pub fn write(&self, mesh: &TriMesh, writer: &mut dyn Write) -> std::io::Result<()> {
        self.log.write(mesh, writer)?;
        let Some(room) = self.room else { return Ok(()) };
        writer.write_all(ROOM)?;
        writer.write_all(&room.to_le_bytes())
    }

    /// Reads the record of a run on this mesh.
    ///
    /// # Errors
    /// The bytes are not a record, or belong to another mesh.
    pub fn read(mesh: &TriMesh, reader: &mut dyn Read) -> Result<Self, RecordError> {
        let log = CollapseLog::read(mesh, reader)?;
        let mut bytes = [0; 8];
        let room = match reader.read_exact(&mut bytes) {
            Ok(()) => bytes.split_first_chunk().filter(|(name, _)| *name == ROOM),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => None,
            Err(error) => return Err(error.into()),
        };
        let room = room.and_then(|(_, count)| count.try_into().ok()).map(u32::from_le_bytes);
        Ok(Self { log, room })
    }

    /// The attributes with the charts that the run has merged.
    #[must_use]
    pub fn attributes(&self, mesh: &TriMesh, attributes: Attributes) -> Attributes {
        let target = Target { faces: self.room.map(|room| room as usize), ..Target::default() };
        attributes.merge_charts(mesh, &target).unwrap_or(attributes)
    }
}

/// Errors of [`LevelSteps`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LevelError {
    /// A maximum error cannot be met.
    #[error(transparent)]
    Simplify(#[from] SimplifyError),
    /// The collapses belong to another mesh.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// A level has no faces to measure distances to.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The model does not match the mesh.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Number of samples on each surface.
pub(crate) const SAMPLES: usize = 200_000;

impl LevelPlan {
    /// The record of the run, with its collapses.
    #[must_use]
    pub fn record(&self, mesh: &TriMesh, log: CollapseLog) -> LevelRecord {
        let faces = self.options.target.face_target(mesh.topology().face_count());
        LevelRecord { log, room: self.attributes.merged().map(|_| as_u32(faces)) }
    }
}

impl LevelSteps {
    /// The limits of the collapse sequence, without the maximum error.
    #[must_use]
    pub fn limits(&self) -> Target {
        Target {
            ratio: self.ratios.iter().copied().reduce(f64::min),
            faces: self.faces.iter().copied().min(),
            ..Target::default()
        }
    }

    /// The largest of the error bounds.
    #[must_use]
    pub fn max_error(&self) -> Option<f64> {
        self.errors.iter().copied().reduce(f64::max)
    }

    /// The run for these levels. Charts are merged as [`Attributes::merge_charts`] does for the coarsest level, unless
    /// `keeps_seams`.
    ///
    /// # Errors
    /// As [`ConstraintChoices::constrain`].
    pub fn plan(
        &self,
        source: Source<'_>,
        options: Options,
        attributes: Attributes,
        (constraints, keeps_seams): (&ConstraintChoices, bool),
        check: ErrorCheck,
    ) -> Result<LevelPlan, ConstraintError> {
        let mut options = options.for_levels();
        let merged = (!keeps_seams).then(|| attributes.merge_charts(source.mesh, &options.target));
        let attributes = merged.flatten().unwrap_or(attributes);
        attributes.constrain(source.mesh, &mut options);
        let kept = constraints.constrain(source, &mut options)?;
        if let Some(error) = self.max_error() {
            options = options.within(error, check);
            // With decimation to the tolerance, the result would not be a stage of the run.
            options.tolerance.decimate = false;
        }
        Ok(LevelPlan { options, attributes, kept })
    }

    /// The wanted numbers of faces that even the coarsest of the levels exceeds.
    #[must_use]
    pub fn missed_faces(&self, mesh: &TriMesh, levels: &[LevelOfDetail]) -> Vec<usize> {
        let fewest = levels.last().map(|level| level.mesh.topology().face_count());
        self.wanted(mesh).filter(|&wanted| fewest.is_some_and(|fewest| wanted < fewest)).collect()
    }

    /// The wanted numbers of faces.
    fn wanted(&self, mesh: &TriMesh) -> impl Iterator<Item = usize> {
        let faces = mesh.topology().face_count() as f64;
        let of_ratios = self.ratios.iter().map(move |ratio| (ratio * faces).ceil() as usize);
        of_ratios.chain(self.faces.iter().copied())
    }

    /// The number of collapses of each level, ascending.
    ///
    /// # Errors
    /// As [`collapses_within`].
    pub fn stages(
        &self,
        log: &CollapseLog,
        mesh: &TriMesh,
        check: ErrorCheck,
    ) -> Result<Vec<usize>, SimplifyError> {
        let mut stages: Vec<usize> =
            self.wanted(mesh).map(|count| log.count_for_faces(count)).collect();
        for &error in &self.errors {
            stages.push(collapses_within(mesh, log, error, check)?);
        }
        stages.sort_unstable();
        Ok(stages)
    }

    /// The levels, from fine to coarse.
    ///
    /// # Errors
    /// The log belongs to another mesh, or the mesh has no faces.
    pub fn levels(
        &self,
        log: &CollapseLog,
        source: Source<'_>,
        attributes: &Attributes,
        check: ErrorCheck,
    ) -> Result<Vec<LevelOfDetail>, LevelError> {
        let original = Surface::new(source.mesh)?;
        let sampling = CompareOptions { samples: SAMPLES, ..CompareOptions::default() };
        let level = |collapses: usize| {
            let (mesh, became) = log.level(source.mesh, collapses)?;
            let model = attributes.carry(source, &mesh, &became)?;
            let distance = compare(&original, &Surface::new(&mesh)?, &sampling);
            Ok(LevelOfDetail { model, mesh, collapses, distance })
        };
        self.stages(log, source.mesh, check)?.into_iter().map(level).collect()
    }
}

/// The height of a usual screen in pixels.
const SCREEN: f64 = 1080.0;

/// For the input and each level, the share of the height of the screen that an object must cover for it to be shown:
/// where the largest error of the next one would exceed a pixel of 1080. The last level has no lower limit. `size` is the
/// diagonal of the object, and `errors` are the largest errors of the levels, from fine to coarse.
#[must_use]
pub fn shown_from(size: f64, errors: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut last = 1.0_f64;
    let mut all: Vec<f64> = errors
        .into_iter()
        .map(|error| {
            last = last.min(size / (SCREEN * error.max(f64::MIN_POSITIVE)));
            last
        })
        .collect();
    all.push(0.0);
    all
}
