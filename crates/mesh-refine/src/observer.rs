//! Who is told how far the work has come, and may stop it.

use core::ops::ControlFlow;

use mesh_core::TriMesh;

use mesh_collapse::{Phase, Progress};

/// What sees [`Progress`].
pub type Observe<'a> = dyn FnMut(&Progress) -> ControlFlow<()> + 'a;

/// An observer of all phases. Once it has said to stop, it is not asked again.
pub struct Observer<'a> {
    observe: Option<&'a mut Observe<'a>>,
    /// What was last said.
    now: Progress,
    is_stopped: bool,
}

impl<'a> Observer<'a> {
    /// For a simplification of so many faces to so many.
    pub fn new(faces_before: usize, face_target: usize, observe: &'a mut Observe<'a>) -> Self {
        let phase = Phase::Collapse;
        let now = Progress { phase, faces_before, faces: faces_before, face_target, collapses: 0 };
        Self { observe: Some(observe), now, is_stopped: false }
    }

    /// Nobody.
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

    /// Passes on what a run of collapses says.
    pub fn observe(&mut self, now: &Progress) -> ControlFlow<()> {
        self.now = *now;
        if let Some(observe) = &mut self.observe
            && !self.is_stopped
        {
            self.is_stopped = observe(now).is_break();
        }
        if self.is_stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The same for a run that is part of another phase.
    pub fn observe_in(&mut self, phase: Phase, now: &Progress) -> ControlFlow<()> {
        let faces = now.faces;
        self.observe(&Progress { phase, faces, ..self.now })
    }

    /// Says what is done now, and with which mesh; whether that is to stop.
    pub fn stops(&mut self, phase: Phase, mesh: &TriMesh) -> bool {
        let faces = mesh.topology().face_count();
        self.observe(&Progress { phase, faces, ..self.now }).is_break()
    }

    /// Whether it has said to stop.
    pub fn is_stopped(&self) -> bool {
        self.is_stopped
    }
}
