//! The normal equations of one step of a fit, and their solution.

use glam::DVec3;
use mesh_collapse::{Factors, Symmetric3};
use mesh_core::{EdgeId, FaceId, TriMesh, VertexId, as_u32, parallel};

use crate::block_loop::for_blocks_in_turn;
use crate::fit::constraints::FitConstraints;
use crate::fit::element::Element;
use crate::fit::freedom::Freedom;

/// The normal equations of the Gauss-Newton step, in blocks of three by three: one for each vertex that is not fixed,
/// and one for each edge between two such vertices.
pub(super) struct System {
    /// The vertices that are not fixed, in order.
    vertices: Vec<VertexId>,
    /// The place of each vertex in this list.
    place_of: Vec<u32>,
    /// The place of the block of each edge.
    block_of: Vec<u32>,
    /// The end of the neighbours of each vertex in `neighbours`.
    ends: Vec<u32>,
    /// The places of the neighbours, and of the blocks of the edges to them.
    neighbours: Vec<[u32; 2]>,
    of_vertex: Vec<Symmetric3>,
    of_edge: Vec<Symmetric3>,
    /// The negative gradient at the vertices.
    residual: Vec<DVec3>,
}

/// Marks an element without a place.
const NONE: u32 = u32::MAX;

/// The number of vertices in a block for one thread.
const BLOCK: usize = 2048;

impl System {
    pub(super) fn new(mesh: &TriMesh, freedoms: &[Freedom]) -> Self {
        let topology = mesh.topology();
        let is_free = |v: VertexId| freedoms[v.index()] != Freedom::Fixed;
        let vertices: Vec<VertexId> = topology.vertices().filter(|&v| is_free(v)).collect();
        let mut place_of = vec![NONE; topology.vertex_capacity()];
        for (place, v) in vertices.iter().enumerate() {
            place_of[v.index()] = as_u32(place);
        }
        let mut block_of = vec![NONE; topology.edge_capacity()];
        let (mut ends, mut neighbours) =
            (Vec::with_capacity(vertices.len()), Vec::with_capacity(2 * topology.edge_count()));
        let mut edges = 0;
        for_blocks_in_turn(
            vertices.len(),
            BLOCK,
            |range| {
                let (mut degrees, mut all) = (Vec::with_capacity(range.len()), Vec::new());
                for &v in &vertices[range] {
                    let before = all.len();
                    let to_free = topology.outgoing(v).filter(|&h| is_free(topology.target(h)));
                    all.extend(to_free.map(|h| (place_of[topology.target(h).index()], h.edge())));
                    degrees.push(all.len() - before);
                }
                (degrees, all)
            },
            |(degrees, all)| {
                for degree in degrees {
                    ends.push(ends.last().copied().unwrap_or(0) + as_u32(degree));
                }
                // Blocks are numbered in the order of first use, so that blocks of neighbours are close in memory.
                for (place, edge) in all {
                    let block = &mut block_of[edge.index()];
                    if *block == NONE {
                        *block = edges;
                        edges += 1;
                    }
                    neighbours.push([place, *block]);
                }
            },
        );
        let of_vertex = vec![Symmetric3::default(); vertices.len()];
        let of_edge = vec![Symmetric3::default(); edges as usize];
        let residual = vec![DVec3::ZERO; vertices.len()];
        Self { vertices, place_of, block_of, ends, neighbours, of_vertex, of_edge, residual }
    }

    /// Adds the pairs of a face.
    pub(super) fn add(&mut self, mesh: &TriMesh, face: FaceId, element: &Element) {
        let sides = mesh.topology().face_half_edges(face);
        let corners = mesh.topology().face_vertices(face);
        for i in 0..3 {
            self.add_to_vertex(corners[i], element.of_corner[i], element.residual[i]);
            self.add_to_block(sides[i].edge(), element.of_side[i]);
        }
    }

    /// Adds a pair of a target and a point on an edge; `along` is the position of the point, from 0 to 1.
    pub(super) fn add_to_edge(&mut self, mesh: &TriMesh, edge: EdgeId, along: f64, target: DVec3) {
        let ends = mesh.topology().edge_vertices(edge);
        let [a, b] = ends.map(|v| mesh.position(v) - target);
        let weights = [1.0 - along, along];
        let force = weights[0] * a + weights[1] * b;
        let unit = Symmetric3 { diagonal: DVec3::ONE, mixed: DVec3::ZERO };
        for (v, weight) in ends.into_iter().zip(weights) {
            self.add_to_vertex(v, weight * weight * unit, -weight * force);
        }
        self.add_to_block(edge, weights[0] * weights[1] * unit);
    }

