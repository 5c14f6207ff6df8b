//! State of a run: the mesh, the cache of the cost, the rules and the log of flips.

use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, FaceTree, TriMesh};

use crate::blocked_edges::Rejection;
use crate::cost::{Change, FlipCost};
use crate::flip_state::FlipState;
use crate::quad::Quad;
use crate::report::Rejections;
use crate::rules::Rules;

/// State of a run. Greedy descent, look-ahead, annealing and rebuilding share it.
pub(crate) struct Run<'a, C: FlipCost> {
    pub(crate) mesh: &'a mut TriMesh,
    pub(crate) cache: C::Cache,
    pub(crate) tree: Option<FaceTree>,
    pub(crate) rules: Rules<'a, C>,
    pub(crate) rejected: Rejections,
    /// The flips so far, in order. Flipping them in reverse order undoes them.
    pub(crate) log: Vec<EdgeId>,
    /// Current cost: the initial cost minus the gains.
    pub(crate) running_cost: f64,
}

impl<'a, C: FlipCost> Run<'a, C> {
    pub(crate) fn new(mesh: &'a mut TriMesh, rules: Rules<'a, C>) -> Self {
        let cache = rules.cost.prepare(mesh);
        Self {
            running_cost: rules.cost.prepared_total(mesh, &cache),
            cache,
            tree: rules.options.forbid_intersections.then(|| FaceTree::new(mesh)),
            rules,
            rejected: Rejections::default(),
            log: Vec::new(),
            mesh,
        }
    }

    /// The rules, and the state for trial flips.
    #[inline]
    pub(crate) fn state(&mut self) -> (&Rules<'a, C>, FlipState<'_, C>) {
        let Self { mesh, cache, tree, rules, .. } = self;
        let cost = rules.cost;
        (&*rules, FlipState { cost, mesh, cache, tree: tree.as_mut() })
    }

    /// Cost of the whole mesh, computed from scratch.
    pub(crate) fn total(&self) -> f64 {
        self.rules.cost.total(self.mesh)
    }

    /// The quadrilateral of an edge that is neither locked nor on the boundary.
    #[inline]
    pub(crate) fn quad(&self, edge: EdgeId) -> Option<Quad> {
        self.rules.quad(self.mesh.topology(), edge)
    }

    /// The change that the flip of an edge would make, legal or not.
    #[inline]
    pub(crate) fn change(&self, edge: EdgeId) -> Option<Change> {
        self.rules.change(self.mesh, &self.cache, edge)
    }

    /// The change that the flip of an edge would make, legal or not, if it lowers the cost.
    #[inline]
    pub(crate) fn gainful_change(&self, edge: EdgeId) -> Option<Change> {
        let quad = self.quad(edge)?;
        let change = self.rules.cost.change_if_lower(self.mesh, &self.cache, &quad)?;
        self.rules.is_gain(change).then_some(change)
    }

    /// [`Run::gainful_change`] of several quadrilaterals. `changes` is as long as `quads`.
    pub(crate) fn gainful_changes(&self, quads: &[Option<Quad>], changes: &mut [Option<Change>]) {
        self.rules.cost.changes_if_lower(self.mesh, &self.cache, quads, changes);
        for change in changes {
            *change = change.filter(|&change| self.rules.is_gain(change));
        }
    }

    /// Whether an edge may flip: the check of the mesh and the constraints of the options.
    pub(crate) fn allow(&self, edge: EdgeId) -> Result<LegalFlip, Rejection> {
        self.rules.allow(self.mesh, self.tree.as_ref(), edge)
    }

    /// Undoes the last flip because flipping back would be a gain as well: both gains are rounding.
    pub(crate) fn undo_rounding(&mut self, change: Change) {
        self.undo_to(self.log.len() - 1);
        self.running_cost += change.gain();
        self.rejected.rounding += 1;
    }

    /// Flips an edge and counts the flip for the limit of flips per edge.
    #[inline]
    pub(crate) fn flip(&mut self, flip: LegalFlip, change: Change) -> Option<Quad> {
        self.rules.flips_of_edge[flip.edge()] += 1;
        self.record(flip, change)
    }

    /// Flips an edge and logs the flip. Does not count it for the limit of flips per edge.
    #[inline]
    pub(crate) fn record(&mut self, flip: LegalFlip, change: Change) -> Option<Quad> {
        self.log.push(flip.edge());
        self.running_cost -= change.gain();
        self.state().1.flip(flip)
    }

    /// Undoes all flips after the first `length`.
    pub(crate) fn undo_to(&mut self, length: usize) {
        while self.log.len() > length {
            if let Some(edge) = self.log.pop() {
                self.state().1.flip_back(edge);
            }
        }
    }

    /// Undoes all flips.
    pub(crate) fn start_over(&mut self, cost: f64, rejected: Rejections) {
        self.undo_to(0);
        self.forget_flips_of_edges();
        self.running_cost = cost;
        self.rejected = rejected;
    }

    /// Repeats flips that were made from this state before.
    pub(crate) fn repeat(&mut self, flips: &[EdgeId]) {
        for &edge in flips {
            if let Ok(flip) = self.mesh.topology().check_flip(edge) {
                self.flip(flip, Change::default());
            }
        }
    }

    /// Resets the count of flips of every edge.
    pub(crate) fn forget_flips_of_edges(&mut self) {
        self.rules.flips_of_edge.as_mut_slice().fill(0);
    }
}
