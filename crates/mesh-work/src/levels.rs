//! Levels of detail: stages of one sequence of edge collapses, with attributes and errors.

use mesh_core::TriMesh;
use mesh_io::{Model, ModelError};
use mesh_metric::{CompareOptions, Comparison, Surface, SurfaceError, compare};
use simplify::{CollapseLog, ErrorCheck, ReplayError, SimplifyError, Target, collapses_within};

use crate::attributes::Attributes;
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
        let faces = mesh.topology().face_count() as f64;
        let of_ratios = self.ratios.iter().map(|ratio| (ratio * faces).ceil() as usize);
        let counts = of_ratios.chain(self.faces.iter().copied());
        let mut stages: Vec<usize> = counts.map(|count| log.count_for_faces(count)).collect();
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
