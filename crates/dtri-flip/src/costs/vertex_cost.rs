//! Costs that are sums over vertices of a function of their integrated curvatures: F1, F3 and the absolute
//! Gaussian curvature.

use core::iter::zip;

use dcurv::{VertexArea, corner_angle, corner_area, vertex_curvature};
use mesh_core::{EdgeId, EdgeMap, Handle, TriMesh, VertexId, VertexMap, parallel};

use super::abs_mean::AbsMean;
use super::edge_sum::{EdgeSum, QUADS, edges};
use crate::cost::{Change, FlipCost, Stencil};
use crate::fold::twice_vector_area;
use crate::high_valence::{HIGH_VALENCE, flips_between_refreshes, has_higher_valence};
use crate::quad::Quad;

/// Sum over vertices of a function of the integrated curvatures and the area of each vertex.
///
/// Shape constraint: [`KeepShape`](crate::ShapeConstraint::KeepShape). At rough places a fold can lower
/// these costs: they measure curvature per vertex and not the orientation of faces.
///
/// Conventions as in [`dcurv::Totals`]: the Gaussian curvature of a boundary vertex is 0, and a vertex
/// without area adds nothing to F1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VertexCost {
    /// The summand.
    pub function: VertexFunction,
    /// The area of a vertex. The absolute Gaussian curvature does not use it.
    pub area: VertexArea,
}

/// The summand of a [`VertexCost`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum VertexFunction {
    /// F1 of DHKL01: `|Hbar|² / S`, which is S times H². No unit.
    SquaredMean,
    /// F3 of DHKL01: `2 |Hbar|` where `Kbar >= 0`, else `2 sqrt(|Hbar|² - S Kbar)`, which is S times
    /// `|k1| + |k2|`. In model units.
    AbsPrincipal,
    /// `|Kbar|`, the absolute angle defect, in radians. The total absolute curvature of Alboul and van
    /// Damme is a different cost, [`AbsExtrinsic`](crate::AbsExtrinsic).
    AbsGaussian,
}

/// The integrated curvatures of a vertex.
#[derive(Clone, Copy, Debug, Default)]
struct Integrals {
    angle_defect: f64,
    abs_mean: f64,
    area: f64,
    boundary: bool,
    /// At a vertex of high valence: number of incremental updates before the next full sum.
    differences_left: u32,
}

impl Integrals {
    fn of(mesh: &TriMesh, vertex: VertexId, area: VertexArea) -> Self {
        let curvature = vertex_curvature(mesh, vertex, area);
        let integrals = curvature.integrals();
        Self {
            angle_defect: integrals.angle_defect.value(),
            abs_mean: integrals.abs_dihedral.value(),
            area: integrals.area.value(),
            boundary: curvature.is_boundary(),
            differences_left: 0,
        }
    }

    /// Componentwise difference.
    fn minus(self, other: &Self) -> Self {
        Self {
            angle_defect: self.angle_defect - other.angle_defect,
            abs_mean: self.abs_mean - other.abs_mean,
            area: self.area - other.area,
            ..self
        }
    }
}

impl VertexFunction {
    #[inline]
    fn of(self, at: &Integrals) -> f64 {
        let k = if at.boundary { 0.0 } else { at.angle_defect };
        let h = at.abs_mean;
        match self {
            Self::SquaredMean if at.area > 0.0 => h * h / at.area,
            Self::SquaredMean => 0.0,
            // An incremental update may leave a slightly negative area.
            Self::AbsPrincipal => 2.0 * (h * h - at.area.max(0.0) * k.min(0.0)).sqrt(),
            Self::AbsGaussian => k.abs(),
        }
    }

    fn needs_angles(self) -> bool {
        self != Self::SquaredMean
    }

    fn needs_areas_and_means(self) -> bool {
        self != Self::AbsGaussian
    }
}

/// Cached integrals of a mesh.
#[derive(Clone, Debug)]
pub struct VertexCostCache {
    integrals: VertexMap<Integrals>,
    /// `1/2 |e| |beta|` of each edge.
    edge_terms: EdgeMap<f64>,
    /// The last flips at vertices of high valence, in order.
    history: Vec<Snapshot>,
}

