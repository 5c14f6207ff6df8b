//! A mesh to try flips on, with all that follows it: flips are done, measured, and undone.

use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, FaceTree, TriMesh};

use crate::cost::FlipCost;
use crate::quad::Quad;

/// The mesh, the cost's cache and the tree of faces, which a flip changes together.
pub(crate) struct Trial<'m, C: FlipCost> {
    pub(crate) cost: &'m C,
    pub(crate) mesh: &'m mut TriMesh,
    pub(crate) cache: &'m mut C::Cache,
    pub(crate) tree: Option<&'m mut FaceTree>,
}

impl<C: FlipCost> Trial<'_, C> {
    /// Flips an edge and brings everything that follows the mesh up to date.
    #[inline]
    pub(crate) fn turn(&mut self, flip: LegalFlip) -> Option<Quad> {
        let edge = flip.edge();
        self.mesh.flip(flip);
        let quad = Quad::around(self.mesh.topology(), edge)?;
        self.cost.update(self.mesh, self.cache, &quad);
        if let Some(tree) = &mut self.tree {
            tree.update(self.mesh, self.mesh.topology().edge_faces(edge).into_iter().flatten());
        }
        Some(quad)
    }

    /// Flips an edge back, which is legal in the state that its flip has led to.
    pub(crate) fn turn_back(&mut self, edge: EdgeId) {
        if let Ok(flip) = self.mesh.topology().check_flip(edge) {
            self.turn(flip);
        }
    }
}
