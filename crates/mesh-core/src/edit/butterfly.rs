//! Butterfly subdivision: smooth values at the middle of edges, interpolating the vertices.
//!
//! ```text
//!      f --- c --- e        x = (a + b) / 2 + 2w (c + d) - w (e + f + g + h)
//!       \   / \   /
//!        \ /   \ /          with w = 1/16; the triangles over the four outer
//!         a -x- b           sides of the two at the edge are its wings
//!        / \   / \
//!       /   \ /   \
//!      h --- d --- g
//! ```
//!
//! Weights depend on the topology alone ([`Butterfly`], [`ButterflyOptions::weights`]). The caller chooses the
//! averaged values: positions, but also colours, scalars or texture coordinates
//! ([`ButterflyOptions::interpolate`], [`ButterflyOptions::refine`]).
//!
//! # Rules
//!
//! - *Interior edge between regular vertices:* the mask above (Dyn, Levin, Gregory 1990). With
//!   w = 1/16 it reproduces cubic polynomials on a regular grid.
//! - *Missing wing*, over a boundary edge: the point of the triangle below it, reflected at the middle of that edge. If
//!   e over (b, c) is missing, it is b + c - a. On a regular grid this is the missing grid point, so linear functions
//!   are reproduced up to the boundary.
//! - *Boundary edge:* the four-point rule (1/2 + w)(a + b) - w (p + q) with the boundary's
//!   previous and next vertex p and q (Dyn, Gregory, Levin 1987); weights 9/16 and -1/16. So
//!   a boundary curve depends on the boundary only.
//! - *Interior vertex without six edges*, under [`IrregularRule::Zorin`]: 3/4 of the vertex and
//!   its one-ring weighted by s₀, s₁, ..., beginning with the other end of the edge (Zorin,
//!   Schröder, Sweldens 1996): 5/12, -1/12, -1/12 for three neighbours, 3/8, 0, -1/8, 0 for four,
//!   (1/4 + cos(2πj/k) + cos(4πj/k)/2) / k for k of them otherwise. If both ends are irregular, the
//!   mean of both rules. The weights do not depend on w.
//! - *Boundary vertices* count as regular for any number of edges: the paper does not cover them, and reflected wings
//!   keep the rule local. So an edge from the boundary to an irregular interior vertex takes the rule of the interior
//!   vertex, whose one-ring is complete. An edge from the boundary to another vertex takes the eight-point mask.
//!
//! All rules have weights that sum to one and depend on connectivity only, hence commute with affine maps. On small
//! meshes a vertex can occur several times in a mask; its weights add up. On a tetrahedron the eight-point mask gives
//! the middle of the edge, and on a single triangle the four-point rule gives (9 (a + b) - 2 c) / 16.

use core::f64::consts::TAU;
use core::ops::{Add, Mul};
use std::collections::HashMap;

use glam::DVec3;

use crate::edit::subdivide_1_to_4::SubdivisionMap;
use crate::mesh::{MeshError, TriMesh};
use crate::parallel;
use crate::topology::Topology;
use crate::topology::handle::{EdgeId, HalfEdgeId, Handle, VertexId};
use crate::topology::pairing::TopologyError;

/// From this valence on, [`ButterflyOptions::refine`] evaluates the rule of Zorin, Schröder and Sweldens for all edges
/// of a vertex at once. Smaller rings are summed edge by edge, which takes less time in total than the faces around.
const CROWDED: usize = 1024;

/// Which rules give the value at the middle of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct ButterflyOptions {
    /// w, the tension: 0 gives the edge's middle, 1/16 the highest order.
    pub tension: f64,
    /// The rule at interior vertices of valence other than six.
    pub irregular: IrregularRule,
}

impl Default for ButterflyOptions {
    fn default() -> Self {
        Self { tension: 1.0 / 16.0, irregular: IrregularRule::default() }
    }
}

/// The rule at interior vertices that do not have six edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum IrregularRule {
    /// The modified scheme of Zorin, Schröder and Sweldens 1996: smooth there too.
    #[default]
    Zorin,
    /// The eight-point mask everywhere: the original scheme, and the most local one.
    EightPoint,
}