    fn add_to_vertex(&mut self, v: VertexId, block: Symmetric3, residual: DVec3) {
        let place = self.place_of[v.index()];
        if place != NONE {
            self.of_vertex[place as usize] += block;
            self.residual[place as usize] += residual;
        }
    }

    fn add_to_block(&mut self, edge: EdgeId, block: Symmetric3) {
        let place = self.block_of[edge.index()];
        if place != NONE {
            self.of_edge[place as usize] += block;
        }
    }

    /// The displacement of each vertex that is not fixed. The solver is conjugate gradients, preconditioned with the
    /// blocks of the vertices. It ends when the residual falls below `tolerance` times its initial value.
    pub(super) fn solve(
        mut self,
        mesh: &TriMesh,
        freedoms: &[Freedom],
        constraints: &FitConstraints,
        tolerance: f64,
    ) -> Vec<(VertexId, DVec3)> {
        let count = self.vertices.len();
        let inverses: Vec<Inverse> = parallel::collect(count, |place| {
            let (v, block) = (self.vertices[place], &self.of_vertex[place]);
            match freedoms[v.index()].curve(constraints) {
                Some(curve) => Inverse::along(block, curve.direction(mesh.position(v))),
                None => Inverse::of(block),
            }
        });
        let dot = |p: &[DVec3], q: &[DVec3]| parallel::sum(count, |i| p[i].dot(q[i]));
        let mut x = vec![DVec3::ZERO; count];
        let mut r = core::mem::take(&mut self.residual);
        let mut z = parallel::collect(count, |i| inverses[i].times(r[i]));
        let mut p = z.clone();
        let mut ap = vec![DVec3::ZERO; count];
        let mut rz = dot(&r, &z);
        let enough = tolerance * tolerance * rz;
        for _ in 0..ITERATIONS {
            if rz <= enough {
                break;
            }
            parallel::fill(&mut ap, |place| self.row_times(place, &p));
            let step = rz / dot(&p, &ap);
            if !step.is_finite() {
                break;
            }
            parallel::update(&mut x, |i, x| *x += step * p[i]);
            parallel::update(&mut r, |i, r| *r -= step * ap[i]);
            parallel::fill(&mut z, |i| inverses[i].times(r[i]));
            let following = dot(&r, &z);
            let keep = following / rz;
            rz = following;
            parallel::update(&mut p, |i, p| *p = z[i] + keep * *p);
        }
        self.vertices.into_iter().zip(x).collect()
    }

    /// The row of a vertex times a vector.
    fn row_times(&self, place: usize, p: &[DVec3]) -> DVec3 {
        let start = place.checked_sub(1).map_or(0, |before| self.ends[before]);
        let neighbours = &self.neighbours[start as usize..self.ends[place] as usize];
        let own = self.of_vertex[place].times(p[place]);
        neighbours.iter().fold(own, |sum, &[neighbour, block]| {
            sum + self.of_edge[block as usize].times(p[neighbour as usize])
        })
    }
}

/// The inverse of the block of a vertex, restricted to the directions in which the vertex may move. Its results lie in
/// these directions, so conjugate gradients stay in this subspace.
enum Inverse {
    Zero,
    Full(Factors),
    Along(DVec3),
}

impl Inverse {
    fn of(block: &Symmetric3) -> Self {
        block.factors(DAMPING).map_or(Self::Zero, Self::Full)
    }

    fn along(block: &Symmetric3, direction: DVec3) -> Self {
        let scale = direction.dot(block.times(direction)).sqrt().recip();
        if scale.is_finite() { Self::Along(scale * direction) } else { Self::Zero }
    }

    fn times(&self, r: DVec3) -> DVec3 {
        match self {
            Self::Zero => DVec3::ZERO,
            Self::Full(factors) => factors.solve(r),
            Self::Along(direction) => direction.dot(r) * *direction,
        }
    }
}

/// Damping relative to the trace of a block.
const DAMPING: f64 = 1e-9;
const ITERATIONS: usize = 60;
