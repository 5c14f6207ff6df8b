//! A run: the mesh, the cost's cache, the rules, and the flips done so far.

use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, FaceTree, TriMesh};

use crate::cost::{Change, FlipCost};
use crate::quad::Quad;
use crate::report::Refused;
use crate::rules::Rules;
use crate::trial::Trial;
use crate::waiting::Refusal;

/// The state of a run, which the greedy run, look-ahead and annealing share.
pub(crate) struct Run<'a, C: FlipCost> {
    pub(crate) mesh: &'a mut TriMesh,
    pub(crate) cache: C::Cache,
    pub(crate) tree: Option<FaceTree>,
    pub(crate) rules: Rules<'a, C>,
    pub(crate) refused: Refused,
    /// The flips so far, in order. Flipping them again from the last to the first undoes them.
    pub(crate) log: Vec<EdgeId>,
    /// The cost so far, added up from the gains.
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
            refused: Refused::default(),
            log: Vec::new(),
            mesh,
        }
    }

    /// The rules, and the mesh to try flips on.
    #[inline]
    pub(crate) fn trial(&mut self) -> (&Rules<'a, C>, Trial<'_, C>) {
        let Self { mesh, cache, tree, rules, .. } = self;
        let cost = rules.cost;
        (&*rules, Trial { cost, mesh, cache, tree: tree.as_mut() })
    }

    /// The cost of the whole mesh, computed afresh.
    pub(crate) fn total(&self) -> f64 {
        self.rules.cost.total(self.mesh)
    }

    /// The quadrilateral of an edge that may flip as far as locks and boundary go.
    #[inline]
    pub(crate) fn quad(&self, edge: EdgeId) -> Option<Quad> {
        self.rules.quad(self.mesh.topology(), edge)
    }

    /// What the flip of an edge would change, legal or not.
    #[inline]
    pub(crate) fn change(&self, edge: EdgeId) -> Option<Change> {
        self.rules.change(self.mesh, &self.cache, edge)
    }

    /// What the flip of an edge would change, legal or not, if it lowers the cost.
    #[inline]
    pub(crate) fn gainful_change(&self, edge: EdgeId) -> Option<Change> {
        let quad = self.quad(edge)?;
        let change = self.rules.cost.change_if_lower(self.mesh, &self.cache, &quad)?;
        self.rules.is_gain(change).then_some(change)
    }

    /// [`Run::gainful_change`] of several edges; `changes` is as long as `quads`, which are theirs.
    pub(crate) fn gainful_changes(&self, quads: &[Option<Quad>], changes: &mut [Option<Change>]) {
        self.rules.cost.changes_if_lower(self.mesh, &self.cache, quads, changes);
        for change in changes {
            *change = change.filter(|&change| self.rules.is_gain(change));
        }
    }

    /// Whether an edge may flip: the check of the mesh, and the guards that were asked for.
    pub(crate) fn allow(&self, edge: EdgeId) -> Result<LegalFlip, Refusal> {
        self.rules.allow(self.mesh, self.tree.as_ref(), edge)
    }

    /// Undoes the last flip, whose way back would be a gain, too: both gains are rounding.
    pub(crate) fn undo_rounding(&mut self, change: Change) {
        self.undo_to(self.log.len() - 1);
        self.running_cost += change.gain();
        self.refused.rounding += 1;
    }

    /// Flips an edge for good.
    #[inline]
    pub(crate) fn flip(&mut self, flip: LegalFlip, change: Change) -> Option<Quad> {
        self.rules.flips_of_edge[flip.edge()] += 1;
        self.record(flip, change)
    }

    /// Flips an edge and notes it, but not for the limit of flips per edge.
    #[inline]
    pub(crate) fn record(&mut self, flip: LegalFlip, change: Change) -> Option<Quad> {
        self.log.push(flip.edge());
        self.running_cost -= change.gain();
        self.trial().1.turn(flip)
    }

    /// Undoes all flips after the first `length`.
    pub(crate) fn undo_to(&mut self, length: usize) {
        while self.log.len() > length {
            if let Some(edge) = self.log.pop() {
                self.trial().1.turn_back(edge);
            }
        }
    }

    /// Undoes everything.
    pub(crate) fn start_over(&mut self, cost: f64, refused: Refused) {
        self.undo_to(0);
        self.forget_flips_of_edges();
        self.running_cost = cost;
        self.refused = refused;
    }

    /// Does flips again that were done from this state before.
    pub(crate) fn repeat(&mut self, flips: &[EdgeId]) {
        for &edge in flips {
            if let Ok(flip) = self.mesh.topology().check_flip(edge) {
                self.flip(flip, Change::default());
            }
        }
    }

    /// Lets every edge flip again as often as at the beginning.
    pub(crate) fn forget_flips_of_edges(&mut self) {
        self.rules.flips_of_edge.as_mut_slice().fill(0);
    }
}