/// The integrals at a vertex of high valence before a flip, to restore them exactly: adding and
/// subtracting a difference would change bits.
#[derive(Clone, Debug)]
struct Snapshot {
    vertex: VertexId,
    edge: EdgeId,
    integrals: Integrals,
}

/// Number of snapshots: more than one look-ahead sequence needs at four corners.
const HISTORY: usize = 64;

impl VertexCostCache {
    /// The integrals at the corners of a quadrilateral.
    #[inline]
    fn at_corners(&self, quad: &Quad) -> [Integrals; 4] {
        // Unrolled by hand: `map` is not inlined.
        let [a, b, c, d] = quad.corners;
        [self.integrals[a], self.integrals[b], self.integrals[c], self.integrals[d]]
    }

    /// Records a snapshot before the flip of an edge. If the flip undoes the last one at this vertex,
    /// returns the snapshot from before that one instead.
    fn restore_or_record(&mut self, vertex: VertexId, edge: EdgeId) -> Option<Integrals> {
        let last = self.history.iter().rposition(|before| before.vertex == vertex);
        if let Some(last) = last.filter(|&last| self.history[last].edge == edge) {
            return Some(self.history.remove(last).integrals);
        }
        if self.history.len() == HISTORY {
            self.history.remove(0);
        }
        self.history.push(Snapshot { vertex, edge, integrals: self.integrals[vertex] });
        None
    }

    fn forget(&mut self, vertex: VertexId) {
        if !self.history.is_empty() {
            self.history.retain(|before| before.vertex != vertex);
        }
    }
}

impl FlipCost for VertexCost {
    type Cache = VertexCostCache;

    fn prepare(&self, mesh: &TriMesh) -> VertexCostCache {
        VertexCostCache {
            integrals: VertexMap::from_vec(parallel::collect(
                mesh.topology().vertex_capacity(),
                |index| self.integrals(mesh, index),
            )),
            edge_terms: AbsMean.all_terms(mesh),
            history: Vec::new(),
        }
    }

    fn update(&self, mesh: &TriMesh, cache: &mut VertexCostCache, flipped: &Quad) {
        let topology = mesh.topology();
        let terms_before = edges(flipped).map(|edge| cache.edge_terms[edge]);
        AbsMean.update_terms(mesh, &mut cache.edge_terms, flipped);
        // The ends of the edge have gained a face, the other corners have lost one. Vertices must have
        // a high valence both for a flip and for its reverse.
        let limits = [HIGH_VALENCE, HIGH_VALENCE, HIGH_VALENCE - 1, HIGH_VALENCE - 1];
        for (place, (vertex, limit)) in zip(flipped.corners, limits).enumerate() {
            cache.integrals[vertex] = if !has_higher_valence(topology, vertex, limit) {
                cache.forget(vertex);
                Integrals::of(mesh, vertex, self.area)
            } else if let Some(before) = cache.restore_or_record(vertex, flipped.edge) {
                before
            } else if cache.integrals[vertex].differences_left == 0 {
                let differences_left = flips_between_refreshes(topology, vertex);
                Integrals { differences_left, ..Integrals::of(mesh, vertex, self.area) }
            } else {
                let back = self.difference(mesh, cache, flipped, terms_before)[place];
                let now = cache.integrals[vertex];
                let differences_left = now.differences_left - 1;
                Integrals { differences_left, ..now.minus(&back) }
            };
        }
    }

    fn total(&self, mesh: &TriMesh) -> f64 {
        let count = mesh.topology().vertex_capacity();
        parallel::sum(count, |index| self.function.of(&self.integrals(mesh, index)))
    }

    fn prepared_total(&self, _: &TriMesh, cache: &VertexCostCache) -> f64 {
        let integrals = cache.integrals.as_slice();
        parallel::sum(integrals.len(), |index| self.function.of(&integrals[index]))
    }

    fn change(&self, mesh: &TriMesh, cache: &VertexCostCache, quad: &Quad) -> Change {
        let means = self.means_after(cache, quad, || AbsMean.terms_after(mesh, quad));
        self.change_with_means(mesh, cache, quad, means)
    }

