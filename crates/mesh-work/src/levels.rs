//! Levels of detail: stages of one run of collapses, with their content and their errors.

use mesh_core::TriMesh;
use mesh_io::{Model, ModelError};
use mesh_metric::{CompareOptions, Comparison, Surface, SurfaceError, compare};
use simplify::{CollapseLog, ErrorCheck, ReplayError, SimplifyError, Target, collapses_within};

use crate::attributes::Attributes;
use crate::loaded::Source;

/// Which levels there are to be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelSteps {
    /// Levels with these parts of the faces of the input.
    pub ratios: Vec<f64>,
    /// Levels with so many faces, or one fewer.
    pub faces: Vec<usize>,
    /// The coarsest levels within these distances of the input, in model units.
    pub errors: Vec<f64>,
}

/// A level of detail.
#[derive(Clone, Debug)]
pub struct LevelOfDetail {
    /// Its content.
    pub model: Model,
    /// The mesh.
    pub mesh: TriMesh,
    /// After how many collapses.
    pub collapses: usize,
    /// Its distance from the input, which comes first.
    pub distance: Comparison,
}

/// Why there are no levels.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LevelError {
    /// A largest error cannot be kept.
    #[error(transparent)]
    Simplify(#[from] SimplifyError),
    /// The collapses are those of another mesh.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// A level has no surface that distances could be measured to.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The content does not fit the mesh.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// How many samples of each surface are compared.
const SAMPLES: usize = 200_000;

impl LevelSteps {
    /// How far the run has to go, but for a largest error.
    #[must_use]
    pub fn limits(&self) -> Target {
        Target {
            ratio: self.ratios.iter().copied().reduce(f64::min),
            faces: self.faces.iter().copied().min(),
            ..Target::default()
        }
    }

    /// The largest of the errors.
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
    /// The log is that of another mesh, or the mesh has no faces.
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
