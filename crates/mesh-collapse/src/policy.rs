//! The common interface of all policies: they follow the mesh.

use core::any::Any;

use mesh_core::{Remap, TriMesh};

use crate::geometry::edge_patch::Collapse;

/// A cost, placement, cost modifier or constraint. A run queries it, and reports its collapses to it.
///
/// A policy that stores data per vertex updates it here. A policy without data needs only `impl Policy for Mine {}`.
/// Queries cannot change the policy, so that many edges can be evaluated in parallel; they get working memory as
/// [`Scratch`].
pub trait Policy: Send + Sync {
    /// Called once, before any query.
    fn prepare(&mut self, mesh: &TriMesh) {
        let _ = mesh;
    }

    /// Called after each collapse, with the mesh in its new state.
    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        let _ = (mesh, collapse);
    }

    /// Called after the gaps of collapses were closed, with the mesh in its new state. Data stored by handle must move
    /// to the new handles. Vertices that are unknown after that were added to the mesh later.
    fn compacted(&mut self, mesh: &TriMesh, remap: &Remap) {
        let _ = (mesh, remap);
    }
}

/// The data of a patch that the choice of a cost or a position uses. Less data is faster: faces are then collected only
/// for edges that are nearly certain to collapse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// The edge and its ends, and the mesh.
    Ends,
    /// In addition, sums over the faces: [`EdgePatch::face_quadric`](crate::EdgePatch::face_quadric) and
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

/// Working memory of evaluations, so that they need not allocate.
///
/// Each thread has its own. It contains what an earlier evaluation, of any edge, has left.
#[derive(Default)]
pub struct Scratch {
    slots: Vec<Box<dyn Any + Send>>,
}

impl Scratch {
    /// The memory of this type, created at the first call.
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
