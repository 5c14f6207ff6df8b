//! Observers, which see the progress of a run and may stop it.

use core::ops::ControlFlow;

use mesh_core::TriMesh;

use mesh_collapse::{Phase, Progress};

/// A function that sees [`Progress`] and may stop the run.
pub type Observe<'a> = dyn FnMut(&Progress) -> ControlFlow<()> + 'a;

/// An observer of all phases. After it has stopped the run, it is not called again.
pub struct Observer<'a> {
    observe: Option<&'a mut Observe<'a>>,
    /// The last progress that was reported.
    now: Progress,
    is_stopped: bool,
}

impl<'a> Observer<'a> {
    /// The observer of a simplification from `faces_before` to `face_target` faces.
    pub fn new(faces_before: usize, face_target: usize, observe: &'a mut Observe<'a>) -> Self {
        let phase = Phase::Collapse;
        let now = Progress { phase, faces_before, faces: faces_before, face_target, collapses: 0 };
        Self { observe: Some(observe), now, is_stopped: false }
    }

    /// No observer.
    pub fn none() -> Self {
        let now = Progress {
            phase: Phase::Collapse,
            faces_before: 0,
            faces: 0,
            face_target: 0,
            collapses: 0,
        };
        Self { observe: None, now, is_stopped: false }
    }

    /// Passes on the progress of a run of collapses.
    pub fn observe(&mut self, now: &Progress) -> ControlFlow<()> {
        self.now = *now;
        if let Some(observe) = &mut self.observe
            && !self.is_stopped
        {
            self.is_stopped = observe(now).is_break();
        }
        if self.is_stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Passes on the progress of a run that is part of another phase.
    pub fn observe_in(&mut self, phase: Phase, now: &Progress) -> ControlFlow<()> {
        let faces = now.faces;
        self.observe(&Progress { phase, faces, ..self.now })
    }

    /// Reports the current phase and mesh, and returns whether the run is to stop.
    pub fn stops(&mut self, phase: Phase, mesh: &TriMesh) -> bool {
        let faces = mesh.topology().face_count();
        self.observe(&Progress { phase, faces, ..self.now }).is_break()
    }

    /// Whether the observer has stopped the run.
    pub fn is_stopped(&self) -> bool {
        self.is_stopped
    }
}