/// Why a mesh cannot be subdivided.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ButterflyError {
    /// The tension is infinite or not a number.
    #[error("the tension is {0}, but it must be finite; the default is 1/16")]
    Tension(f64),
    /// The subdivided mesh would exceed 32-bit indices.
    #[error("step {step} fails: {source}; ask for fewer steps")]
    TooLarge {
        /// The step, counted from one.
        step: u32,
        /// The reason.
        source: TopologyError,
    },
    /// Coordinates so large that their weighted sum overflows.
    #[error("step {step} fails: {source}")]
    Overflow {
        /// The step, counted from one.
        step: u32,
        /// The vertex of the subdivided mesh.
        source: MeshError,
    },
}

/// The vertices of the eight-point mask around an interior edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Butterfly {
    /// a and b, the ends of the edge in the direction of its half-edge `2e`.
    pub ends: [VertexId; 2],
    /// c and d, the apexes of the triangles to the left and to the right.
    pub apexes: [VertexId; 2],
    /// e, f, g, h: the apexes across the sides (b, c), (c, a), (d, b), (a, d); `None` where the
    /// side is a boundary edge.
    pub wings: [Option<VertexId>; 4],
}

impl Butterfly {
    /// The mask of an edge; `None` for a boundary edge.
    ///
    /// # Panics
    /// When the edge is not in the mesh.
    #[must_use]
    pub fn around(topology: &Topology, edge: EdgeId) -> Option<Self> {
        let [h, twin] = edge.half_edges();
        let apexes = [topology.apex(h)?, topology.apex(twin)?];
        let [bc, ad] = [topology.next(h), topology.next(twin)];
        let [ca, db] = [topology.next(bc), topology.next(ad)];
        let wings = [bc, ca, db, ad].map(|side| topology.apex(side.twin()));
        Some(Self { ends: [topology.target(twin), topology.target(h)], apexes, wings })
    }

    /// The weights of the mask with tension `w`; missing wings are reflected. Vertices may be given several times;
    /// their weights add up.
    pub fn weights(&self, w: f64, mut give: impl FnMut(VertexId, f64)) {
        let ([a, b], [c, d]) = (self.ends, self.apexes);
        give(a, 0.5);
        give(b, 0.5);
        give(c, 2.0 * w);
        give(d, 2.0 * w);
        let sides = [(b, c, a), (c, a, b), (d, b, a), (a, d, b)];
        for (wing, (from, to, below)) in self.wings.into_iter().zip(sides) {
            match wing {
                Some(wing) => give(wing, -w),
                None => {
                    give(from, -w);
                    give(to, -w);
                    give(below, w);
                }
            }
        }
    }
}

impl ButterflyOptions {
    /// The weights of the value at the middle of an edge; they sum to one. Vertices may be given
    /// several times; their weights add up.
    ///
    /// # Panics
    /// When the edge is not in the mesh.
    pub fn weights(&self, topology: &Topology, edge: EdgeId, mut give: impl FnMut(VertexId, f64)) {
        let Some(butterfly) = Butterfly::around(topology, edge) else {
            return four_point_weights(topology, edge, self.tension, give);
        };
        let [h, twin] = edge.half_edges();
        match [self.irregular_valence(topology, h), self.irregular_valence(topology, twin)] {
            [None, None] => butterfly.weights(self.tension, give),
            [Some(valence), None] => zorin_weights(topology, h, valence, give),
            [None, Some(valence)] => zorin_weights(topology, twin, valence, give),
            [Some(at_origin), Some(at_target)] => {
                zorin_weights(topology, h, at_origin, |v, weight| give(v, 0.5 * weight));
                zorin_weights(topology, twin, at_target, |v, weight| give(v, 0.5 * weight));
            }
        }
    }

