//! One line of the study: a mesh, a program and its errors.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// An estimator of ours. Lengths are in mean edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Ours {
    Auto,
    Vertex,
    FitNearest,
    Fit2Rings,
    Fit3Edges,
    Ball4Edges,
    Corrected4Edges,
    Face,
}

impl Ours {
    /// The name in the tables.
    #[must_use]
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Vertex => "vertex",
            Self::FitNearest => "fit",
            Self::Fit2Rings => "fit, 2 rings",
            Self::Fit3Edges => "fit, 3 edges",
            Self::Ball4Edges => "ball, 4 edges",
            Self::Corrected4Edges => "corrected, 4 edges",
            Self::Face => "face",
        }
    }
}

/// One line of the study. Errors of curvatures are relative, angles in degrees.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) surface: String,
    pub(super) sampling: String,
    pub(super) vertices: usize,
    pub(super) noise: f64,
    pub(super) program: String,
    /// Errors of the principal curvatures: the median and the 95th percentile.
    pub(super) k_median: f64,
    pub(super) k_95: f64,
    /// Errors of the mean and of the Gaussian curvature.
    pub(super) mean_median: f64,
    pub(super) gaussian_median: f64,
    /// Angle to the exact direction of the larger curvature where the curvatures differ; NaN if not estimated.
    pub(super) direction_median: f64,
    pub(super) normal_median: f64,
    /// Share of vertices without an estimate.
    pub(super) unknown: f64,
    /// Share of vertices whose error is within the predicted one; NaN without predictions.
    pub(super) within: f64,
    /// Processor time.
    pub(super) seconds: f64,
}

/// Surface, sampling, vertices and noise.
pub(super) type Cell = (String, String, usize, String);

/// Surface, sampling, vertices, noise and program.
pub(super) type Key = (String, String, usize, String, String);

impl Row {
    pub(super) fn key(&self) -> Key {
        let Self { surface, sampling, vertices, noise, program, .. } = self;
        (surface.clone(), sampling.clone(), *vertices, noise.to_string(), program.clone())
    }

    /// The mesh, without the program.
    pub(super) fn cell(&self) -> Cell {
        let (surface, sampling, vertices, noise, _) = self.key();
        (surface, sampling, vertices, noise)
    }

    pub(super) fn is_ours(&self) -> bool {
        Ours::value_variants().iter().any(|ours| ours.name() == self.program)
    }
}
