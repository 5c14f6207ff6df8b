//! Fitting, annealing and taking down peaks, one after the other.

use std::sync::Arc;

use mesh_core::{TriMesh, VertexId, VertexMap};
use mesh_metric::Surface;

use crate::collapse::constraint::{Boundary, Constraints, Marks};
use crate::collapse::level::Level;
use crate::error::SimplifyError;
use crate::finish::anneal::{AnnealOptions, AnnealReport, anneal_observed};
use crate::finish::curve::Curve;
use crate::finish::fit::constraints::FitConstraints;
use crate::finish::fit::{FitOptions, FitReport, fit_observed};
use crate::finish::observer::Observer;
use crate::finish::peaks::{PeakOptions, PeakReport, cut_peaks_observed};
use crate::finish::texture_fit::{Texture, TextureCheck, fit_unfolded};

/// A level and what was done with it since.
pub(crate) struct Finished {
    pub(crate) mesh: TriMesh,
    /// For each vertex of the level, the one that it has become; `None` when they are the same.
    pub(crate) vertex_map: Option<VertexMap<Option<VertexId>>>,
    pub(crate) fit: Option<FitReport>,
    pub(crate) anneal: Option<AnnealReport>,
    pub(crate) peaks: Option<PeakReport>,
    /// What holds for the mesh as it is now.
    pub(crate) constraints: FitConstraints,
}

impl Finished {
    /// A mesh with which nothing was done yet.
    pub(crate) fn untouched(mesh: TriMesh, constraints: FitConstraints) -> Self {
        Self { mesh, vertex_map: None, fit: None, anneal: None, peaks: None, constraints }
    }

    /// Goes on to the next mesh, unless more faces turn over in the texture there.
    fn take_unfolded(
        &mut self,
        next: TriMesh,
        then: &VertexMap<Option<VertexId>>,
        texture: Option<&TextureCheck<'_>>,
    ) -> bool {
        let before = self.vertex_map.clone();
        let folds = texture.map_or(0, |check| check.folded_after(&self.mesh, before.as_ref()));
        self.follow(then);
        let then = self.vertex_map.as_ref();
        if texture.is_some_and(|check| check.folded_after(&next, then) > folds) {
            self.vertex_map = before;
            return false;
        }
        self.mesh = next;
        true
    }

    /// Follows the vertices to what they have become in the next mesh.
    pub(crate) fn follow(&mut self, then: &VertexMap<Option<VertexId>>) {
        match &mut self.vertex_map {
            None => self.vertex_map = Some(then.clone()),
            Some(map) => map.as_mut_slice().iter_mut().for_each(|new| {
                *new = new.and_then(|v| then.get(v).copied().flatten());
            }),
        }
    }
}

/// What is done with a level.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Steps {
    pub(crate) fit: Option<FitOptions>,
    pub(crate) anneal: Option<AnnealOptions>,
    pub(crate) peaks: Option<PeakOptions>,
}

/// How levels of a mesh are finished.
pub(crate) struct Finishing<'a> {
    original: &'a Surface,
    /// The boundary and the feature lines of the original.
    curves: [Option<Arc<Curve>>; 2],
    steps: Steps,
    texture: Option<Texture<'a>>,
}

impl<'a> Finishing<'a> {
    /// For a mesh and its surface. With a texture, no step makes more faces turn over there.
    pub(crate) fn new(
        mesh: &TriMesh,
        original: &'a Surface,
        constraints: &Constraints,
        steps: Steps,
        texture: Option<Texture<'a>>,
    ) -> Self {
        let boundary = match constraints.boundary {
            Boundary::Lock => None,
            Boundary::Quadrics | Boundary::Free => Curve::boundary(mesh),
        };
        let features = constraints.features.as_ref().and_then(|features| {
            Curve::of_edges(mesh, |e| features.get(e).is_some_and(|&feature| feature))
        });
        let curves = [boundary, features].map(|curve| curve.map(Arc::new));
        Self { original, curves, steps, texture }
    }

    /// A level as it is, and what the vertices of the original are in it.
    pub(crate) fn leave(&self, level: Level) -> (Finished, VertexMap<Option<VertexId>>) {
        let constraints = self.constraints(level.marks);
        (Finished::untouched(level.mesh, constraints), level.became)
    }

    /// Fits, anneals and takes down peaks, as far as that is wanted and the observer lets it. Also tells
    /// what the vertices of the original are in the level.
    pub(crate) fn finish(
        &self,
        level: Level,
        observer: &mut Observer<'_>,
    ) -> Result<(Finished, VertexMap<Option<VertexId>>), SimplifyError> {
        let Level { mesh, marks, became } = level;
        let mut constraints = self.constraints(marks);
        let unchanged = constraints.clone();
        let texture = self.texture.as_ref().map(|texture| texture.check(&became));
        let mut done = Finished::untouched(mesh, FitConstraints::default());
        if let Some(options) = &self.steps.fit {
            done.fit = Some(match &texture {
                Some(check) => {
                    let mesh = &mut done.mesh;
                    fit_unfolded(mesh, self.original, &constraints, options, check, observer)?
                }
                None => {
                    fit_observed(&mut done.mesh, self.original, &constraints, options, observer)?
                }
            });
        }
        if let Some(options) = &self.steps.anneal
            && options.has_work(&done.mesh, self.original)
            && !observer.is_stopped()
        {
            let mut next = done.mesh.clone();
            let report =
                anneal_observed(&mut next, self.original, &mut constraints, options, observer)?;
            if done.take_unfolded(next, &report.vertex_map, texture.as_ref()) {
                done.anneal = Some(report);
            } else {
                constraints.clone_from(&unchanged);
            }
        }
        if let Some(options) = &self.steps.peaks
            && !observer.is_stopped()
        {
            let original = self.original;
            if texture.is_some() {
                let mut next = done.mesh.clone();
                let report =
                    cut_peaks_observed(&mut next, original, &mut constraints, options, observer)?;
                if done.take_unfolded(next, &report.vertex_map, texture.as_ref()) {
                    done.peaks = Some(report);
                }
            } else {
                // There is nothing to go back for.
                let mesh = &mut done.mesh;
                let report =
                    cut_peaks_observed(mesh, original, &mut constraints, options, observer)?;
                done.follow(&report.vertex_map);
                done.peaks = Some(report);
            }
        }
        done.constraints = constraints;
        Ok((done, became))
    }

    fn constraints(&self, Marks { locked, features, guards }: Marks) -> FitConstraints {
        let [boundary_curve, feature_curve] = self.curves.clone();
        FitConstraints { fixed: locked, features, boundary_curve, feature_curve, guards }
    }
}