    /// The value at the middle of an edge, from one value per vertex (indexed as the vertices
    /// are). Reads only the few vertices that have a weight.
    ///
    /// ```
    /// use mesh_core::butterfly::ButterflyOptions;
    /// use mesh_core::{Topology, VertexId};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let square = Topology::from_triangles(4, &[[0, 1, 2], [0, 2, 3]])?;
    /// let side = square.find_half_edge(VertexId::new(0), VertexId::new(1)).ok_or("no edge")?;
    /// let heights = [0.0, 1.0, 1.0, 0.0];
    /// let middle = ButterflyOptions::default().interpolate(&square, side.edge(), &heights);
    /// assert_eq!(middle, 0.5);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Panics
    /// When the edge is not in the mesh, or a vertex has no value.
    #[must_use]
    pub fn interpolate<T>(&self, topology: &Topology, edge: EdgeId, values: &[T]) -> T
    where
        T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>,
    {
        let mut value = T::default();
        self.weights(topology, edge, |v, weight| value = value + values[v.index()] * weight);
        value
    }

    /// The values on the mesh that [`Topology::subdivide_1_to_4`] makes: the given values of the vertices, followed by
    /// one value per edge. Removed edges get the default value.
    ///
    /// # Panics
    /// When there is not one value per vertex.
    #[must_use]
    pub fn refine<T>(&self, topology: &Topology, values: &[T]) -> Vec<T>
    where
        T: Copy + Default + Add<Output = T> + Mul<f64, Output = T> + Send + Sync,
    {
        assert_eq!(values.len(), topology.vertex_capacity(), "one value per vertex is needed");
        let vertices = values.len();
        let crowded = self.crowded_rings(topology, values);
        let of_edge = |edge: EdgeId| {
            let sides = edge.half_edges();
            let known = sides.map(|h| crowded.get(&h).copied());
            if known.iter().all(Option::is_none) {
                return self.interpolate(topology, edge, values);
            }
            let small_ring = |h: HalfEdgeId| {
                let valence = self.irregular_valence(topology, h)?;
                let mut value = T::default();
                zorin_weights(topology, h, valence, |v, weight| {
                    value = value + values[v.index()] * weight;
                });
                Some(value)
            };
            match [0, 1].map(|end| known[end].or_else(|| small_ring(sides[end]))) {
                [Some(a), Some(b)] => a * 0.5 + b * 0.5,
                [a, b] => a.or(b).unwrap_or_default(),
            }
        };
        parallel::collect(vertices + topology.edge_capacity(), |i| {
            if i < vertices {
                return values[i];
            }
            let edge = EdgeId::from_index(i - vertices);
            if topology.contains_edge(edge) { of_edge(edge) } else { T::default() }
        })
    }

    /// The values of the irregular rule at the vertices of [`CROWDED`] edges, for each half-edge that leaves them.
    ///
    /// The weights are a constant and two cosines, so five sums over the ring give the value of every edge:
    /// Σ cos(m (j - i)) vⱼ = cos(mi) Σ cos(mj) vⱼ + sin(mi) Σ sin(mj) vⱼ.
    fn crowded_rings<T>(&self, topology: &Topology, values: &[T]) -> HashMap<HalfEdgeId, T>
    where
        T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>,
    {
        let mut rings = HashMap::new();
        for vertex in topology.vertices() {
            let Some(h) = topology.half_edge_of_vertex(vertex) else { continue };
            let Some(valence) = self.irregular_valence(topology, h) else { continue };
            if valence < CROWDED {
                continue;
            }
            let waves = |i: usize| {
                let (s, c) = (TAU * i as f64 / valence as f64).sin_cos();
                [1.0, c, s, c * c - s * s, 2.0 * s * c]
            };
            let mut sums = [T::default(); 5];
            for (i, spoke) in topology.outgoing(vertex).enumerate() {
                let (value, waves) = (values[topology.target(spoke).index()], waves(i));
                sums = core::array::from_fn(|k| sums[k] + value * waves[k]);
            }
            for (i, spoke) in topology.outgoing(vertex).enumerate() {
                let [one, c, s, c2, s2] = waves(i);
                let factors = [0.25 * one, c, s, 0.5 * c2, 0.5 * s2];
                let ring = (sums.into_iter().zip(factors))
                    .fold(T::default(), |value, (sum, factor)| {
                        value + sum * (factor / valence as f64)
                    });
                rings.insert(spoke, values[vertex.index()] * 0.75 + ring);
            }
        }
        rings
    }

