//! A run: the mesh, the cost's cache, the guards, and the flips done so far.

use mesh_core::edit::LegalFlip;
use mesh_core::{EdgeId, EdgeMap, FaceTree, TriMesh};

use crate::cost::{Change, FlipCost};
use crate::features::locked_edges;
use crate::fold::{flattens, folds};
use crate::intersection::crossed_by_flip;
use crate::options::FlipOptions;
use crate::quad::Quad;
use crate::report::Refused;
use crate::waiting::Refusal;

/// The state of a run, which the greedy run, look-ahead and annealing share.
pub(crate) struct Run<'a, C: FlipCost> {
    pub(crate) mesh: &'a mut TriMesh,
    pub(crate) cost: &'a C,
    pub(crate) cache: C::Cache,
    pub(crate) options: &'a FlipOptions,
    pub(crate) locked: EdgeMap<bool>,
    pub(crate) refused: Refused,
    /// The flips so far, in order. Flipping them again from the last to the first undoes them.
    pub(crate) log: Vec<EdgeId>,
    /// The cost so far, added up from the gains.
    pub(crate) running_cost: f64,
    flips_of_edge: EdgeMap<u32>,
    tree: Option<FaceTree>,
    /// Smaller gains are rounding.
    noise: f64,
    /// Smaller distances are rounding.
    resolution: f64,
    max_flips_per_edge: u32,
}

impl<'a, C: FlipCost> Run<'a, C> {
    pub(crate) fn new(mesh: &'a mut TriMesh, cost: &'a C, options: &'a FlipOptions) -> Self {
        let cache = cost.prepare(mesh);
        Self {
            running_cost: cost.prepared_total(mesh, &cache),
            cache,
            cost,
            options,
            locked: locked_edges(mesh, options),
            refused: Refused::default(),
            log: Vec::new(),
            flips_of_edge: mesh.topology().edge_map(0),
            tree: options.forbid_intersections.then(|| FaceTree::new(mesh)),
            noise: noise_floor(mesh, cost.length_exponent()),
            resolution: resolution(mesh),
            max_flips_per_edge: options.max_flips_per_edge.unwrap_or(if cost.is_potential() {
                FLIPS_PER_EDGE
            } else {
                FLIPS_PER_EDGE_IN_CIRCLES
            }),
            mesh,
        }
    }

    /// The quadrilateral of an edge that may flip as far as locks and boundary go.
    #[inline]
    pub(crate) fn quad(&self, edge: EdgeId) -> Option<Quad> {
        let topology = self.mesh.topology();
        if self.locked[edge] || !topology.contains_edge(edge) {
            return None;
        }
        Quad::around(topology, edge)
    }

    /// What the flip of an edge would change, legal or not.
    #[inline]
    pub(crate) fn change(&self, edge: EdgeId) -> Option<Change> {
        self.quad(edge).map(|quad| self.cost.change(self.mesh, &self.cache, &quad))
    }

    /// What the flip of an edge would change, legal or not, if it lowers the cost.
    #[inline]
    pub(crate) fn gainful_change(&self, edge: EdgeId) -> Option<Change> {
        let quad = self.quad(edge)?;
        let change = self.cost.change_if_lower(self.mesh, &self.cache, &quad)?;
        self.is_gain(change).then_some(change)
    }

    /// [`Run::gainful_change`] of several edges; `changes` is as long as `quads`, which are theirs.
    pub(crate) fn gainful_changes(&self, quads: &[Option<Quad>], changes: &mut [Option<Change>]) {
        self.cost.changes_if_lower(self.mesh, &self.cache, quads, changes);
        for change in changes {
            *change = change.filter(|&change| self.is_gain(change));
        }
    }

    /// Whether a change lowers the cost by more than rounding. Never for NaN.
    #[inline]
    pub(crate) fn is_gain(&self, change: Change) -> bool {
        change.gain() > self.noise + RELATIVE_NOISE * (change.before.abs() + change.after.abs())
    }

    /// Whether an edge may flip: the check of the mesh, and the guards that were asked for.
    pub(crate) fn allow(&self, edge: EdgeId) -> Result<LegalFlip, Refusal> {
        let quad = self.quad(edge).ok_or(Refusal::Never)?;
        let flip = self.mesh.topology().check_flip(edge)?;
        if self.flips_of_edge[edge] >= self.max_flips_per_edge {
            return Err(Refusal::Cycle);
        }
        if flattens(self.mesh, &quad, self.resolution) {
            return Err(Refusal::Flat);
        }
        if self.options.max_fold.is_some_and(|limit| folds(self.mesh, &quad, limit)) {
            return Err(Refusal::Fold);
        }
        match self.tree.as_ref().and_then(|tree| crossed_by_flip(tree, self.mesh, &quad)) {
            Some(face) => Err(Refusal::Intersection(face)),
            None => Ok(flip),
        }
    }

    /// Flips an edge and brings everything that follows the mesh up to date, but keeps no record.
    #[inline]
    pub(crate) fn turn(&mut self, flip: LegalFlip) -> Option<Quad> {
        let edge = flip.edge();
        self.mesh.flip(flip);
        let quad = Quad::around(self.mesh.topology(), edge)?;
        self.cost.update(self.mesh, &mut self.cache, &quad);
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

    /// Undoes the last flip, whose way back would be a gain, too: both gains are rounding.
    pub(crate) fn undo_rounding(&mut self, change: Change) {
        self.undo_to(self.log.len() - 1);
        self.running_cost += change.gain();
        self.refused.rounding += 1;
    }

    /// Flips an edge for good.
    #[inline]
    pub(crate) fn flip(&mut self, flip: LegalFlip, change: Change) -> Option<Quad> {
        self.flips_of_edge[flip.edge()] += 1;
        self.record(flip, change)
    }

    /// Flips an edge and notes it, but not for the limit of flips per edge.
    #[inline]
    pub(crate) fn record(&mut self, flip: LegalFlip, change: Change) -> Option<Quad> {
        self.log.push(flip.edge());
        self.running_cost -= change.gain();
        self.turn(flip)
    }

    /// Undoes all flips after the first `length`.
    pub(crate) fn undo_to(&mut self, length: usize) {
        while self.log.len() > length {
            if let Some(edge) = self.log.pop() {
                self.turn_back(edge);
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
        self.flips_of_edge.as_mut_slice().fill(0);
    }
}

/// Relative rounding of the sums that a change consists of.
const RELATIVE_NOISE: f64 = 1e-12;

/// How often an edge may flip by default, for potentials and for other costs.
const FLIPS_PER_EDGE: u32 = 100;
const FLIPS_PER_EDGE_IN_CIRCLES: u32 = 8;

/// The gain that rounding the coordinates could make.
///
/// Rounding changes a length by the [`resolution`]; a cost with the unit length^k changes by about
/// that times l^(k-1), where l is the typical edge length.
fn noise_floor(mesh: &TriMesh, length_exponent: i32) -> f64 {
    let topology = mesh.topology();
    let lengths = topology.edges().map(|e| {
        let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v));
        a.distance(b)
    });
    let mean = lengths.sum::<f64>() / (topology.edge_count().max(1) as f64);
    let floor = resolution(mesh) * mean.powi(length_exponent - 1);
    if floor.is_finite() { floor } else { 0.0 }
}

/// Distances that sums and products of a few of the mesh's coordinates cannot tell from 0.
fn resolution(mesh: &TriMesh) -> f64 {
    let size = mesh.positions().iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    64.0 * f64::EPSILON * size
}
