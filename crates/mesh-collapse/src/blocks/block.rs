//! A block of a flat mesh with all data that its collapses need, and the result of its collapses.

use glam::DVec3;
use mesh_core::{TriMesh, as_u32, parallel};

use crate::blocks::block_mesh::{BlockMesh, Goal, Part, Step};
use crate::blocks::bucket_queue::BUCKETS;
use crate::blocks::cost_threshold::{CostThreshold, Forecast};
use crate::blocks::flat_mesh::FlatMesh;
use crate::blocks::partition::Partition;
use crate::blocks::rules::Rules;
use crate::geometry::quadric::Quadric;
use crate::rejection::Rejections;

/// A block of a flat mesh as plain data. It can be collapsed anywhere, with bit-identical results.
///
/// It contains all faces that have a corner in the block. Vertices of other blocks are included only as corners of
/// these faces; neither they nor their neighbours move.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Block {
    part: Part,
    /// The ids of the faces in the original. The first `handed_on` faces are handed on to the next flat mesh.
    face_ids: Vec<u32>,
    handed_on: usize,
    /// The vertex ids in the flat mesh and in the original.
    vertices: Vec<u32>,
    vertex_ids: Vec<u32>,
}

/// The result of a block.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reduced {
    /// The ids of the remaining vertices in the flat mesh and in the original.
    pub(super) vertices: Vec<u32>,
    pub(super) vertex_ids: Vec<u32>,
    pub(super) positions: Vec<DVec3>,
    pub(super) quadrics: Vec<Quadric>,
    /// Triangles with vertex ids of the flat mesh.
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) face_ids: Vec<u32>,
    pub(super) half_edges: Vec<[u32; 3]>,
    pub(super) forecast: Forecast,
    pub(super) done: Done,
}

/// The work done on a block, with ids of the original.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Done {
    /// Pairs of a removed vertex and the vertex that it was merged into.
    pub(super) merged: Vec<[u32; 2]>,
    /// Every collapse, if they are recorded.
    pub(super) steps: Vec<Step>,
    pub(super) rejections: Rejections,
    pub(super) max_cost: f64,
}

impl Reduced {
    /// The number of remaining faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.triangles.len()
    }

    /// The number of collapses.
    #[must_use]
    pub fn collapses(&self) -> usize {
        self.done.merged.len()
    }

    /// The number of removed faces by cost.
    #[must_use]
    pub fn forecast(&self) -> &Forecast {
        &self.forecast
    }
}

impl Block {
    /// Cuts a block out of a flat mesh.
    ///
    /// # Panics
    /// The partition belongs to another flat mesh, or has no such block.
    #[must_use]
    pub fn new(flat: &FlatMesh<'_>, partition: &Partition, block: usize, rules: &Rules) -> Self {
        let own = partition.vertices(block);
        let first = partition.first(block);
        let corners = |face: u32| flat.triangle(face as usize).unwrap_or_default();
        let block_of = |v: u32| partition.block_of(v);
        // A face belongs to the lowest-numbered block among the blocks of its corners.
        let is_handed_on =
            |&face: &u32| corners(face).into_iter().map(block_of).min() == Some(block);
        let (mut faces, others): (Vec<u32>, Vec<u32>) =
            partition.mixed(block).iter().partition(|&face| is_handed_on(face));
        let mut foreign: Vec<u32> = Vec::new();
        for &face in faces.iter().chain(&others) {
            foreign.extend(corners(face).into_iter().filter(|&v| block_of(v) != block));
        }
        faces.extend_from_slice(partition.inner(block));
        let handed_on = faces.len();
        faces.extend(others);
        foreign.sort_unstable();
        foreign.dedup();
        let number = |v: u32| {
            // For vertices before the block, the difference wraps to a very large number.
            let place = partition.rank(v).wrapping_sub(as_u32(first));
            if (place as usize) < own.len() {
                return place;
            }
            let (Ok(place) | Err(place)) = foreign.binary_search(&v);
            as_u32(own.len() + place)
        };
        let triangle = |&face: &u32| {
            let [a, b, c] = corners(face);
            [number(a), number(b), number(c)]
        };
        let triangles = faces.iter().map(triangle).collect();
        let half_edges = if rules.record {
            faces.iter().map(|&face| flat.half_edges(face as usize)).collect()
        } else {
            Vec::new()
        };
        let quadrics = if flat.quadrics.is_empty() {
            Vec::new()
        } else {
            own.iter().map(|&v| flat.quadrics[v as usize]).collect()
        };
        let vertices: Vec<u32> = own.iter().chain(&foreign).copied().collect();
        let positions = vertices.iter().map(|&v| flat.positions[v as usize]).collect();
        Self {
            part: Part {
                triangles,
                positions,
                quadrics,
                own: own.len(),
                half_edges,
                half_edge_capacity: 0,
            },
            face_ids: faces.iter().map(|&face| flat.face_id(face as usize)).collect(),
            handed_on,
            vertex_ids: vertices.iter().map(|&v| flat.vertex_id(v)).collect(),
            vertices,
        }
    }

