//! A mesh together with the data that each flip updates.

use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, FaceTree, TriMesh};

use crate::cost::FlipCost;
use crate::quad::Quad;

/// The mesh, the cache of the cost and the tree of faces. A flip updates all three.
pub(crate) struct FlipState<'m, C: FlipCost> {
    pub(crate) cost: &'m C,
    pub(crate) mesh: &'m mut TriMesh,
    pub(crate) cache: &'m mut C::Cache,
    pub(crate) tree: Option<&'m mut FaceTree>,
}

impl<C: FlipCost> FlipState<'_, C> {
    /// Flips an edge and updates the cache and the tree.
    #[inline]
    pub(crate) fn flip(&mut self, flip: LegalFlip) -> Option<Quad> {
        let edge = flip.edge();
        self.mesh.flip(flip);
        let quad = Quad::around(self.mesh.topology(), edge)?;
        self.cost.update(self.mesh, self.cache, &quad);
        if let Some(tree) = &mut self.tree {
            tree.update(self.mesh, self.mesh.topology().edge_faces(edge).into_iter().flatten());
        }
        Some(quad)
    }

    /// Reverses the flip of an edge. Legal directly after that flip.
    pub(crate) fn flip_back(&mut self, edge: EdgeId) {
        if let Ok(flip) = self.mesh.topology().check_flip(edge) {
            self.flip(flip);
        }
    }
}
