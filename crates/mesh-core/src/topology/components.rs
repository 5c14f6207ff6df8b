//! Euler characteristic, components and genus.

use crate::attribute::VertexMap;
use crate::topology::Topology;
use crate::topology::handle::VertexId;

/// The connected components of a mesh; made by [`Topology::components`].
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Components {
    /// The component of each vertex, counted from 0; `None` for isolated and removed vertices.
    pub of_vertex: VertexMap<Option<u32>>,
    /// The number of components; isolated vertices are none.
    pub count: usize,
}

impl Topology {
    /// Vertices minus edges plus faces, isolated vertices not counted.
    #[must_use]
    pub fn euler_characteristic(&self) -> i64 {
        let used = self.vertices().filter(|&v| !self.is_isolated_vertex(v)).count();
        used as i64 - self.edge_count() as i64 + self.face_count() as i64
    }

    /// The connected components, numbered by their smallest vertex.
    #[must_use]
    pub fn components(&self) -> Components {
        let mut of_vertex: VertexMap<Option<u32>> = self.vertex_map(None);
        let mut count = 0;
        let mut open: Vec<VertexId> = Vec::new();
        for seed in self.vertices() {
            if of_vertex[seed].is_some() || self.is_isolated_vertex(seed) {
                continue;
            }
            of_vertex[seed] = Some(count);
            open.push(seed);
            while let Some(vertex) = open.pop() {
                for neighbour in self.one_ring(vertex) {
                    if of_vertex[neighbour].is_none() {
                        of_vertex[neighbour] = Some(count);
                        open.push(neighbour);
                    }
                }
            }
            count += 1;
        }
        Components { of_vertex, count: count as usize }
    }

    /// The total genus: the number of handles, summed over the components.
    ///
    /// From the Euler characteristic `2 c - 2 g - b` of `c` orientable components with `b`
    /// boundary loops; half-edge meshes are always orientable.
    #[must_use]
    pub fn genus(&self) -> usize {
        let components = self.components().count as i64;
        let loops = self.boundary_loops().len() as i64;
        usize::try_from((2 * components - loops - self.euler_characteristic()) / 2).unwrap_or(0)
    }
}
