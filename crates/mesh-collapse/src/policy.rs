//! What all policies of a run have in common: they follow the mesh.

use core::any::Any;

use mesh_core::{Remap, TriMesh};

use crate::geometry::edge_patch::Collapse;

/// A cost, placement, cost modifier or constraint: something that a run asks, and tells what it does.
///
/// A policy that keeps something per vertex brings it up to date here. One that keeps nothing needs
/// no more than `impl Policy for Mine {}`. Nothing in it may be changed while it is asked, so that
/// many edges can be looked at side by side: memory to work in is handed over as [`Scratch`].
pub trait Policy: Send + Sync {
    /// Called once, before anything is asked for.
    fn prepare(&mut self, mesh: &TriMesh) {
        let _ = mesh;
    }

    /// Called after each collapse, with the mesh as it is then.
    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        let _ = (mesh, collapse);
    }

    /// Called when the gaps that collapses leave were closed, with the mesh as it is then: whatever is
    /// kept by handle moves to the new ones. Vertices that are not known after that have been put
    /// into the mesh since.
    fn compacted(&mut self, mesh: &TriMesh, remap: &Remap) {
        let _ = (mesh, remap);
    }
}

/// What of a patch the choice of a cost or a place looks at. Less is quicker: the faces are collected for no
/// edge but those that are as good as chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// The edge and its ends, and the mesh.
    Ends,
    /// Besides, what the faces add up to: [`EdgePatch::face_quadric`](crate::EdgePatch::face_quadric) and
    /// [`EdgePatch::volume_plane`](crate::EdgePatch::volume_plane).
    Sums,
    /// The faces.
    Faces,
}

impl<P: Policy + ?Sized> Policy for Box<P> {
    fn prepare(&mut self, mesh: &TriMesh) {
        (**self).prepare(mesh);
    }

    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        (**self).collapsed(mesh, collapse);
    }

    fn compacted(&mut self, mesh: &TriMesh, remap: &Remap) {
        (**self).compacted(mesh, remap);
    }
}

/// Memory that an evaluation may write to, so that it allocates nothing of its own.
///
/// Each thread has one. What is in it is whatever an evaluation, of any edge, has left there.
#[derive(Default)]
pub struct Scratch {
    slots: Vec<Box<dyn Any + Send>>,
}

impl Scratch {
    /// The memory of a type, made when it is asked for first.
    pub fn get<T: Default + Send + 'static>(&mut self) -> &mut T {
        let known = self.slots.iter().position(|slot| slot.is::<T>());
        let index = known.unwrap_or_else(|| {
            self.slots.push(Box::<T>::default());
            self.slots.len() - 1
        });
        #[expect(clippy::expect_used, reason = "the slot at this index is of this type")]
        self.slots[index].downcast_mut().expect("a slot of this type")
    }
}