    /// The valence of the half-edge's origin if the irregular rule applies there.
    fn irregular_valence(&self, topology: &Topology, h: HalfEdgeId) -> Option<usize> {
        let vertex = topology.origin(h);
        if self.irregular == IrregularRule::EightPoint || topology.is_boundary_vertex(vertex) {
            return None;
        }
        Some(topology.valence(vertex)).filter(|&valence| valence != 6)
    }
}

/// The four-point rule along the boundary.
fn four_point_weights(
    topology: &Topology,
    edge: EdgeId,
    w: f64,
    mut give: impl FnMut(VertexId, f64),
) {
    let [h, twin] = edge.half_edges();
    let exterior = if topology.is_exterior(h) { h } else { twin };
    give(topology.origin(exterior), 0.5 + w);
    give(topology.target(exterior), 0.5 + w);
    give(topology.origin(topology.previous(exterior)), -w);
    give(topology.target(topology.next(exterior)), -w);
}

/// The rule of Zorin, Schröder and Sweldens at the origin of `h`, an interior vertex.
fn zorin_weights(
    topology: &Topology,
    h: HalfEdgeId,
    valence: usize,
    mut give: impl FnMut(VertexId, f64),
) {
    give(topology.origin(h), 0.75);
    // The weights are symmetric, so the direction around the ring does not matter.
    let mut incident_edge = h;
    let mut ring = |weight| {
        give(topology.target(incident_edge), weight);
        incident_edge = topology.next(incident_edge.twin());
    };
    match valence {
        3 => [5.0 / 12.0, -1.0 / 12.0, -1.0 / 12.0].into_iter().for_each(ring),
        4 => [0.375, 0.0, -0.125, 0.0].into_iter().for_each(ring),
        _ => {
            // cos and sin of 2πj/k, rotated from one neighbour to the next.
            let (sin, cos) = (TAU / valence as f64).sin_cos();
            let (mut c, mut s) = (1.0, 0.0);
            for _ in 0..valence {
                // cos(2x) / 2 = cos²(x) - 1/2
                ring((c * c + c - 0.25) / valence as f64);
                (c, s) = (c * cos - s * sin, s * cos + c * sin);
            }
        }
    }
}

/// A subdivided mesh and the maps of all steps.
#[derive(Clone, Debug)]
pub struct Subdivision {
    /// The mesh. It begins with the vertices of the input, at their positions.
    pub mesh: TriMesh,
    /// Per step, where vertices, edges and faces came from.
    pub steps: Vec<SubdivisionMap>,
}

/// Subdivides a mesh `steps` times: each step cuts every face into four and places a vertex on every edge.
/// Euler characteristic, boundary loops and the position of every vertex are kept.
///
/// To carry attributes along, take the steps by hand with [`Topology::subdivide_1_to_4`] and
/// [`ButterflyOptions::refine`], once for positions and once for each attribute.
///
/// # Errors
/// A tension that is not finite; a mesh that would exceed 32-bit indices; coordinates near the
/// largest that double precision holds.
pub fn subdivide(
    mesh: &TriMesh,
    steps: u32,
    options: &ButterflyOptions,
) -> Result<Subdivision, ButterflyError> {
    if !options.tension.is_finite() {
        return Err(ButterflyError::Tension(options.tension));
    }
    let mut subdivision = Subdivision { mesh: mesh.clone(), steps: Vec::new() };
    for step in 1..=steps {
        let coarse = subdivision.mesh.topology();
        let (fine, origins) = coarse
            .subdivide_1_to_4()
            .map_err(|source| ButterflyError::TooLarge { step, source })?;
        let positions: Vec<DVec3> = options.refine(coarse, subdivision.mesh.positions());
        subdivision.mesh = TriMesh::new(fine, positions)
            .map_err(|source| ButterflyError::Overflow { step, source })?;
        subdivision.steps.push(origins);
    }
    Ok(subdivision)
}