    fn change_if_lower(
        &self,
        mesh: &TriMesh,
        cache: &VertexCostCache,
        quad: &Quad,
    ) -> Option<Change> {
        let means = self.means_after(cache, quad, || AbsMean.terms_after(mesh, quad));
        self.lower_change_with_means(mesh, cache, quad, means)
    }

    fn changes_if_lower(
        &self,
        mesh: &TriMesh,
        cache: &VertexCostCache,
        quads: &[Option<Quad>],
        changes: &mut [Option<Change>],
    ) {
        for (quads, changes) in zip(quads.chunks(QUADS), changes.chunks_mut(QUADS)) {
            let terms_after = if self.function.needs_areas_and_means() {
                AbsMean.all_terms_after(mesh, quads)
            } else {
                [[0.0; QUADS]; 5]
            };
            for (i, (change, quad)) in zip(changes, quads).enumerate() {
                let [diagonal, bc, ca, ad, db] = &terms_after;
                let terms = [diagonal[i], bc[i], ca[i], ad[i], db[i]];
                *change = quad.as_ref().and_then(|quad| {
                    let means = self.means_after(cache, quad, || terms);
                    self.lower_change_with_means(mesh, cache, quad, means)
                });
            }
        }
    }

    fn stencil(&self) -> Stencil {
        Stencil::CornerStars
    }

    fn length_exponent(&self) -> i32 {
        i32::from(self.function == VertexFunction::AbsPrincipal)
    }
}

/// The integrals at the four corners of a quadrilateral, in transition to the state after the flip.
struct Corners<'a> {
    quad: &'a Quad,
    integrals: [Integrals; 4],
}

impl Corners<'_> {
    fn at(&mut self, vertex: VertexId) -> Option<&mut Integrals> {
        let place = self.quad.corners.iter().position(|&v| v == vertex)?;
        Some(&mut self.integrals[place])
    }
}

impl VertexCost {
    /// The change from the integrals before the flip: subtracts the terms of the old triangles and edges,
    /// adds the terms of the new ones.
    fn change_with_means(
        &self,
        mesh: &TriMesh,
        cache: &VertexCostCache,
        quad: &Quad,
        means: [f64; 4],
    ) -> Change {
        let before = cache.at_corners(quad);
        let mut after = Corners { quad, integrals: before };
        for (at, abs_mean) in after.integrals.iter_mut().zip(means) {
            at.abs_mean = abs_mean;
        }
        if self.function.needs_angles() {
            self.exchange_angles(mesh, &mut after);
        }
        if self.function.needs_areas_and_means() {
            self.exchange_areas(mesh, &mut after);
        }
        Change { before: self.sum(&before), after: self.sum(&after.integrals) }
    }

    /// The contribution of the four corners to the cost.
    #[inline]
    fn sum(&self, corners: &[Integrals; 4]) -> f64 {
        corners.iter().map(|at| self.function.of(at)).sum()
    }

    fn lower_change_with_means(
        &self,
        mesh: &TriMesh,
        cache: &VertexCostCache,
        quad: &Quad,
        means: [f64; 4],
    ) -> Option<Change> {
        if self.cannot_be_lower(mesh, cache, quad, means) {
            return None;
        }
        Some(self.change_with_means(mesh, cache, quad, means))
    }

    /// The absolute mean curvatures at the four corners after the flip.
    fn means_after(
        &self,
        cache: &VertexCostCache,
        quad: &Quad,
        terms_after: impl FnOnce() -> [f64; 5],
    ) -> [f64; 4] {
        let [a, b, c, d] = cache.at_corners(quad);
        let mut means = [a.abs_mean, b.abs_mean, c.abs_mean, d.abs_mean];
        if self.function.needs_areas_and_means() {
            exchange_means(&cache.edge_terms, terms_after(), quad, &mut means);
        }
        means
    }

