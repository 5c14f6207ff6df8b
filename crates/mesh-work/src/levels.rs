//! Levels of detail: stages of one sequence of edge collapses, with attributes and errors.

use std::io::{ErrorKind, Read, Write};

use mesh_core::{Checksum, TriMesh, as_u32};
use mesh_io::{Model, ModelError};
use mesh_metric::{CompareOptions, Comparison, Surface, SurfaceError, compare};
use simplify::{
    CollapseLog, ErrorCheck, FaceLimits, Options, RecordError, SimplifyError, Stages, Target,
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
    /// The limits on new faces.
    pub limits: FaceLimits,
}

/// What stands for "no charts were merged" in a record.
const NO_ROOM: u32 = u32::MAX;

impl LevelRecord {
    /// Writes the log as [`CollapseLog::write`] does, and after it, in little-endian order:
    ///
    /// | bytes | what |
    /// |---|---|
    /// | 4 | the number of faces that charts were merged for, 2³² - 1 if none were |
    /// | 8, 8 | the greatest length of an edge and the smallest angle in radians, NaN for no limit |
    /// | 4 | the greatest valence, 0 for no limit |
    /// | 8 | the checksum [`Checksum`] of all bytes before |
    ///
    /// # Errors
    /// The writer fails.
    pub fn write(&self, mesh: &TriMesh, writer: &mut dyn Write) -> std::io::Result<()> {
        let mut summing = Summing { inner: writer, sum: Checksum::default() };
        self.log.write(mesh, &mut summing)?;
        summing.write_all(&self.room.unwrap_or(NO_ROOM).to_le_bytes())?;
        let FaceLimits { max_edge, min_angle, max_valence } = self.limits;
        for number in [max_edge, min_angle] {
            summing.write_all(&number.unwrap_or(f64::NAN).to_le_bytes())?;
        }
        summing.write_all(&max_valence.map_or(0, as_u32).to_le_bytes())?;
        let sum = summing.sum.value();
        summing.inner.write_all(&sum.to_le_bytes())
    }

    /// Reads the record of a run on this mesh.
    ///
    /// # Errors
    /// The bytes are not a record, do not match their checksum, or belong to another mesh.
    pub fn read(mesh: &TriMesh, reader: &mut dyn Read) -> Result<Self, RecordError> {
        let mut summing = Summing { inner: reader, sum: Checksum::default() };
        let log = CollapseLog::read(mesh, &mut summing)?;
        let room = u32::from_le_bytes(next(&mut summing)?);
        let max_edge = f64::from_le_bytes(next(&mut summing)?);
        let min_angle = f64::from_le_bytes(next(&mut summing)?);
        let max_valence = u32::from_le_bytes(next(&mut summing)?);
        let sum = summing.sum.value();
        if u64::from_le_bytes(next(summing.inner)?) != sum {
            return Err(RecordError::Damaged);
        }
        let limits = FaceLimits {
            max_edge: Some(max_edge).filter(|length| !length.is_nan()),
            min_angle: Some(min_angle).filter(|angle| !angle.is_nan()),
            max_valence: Some(max_valence as usize).filter(|&count| count > 0),
        };
        Ok(Self { log, room: Some(room).filter(|&room| room != NO_ROOM), limits })
    }

    /// The attributes with the charts that the run has merged.
    #[must_use]
    pub fn attributes(&self, mesh: &TriMesh, attributes: Attributes) -> Attributes {
        let target = Target { faces: self.room.map(|room| room as usize), ..Target::default() };
        attributes.merge_charts(mesh, &target).unwrap_or(attributes)
    }
}

/// The next bytes of a record.
fn next<const N: usize>(reader: &mut dyn Read) -> Result<[u8; N], RecordError> {
    let mut bytes = [0; N];
    match reader.read_exact(&mut bytes) {
        Ok(()) => Ok(bytes),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Err(RecordError::Damaged),
        Err(error) => Err(error.into()),
    }
}

/// A reader or writer with the checksum of the bytes that pass through it.
struct Summing<'i, T: ?Sized> {
    inner: &'i mut T,
    sum: Checksum,
}

impl Write for Summing<'_, dyn Write + '_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = self.inner.write(bytes)?;
        self.sum.add(bytes.get(..count).unwrap_or_default());
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

impl Read for Summing<'_, dyn Read + '_> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let count = self.inner.read(bytes)?;
        self.sum.add(bytes.get(..count).unwrap_or_default());
        Ok(count)
    }
}

/// The stages of a run with these attributes and limits on faces.
pub(crate) fn stages_of<'a>(
    mesh: &'a TriMesh,
    log: &'a CollapseLog,
    attributes: &Attributes,
    limits: FaceLimits,
) -> Stages<'a> {
    let mut options = Options::default();
    attributes.constrain(mesh, &mut options);
    options.protect.limits = limits;
    Stages::new(mesh, log, options)
}

/// Errors of [`LevelSteps`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LevelError {
    /// A maximum error cannot be met, or the collapses belong to another mesh.
    #[error(transparent)]
    Simplify(#[from] SimplifyError),
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
        let limits = self.options.protect.limits;
        LevelRecord { log, room: self.attributes.merged().map(|_| as_u32(faces)), limits }
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
    /// As [`Stages::within`].
    fn counts(
        &self,
        record: &LevelRecord,
        mesh: &TriMesh,
        stages: &Stages<'_>,
        check: ErrorCheck,
    ) -> Result<Vec<usize>, SimplifyError> {
        let mut counts: Vec<usize> =
            self.wanted(mesh).map(|count| record.log.count_for_faces(count)).collect();
        for &error in &self.errors {
            counts.push(stages.within(error, check)?);
        }
        counts.sort_unstable();
        Ok(counts)
    }

    /// The levels, from fine to coarse: [`Stages`] of the run.
    ///
    /// # Errors
    /// The record belongs to another mesh, or the mesh has no faces.
    pub fn levels(
        &self,
        record: &LevelRecord,
        source: Source<'_>,
        attributes: &Attributes,
        check: ErrorCheck,
    ) -> Result<Vec<LevelOfDetail>, LevelError> {
        let original = Surface::new(source.mesh)?;
        let sampling = CompareOptions { samples: SAMPLES, ..CompareOptions::default() };
        let stages = stages_of(source.mesh, &record.log, attributes, record.limits);
        let level = |collapses: usize| {
            let (mesh, became) = stages.level(collapses)?;
            let model = attributes.carry(source, &mesh, &became)?;
            let distance = compare(&original, &Surface::new(&mesh)?, &sampling);
            Ok(LevelOfDetail { model, mesh, collapses, distance })
        };
        self.counts(record, source.mesh, &stages, check)?.into_iter().map(level).collect()
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