    /// A block with the whole flat mesh, except the held vertices.
    pub(super) fn whole(flat: FlatMesh<'_>, rules: &Rules) -> Self {
        if let Some(mesh) = flat.whole.filter(|mesh| mesh.topology().is_compact()) {
            return Self::of_mesh(mesh);
        }
        let vertices: Vec<u32> = flat.vertices().collect();
        let unused = !rules.record && !flat.half_edges.is_empty();
        if flat.whole.is_some() || unused {
            let partition = Partition::whole(&flat);
            return Self::new(&flat, &partition, 0, rules);
        }
        let FlatMesh { positions, quadrics, vertex_ids, triangles, face_ids, half_edges, .. } =
            flat;
        let (own, handed_on) = (vertices.len(), triangles.len());
        let positions = positions.into_owned();
        let largest = half_edges.as_flattened().iter().max();
        let half_edge_capacity = largest.map_or(0, |&half_edge| (half_edge as usize | 1) + 1);
        let part = Part { triangles, positions, quadrics, own, half_edges, half_edge_capacity };
        Self { part, face_ids, handed_on, vertices, vertex_ids }
    }

    /// A block with a whole mesh without gaps.
    fn of_mesh(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let half_edges = topology.faces().map(|face| topology.face_half_edges(face));
        let half_edges: Vec<[u32; 3]> =
            half_edges.map(|[a, b, c]| [a.get(), b.get(), c.get()]).collect();
        let (own, handed_on) = (topology.vertex_count(), half_edges.len());
        let vertices: Vec<u32> = (0..as_u32(own)).collect();
        Self {
            part: Part {
                triangles: topology.triangles().collect(),
                positions: mesh.positions().to_vec(),
                quadrics: Vec::new(),
                own,
                half_edges,
                half_edge_capacity: topology.half_edge_capacity(),
            },
            face_ids: (0..as_u32(handed_on)).collect(),
            handed_on,
            vertex_ids: vertices.clone(),
            vertices,
        }
    }

    /// The number of faces that would be removed at each cost, if the block were collapsed to this share of its faces.
    #[must_use]
    pub fn forecast(self, rules: &Rules, share: f64) -> Forecast {
        let faces = self.part.triangles.len();
        let mut forecast = Forecast::of(faces);
        let part = Part { half_edges: Vec::new(), half_edge_capacity: 0, ..self.part };
        let mut block_mesh = BlockMesh::new(part, *rules);
        let goal = Goal { end: BUCKETS, faces: (share * faces as f64) as usize };
        block_mesh.run(goal, &mut |_, _| true, &mut |bucket, faces| forecast.add(bucket, faces));
        forecast
    }

    /// Collapses the edges of the block that cost less than a threshold.
    #[must_use]
    pub fn reduce(self, rules: &Rules, threshold: CostThreshold) -> Reduced {
        let goal = Goal { end: threshold.bucket(), faces: 0 };
        self.reduce_to(rules, goal, &mut |_, _| true).0
    }

    /// [`Block::reduce`] with a number of faces as the target. Also returns whether `goes_on` never returned false.
    pub(super) fn reduce_to(
        self,
        rules: &Rules,
        goal: Goal,
        goes_on: &mut dyn FnMut(usize, usize) -> bool,
    ) -> (Reduced, bool) {
        let Self { part, face_ids, handed_on, vertices, vertex_ids } = self;
        let own = part.own;
        let mut forecast = Forecast::of(part.triangles.len());
        let mut block_mesh = BlockMesh::new(part, *rules);
        let is_whole =
            block_mesh.run(goal, goes_on, &mut |bucket, faces| forecast.add(bucket, faces));
        let block_mesh = &block_mesh;
        let of_faces = || {
            let (mut triangles, mut faces, mut half_edges) = (Vec::new(), Vec::new(), Vec::new());
            for (face, triangle) in block_mesh.triangles().take_while(|&(face, _)| face < handed_on)
            {
                let [a, b, c] = triangle;
                triangles.push([vertices[a as usize], vertices[b as usize], vertices[c as usize]]);
                faces.push(face_ids[face]);
                if rules.record {
                    half_edges.push(block_mesh.half_edges(face));
                }
            }
            (triangles, faces, half_edges)
        };
        let of_vertices = || {
            let mut is_gone = vec![false; own];
            block_mesh.merged.iter().for_each(|&[removed, _]| is_gone[removed as usize] = true);
            let left: Vec<usize> = (0..own).filter(|&v| !is_gone[v]).collect();
            let positions: Vec<DVec3> = left.iter().map(|&v| block_mesh.position(v)).collect();
            let quadrics: Vec<Quadric> = left.iter().map(|&v| block_mesh.quadric(v)).collect();
            (left, positions, quadrics)
        };
        let ((triangles, face_ids, half_edges), (left, positions, quadrics)) =
            parallel::both(of_faces, of_vertices);
        let id = |v: u32| vertex_ids[v as usize];
        let step = |step: &Step| Step { removed: id(step.removed), kept: id(step.kept), ..*step };
        let reduced = Reduced {
            vertices: left.iter().map(|&v| vertices[v]).collect(),
            vertex_ids: left.iter().map(|&v| vertex_ids[v]).collect(),
            positions,
            quadrics,
            triangles,
            face_ids,
            half_edges,
            forecast,
            done: Done {
                merged: block_mesh.merged.iter().map(|pair| pair.map(id)).collect(),
                steps: block_mesh.steps.iter().map(step).collect(),
                rejections: block_mesh.rejections,
                max_cost: block_mesh.max_cost,
            },
        };
        (reduced, is_whole)
    }
}