    /// Whether a lower bound from the means alone exceeds the current cost. F3 is at least twice the sum
    /// of the means. F1 is at least `(sum of |Hbar|)² / (sum of S)` for any distribution of the area.
    fn cannot_be_lower(
        &self,
        mesh: &TriMesh,
        cache: &VertexCostCache,
        quad: &Quad,
        means: [f64; 4],
    ) -> bool {
        let before = cache.at_corners(quad);
        let cost = self.sum(&before);
        let mean: f64 = means.iter().sum();
        match self.function {
            VertexFunction::AbsGaussian => false,
            VertexFunction::AbsPrincipal => 2.0 * mean > cost * (1.0 + MARGIN),
            VertexFunction::SquaredMean => {
                let area = |triangles: [[VertexId; 3]; 2]| -> f64 {
                    triangles.iter().map(|&t| 0.5 * twice_vector_area(mesh, t).length()).sum()
                };
                let areas = before.iter().map(|at| at.area).sum::<f64>()
                    + area(quad.flipped_triangles())
                    - area(quad.triangles());
                mean * mean > cost * areas * (1.0 + MARGIN)
            }
        }
    }

    /// The change of the integrals at the corners if the edge were flipped back.
    fn difference(
        &self,
        mesh: &TriMesh,
        cache: &VertexCostCache,
        flipped: &Quad,
        terms_before: [f64; 5],
    ) -> [Integrals; 4] {
        let mut after = Corners { quad: flipped, integrals: [Integrals::default(); 4] };
        let mut means = [0.0; 4];
        exchange_means(&cache.edge_terms, terms_before, flipped, &mut means);
        for (at, mean) in zip(&mut after.integrals, means) {
            at.abs_mean = mean;
        }
        self.exchange_angles(mesh, &mut after);
        self.exchange_areas(mesh, &mut after);
        after.integrals
    }

    fn integrals(&self, mesh: &TriMesh, index: usize) -> Integrals {
        let vertex = VertexId::from_index(index);
        if mesh.topology().contains_vertex(vertex) {
            Integrals::of(mesh, vertex, self.area)
        } else {
            Integrals::default()
        }
    }

    fn exchange_angles(&self, mesh: &TriMesh, after: &mut Corners<'_>) {
        exchange_faces(
            after,
            |corner, next, last| {
                corner_angle(mesh.position(corner), mesh.position(next), mesh.position(last))
            },
            |at, angle| at.angle_defect -= angle,
        );
    }

    fn exchange_areas(&self, mesh: &TriMesh, after: &mut Corners<'_>) {
        exchange_faces(
            after,
            |corner, next, last| {
                let (p, q, r) = (mesh.position(corner), mesh.position(next), mesh.position(last));
                corner_area(self.area, p, q, r).value()
            },
            |at, area| at.area += area,
        );
    }
}

/// Subtracts the shares of the old triangles and adds the shares of the new ones.
fn exchange_faces(
    after: &mut Corners<'_>,
    share: impl Fn(VertexId, VertexId, VertexId) -> f64,
    add: impl Fn(&mut Integrals, f64),
) {
    let quad = after.quad;
    for (triangles, sign) in [(quad.triangles(), -1.0), (quad.flipped_triangles(), 1.0)] {
        for [p, q, r] in triangles {
            for [corner, next, last] in [[p, q, r], [q, r, p], [r, p, q]] {
                let share = share(corner, next, last);
                if let Some(at) = after.at(corner) {
                    add(at, sign * share);
                }
            }
        }
    }
}

/// Updates the means. Each end of an edge gets half of its term.
fn exchange_means(terms: &EdgeMap<f64>, terms_after: [f64; 5], quad: &Quad, means: &mut [f64; 4]) {
    let edges = edges(quad);
    let change = |side: usize| terms_after[side] - terms[edges[side]];
    let (diagonal, turned) = (terms[edges[0]], terms_after[0]);
    let (bc, ca, ad, db) = (change(1), change(2), change(3), change(4));
    means[0] += 0.5 * (ca + ad - diagonal);
    means[1] += 0.5 * (bc + db - diagonal);
    means[2] += 0.5 * (bc + ca + turned);
    means[3] += 0.5 * (ad + db + turned);
}

/// Safety margin of the bound against rounding.
const MARGIN: f64 = 1e-9;
