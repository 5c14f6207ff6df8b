//! What a scene is simplified to, how, and why it cannot be.

use mesh_core::build::{BuildError, Repair};
use mesh_io::{ModelError, Quantization, ReadError, Scene, WriteError};
use mesh_metric::SurfaceError;
use simplify::{ReplayError, SimplifyError};

use crate::attributes::AttributeRules;
use crate::length::{Length, NoExtent};
use crate::policy::Choices;

/// How a scene is simplified.
#[derive(Clone, Debug)]
pub struct SceneRules {
    /// When to stop.
    pub target: SceneTarget,
    /// What shares a number of faces.
    pub budget: SceneBudget,
    /// How each mesh is simplified.
    pub choices: Choices,
    /// How attributes are weighted and transferred.
    pub attributes: AttributeRules,
    /// Whether all borders of texture charts, materials and primitives stay, even if the shape suffers.
    pub keep_seams: bool,
    /// The number of poses in which the errors of a mesh with a skin or morph targets count, besides the pose of the
    /// file; 0 for that one only. They are the shapes that differ most, of the nodes as they are, the morph targets,
    /// and the key frames of animations.
    pub poses: usize,
    /// How the data of vertices will be rounded when the result is written. Error limits and errors include it.
    pub quantization: Option<Quantization>,
    /// The repairs of the meshes. Vertices at equal positions are welded unless a weld is given.
    pub repair: Repair,
    /// Whether repairs that a mesh needs are made besides.
    pub needed_repairs: bool,
    /// Whether vertices that the format splits are joined.
    pub join: bool,
}

/// More poses lower the errors in other poses hardly further.
const POSES: usize = 8;

impl Default for SceneRules {
    fn default() -> Self {
        Self {
            target: SceneTarget::default(),
            budget: SceneBudget::default(),
            choices: Choices::default(),
            attributes: AttributeRules::default(),
            keep_seams: false,
            poses: POSES,
            quantization: None,
            repair: Repair::strict(),
            needed_repairs: true,
            join: true,
        }
    }
}

/// The largest growth of the box of a mesh that an error limit allows for.
const GROWTH: f64 = 1.1;

impl SceneRules {
    /// The bound of the rounding of each mesh of a scene; all are 0 if it will not be rounded.
    pub(super) fn rounding(&self, scene: &Scene) -> Result<Vec<f64>, SceneError> {
        Ok(match &self.quantization {
            Some(quantization) => scene.quantization_bounds(quantization)?,
            None => vec![0.0; scene.mesh_count()],
        })
    }

    /// What rounding leaves of an error limit.
    pub(super) fn without_rounding(&self, limit: f64, scene: &Scene) -> Result<f64, SceneError> {
        let rounding = self.rounding(scene)?.into_iter().fold(0.0, f64::max);
        // Fitting can make the box of a result a little larger than that of the input, and its grid coarser.
        let rounding = GROWTH * rounding;
        if rounding == 0.0 || limit > rounding {
            Ok(limit - rounding)
        } else {
            Err(SceneError::Rounding { limit, rounding })
        }
    }
}

/// The targets of the simplification of a scene. It stops at the first target that is reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneTarget {
    /// The number of faces that are drawn. A mesh that is drawn twice counts twice.
    pub faces: Option<usize>,
    /// The share of the faces.
    pub ratio: Option<f64>,
    /// The largest distance from the input, in units of the scene. A percentage is a share of the diagonal of the
    /// bounding box of the scene.
    pub max_error: Option<Length>,
    /// Whether a plain distance is a share of the diagonal as well.
    pub relative: bool,
}

/// What shares a number of faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SceneBudget {
    /// The scene: the squared distance from the input, over all surfaces as they are drawn, is least.
    #[default]
    Scene,
    /// Each mesh by itself: the target is for every mesh.
    Mesh,
    /// Each node that draws a mesh: the target applies to what the node draws. Nodes that draw the same mesh share one
    /// result where their results are equal. Nodes with other scales or numbers of instances get a mesh of their own.
    Node,
}

/// Why a scene cannot be simplified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The data of a mesh cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A mesh cannot be built.
    #[error("mesh {mesh}: {source}")]
    Build {
        /// The mesh.
        mesh: usize,
        /// The defect.
        source: Box<BuildError>,
    },
    /// A mesh cannot be simplified as asked.
    #[error("mesh {mesh}: {source}")]
    Simplify {
        /// The mesh.
        mesh: usize,
        /// The reason.
        source: SimplifyError,
    },
    /// The collapses of a mesh cannot be repeated.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// The error of a mesh cannot be measured.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The data of a mesh are inconsistent.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The result does not fit into the scene.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The rounding of the result takes all of an error limit.
    #[error(
        "the error limit {limit:.3e} leaves nothing for the simplification: rounding moves vertices by up to {rounding:.3e}; raise the limit, or take more bits"
    )]
    Rounding {
        /// The error limit, in units of the scene.
        limit: f64,
        /// The bound of the rounding.
        rounding: f64,
    },
    /// A length is relative to a scene without extent.
    #[error(transparent)]
    NoExtent(#[from] NoExtent),
}
